//! DOING IT: the only loops over whole planes.
//!
//! [`run()`] executes a [`Plan`](crate::plan::Plan): stage by stage, bands of rows in parallel, planes from a pool that
//! get back to it as soon as their last reader ran. [`run_each`] hands maps out while the rest is computed; [`run_slabs`]
//! makes all maps at once, some hundred rows at a time. [`run_node`]
//! evaluates one node alone.

mod run;
mod single;
mod slabs;

pub use run::{Cancelled, Control, Evaluation, MapPlanes, OnProgress, run, run_each};
pub use single::{Input, run_node};
pub use slabs::{MapRows, Stopped, run_slabs};
