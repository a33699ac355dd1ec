//! A PNG file whose rows come in order, some at a time.
//!
//! Strips are written while the next ones are encoded, the last ones of a call while those of the next call are: writing takes
//! turns on one thread, and the others would wait for it.

use std::io::Write;
use std::sync::Arc;

use ::png::{ScaledFloat, SrgbRenderingIntent};
use rayon::prelude::*;

use super::strip::{self, Room, Strip};
use super::{PngCompression, bit_depth, color_type, problem};
use crate::base::MapKind;
use crate::base::watch::{Watched, Work};
use crate::io::Problem;
use crate::maps::{MapTold, Quantiser, RowTold};

/// A file whose rows come in order, some at a time; the bytes do not depend on how many.
pub(in crate::io) struct Stream<W: Write + Send> {
    sink: Sink<W>,
    compression: PngCompression,
    hashed: bool,
    /// Values of a row, and rows.
    size: (usize, usize),
    strip_rows: usize,
    /// The first row that is not encoded.
    next: usize,
    /// Strips that are to be written.
    made: Vec<Strip>,
    room: Arc<Room>,
}

/// Where strips go, in order.
struct Sink<W: Write> {
    writer: ::png::Writer<W>,
    told: Vec<RowTold>,
    /// Of the samples of each strip, where they will be compared.
    hashes: Vec<blake3::Hash>,
    adler: u32,
    /// What is to be written next, and how many bytes of it.
    chunk: Vec<u8>,
    held: usize,
}

impl<W: Write> Sink<W> {
    /// Write strips, whose memory goes back to `room`; the last one is held, as the stream may end behind it.
    fn put(&mut self, strips: Vec<Strip>, room: &Room, watched: Watched<'_>) -> Result<(), Problem> {
        for strip in strips {
            let old = if self.told.is_empty() {
                self.chunk.extend(&strip.bytes[..strip.used]);
                self.held = self.chunk.len();
                strip.bytes
            } else {
                let chunk = &self.chunk[..self.held];
                watched
                    .piece(Work::Write, || self.writer.write_chunk(::png::chunk::IDAT, chunk))
                    .map_err(problem)?;
                self.held = strip.used;
                std::mem::replace(&mut self.chunk, strip.bytes)
            };
            room.bytes.give_back(old);
            self.adler = zlib_rs::adler32::adler32_combine(self.adler, strip.adler, strip.length);
            self.told.extend(strip.told);
            self.hashes.extend(strip.samples);
        }
        Ok(())
    }
}

impl<W: Write + Send> Stream<W> {
    /// Begin a file of so many rows like those of the quantiser. `hashed`: it will be compared by
    /// [`verify_hashes`](super::verify_hashes); `room` can be shared with other files.
    pub(in crate::io) fn new(
        quantiser: &Quantiser<'_>,
        height: usize,
        compression: PngCompression,
        hashed: bool,
        room: Arc<Room>,
        out: W,
    ) -> Result<Self, Problem> {
        let width = quantiser.width();
        let side = |n: usize| {
            i32::try_from(n).map(i32::unsigned_abs).map_err(|_| Problem::Unencodable { width, height })
        };
        let mut encoder = ::png::Encoder::new(out, side(width)?, side(height)?);
        encoder.set_color(color_type(quantiser.channels()));
        encoder.set_depth(bit_depth(quantiser.depth()));
        if quantiser.kind() == MapKind::Color {
            encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        } else {
            encoder.set_source_gamma(ScaledFloat::new(1.0));
        }
        let sink = Sink {
            writer: encoder.write_header().map_err(problem)?,
            told: Vec::with_capacity(height),
            hashes: Vec::new(),
            adler: 1,
            // The head of a zlib stream: deflate, a window of 32 KiB.
            chunk: vec![0x78, 0x01],
            held: 2,
        };
        Ok(Self {
            sink,
            compression,
            hashed,
            size: (width * quantiser.channels(), height),
            strip_rows: strip::rows(compression, quantiser.row_bytes()),
            next: 0,
            made: Vec::new(),
            room,
        })
    }

    /// The first row that is not encoded.
    pub(in crate::io) fn next(&self) -> usize {
        self.next
    }

    /// Rows of the whole file.
    pub(in crate::io) fn height(&self) -> usize {
        self.size.1
    }

    /// Encode the strips that lie before row `end`: the quantiser holds all rows from [`Stream::next`] to there.
    pub(in crate::io) fn advance(
        &mut self,
        quantiser: &Quantiser<'_>,
        end: usize,
        watched: Watched<'_>,
    ) -> Result<(), Problem> {
        let (height, rows) = (self.size.1, self.strip_rows);
        let strips = (self.next..end).step_by(rows).map(|first| first..(first + rows).min(height));
        let strips: Vec<_> = strips.filter(|strip| strip.end <= end).collect();
        for batch in strips.chunks(2 * rayon::current_num_threads().max(1)) {
            let before = std::mem::take(&mut self.made);
            let Self { sink, room, compression, hashed, .. } = self;
            let encode = |rows: &std::ops::Range<usize>| {
                let strip = || strip::encode(quantiser, *compression, rows.clone(), *hashed, room);
                watched.piece(Work::Encode, strip)
            };
            let (put, made) = rayon::join(
                || sink.put(before, room, watched),
                || batch.par_iter().with_max_len(1).map(encode).collect::<Vec<_>>(),
            );
            put?;
            self.made = made.into_iter().collect::<Result<_, _>>()?;
            self.next = batch.last().map_or(self.next, |rows| rows.end);
        }
        Ok(())
    }

    /// End the file, all of whose rows are encoded; returns what was found out, and the hashes of its strips if they were
    /// asked for.
    pub(in crate::io) fn finish(self, watched: Watched<'_>) -> Result<(MapTold, Vec<blake3::Hash>), Problem> {
        let Self { mut sink, made, room, .. } = self;
        debug_assert_eq!(self.next, self.size.1, "rows are missing");
        sink.put(made, &room, watched)?;
        let Sink { mut writer, told, hashes, adler, mut chunk, held } = sink;
        // The last block, which is empty, and the checksum.
        chunk.truncate(held);
        chunk.extend([0x03, 0x00]);
        chunk.extend(adler.to_be_bytes());
        writer.write_chunk(::png::chunk::IDAT, &chunk).map_err(problem)?;
        writer.finish().map_err(problem)?;
        let (values, rows) = self.size;
        Ok((MapTold::of_rows(values * rows, told), hashes))
    }
}
