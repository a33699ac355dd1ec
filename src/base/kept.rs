//! Room to work in that is kept from one band to the next.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, PoisonError};

/// Values that are costly to make, such as buffers: as many are made as threads ask at once, and used again.
///
/// What is in them when they are lent is what the last borrower left. A thread of a pool gets the value that it had before, if
/// that is free: it is in the thread's caches, and what it knows of the last band often holds for the next.
#[derive(Debug)]
pub struct Kept<T>(Mutex<Vec<(Option<usize>, T)>>);

impl<T> Kept<T> {
    /// Nothing yet.
    pub fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// Lend a value to `work`: one that nobody has, or a new one.
    pub fn lend<R>(&self, new: impl FnOnce() -> T, work: impl FnOnce(&mut T) -> R) -> R {
        let mut value = self.take().unwrap_or_else(new);
        let result = work(&mut value);
        self.give_back(value);
        result
    }

    /// A value that nobody has, if there is one; for what is given back elsewhere than where it was taken.
    pub fn take(&self) -> Option<T> {
        let own = rayon::current_thread_index();
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let at = kept.iter().rposition(|(thread, _)| *thread == own).or(kept.len().checked_sub(1))?;
        Some(kept.swap_remove(at).1)
    }

    /// Take a value back, or a new one.
    pub fn give_back(&self, value: T) {
        let own = rayon::current_thread_index();
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push((own, value));
    }
}

impl<T: Default> Kept<T> {
    /// Lend a value, one that nobody has or the default, until what is returned is dropped.
    pub fn borrow(&self) -> Lent<'_, T> {
        Lent { value: self.take().unwrap_or_default(), to: self }
    }
}

/// A value that goes back where it was lent.
#[derive(Debug)]
pub struct Lent<'a, T: Default> {
    value: T,
    to: &'a Kept<T>,
}

impl<T: Default> Deref for Lent<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T: Default> DerefMut for Lent<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.value
    }
}

impl<T: Default> Drop for Lent<'_, T> {
    fn drop(&mut self) {
        self.to.give_back(std::mem::take(&mut self.value));
    }
}

impl<T> Default for Kept<T> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_lent_to_one_at_a_time_and_made_when_all_are_lent() {
        let kept = Kept::new();
        let outer = kept.lend(
            || 1,
            |outer| {
                kept.lend(|| 2, |inner| assert_eq!(*inner, 2));
                *outer += 10;
                *outer
            },
        );
        assert_eq!(outer, 11);
        // Both are free: the last one that was given back comes first, and nothing is made.
        let next = kept.lend(|| 3, |first| kept.lend(|| 4, |second| (*first, *second)));
        assert_eq!(next, (11, 2));
    }

    #[test]
    fn what_is_borrowed_comes_back_as_it_was_left() {
        let kept = Kept::new();
        let (mut first, second) = (kept.borrow(), kept.borrow());
        assert_eq!((*first, *second), (0, 0));
        *first = 5;
        drop(second);
        drop(first);
        assert_eq!(*kept.borrow(), 5);
    }

    #[test]
    fn a_thread_gets_what_it_had() {
        let kept = Kept::<Option<usize>>::new();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        // All three have one at once, and give them back in any order.
        let together = std::sync::Barrier::new(3);
        pool.broadcast(|thread| {
            let mut own = kept.borrow();
            *own = Some(thread.index());
            together.wait();
        });
        let found = pool.broadcast(|thread| {
            let own = kept.borrow();
            together.wait();
            *own == Some(thread.index())
        });
        assert_eq!(found, [true; 3]);
    }
}
