//! How the command ends.

use std::fmt::Display;
use std::process::ExitCode;

use crate::io::IoError;
use crate::preset::PresetError;

/// Exit codes; part of the interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Exit {
    /// Done.
    Done = 0,
    /// Done, and something differs: `verify` found changed or missing files, `film` more than `--tolerance`, a case of `report` failed.
    Differs = 1,
    /// The arguments or a preset cannot be used; nothing was written.
    Bad = 2,
    /// A file or directory cannot be read or written.
    File = 3,
    /// The maps need more memory than `--memory`; nothing was written.
    Memory = 4,
    /// Stopped by Ctrl-C; the set at work was not written, `render` wrote the picture as far as it was.
    Interrupted = 130,
}

impl Exit {
    /// Every code with its meaning, for `--help`.
    pub(super) const TABLE: &str = "Exit codes:
  0    done
  1    done, and something differs (verify, film, report)
  2    the arguments or a preset cannot be used; nothing was written
  3    a file or directory cannot be read or written
  4    more memory is needed than --memory allows; nothing was written
  130  stopped by Ctrl-C; the set at work was not written, a picture was written as it was";
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// Why a verb could not do its work.
#[derive(Debug)]
pub(super) enum Failure {
    /// A preset's diagnostics.
    Preset(Box<PresetError>),
    /// One message.
    Message {
        /// The code to end with.
        exit: Exit,
        /// What is wrong.
        message: String,
        /// What to do.
        help: Option<String>,
    },
    /// Everything has been told already.
    Told(Exit),
}

impl Failure {
    /// Arguments that cannot be used.
    pub(super) fn usage(message: impl Display, help: impl Display) -> Self {
        Self::Message { exit: Exit::Bad, message: message.to_string(), help: Some(help.to_string()) }
    }

    /// The code to end with.
    pub(super) fn exit(&self) -> Exit {
        match self {
            Self::Preset(_) => Exit::Bad,
            Self::Message { exit, .. } | Self::Told(exit) => *exit,
        }
    }
}

impl From<PresetError> for Failure {
    fn from(error: PresetError) -> Self {
        Self::Preset(Box::new(error))
    }
}

impl From<IoError> for Failure {
    fn from(error: IoError) -> Self {
        Self::Message { exit: Exit::File, message: error.to_string(), help: error.help().map(str::to_owned) }
    }
}

/// Standard output that nobody reads any more is no fault of ours: the command ends quietly.
impl From<std::io::Error> for Failure {
    fn from(error: std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::BrokenPipe {
            return Self::Told(Exit::Done);
        }
        Self::Message {
            exit: Exit::File,
            message: format!("standard output cannot be written: {error}"),
            help: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_has_every_code() {
        let all = [Exit::Done, Exit::Differs, Exit::Bad, Exit::File, Exit::Memory, Exit::Interrupted];
        let rows: Vec<u8> = Exit::TABLE
            .lines()
            .skip(1)
            .filter_map(|line| line.split_whitespace().next()?.parse().ok())
            .collect();
        assert_eq!(rows, all.map(|e| e as u8));
    }
}
