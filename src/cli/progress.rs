//! The progress bar: the set and the step at work, on standard error, where that is a terminal.

use std::io::IsTerminal as _;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Steps of the bar for evaluating; writing takes the rest.
const EVALUATED: u64 = 800;
/// Steps of the whole bar.
const WHOLE: u64 = 1000;

/// Shows how far the sets are.
#[derive(Debug)]
pub(super) struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar, hidden where `quiet` or where nobody sees it.
    pub(super) fn new(quiet: bool) -> Self {
        let bar = if quiet || !std::io::stderr().is_terminal() {
            ProgressBar::hidden()
        } else {
            ProgressBar::with_draw_target(Some(WHOLE), ProgressDrawTarget::stderr_with_hz(12))
        };
        let style = ProgressStyle::with_template("{prefix} [{bar:24}] {percent:>3} %  {wide_msg}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("=> "));
        if !bar.is_hidden() {
            bar.enable_steady_tick(Duration::from_millis(250));
        }
        Self { bar }
    }

    /// A set begins.
    pub(super) fn start(&self, set: String) {
        self.bar.set_prefix(set);
        self.bar.set_position(0);
        self.bar.set_message("");
    }

    /// So much of the evaluation is done, and this step is at work.
    pub(super) fn evaluated(&self, share: f32, step: &str) {
        self.bar.set_position((share * EVALUATED as f32) as u64);
        if !self.bar.is_hidden() {
            self.bar.set_message(step.to_owned());
        }
    }

    /// So much of the whole is done, and this is at work.
    pub(super) fn share(&self, share: f32, step: &str) {
        self.bar.set_position((share * WHOLE as f32) as u64);
        if !self.bar.is_hidden() {
            self.bar.set_message(step.to_owned());
        }
    }

    /// One of `count` files is written.
    pub(super) fn written(&self, file: &str, count: usize) {
        self.bar.inc((WHOLE - EVALUATED) / count.max(1) as u64);
        self.bar.set_message(format!("wrote {file}"));
    }

    /// Print a line without breaking the bar.
    pub(super) fn suspend<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
