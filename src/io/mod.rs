//! FILES: texture sets to PNG and OpenEXR with a manifest, whole or not at all; image files as inputs.
//!
//! | Item | What it is |
//! | --- | --- |
//! | [`write_set`], [`SetWriter`] | a set into a directory, at once or map by map |
//! | [`WriteOptions`], [`NameTemplate`] | which files, how named, how encoded, whether read back |
//! | [`PngCompression`], [`ExrCompression`] | time against size |
//! | [`Manifest`], [`verify_dir`] | what a directory holds, and whether it still does |
//! | [`read_set`] | a set of a directory, back as maps |
//! | [`read_image`], [`load_assets`] | PNG, OpenEXR and Radiance HDR files as inputs |
//! | [`stage_channels`], [`stage_picture`], [`write_picture`] | rendered pictures |
//! | [`Aside`] | a file that is written and not yet in its place, so that several come together |
//! | [`write_text`] | a text file, whole or not at all |
//! | [`IoError`] | a path and what is wrong with it |
//!
//! Bytes depend on the set, the options and the version, never on threads, time, path or machine.

mod atomic;
mod error;
mod exr;
mod hdr;
mod manifest;
mod names;
mod picture;
mod png;
mod read;
mod sets;
mod stream;
mod write;

pub use atomic::Aside;
pub use error::{IoError, Problem};
pub use exr::{ExrCompression, ExrOptions, ExrSample};
pub use manifest::{
    Compression, Encoding, FILE_NAME, FORMAT, FileCheck, FileFormat, FileStatus, Manifest, ManifestEntry,
    MapRecord, SampleKind, SetRecord, VerifyReport, verify_dir,
};
pub use names::{NameError, NameTemplate};
pub use picture::{stage_channels, stage_picture, write_picture};
pub use png::PngCompression;
pub use read::{MAX_SAMPLES, load_assets, read_bytes, read_image};
pub use sets::read_set;
pub use stream::{MapHead, Parts};
pub use write::{Output, SetWriter, Staged, WriteOptions, encode_exr, encode_png, write_set, write_text};
