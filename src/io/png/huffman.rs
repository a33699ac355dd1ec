//! Deflate (RFC 1951) by Huffman codes and runs of zeros, without a search for repeats.
//!
//! Filtered rows of grainy maps hold zeros and small numbers but few repeats: a search takes ten times as long and often
//! makes the file larger, because a match costs more than the short codes it stands for. Counting first and coding
//! after makes the size of a block exact before it is written, so there is one buffer and no growth.

mod packed;

use self::packed::Packed;
use crate::multiversion;

/// Longest code: four of them and the rest of a byte fit in 64 bits, so that four symbols are written at once.
const MAX_BITS: usize = 12;
/// Longest code of the alphabet that tells the lengths of the codes.
const MAX_META_BITS: usize = 7;
/// Eight zeros, at least so often in a row, are told as a run: below it, codes of one bit are no longer.
const RUN_WORDS: usize = 2;
/// Bytes of a block at most: each has its own codes.
const BLOCK: usize = 1 << 15;
/// The symbol that ends a block; those above it are lengths of runs.
const END: usize = 256;
/// Literals, the end and the lengths.
const SYMBOLS: usize = 286;
/// Greatest length of a repeat.
const MAX_REPEAT: usize = 258;
/// The order in which the lengths of the meta codes are told.
const META_ORDER: [usize; 19] = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];

/// Compress `bytes` into `out`: whole blocks, none of them marked as the last one of a stream, up to the end of a byte.
/// Returns their length, at most that of `bytes` and 5 bytes in 32 KiB; what lies behind it in `out`, which grows where it
/// must, is room for the next time.
pub(super) fn compress(bytes: &[u8], out: &mut Vec<u8>) -> usize {
    let mut bits = BitWriter { out, at: 0, bits: 0, count: 0 };
    let mut packed = Packed::default();
    for block in bytes.chunks(BLOCK) {
        let counts = Counts::of(block);
        let codes = Codes::new(&counts);
        let size = codes.bits_of(&counts);
        if size >= 8 * block.len() {
            bits.stored(block);
        } else {
            bits.reserve(size);
            bits.within(|bits| codes.tell(bits));
            let literals = codes.literals();
            packed.set(block, &literals);
            bits.within(|bits| {
                coded(block, &codes.symbols, &literals, &packed, bits);
                bits.put(codes.symbols[END]);
            });
        }
    }
    bits.align()
}

/// What a block consists of.
trait Tokens {
    fn literal(&mut self, byte: u8);
    /// The byte before, again so often: 3 to 258.
    fn repeat(&mut self, length: usize);

    /// The bytes from `8 i` on.
    fn word(&mut self, i: usize, word: &[u8; 8]);

    #[inline(always)]
    fn zeros(&mut self, count: usize) {
        self.literal(0);
        let mut rest = count - 1;
        while rest >= 3 {
            let length = rest.min(MAX_REPEAT);
            self.repeat(length);
            rest -= length;
        }
        for _ in 0..rest {
            self.literal(0);
        }
    }
}

multiversion! {
    fn counted(block: &[u8], counts: &mut Counts) { tokens(block, counts) }
}

multiversion! {
    /// Wider sets have shifts by a register that take one step instead of three.
    fn coded(
        block: &[u8],
        codes: &[Code; SYMBOLS],
        literals: &[u32; 256],
        packed: &Packed,
        bits: &mut Bits<'_>,
    ) {
        let mut own = Bits { out: &mut *bits.out, ..*bits };
        tokens(block, &mut Coded { codes, literals, packed, bits: &mut own });
        (bits.at, bits.bits, bits.count) = (own.at, own.bits, own.count);
    }
}

/// Tell the tokens of a block, the same at every call.
#[inline(always)]
fn tokens(block: &[u8], to: &mut impl Tokens) {
    let (words, tail) = block.as_chunks::<8>();
    let mut i = 0;
    while i < words.len() {
        if u64::from_ne_bytes(words[i]) != 0 {
            to.word(i, &words[i]);
            i += 1;
            continue;
        }
        let zeros = words[i..].iter().take_while(|&&w| u64::from_ne_bytes(w) == 0).count();
        if zeros >= RUN_WORDS {
            to.zeros(8 * zeros);
        } else {
            (i..i + zeros).for_each(|i| to.word(i, &[0; 8]));
        }
        i += zeros;
    }
    for &byte in tail {
        to.literal(byte);
    }
}

/// How often each symbol occurs.
struct Counts {
    /// A table for each byte of a word, because a count that was just written is slow to read; none exceeds [`BLOCK`].
    literals: [[u16; 256]; 8],
    lengths: [u32; SYMBOLS - END - 1],
}

impl Counts {
    fn of(block: &[u8]) -> Self {
        let mut counts = Self { literals: [[0; 256]; 8], lengths: [0; SYMBOLS - END - 1] };
        counted(block, &mut counts);
        counts
    }

    fn symbols(&self) -> [u32; SYMBOLS] {
        let mut symbols = [0; SYMBOLS];
        for table in &self.literals {
            for (sum, &n) in symbols.iter_mut().zip(table) {
                *sum += u32::from(n);
            }
        }
        symbols[END] = 1;
        symbols[END + 1..].copy_from_slice(&self.lengths);
        symbols
    }
}

impl Tokens for Counts {
    fn literal(&mut self, byte: u8) {
        self.literals[0][usize::from(byte)] += 1;
    }

    #[inline(always)]
    fn word(&mut self, _: usize, word: &[u8; 8]) {
        for (table, &byte) in self.literals.iter_mut().zip(word) {
            table[usize::from(byte)] += 1;
        }
    }

    fn repeat(&mut self, length: usize) {
        self.lengths[length_symbol(length).0 - END - 1] += 1;
    }
}

/// The symbol of a repeat's length, its extra bits and how many there are (RFC 1951, 3.2.5).
#[inline(always)]
fn length_symbol(length: usize) -> (usize, u32, u32) {
    match length {
        MAX_REPEAT => (285, 0, 0),
        3..=6 => (END - 2 + length, 0, 0),
        _ => {
            let above = length - 3;
            let extra = above.ilog2() - 2;
            let quarter = (above >> extra) & 3;
            (END + 5 + 4 * extra as usize + quarter, (above & ((1 << extra) - 1)) as u32, extra)
        }
    }
}

/// Bits as they are written, and how many.
#[derive(Clone, Copy, Default)]
struct Code {
    bits: u16,
    count: u8,
}

/// The codes of a block, and how the block tells them.
struct Codes {
    symbols: [Code; SYMBOLS],
    meta: [Code; 19],
    /// Symbols of the meta alphabet, their extra bits and how many of those.
    told: Vec<(u8, u8, u8)>,
    /// Literals and lengths that are told; meta lengths that are told.
    told_counts: [usize; 2],
}

impl Codes {
    fn new(counts: &Counts) -> Self {
        let mut lengths = [0; SYMBOLS];
        code_lengths(&counts.symbols(), MAX_BITS, &mut lengths);
        let told_symbols = 1 + lengths.iter().rposition(|&n| n > 0).unwrap_or(END);
        // One distance, 1, of one bit.
        let mut all = lengths[..told_symbols].to_vec();
        all.push(1);
        let told = run_lengths(&all);
        let mut meta_counts = [0; 19];
        for &(symbol, _, _) in &told {
            meta_counts[usize::from(symbol)] += 1;
        }
        let mut meta = [0; 19];
        code_lengths(&meta_counts, MAX_META_BITS, &mut meta);
        let told_meta = 1 + META_ORDER.iter().rposition(|&s| meta[s] > 0).unwrap_or(3).max(3);
        Self {
            symbols: canonical(&lengths),
            meta: canonical(&meta),
            told,
            told_counts: [told_symbols, told_meta],
        }
    }

    /// Bits of a block with these counts.
    fn bits_of(&self, counts: &Counts) -> usize {
        let told = self.told.iter().map(|&(s, _, extra)| self.meta[usize::from(s)].count + extra);
        let header = 17 + 3 * self.told_counts[1] + told.map(usize::from).sum::<usize>();
        let of_symbols = counts.symbols();
        let coded = of_symbols.iter().zip(&self.symbols).map(|(&n, c)| n as usize * usize::from(c.count));
        // After a length come its extra bits and the bit of the distance.
        let after = counts.lengths.iter().enumerate().map(|(i, &n)| {
            let extra = if i < 28 { (i / 4).saturating_sub(1) } else { 0 };
            n as usize * (extra + 1)
        });
        header + coded.sum::<usize>() + after.sum::<usize>()
    }

    /// The literals' codes, each as its bits and, above them, how many those are.
    fn literals(&self) -> [u32; 256] {
        std::array::from_fn(|s| u32::from(self.symbols[s].bits) | u32::from(self.symbols[s].count) << 16)
    }

    /// The head of a block.
    fn tell(&self, to: &mut Bits<'_>) {
        // Not the last block; codes of its own.
        to.put_bits(0b100, 3);
        let [symbols, meta] = self.told_counts;
        to.put_bits((symbols - 257) as u64, 5);
        to.put_bits(0, 5);
        to.put_bits((meta - 4) as u64, 4);
        for &s in &META_ORDER[..meta] {
            to.put_bits(u64::from(self.meta[s].count), 3);
        }
        for &(symbol, value, extra) in &self.told {
            to.put(self.meta[usize::from(symbol)]);
            to.put_bits(u64::from(value), u32::from(extra));
        }
    }
}

/// Lengths of codes as meta symbols: repeats of the last one (16) and of zero (17, 18).
fn run_lengths(lengths: &[u8]) -> Vec<(u8, u8, u8)> {
    let mut told = Vec::new();
    for run in lengths.chunk_by(|a, b| a == b) {
        let (length, mut left) = (run[0], run.len());
        if length > 0 {
            told.push((length, 0, 0));
            left -= 1;
        }
        while left >= 3 {
            let n = match length {
                0 => left.min(138),
                _ => left.min(6),
            };
            told.push(match (length, n) {
                (0, 11..) => (18, (n - 11) as u8, 7),
                (0, _) => (17, (n - 3) as u8, 3),
                _ => (16, (n - 3) as u8, 2),
            });
            left -= n;
        }
        told.extend((0..left).map(|_| (length, 0, 0)));
    }
    told
}

/// Lengths of a prefix code for symbols that occur so often: Huffman's, cut to `limit` bits. A symbol that does not
/// occur has none; one that is alone has 1.
fn code_lengths(counts: &[u32], limit: usize, lengths: &mut [u8]) {
    lengths.fill(0);
    // Rarest first; a number is sorted faster than a pair.
    let mut leaves: Vec<u64> =
        counts.iter().zip(0..).filter(|(n, _)| **n > 0).map(|(&n, s)| u64::from(n) << 32 | s).collect();
    leaves.sort_unstable();
    let symbol = |leaf: u64| (leaf & 0xffff_ffff) as usize;
    if let [only] = leaves[..] {
        lengths[symbol(only)] = 1;
    }
    if leaves.len() < 2 {
        return;
    }
    // Nodes by weight: leaves, then pairs in the order they are made, which is ascending, too.
    let n = leaves.len();
    let mut weight: Vec<u64> = leaves.iter().map(|leaf| leaf >> 32).collect();
    let mut parent = vec![0; 2 * n - 1];
    let (mut leaf, mut pair) = (0, n);
    for made in n..2 * n - 1 {
        let mut sum = 0;
        for _ in 0..2 {
            let next = if leaf < n && (pair == made || weight[leaf] <= weight[pair]) {
                &mut leaf
            } else {
                &mut pair
            };
            parent[*next] = made;
            sum += weight[*next];
            *next += 1;
        }
        weight.push(sum);
    }
    let mut depth = vec![0usize; 2 * n - 1];
    let mut of_length = vec![0usize; limit + 1];
    for i in (0..2 * n - 2).rev() {
        depth[i] = depth[parent[i]] + 1;
        if i < n {
            of_length[depth[i].min(limit)] += 1;
        }
    }
    // What was cut takes more than there is: lengthen the longest of the others until the sum of 2^-length is 1.
    let mut taken: usize = of_length.iter().enumerate().skip(1).map(|(l, &k)| k << (limit - l)).sum();
    while taken > 1 << limit {
        let l = (1..limit).rev().find(|&l| of_length[l] > 0).unwrap_or(1);
        of_length[l] -= 1;
        of_length[l + 1] += 2;
        of_length[limit] -= 1;
        taken -= 1;
    }
    // The rarest get the longest.
    let longest_first = (1..=limit).rev().flat_map(|l| std::iter::repeat_n(l as u8, of_length[l]));
    for (&leaf, length) in leaves.iter().zip(longest_first) {
        lengths[symbol(leaf)] = length;
    }
}

/// The canonical codes of these lengths, first bit lowest (RFC 1951, 3.2.2).
fn canonical<const N: usize>(lengths: &[u8; N]) -> [Code; N] {
    let mut of_length = [0u16; 16];
    for &length in lengths {
        of_length[usize::from(length) % 16] += 1;
    }
    let mut next = [0u16; 16];
    let mut code = 0;
    for length in 1..16 {
        next[length] = code;
        code = (code + of_length[length]) << 1;
    }
    lengths.map(|count| {
        if count == 0 {
            return Code::default();
        }
        let code = &mut next[usize::from(count)];
        let bits = code.reverse_bits() >> (16 - count);
        *code += 1;
        Code { bits, count }
    })
}

/// Writes the tokens of a block by its codes.
struct Coded<'a, 'b> {
    codes: &'a [Code; SYMBOLS],
    /// Each literal's bits, and above them how many there are.
    literals: &'a [u32; 256],
    packed: &'a Packed,
    bits: &'a mut Bits<'b>,
}

impl Tokens for Coded<'_, '_> {
    #[inline(always)]
    fn literal(&mut self, byte: u8) {
        self.bits.put(self.codes[usize::from(byte)]);
    }

    #[inline(always)]
    fn word(&mut self, i: usize, word: &[u8; 8]) {
        if let Some((bits, count)) = self.packed.word(i) {
            return self.bits.put_bits(bits, count);
        }
        for half in word.as_chunks::<4>().0 {
            let (mut bits, mut count) = (0, 0);
            for &byte in half {
                let code = self.literals[usize::from(byte)];
                bits |= u64::from(code & 0xffff) << count;
                count += code >> 16;
            }
            self.bits.put_bits(bits, count);
        }
    }

    #[inline(always)]
    fn repeat(&mut self, length: usize) {
        let (symbol, value, extra) = length_symbol(length);
        self.bits.put(self.codes[symbol]);
        // The distance's only code is a zero.
        self.bits.put_bits(u64::from(value), extra + 1);
    }
}

/// Bits into bytes, lowest first.
struct Bits<'a> {
    /// Room that was reserved.
    out: &'a mut [u8],
    /// Where the next byte goes.
    at: usize,
    /// Fewer than 8 bits between calls.
    bits: u64,
    count: u32,
}

impl Bits<'_> {
    #[inline(always)]
    fn put(&mut self, code: Code) {
        self.put_bits(u64::from(code.bits), u32::from(code.count));
    }

    /// At most 56 bits.
    #[inline(always)]
    fn put_bits(&mut self, bits: u64, count: u32) {
        self.bits |= bits << self.count;
        self.count += count;
        self.out[self.at..self.at + 8].copy_from_slice(&self.bits.to_le_bytes());
        self.at += (self.count / 8) as usize;
        self.bits >>= self.count & !7;
        self.count &= 7;
    }
}

/// Blocks of bits, one after another.
struct BitWriter<'a> {
    out: &'a mut Vec<u8>,
    /// Where the next byte goes; what lies behind it in `out` is room.
    at: usize,
    bits: u64,
    count: u32,
}

impl BitWriter<'_> {
    /// Make room for so many bits.
    fn reserve(&mut self, bits: usize) {
        let end = self.at + bits / 8 + 16;
        if self.out.len() < end {
            self.out.resize(end, 0);
        }
    }

    /// Write into the room that was reserved. What is written with is a value of its own, so that a loop keeps it in registers.
    #[inline(always)]
    fn within(&mut self, write: impl FnOnce(&mut Bits<'_>)) {
        let mut bits = Bits { out: &mut self.out[self.at..], at: 0, bits: self.bits, count: self.count };
        write(&mut bits);
        (self.bits, self.count) = (bits.bits, bits.count);
        self.at += bits.at;
    }

    /// The bytes as they are.
    fn stored(&mut self, block: &[u8]) {
        for part in block.chunks(usize::from(u16::MAX)) {
            self.stored_head(part.len() as u16);
            self.reserve(8 * part.len());
            self.out[self.at..self.at + part.len()].copy_from_slice(part);
            self.at += part.len();
        }
    }

    /// The head of a stored block, which ends at a byte.
    fn stored_head(&mut self, length: u16) {
        self.reserve(64);
        self.within(|to| {
            to.put_bits(0, 3);
            to.put_bits(0, (8 - to.count) % 8);
            to.put_bits(u64::from(length) | u64::from(!length) << 16, 32);
        });
    }

    /// End at a byte, which is returned: an empty stored block does, where need be.
    fn align(mut self) -> usize {
        if self.count > 0 {
            self.stored_head(0);
        }
        self.at
    }
}

#[cfg(test)]
mod tests;
