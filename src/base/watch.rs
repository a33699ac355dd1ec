//! Who is told what is at work: the rooms that work say it, whoever holds a clock measures it.

use std::fmt::Debug;

/// A kind of work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Work {
    /// A node is evaluated, on a band of rows or whole.
    Node,
    /// A part of a file is quantised and compressed.
    Encode,
    /// A part of a file is written, or the file is read back for its hash.
    Write,
}

/// Told of every piece of work, by the thread that does it. Pieces of one thread lie one in another or apart.
pub trait Watch: Debug + Sync {
    /// A piece of work begins; what is returned is handed to [`Watch::end`].
    fn begin(&self) -> u64;
    /// The piece that began then has ended. `name` is that of the node or the file.
    fn end(&self, begin: u64, work: Work, name: &str);
}

/// A node or a file at work, and who is told of it.
#[derive(Clone, Copy, Debug)]
pub struct Watched<'a> {
    /// Its name.
    pub name: &'a str,
    /// Who is told, if any.
    pub by: Option<&'a dyn Watch>,
}

impl Watched<'_> {
    /// Do a piece of work, and tell of it where someone watches.
    #[inline]
    pub fn piece<T>(&self, work: Work, piece: impl FnOnce() -> T) -> T {
        let Some(watch) = self.by else { return piece() };
        let begin = watch.begin();
        let made = piece();
        watch.end(begin, work, self.name);
        made
    }
}
