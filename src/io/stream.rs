//! PNG files of a set whose maps come some rows at a time, all at once.

use std::io::BufWriter;
use std::sync::Arc;

use rayon::prelude::*;

use super::atomic::{Handle, OpenAside};
use super::png::{self, Stream};
use super::write::{Output, SetWriter, Staged};
use super::{IoError, Problem};
use crate::base::watch::Watched;
use crate::base::{MapKind, Rows};
use crate::maps::{NormalFormat, Quantiser};

/// What is known of a map before its rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapHead {
    /// What it is.
    pub kind: MapKind,
    /// The values that integers store as 0 and 1.
    pub range: [f32; 2],
    /// Which way green points; `None` for anything but a normal.
    pub normal_format: Option<NormalFormat>,
}

/// A file of one map, as far as its rows have come.
struct Part {
    head: MapHead,
    file: String,
    aside: OpenAside,
    stream: Stream<BufWriter<Handle>>,
    row_bytes: usize,
}

/// The PNG files of a set, written aside as rows come. Dropped, they leave nothing.
pub struct Parts<'w, 'a> {
    writer: &'w SetWriter<'a>,
    parts: Vec<Part>,
}

impl<'w, 'a> Parts<'w, 'a> {
    /// Begin a file for each head; `width` and `height` are those of all maps.
    ///
    /// # Errors
    /// If a file cannot be made, or the size does not fit the format.
    pub fn new(
        writer: &'w SetWriter<'a>,
        heads: &[MapHead],
        [width, height]: [usize; 2],
    ) -> Result<Self, IoError> {
        let options = writer.options;
        let blank = vec![0.0; width];
        let room = Arc::default();
        let part = |head: &MapHead| {
            let file = writer.file_name(Output::Png, Some((head.kind, head.normal_format)))?;
            let (aside, out) = OpenAside::new(writer.dir.join(&file))?;
            let lanes = vec![Rows::broadcast(&blank); head.kind.channels()];
            let quantiser = Quantiser::of_rows(head.kind, head.range, lanes, &options.encode);
            let out = BufWriter::with_capacity(1 << 18, out);
            let stream = Stream::new(&quantiser, height, options.png, options.verify, Arc::clone(&room), out)
                .map_err(|p| p.at(aside.path()))?;
            Ok(Part { head: *head, file, aside, stream, row_bytes: quantiser.row_bytes() })
        };
        Ok(Self { writer, parts: heads.iter().map(part).collect::<Result<_, IoError>>()? })
    }

    /// Encode rows before `end` of all maps, on the current rayon pool. `lanes` gives the channels of a map, with the rows
    /// from the one that was returned last for it (0 at first) to `end`; normals are OpenGL's. Returns the first row of
    /// each map that must be there the next time.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn rows<'r>(
        &mut self,
        lanes: impl Fn(MapKind) -> Vec<Rows<'r>> + Sync,
        end: usize,
    ) -> Result<Vec<(MapKind, usize)>, IoError> {
        let writer = self.writer;
        let advance = |part: &mut Part| -> Result<(MapKind, usize), Problem> {
            let MapHead { kind, range, normal_format } = part.head;
            let mut lanes = lanes(kind);
            let turned = match (normal_format, &lanes[..]) {
                (Some(NormalFormat::Dx), [_, green, _]) => turned(green, part.stream.next(), end),
                _ => Vec::new(),
            };
            if !turned.is_empty() {
                let first = part.stream.next() as i64;
                lanes[1] = Rows::window(&turned, lanes[1].width(), part.stream.height(), first);
            }
            let quantiser = Quantiser::of_rows(kind, range, lanes, &writer.options.encode);
            let watched = Watched { name: &part.file, by: writer.watch };
            part.stream.advance(&quantiser, end, watched)?;
            Ok((kind, part.stream.next()))
        };
        self.parts
            .par_iter_mut()
            .with_max_len(1)
            .map(|part| advance(part).map_err(|problem| problem.at(part.aside.path())))
            .collect()
    }

    /// End all files, and compare every sample if that is asked for.
    ///
    /// # Errors
    /// If a file cannot be written, or does not read back as it was written.
    pub fn finish(self) -> Result<Vec<Staged>, IoError> {
        let writer = self.writer;
        let finish = |part: Part| {
            let Part { head, file, aside, stream, row_bytes } = part;
            let watched = Watched { name: &file, by: writer.watch };
            let (told, hashes) = stream.finish(watched).map_err(|p| p.at(aside.path()))?;
            let mut aside = aside.close();
            if writer.options.verify {
                let compression = writer.options.png;
                aside = aside.verify(|file| png::verify_hashes(row_bytes, compression, &hashes, file))?;
            }
            Ok(writer.staged(Output::Png, file, aside, &[head], Some(told)))
        };
        self.parts.into_par_iter().with_max_len(1).map(finish).collect()
    }
}

/// Green pointing the other way, from row `first` on.
fn turned(green: &Rows<'_>, first: usize, end: usize) -> Vec<f32> {
    (first..end).flat_map(|y| green.row(y as i64)).map(|v| -v).collect()
}
