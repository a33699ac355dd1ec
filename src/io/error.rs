//! What can go wrong with a file, and with which file.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A problem with one file or directory.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", .path.display())]
pub struct IoError {
    /// The file or directory, as it was given.
    pub path: PathBuf,
    /// What is wrong with it.
    pub problem: Problem,
}

/// What is wrong with a file or directory.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// It does not exist.
    #[error("no such file or directory")]
    NotFound,
    /// A directory is wanted here, or on the way here.
    #[error("not a directory")]
    NotADirectory,
    /// A file is wanted here.
    #[error("is a directory")]
    IsADirectory,
    /// It, or the file system, may not be written (or read).
    #[error("permission denied or read-only")]
    Denied,
    /// The file system or the quota is full.
    #[error("no space left on the file system")]
    DiskFull,
    /// Any other error of the operating system.
    #[error("{0}")]
    Os(std::io::Error),
    /// The file is damaged, or no image that can be read here.
    #[error("not a readable {format} file: {message}")]
    Format {
        /// What it should be.
        format: &'static str,
        /// What the decoder said.
        message: String,
    },
    /// The image is larger than an input may be.
    #[error(
        "{width}x{height} texels in {channels} channels are more than the {limit} samples that an input may have"
    )]
    TooLarge {
        /// Texels across.
        width: u64,
        /// Texels down.
        height: u64,
        /// Channels.
        channels: u64,
        /// Greatest number of samples.
        limit: u64,
    },
    /// The file is longer than it may be.
    #[error("it has more than {most} bytes")]
    Long {
        /// Greatest length, bytes.
        most: usize,
    },
    /// The image is wider or higher than its format allows.
    #[error("{width}x{height} texels do not fit the format")]
    Unencodable {
        /// Texels across.
        width: usize,
        /// Texels down.
        height: usize,
    },
    /// What was read back differs from what was written.
    #[error("read back after writing, {0}")]
    ReadBack(String),
    /// The file name cannot be made.
    #[error("{0}")]
    Name(#[from] super::NameError),
    /// The manifest is damaged, or newer than this version.
    #[error("damaged manifest: {0}")]
    Manifest(String),
}

impl Problem {
    /// The same problem, of this file.
    pub(crate) fn at(self, path: impl AsRef<Path>) -> IoError {
        IoError { path: path.as_ref().to_owned(), problem: self }
    }

    /// What to do about it, where something can be said.
    pub fn help(&self) -> Option<&'static str> {
        Some(match self {
            Self::NotADirectory => "give a directory, or remove the file that is in its place",
            Self::IsADirectory => "give a file, or choose another name by the file name template",
            Self::Denied => {
                "check the permissions of the directory and whether its file system is mounted read-only"
            }
            Self::DiskFull => "free some space, write fewer maps, or choose another directory",
            Self::Format { .. } => {
                "images are read as PNG, OpenEXR or Radiance HDR, by content, not by extension"
            }
            Self::Long { .. } => "give a smaller file",
            Self::TooLarge { .. } => "scale the image down",
            Self::Unencodable { .. } => "choose a smaller size",
            Self::ReadBack(_) => {
                "the disk, the memory or another program changed the file while it was written"
            }
            Self::Manifest(_) => "write the sets again into an empty directory, or restore manifest.json",
            Self::NotFound | Self::Os(_) | Self::Name(_) => return None,
        })
    }
}

impl IoError {
    /// What to do about it, where something can be said.
    pub fn help(&self) -> Option<&'static str> {
        self.problem.help()
    }
}

impl From<std::io::Error> for Problem {
    fn from(error: std::io::Error) -> Self {
        match error.kind() {
            ErrorKind::NotFound => Self::NotFound,
            ErrorKind::NotADirectory => Self::NotADirectory,
            ErrorKind::IsADirectory => Self::IsADirectory,
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => Self::Denied,
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => Self::DiskFull,
            _ => Self::Os(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_message_has_the_path_and_the_cause() {
        let error = Problem::from(std::io::Error::from(ErrorKind::StorageFull)).at("out/a.png");
        assert_eq!(error.to_string(), "out/a.png: no space left on the file system");
        assert!(error.help().is_some());
    }
}
