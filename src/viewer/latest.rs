//! The newest request wins: a place for one request, and the thread that waits there.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A place for one request. A newer one takes the place of one that waits, and tells the one at work to stop.
#[derive(Debug)]
pub(super) struct Latest<T> {
    waiting: Mutex<Waiting<T>>,
    came: Condvar,
    stale: AtomicBool,
}

#[derive(Debug)]
struct Waiting<T> {
    request: Option<T>,
    closed: bool,
}

/// What a wait came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Taken<T> {
    /// A request.
    Request(T),
    /// None so far.
    Nothing,
    /// Nobody will ask any more.
    Closed,
}

impl<T> Latest<T> {
    /// Nothing is asked yet.
    pub(super) fn new() -> Self {
        Self {
            waiting: Mutex::new(Waiting { request: None, closed: false }),
            came: Condvar::new(),
            stale: AtomicBool::new(false),
        }
    }

    /// Ask; what was asked before and is not done yet is not wanted any more.
    pub(super) fn put(&self, request: T) {
        let mut waiting = self.lock();
        waiting.request = Some(request);
        self.stale.store(true, Ordering::Relaxed);
        self.came.notify_one();
    }

    /// Wait for a request; `None` once nobody will ask any more.
    pub(super) fn take(&self) -> Option<T> {
        let mut waiting = self.lock();
        loop {
            if waiting.closed {
                return None;
            }
            if let Some(request) = waiting.request.take() {
                self.stale.store(false, Ordering::Relaxed);
                return Some(request);
            }
            waiting = self.came.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Wait for a request, so long at most.
    pub(super) fn take_within(&self, limit: Duration) -> Taken<T> {
        let start = Instant::now();
        let mut waiting = self.lock();
        loop {
            if waiting.closed {
                return Taken::Closed;
            }
            if let Some(request) = waiting.request.take() {
                self.stale.store(false, Ordering::Relaxed);
                return Taken::Request(request);
            }
            let Some(left) = limit.checked_sub(start.elapsed()) else { return Taken::Nothing };
            waiting = self.came.wait_timeout(waiting, left).unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Set while the request at work is not wanted any more.
    pub(super) fn stale(&self) -> &AtomicBool {
        &self.stale
    }

    /// Whether the request at work is not wanted any more.
    pub(super) fn is_stale(&self) -> bool {
        self.stale.load(Ordering::Relaxed)
    }

    /// Nobody will ask any more.
    pub(super) fn close(&self) {
        self.lock().closed = true;
        self.stale.store(true, Ordering::Relaxed);
        self.came.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Waiting<T>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    #[test]
    fn only_the_newest_request_is_handed_out() {
        let place = Latest::new();
        place.put(1);
        place.put(2);
        assert_eq!(place.take(), Some(2));
        assert!(!place.is_stale());
        place.put(3);
        assert!(place.is_stale(), "the one at work is told");
        assert_eq!(place.take(), Some(3));
        assert!(!place.is_stale());
    }

    #[test]
    fn a_wait_ends_without_a_request_too() {
        let place = Latest::new();
        assert_eq!(place.take_within(Duration::from_millis(1)), Taken::Nothing);
        place.put(1);
        assert_eq!(place.take_within(Duration::ZERO), Taken::Request(1));
        place.close();
        assert_eq!(place.take_within(Duration::from_secs(60)), Taken::Closed);
    }

    #[test]
    fn who_waits_is_woken_and_sent_home() {
        let place = Arc::new(Latest::new());
        let worker = {
            let place = place.clone();
            std::thread::spawn(move || std::iter::from_fn(|| place.take()).last())
        };
        place.put("work");
        while place.lock().request.is_some() {
            std::thread::yield_now();
        }
        place.close();
        assert_eq!(worker.join().expect("the thread ends"), Some("work"));
        assert!(place.is_stale(), "work at hand is not wanted any more");
    }
}
