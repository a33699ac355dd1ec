//! `report`: error against time, as one page and the numbers beside it.

use std::io::Write as _;

use super::args::{Report, ReportKind};
use super::exit::{Exit, Failure};
use super::progress::Progress;
use crate::io;
use crate::report::optics::{self, Effort};

/// Measure, and write the files.
pub(super) fn run(args: &Report) -> Result<Exit, Failure> {
    // What cannot be written is told before the minutes of work.
    std::fs::create_dir_all(&args.output).map_err(|e| Failure::Message {
        exit: Exit::File,
        message: format!("{} cannot be made: {}", args.output.display(), super::load::plain(&e)),
        help: None,
    })?;
    let progress = Progress::new(args.json);
    progress.start("report".into());
    let mut watch = |share: f32, step: &str| progress.evaluated(share, step);
    let effort = if args.quick { Effort::Quick } else { Effort::Full };
    let report = match args.kind {
        ReportKind::Optics => optics::report(effort, &mut watch),
    };
    let files = report.files();
    files.iter().try_for_each(|(name, text)| io::write_text(&args.output.join(name), text))?;
    drop(progress);
    let mut out = anstream::stdout();
    if args.json {
        writeln!(out, "{}", report.json())?;
    } else {
        write!(out, "{}", report.summary)?;
        writeln!(out, "{}", args.output.join(&files[0].0).display())?;
    }
    Ok(if report.failures.is_empty() { Exit::Done } else { Exit::Differs })
}
