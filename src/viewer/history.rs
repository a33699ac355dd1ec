//! Undo and redo.

/// A value with what it was before and, after an undo, what it was then.
#[derive(Clone, Debug)]
pub(super) struct History<T> {
    past: Vec<T>,
    now: T,
    future: Vec<T>,
    /// What is being moved: a drag of one slider is one step.
    moving: Option<String>,
}

/// Most steps that can be undone.
const MOST: usize = 500;

impl<T: Clone + PartialEq> History<T> {
    /// Begin.
    pub(super) fn new(now: T) -> Self {
        Self { past: Vec::new(), now, future: Vec::new(), moving: None }
    }

    /// As it is.
    pub(super) fn now(&self) -> &T {
        &self.now
    }

    /// Change it. Changes of one `what` in a row are one step, until [`History::settle`].
    pub(super) fn set(&mut self, next: T, what: &str) {
        if next == self.now {
            return;
        }
        if self.moving.as_deref() != Some(what) {
            self.past.push(self.now.clone());
            if self.past.len() > MOST {
                self.past.remove(0);
            }
            self.moving = Some(what.to_owned());
        }
        self.future.clear();
        self.now = next;
    }

    /// What comes next is a step of its own.
    pub(super) fn settle(&mut self) {
        self.moving = None;
    }

    /// Whether there is a step to take back.
    pub(super) fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// Whether a step was taken back.
    pub(super) fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// Take a step back; false if there is none.
    pub(super) fn undo(&mut self) -> bool {
        let Some(before) = self.past.pop() else { return false };
        self.future.push(std::mem::replace(&mut self.now, before));
        self.settle();
        true
    }

    /// Take a step forward again; false if there is none.
    pub(super) fn redo(&mut self) -> bool {
        let Some(after) = self.future.pop() else { return false };
        self.past.push(std::mem::replace(&mut self.now, after));
        self.settle();
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_is_one_step() {
        let mut history = History::new(0);
        (1..=5).for_each(|i| history.set(i, "size"));
        history.set(9, "rows");
        assert!(history.undo());
        assert_eq!(*history.now(), 5);
        assert!(history.undo() && !history.undo());
        assert_eq!(*history.now(), 0);
        assert!(history.redo() && history.redo() && !history.redo());
        assert_eq!(*history.now(), 9);
    }

    #[test]
    fn two_drags_of_one_slider_are_two_steps() {
        let mut history = History::new(0);
        history.set(1, "size");
        history.settle();
        history.set(2, "size");
        assert!(history.undo());
        assert_eq!(*history.now(), 1);
    }

    #[test]
    fn a_change_after_an_undo_ends_what_was_undone() {
        let mut history = History::new(0);
        history.set(1, "a");
        history.undo();
        history.set(2, "a");
        assert!(!history.can_redo());
        assert!(history.undo());
        assert_eq!(*history.now(), 0);
    }

    #[test]
    fn what_changes_nothing_is_no_step_and_memory_is_bounded() {
        let mut history = History::new(0);
        history.set(0, "a");
        assert!(!history.can_undo());
        for i in 1..2000 {
            history.set(i, "a");
            history.settle();
        }
        assert_eq!(std::iter::from_fn(|| history.undo().then_some(())).count(), MOST);
    }
}
