//! Files that are watched: a preset is read anew once it changed on disk.

use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::Duration;

use super::desk::{Desk, Opened};
use super::latest::{Latest, Taken};
use super::problem::Problem;

/// Between two looks.
const PAUSE: Duration = Duration::from_millis(250);

/// What came of reading a preset anew.
pub(super) type Reloaded = Result<Opened, Vec<Problem>>;

/// Watch the preset that was asked for last, until nobody asks any more. `wake` is called after each news.
pub(super) fn serve(
    requests: &Latest<Arc<Opened>>,
    desk: &dyn Desk,
    news: &Sender<Reloaded>,
    wake: &dyn Fn(),
) {
    let mut watched: Option<(Arc<Opened>, u64)> = None;
    loop {
        match requests.take_within(PAUSE) {
            Taken::Closed => return,
            Taken::Request(opened) => watched = Some((opened.clone(), opened.stamp)),
            Taken::Nothing => {}
        }
        let Some((opened, stamp)) = &mut watched else { continue };
        let now = desk.stamp(opened);
        if now == *stamp {
            continue;
        }
        *stamp = now;
        let read = desk.open(&opened.word);
        // Written while it was read: the next look finds that.
        if let Ok(new) = &read {
            watched = Some((Arc::new(new.clone()), new.stamp));
        }
        // Who does not listen any more closes the requests, too.
        let _ = news.send(read);
        wake();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::testing::Table;
    use std::sync::Mutex;
    use std::sync::mpsc;

    /// A file that is written by the test: its stamp, and what it is read as.
    struct File(Mutex<(u64, Reloaded)>);

    impl File {
        fn write(&self, stamp: u64, read: Reloaded) {
            *self.0.lock().expect("no panic") = (stamp, read);
        }
    }

    /// As [`Table`], but for one file.
    impl Desk for File {
        fn open(&self, _: &str) -> Reloaded {
            let (stamp, read) = &*self.0.lock().expect("no panic");
            read.clone().map(|opened| Opened { stamp: *stamp, ..opened })
        }
        fn stamp(&self, _: &Opened) -> u64 {
            self.0.lock().expect("no panic").0
        }
        fn images(&self, o: &Opened, g: &mut crate::graph::Graph) -> Result<(), crate::preset::PresetError> {
            Table.images(o, g)
        }
        fn scene(&self, word: &str) -> Result<crate::viewer::OpenedScene, Vec<Problem>> {
            Table.scene(word)
        }
        fn memory(&self) -> Option<u64> {
            None
        }
        fn save(&self, path: &str, text: &str) -> Result<(), String> {
            Table.save(path, text)
        }
        fn export(&self, set: &crate::maps::TextureSet, folder: &str) -> Result<String, String> {
            Table.export(set, folder)
        }
    }

    #[test]
    fn a_changed_file_is_read_once_for_each_change_also_after_an_error() {
        let opened = Table.open("python_regius").expect("a built-in preset");
        let file = File(Mutex::new((0, Ok(opened.clone()))));
        let requests = Latest::new();
        let (send, receive) = mpsc::channel();
        std::thread::scope(|scope| {
            scope.spawn(|| serve(&requests, &file, &send, &|| ()));
            requests.put(Arc::new(opened.clone()));
            let wait = Duration::from_secs(20);
            file.write(1, Err(vec![Problem::plain("broken", "")]));
            assert!(receive.recv_timeout(wait).expect("it is told").is_err());
            file.write(2, Ok(opened));
            assert_eq!(receive.recv_timeout(wait).expect("it is told").map(|o| o.stamp), Ok(2));
            assert!(receive.recv_timeout(3 * PAUSE).is_err(), "nothing changed since");
            requests.close();
        });
    }
}
