//! What can keep a preview from being drawn.

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PreviewError {
    /// The machine has no graphics driver that can be used.
    #[error("no graphics adapter: {0}")]
    NoAdapter(String),
    /// There is an adapter, and it gives no device.
    #[error("the adapter {adapter} gives no device: {reason}")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// What the driver says.
        reason: String,
    },
    /// Something is larger than the adapter can hold.
    #[error("{what} needs {needed}, the adapter holds {most} at most")]
    TooLarge {
        /// What, and in which unit.
        what: &'static str,
        /// How much it needs.
        needed: u64,
        /// How much there can be.
        most: u64,
    },
    /// A picture of no pixels.
    #[error("a picture of {0} x {1} pixels is none")]
    Empty(usize, usize),
    /// A material's numbers are out of range.
    #[error("{0}")]
    Material(String),
    /// The adapter's memory does not suffice.
    #[error("the adapter's memory does not suffice: {0}")]
    OutOfMemory(String),
    /// The device went away while it drew.
    #[error("the graphics device was lost: {0}")]
    Lost(String),
    /// The driver refused what we asked for: a fault of ours or of the driver.
    #[error("the graphics driver refused: {0}")]
    Refused(String),
}
