//! Strips of an image: quantised, filtered and deflated apart, so that all cores work on one map.
//!
//! A strip reads nothing of its neighbours (its first row is filtered within itself, its matches reach no further), and
//! ends at a byte: one after another they are one zlib stream. Where strips begin depends on the size of the map only, and
//! so do the bytes.

use std::ops::Range;

use zlib_rs::{Deflate, DeflateConfig, DeflateFlush, Status};

use super::filter::{self, Filter};
use super::{PngCompression, huffman};
use crate::base::kept::Kept;
use crate::io::Problem;
use crate::maps::{Quantiser, RowTold};

/// Bytes of a strip, about: its samples and what becomes of them stay in the second cache.
const FAST_BYTES: usize = 1 << 17;
/// The same where repeats are looked for: they are found within a strip only.
const SEARCHED_BYTES: usize = 1 << 19;
/// Rows of a strip at least: its first row is filtered less well.
const LEAST_ROWS: usize = 8;

/// How filtered bytes are compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coder {
    /// [`huffman`].
    Huffman,
    /// zlib with a search for repeats of this level, 2 to 9 (level 1 of zlib-rs 0.6.8 panics on noise).
    Zlib(i32),
}

/// What is tried on each strip; the smallest is kept.
///
/// Measured on the maps of built-in presets (`benches/README.md`, "Compression"): Huffman codes alone are as good as a search on
/// heights, normals and roughness, whatever the level; a search finds something in patterns of flat colour, more of
/// it behind the plainer filters.
pub(super) fn candidates(compression: PngCompression) -> &'static [(Filter, Coder)] {
    use Coder::{Huffman, Zlib};
    match compression {
        PngCompression::Fast => &[(Filter::Paeth, Huffman)],
        PngCompression::Balanced => {
            &[(Filter::Paeth, Huffman), (Filter::Sub, Zlib(3)), (Filter::Up, Zlib(3))]
        }
        PngCompression::Small => &[
            (Filter::Paeth, Huffman),
            (Filter::Sub, Zlib(6)),
            (Filter::Up, Zlib(6)),
            (Filter::Paeth, Zlib(6)),
        ],
    }
}

/// Rows of a strip of such a map.
pub(super) fn rows(compression: PngCompression, row_bytes: usize) -> usize {
    let bytes = if compression == PngCompression::Fast { FAST_BYTES } else { SEARCHED_BYTES };
    (bytes / row_bytes.max(1)).max(LEAST_ROWS)
}

/// Some rows of a map, compressed.
pub(super) struct Strip {
    /// Whole deflate blocks, none of them the last one, up to the end of a byte; and room behind them.
    pub(super) bytes: Vec<u8>,
    /// Bytes of the blocks.
    pub(super) used: usize,
    /// Adler-32 of what they hold.
    pub(super) adler: u32,
    /// Bytes of what they hold.
    pub(super) length: u64,
    /// What encoding found out about the rows.
    pub(super) told: Vec<RowTold>,
    /// BLAKE3 of the samples, where they will be compared.
    pub(super) samples: Option<blake3::Hash>,
}

/// Memory that the strips of all files of a set use again: fresh pages cost more than what is written to them.
#[derive(Default)]
pub(in crate::io) struct Room {
    /// Of each thread.
    scratch: Kept<Scratch>,
    /// Of compressed strips that are written.
    pub(super) bytes: Kept<Vec<u8>>,
}

/// Buffers that strips of one thread use again.
#[derive(Default)]
struct Scratch {
    codes: Vec<u16>,
    samples: Vec<u8>,
    filtered: Vec<u8>,
    tried: Vec<u8>,
}

/// Encode the rows of a strip.
pub(super) fn encode(
    quantiser: &Quantiser<'_>,
    compression: PngCompression,
    strip_rows: Range<usize>,
    hashed: bool,
    room: &Room,
) -> Result<Strip, Problem> {
    let mut scratch = room.scratch.borrow();
    let Scratch { codes, samples, filtered, tried } = &mut *scratch;
    let row_bytes = quantiser.row_bytes();
    samples.resize(strip_rows.len() * row_bytes, 0);
    let told = samples.chunks_exact_mut(row_bytes).zip(strip_rows).map(|(row, y)| {
        quantiser.row(y, codes, row);
        quantiser.told(y, codes)
    });
    let told = told.collect();
    let hash = hashed.then(|| blake3::hash(samples));
    let bytes = room.bytes.take().unwrap_or_default();
    let mut strip = Strip { told, bytes, used: usize::MAX, adler: 1, length: 0, samples: hash };
    let texel_bytes = row_bytes / quantiser.width();
    for &(filter, coder) in candidates(compression) {
        filter::rows(samples, row_bytes, texel_bytes, filter, filtered);
        let length = match coder {
            Coder::Huffman => huffman::compress(filtered, tried),
            Coder::Zlib(level) => zlib(filtered, level, tried)?,
        };
        if length < strip.used {
            std::mem::swap(&mut strip.bytes, tried);
            strip.used = length;
            strip.adler = zlib_rs::adler32::adler32(1, filtered);
            strip.length = filtered.len() as u64;
        }
    }
    Ok(strip)
}

/// Deflate blocks by zlib-rs up to the end of a byte; as [`huffman::compress`].
fn zlib(bytes: &[u8], level: i32, out: &mut Vec<u8>) -> Result<usize, Problem> {
    let config = DeflateConfig { level, window_bits: -15, ..DeflateConfig::default() };
    let mut deflate = Deflate::new_with_config(config);
    // Its bound on a stream, and the empty block of the flush.
    out.resize(zlib_rs::compress_bound(bytes.len()) + 16, 0);
    let bad = |message: String| Problem::Format { format: "PNG", message };
    let status = deflate.compress(bytes, out, DeflateFlush::SyncFlush).map_err(|e| bad(e.as_str().into()))?;
    if status != Status::Ok || deflate.total_in() != bytes.len() as u64 {
        return Err(bad(format!("{} of {} bytes were compressed", deflate.total_in(), bytes.len())));
    }
    Ok(deflate.total_out() as usize)
}
