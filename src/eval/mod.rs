//! DOING IT: the only loops over whole planes.

mod single;

pub use single::{Input, run_node};
