//! Room to work in that is kept from one band to the next.

use std::sync::{Mutex, PoisonError};

/// Values that are costly to make, such as buffers: as many are made as threads ask at once, and used again.
///
/// What is in them when they are lent is what the last borrower left.
#[derive(Debug)]
pub struct Kept<T>(Mutex<Vec<T>>);

impl<T> Kept<T> {
    /// Nothing yet.
    pub fn new() -> Self {
        Self(Mutex::new(Vec::new()))
    }

    /// Lend a value to `work`: one that nobody has, or a new one.
    pub fn lend<R>(&self, new: impl FnOnce() -> T, work: impl FnOnce(&mut T) -> R) -> R {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut value = kept.unwrap_or_else(new);
        let result = work(&mut value);
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(value);
        result
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
}
