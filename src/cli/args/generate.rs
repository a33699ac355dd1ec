//! `generate`: presets, and what is made of each.

use std::ops::Range;
use std::path::PathBuf;
use std::str::FromStr;

use clap::{Args, ValueEnum};

use super::{Set, SizeArg};
use crate::base::MapKind;
use crate::cli::exit::{Exit, Failure};
use crate::io::NameTemplate;
use crate::maps::Depth;
use crate::preset::suggest;

const GENERATE_EXAMPLES: &str = "Examples:
  ophidian generate lampropeltis_triangulum -o out
  ophidian generate presets/*.toml --size 1024 -o out       many presets, a set each
  ophidian generate milk_snake.toml --seeds 0..50           fifty individuals
  ophidian generate milk_snake.toml --set pattern.size=0.3  another value, same checks
  ophidian generate milk_snake.toml --size 512x1024 --format png,exr --depth 16 --verify";

/// `generate`
#[derive(Debug, Args)]
#[command(after_help = format!("{GENERATE_EXAMPLES}\n\n{}", Exit::TABLE))]
pub(in crate::cli) struct Generate {
    /// Built-in presets by scientific or common name, or preset files.
    #[arg(required = true, value_name = "PRESET")]
    pub(in crate::cli) presets: Vec<String>,
    /// Directory of the files; it is made if need be.
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub(in crate::cli) output: PathBuf,
    /// Texels on the longer side (64 to 16384 are sensible), or exactly WIDTHxHEIGHT.
    #[arg(long, default_value = "2048", value_name = "N|WxH")]
    pub(in crate::cli) size: SizeArg,
    /// The individual; the preset's own unless set.
    #[arg(long, conflicts_with = "seeds")]
    pub(in crate::cli) seed: Option<u64>,
    /// Several individuals, the last one excluded: 0..50 makes fifty sets.
    #[arg(long, value_name = "A..B")]
    pub(in crate::cli) seeds: Option<SeedsArg>,
    /// Maps, with commas: color, height, normal, roughness, iridescence, ambient_occlusion, curvature, translucency,
    /// scale_id, pattern_mask; or `five` for the first five; or `all` that the preset has.
    #[arg(long, default_value = "all")]
    pub(in crate::cli) maps: MapsArg,
    #[command(flatten)]
    pub(in crate::cli) set: Set,
    /// File formats, with commas; exr-layers is one file of all maps.
    #[arg(long, value_delimiter = ',', default_value = "png")]
    pub(in crate::cli) format: Vec<Format>,
    /// Bits of PNG samples, for all maps or by map: `16` or `color=16,normal=16`.
    #[arg(long, value_name = "BITS")]
    pub(in crate::cli) depth: Option<DepthArg>,
    /// Time spent to make PNG files smaller.
    #[arg(long, value_enum, default_value = "fast")]
    pub(in crate::cli) compress: CompressArg,
    /// Compression of OpenEXR files; all are lossless.
    #[arg(long, value_enum, default_value = "piz")]
    pub(in crate::cli) exr_compress: ExrCompressArg,
    /// Which way the green of normals points: OpenGL up, DirectX down, or a file of each.
    #[arg(long, value_enum, default_value = "gl")]
    pub(in crate::cli) normal: NormalArg,
    /// File names, with {preset}, {map}, {seed}, {size} and {ext}.
    #[arg(long, value_name = "TEMPLATE")]
    pub(in crate::cli) name: Option<String>,
    /// Threads; all cores unless set. The files do not depend on it.
    #[arg(long, env = "OPHIDIAN_THREADS", value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(in crate::cli) threads: Option<u16>,
    /// Most memory for maps, such as 4G or 512M; what is free unless set. PNG files that need more are made some hundred
    /// rows at a time; other formats are refused.
    #[arg(long, value_name = "SIZE")]
    pub(in crate::cli) memory: Option<BytesArg>,
    /// Read every file back and compare before it takes its name.
    #[arg(long)]
    pub(in crate::cli) verify: bool,
    /// Write where the time went, by thread, as a trace that ui.perfetto.dev opens.
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) trace: Option<PathBuf>,
    /// Print the times of every node and file of each set.
    #[arg(long)]
    pub(in crate::cli) stats: bool,
    /// Print nothing but problems.
    #[arg(short, long)]
    pub(in crate::cli) quiet: bool,
    /// Print one JSON object per set on standard output.
    #[arg(long)]
    pub(in crate::cli) json: bool,
}

/// Seeds, the last excluded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::cli) struct SeedsArg(pub(in crate::cli) Range<u64>);

impl FromStr for SeedsArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || "write two whole numbers, such as 0..50 (0 to 49) or 1..=50 (1 to 50)".to_owned();
        let (a, b) = text.split_once("..").ok_or_else(bad)?;
        let a: u64 = a.trim().parse().map_err(|_| bad())?;
        let end = match b.strip_prefix('=') {
            Some(b) => b.trim().parse::<u64>().ok().and_then(|b| b.checked_add(1)),
            None => b.trim().parse().ok(),
        };
        let b = end.ok_or_else(bad)?;
        if a >= b {
            return Err(format!(
                "{text} is empty; the end is excluded: {a}..{} is one set",
                a.saturating_add(1)
            ));
        }
        Ok(Self(a..b))
    }
}

/// Which maps.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::cli) enum MapsArg {
    /// All that the preset has.
    All,
    /// These.
    List(Vec<MapKind>),
}

impl FromStr for MapsArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut list = Vec::new();
        for word in text.split(',').map(str::trim) {
            match word {
                "all" => return Ok(Self::All),
                "five" => list.extend(MapKind::FIVE),
                _ => list.push(map_kind(word)?),
            }
        }
        list.sort();
        list.dedup();
        Ok(Self::List(list))
    }
}

fn map_kind(word: &str) -> Result<MapKind, String> {
    MapKind::from_name(word).ok_or_else(|| {
        let mut names = MapKind::ALL.map(MapKind::name).to_vec();
        names.extend(["five", "all"]);
        let help = suggest::help(word, &names).unwrap_or_default();
        format!("there is no map `{word}`; {help}")
    })
}

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum Format {
    /// A PNG per map.
    Png,
    /// An OpenEXR file per map, in physical units.
    Exr,
    /// One OpenEXR file with a layer per map.
    ExrLayers,
}

/// Compression of PNG files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum CompressArg {
    /// Huffman codes only.
    Fast,
    /// A quick search for repeats, too, where it helps.
    Balanced,
    /// A thorough search, behind several filters.
    Small,
}

/// Compression of OpenEXR files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum ExrCompressArg {
    /// Wavelets and Huffman codes: best for images with grain.
    Piz,
    /// Deflate, 16 lines a block.
    Zip,
    /// None.
    None,
}

/// Which normal maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(in crate::cli) enum NormalArg {
    /// Green up: glTF, Blender, Godot, Unity.
    Gl,
    /// Green down: Unreal.
    Dx,
    /// A file of each.
    Both,
}

/// Depths of PNG files, all or by map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::cli) struct DepthArg(pub(in crate::cli) Vec<(MapKind, Depth)>);

impl FromStr for DepthArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let depth = |text: &str| match text {
            "8" => Ok(Depth::Eight),
            "16" => Ok(Depth::Sixteen),
            _ => Err("depths are 8 and 16: write one for all maps, or by map, color=16,normal=8".to_owned()),
        };
        let mut list = Vec::new();
        for part in text.split(',').map(str::trim) {
            match part.split_once('=') {
                Some((map, bits)) => list.push((map_kind(map)?, depth(bits)?)),
                None => {
                    let depth = depth(part)?;
                    list.extend(MapKind::ALL.map(|kind| (kind, depth)));
                }
            }
        }
        Ok(Self(list))
    }
}

/// An amount of memory, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cli) struct BytesArg(pub(in crate::cli) u64);

impl FromStr for BytesArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let bad = || "write a number with K, M, G or T, such as 4G or 512M (powers of 1024)".to_owned();
        let text = text.trim();
        let text = text.strip_suffix(['B', 'b']).unwrap_or(text);
        let text = text.strip_suffix(['i']).unwrap_or(text);
        let shift = match text.chars().last().map(|c| c.to_ascii_uppercase()) {
            Some('K') => 10,
            Some('M') => 20,
            Some('G') => 30,
            Some('T') => 40,
            _ => 0,
        };
        let digits = if shift > 0 { &text[..text.len() - 1] } else { text };
        let number: f64 = digits.parse().map_err(|_| bad())?;
        let bytes = number * (1u64 << shift) as f64;
        if bytes >= 0.0 && bytes < u64::MAX as f64 { Ok(Self(bytes as u64)) } else { Err(bad()) }
    }
}

/// The template of file names: the one given, or one that keeps several seeds apart.
pub(in crate::cli) fn names(given: Option<&str>, several_seeds: bool) -> Result<NameTemplate, Failure> {
    let text =
        given.unwrap_or(if several_seeds { "{preset}_{seed}_{map}.{ext}" } else { "{preset}_{map}.{ext}" });
    if several_seeds && !text.contains("{seed}") {
        let help = "put {seed} into it: {preset}_{seed}_{map}.{ext}";
        return Err(Failure::usage("--name gives every seed the same file names", help));
    }
    text.parse().map_err(|e| Failure::usage(e, "such as {preset}_{map}.{ext}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_are_ranges_that_hold_something() {
        assert_eq!("3..5".parse(), Ok(SeedsArg(3..5)));
        assert_eq!("3..=5".parse(), Ok(SeedsArg(3..6)));
        for bad in ["5..5", "6..5", "5", "..", "a..b", "0..=18446744073709551615", "-1..3"] {
            assert!(bad.parse::<SeedsArg>().is_err(), "{bad}");
        }
    }

    #[test]
    fn maps_are_names_five_or_all() {
        assert_eq!("five".parse(), Ok(MapsArg::List(MapKind::FIVE.to_vec())));
        assert_eq!("normal,color,normal".parse(), Ok(MapsArg::List(vec![MapKind::Color, MapKind::Normal])));
        let error = "colour".parse::<MapsArg>().expect_err("British");
        assert!(error.contains("did you mean `color`"), "{error}");
    }

    #[test]
    fn memory_has_units_of_1024() {
        for (text, bytes) in
            [("4G", 4 << 30), ("512MiB", 512 << 20), ("1.5k", 1536), ("7", 7), ("1TB", 1 << 40)]
        {
            assert_eq!(text.parse(), Ok(BytesArg(bytes)), "{text}");
        }
        for bad in ["", "G", "-1G", "lots", "nan", "1e30G"] {
            assert!(bad.parse::<BytesArg>().is_err(), "{bad}");
        }
    }

    #[test]
    fn depths_are_for_all_or_by_map() {
        let of = |text: &str| text.parse::<DepthArg>().map(|d| d.0);
        assert_eq!(of("color=16"), Ok(vec![(MapKind::Color, Depth::Sixteen)]));
        assert_eq!(of("16").map(|d| d.len()), Ok(10));
        assert!(of("12").is_err() && of("colour=8").is_err());
    }
}
