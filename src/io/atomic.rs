//! Write aside, then rename: a file is whole or absent.

use std::fs::File;
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use tempfile::NamedTempFile;

use super::{IoError, Problem};
use crate::base::watch::{Watched, Work};

/// Start of the name of a file that is being written; one that is left was interrupted by a crash.
const PREFIX: &str = ".ophidian-";

/// A file that is written beside its place and not yet there. Dropped, it leaves nothing.
#[derive(Debug)]
pub struct Aside {
    temp: NamedTempFile,
    path: PathBuf,
    /// Its size.
    pub(super) bytes: u64,
    /// BLAKE3 of what the file holds.
    pub(super) blake3: blake3::Hash,
}

impl Aside {
    /// Write `path` aside by `write`, then hash it.
    ///
    /// The data is handed to the operating system, not forced to the disk: a power cut may still lose the newest files,
    /// never half of an old one.
    pub(super) fn write(
        path: PathBuf,
        write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), Problem>,
    ) -> Result<Self, IoError> {
        Self::write_watched(path, Watched { name: "", by: None }, write)
    }

    /// As [`Aside::write`], telling of the last write and the hash; `write` tells of the rest.
    pub(super) fn write_watched(
        path: PathBuf,
        watched: Watched<'_>,
        write: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), Problem>,
    ) -> Result<Self, IoError> {
        let done = || -> Result<_, Problem> {
            if path.is_dir() {
                return Err(Problem::IsADirectory);
            }
            let mut temp = create(path.parent().unwrap_or(Path::new("")))?;
            let mut buffered = BufWriter::with_capacity(1 << 18, temp.as_file_mut());
            write(&mut buffered)?;
            let (bytes, blake3) = watched.piece(Work::Write, || -> std::io::Result<_> {
                buffered.flush()?;
                hash(buffered.get_mut())
            })?;
            drop(buffered);
            Ok((temp, bytes, blake3))
        };
        match done() {
            Ok((temp, bytes, blake3)) => Ok(Self { temp, path, bytes, blake3 }),
            Err(problem) => Err(problem.at(path)),
        }
    }

    /// Check the written file, from its start, before it is renamed.
    pub(super) fn verify(
        mut self,
        check: impl FnOnce(&mut File) -> Result<(), Problem>,
    ) -> Result<Self, IoError> {
        let file = self.temp.as_file_mut();
        let result = file.seek(SeekFrom::Start(0)).map_err(Problem::from).and_then(|_| check(file));
        match result {
            Ok(()) => Ok(self),
            Err(problem) => Err(problem.at(self.path)),
        }
    }

    /// Rename it to its place, replacing what was there.
    ///
    /// # Errors
    /// If it cannot be renamed.
    pub fn commit(self) -> Result<(), IoError> {
        self.temp.persist(&self.path).map(drop).map_err(|e| Problem::from(e.error).at(self.path))
    }
}

/// A file that is being written aside, by whoever holds its handle.
#[derive(Debug)]
pub(super) struct OpenAside {
    temp: NamedTempFile,
    path: PathBuf,
    hasher: Arc<Mutex<blake3::Hasher>>,
}

/// What an [`OpenAside`] is written by, from its start: what passes is hashed while it is at hand.
#[derive(Debug)]
pub(super) struct Handle {
    file: File,
    hasher: Arc<Mutex<blake3::Hasher>>,
}

impl Write for Handle {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.file.write(bytes)?;
        // Hashing does not panic.
        self.hasher.lock().unwrap_or_else(PoisonError::into_inner).update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

impl OpenAside {
    /// Begin to write `path` aside.
    pub(super) fn new(path: PathBuf) -> Result<(Self, Handle), IoError> {
        let begun = || -> Result<_, Problem> {
            if path.is_dir() {
                return Err(Problem::IsADirectory);
            }
            let temp = create(path.parent().unwrap_or(Path::new("")))?;
            let file = temp.as_file().try_clone()?;
            Ok((temp, file))
        };
        let hasher = Arc::new(Mutex::new(blake3::Hasher::new()));
        match begun() {
            Ok((temp, file)) => {
                let handle = Handle { file, hasher: hasher.clone() };
                Ok((Self { temp, path, hasher }, handle))
            }
            Err(problem) => Err(problem.at(path)),
        }
    }

    /// Where it will be.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// End it, now that all is written.
    pub(super) fn close(self) -> Aside {
        let Self { temp, path, hasher } = self;
        let hasher = hasher.lock().unwrap_or_else(PoisonError::into_inner);
        Aside { temp, path, bytes: hasher.count(), blake3: hasher.finalize() }
    }
}

fn create(dir: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(".part");
    #[cfg(unix)]
    {
        // As any other file the user makes, by the umask; tempfile's default is for secrets.
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(if dir.as_os_str().is_empty() { Path::new(".") } else { dir })
}

/// Size and BLAKE3 of an open file.
pub(super) fn hash(file: &mut File) -> std::io::Result<(u64, blake3::Hash)> {
    file.seek(SeekFrom::Start(0))?;
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(&mut *file)?;
    Ok((hasher.count(), hasher.finalize()))
}

/// Make a directory and its parents.
///
/// # Errors
/// [`Problem::NotADirectory`] if it, or a parent, is a file.
pub(super) fn make_dir(dir: &Path) -> Result<(), IoError> {
    match std::fs::create_dir_all(dir) {
        // create_dir_all says "exists" of a file in its place.
        Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => Err(Problem::NotADirectory.at(dir)),
        result => result.map_err(|e| Problem::from(e).at(dir)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(dir: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_only_when_it_is_committed() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        let aside = Aside::write(path.clone(), |w| Ok(w.write_all(b"new")?)).unwrap();
        assert_eq!((aside.bytes, aside.blake3), (3, blake3::hash(b"new")));
        assert!(!path.exists());
        aside.commit().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(names(dir.path()), ["a.txt"]);
        #[cfg(unix)]
        {
            // The permissions are those of a file that is made plainly.
            use std::os::unix::fs::PermissionsExt as _;
            let plain = dir.path().join("plain");
            std::fs::write(&plain, b"").unwrap();
            let mode = |p: &Path| std::fs::metadata(p).unwrap().permissions().mode();
            assert_eq!(mode(&path), mode(&plain));
        }
    }

    #[test]
    fn a_failing_write_or_check_keeps_the_old_file_and_leaves_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        std::fs::write(&path, b"old").unwrap();
        let full = || std::io::Error::from(std::io::ErrorKind::StorageFull);
        let error = Aside::write(path.clone(), |w| {
            w.write_all(&[1; 1 << 20])?;
            Err(full().into())
        });
        assert!(matches!(error, Err(IoError { problem: Problem::DiskFull, .. })));
        let error = Aside::write(path.clone(), |w| Ok(w.write_all(b"new")?))
            .unwrap()
            .verify(|_| Err(Problem::ReadBack("texel 0 differs".into())));
        assert!(matches!(error, Err(IoError { problem: Problem::ReadBack(_), .. })));
        drop(Aside::write(path.clone(), |w| Ok(w.write_all(b"new")?)).unwrap());
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(dir.path()), ["a.txt"]);
    }

    #[test]
    fn directories_that_are_files_and_files_that_are_directories_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("file");
        std::fs::write(&file, b"").unwrap();
        for bad in [file.clone(), file.join("below")] {
            assert!(matches!(make_dir(&bad).unwrap_err().problem, Problem::NotADirectory), "{bad:?}");
        }
        let error = Aside::write(dir.path().to_owned(), |_| Ok(())).unwrap_err();
        assert!(matches!(error.problem, Problem::IsADirectory), "{error}");
        assert_eq!(error.path, dir.path());
    }

    /// /dev/full exists on Linux only; elsewhere the injected error above stands alone.
    #[test]
    #[cfg(target_os = "linux")]
    fn a_full_disk_is_told_as_one() {
        let Ok(mut full) = File::options().write(true).open("/dev/full") else {
            println!("SKIPPED: /dev/full cannot be opened");
            return;
        };
        let error = full.write_all(b"x").unwrap_err();
        assert!(matches!(Problem::from(error), Problem::DiskFull));
    }
}
