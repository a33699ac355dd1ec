//! `manifest.json`: what a directory of texture sets holds, and whether it still does.
//!
//! One manifest for a directory, a record per set: preset, seed, size and hash, and each file with its content. Keys
//! are in one order; no time, path or machine is in it, so the same sets give the same bytes.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::atomic::{Aside, hash};
use super::{ExrCompression, IoError, PngCompression, Problem, names};
use crate::base::MapKind;
use crate::maps::{NormalFormat, QuantError, SetId};
use crate::optics::SkinOptics;

/// The manifest's name in its directory.
pub const FILE_NAME: &str = "manifest.json";

/// The version of the manifest's form that this crate writes and reads.
pub const FORMAT: u32 = 1;

/// Largest manifest that is read: a hundred thousand files are below it.
const MAX_BYTES: u64 = 1 << 27;

/// What a directory holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// [`FORMAT`].
    pub format: u32,
    /// The sets, by preset, seed and size.
    pub sets: Vec<SetRecord>,
}

/// One texture set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetRecord {
    /// Name of the preset.
    pub preset: String,
    /// The seed.
    pub seed: u64,
    /// Width and height in texels.
    pub size: [usize; 2],
    /// Width (girth) and height (length) in mm.
    pub size_mm: [f32; 2],
    /// BLAKE3 of the preset as evaluated, hexadecimal.
    pub preset_blake3: String,
    /// What the skin is made of, for whoever renders it; left out where the preset says nothing of it.
    #[serde(default, skip_serializing_if = "SkinOptics::is_empty")]
    pub material: SkinOptics,
    /// The crate that made it, and its version.
    pub generator: String,
    /// Its files, by name.
    pub files: Vec<ManifestEntry>,
}

/// One file of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManifestEntry {
    /// Name in the manifest's directory.
    pub file: String,
    /// How it is written.
    pub format: FileFormat,
    /// Size in bytes.
    pub bytes: u64,
    /// BLAKE3 of the file, hexadecimal.
    pub blake3: String,
    /// How it is compressed; left out where it is the usual way: `fast` for PNG, `piz` for OpenEXR.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compression: Option<Compression>,
    /// The maps it holds: one, unless it is a file of all maps.
    pub maps: Vec<MapRecord>,
}

/// Kind of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FileFormat {
    /// PNG, integers.
    Png,
    /// OpenEXR, floats.
    Exr,
}

/// How a file is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Compression {
    /// A PNG.
    Png(PngCompression),
    /// An OpenEXR file.
    Exr(ExrCompression),
}

impl From<PngCompression> for Compression {
    fn from(compression: PngCompression) -> Self {
        Self::Png(compression)
    }
}

impl From<ExrCompression> for Compression {
    fn from(compression: ExrCompression) -> Self {
        Self::Exr(compression)
    }
}

/// One map in a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapRecord {
    /// Which.
    pub map: MapKind,
    /// Channel names, in the order of the map's planes.
    pub channels: Vec<String>,
    /// Samples.
    pub sample: SampleKind,
    /// How samples become values.
    pub encoding: Encoding,
    /// Unit of the values; left out for pure numbers.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// The physical range: the values of the least and greatest integer sample; for floats, what the map may hold.
    pub range: [f32; 2],
    /// Which way green points; normals only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub normal_format: Option<NormalFormat>,
    /// Error of the integer samples, in the map's unit; left out for floats.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<QuantError>,
}

/// Type of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SampleKind {
    /// 8-bit integer.
    U8,
    /// 16-bit integer.
    U16,
    /// 16-bit float.
    F16,
    /// 32-bit float.
    F32,
}

/// How samples become values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Encoding {
    /// The sRGB transfer function; the value is linear light.
    Srgb,
    /// Linear in the range.
    Linear,
    /// The sample is the value.
    Value,
    /// The sample is the value's low 16 bits: ids beyond 65 535, which repeat. OpenEXR has them whole.
    IdLow16,
}

impl SetRecord {
    /// A set without files yet, made by this version.
    pub fn new(set: &SetId) -> Self {
        Self {
            preset: set.preset.clone(),
            seed: set.seed,
            size: [set.domain.width, set.domain.height],
            size_mm: [set.domain.girth_mm, set.domain.length_mm],
            preset_blake3: blake3::Hash::from_bytes(set.preset_hash).to_hex().to_string(),
            material: set.optics,
            generator: concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")).to_owned(),
            files: Vec::new(),
        }
    }

    fn key(&self) -> (&str, u64, [usize; 2]) {
        (&self.preset, self.seed, self.size)
    }

    fn made_alike(&self, other: &Self) -> bool {
        self.key() == other.key()
            && self.size_mm == other.size_mm
            && self.preset_blake3 == other.preset_blake3
            && self.material == other.material
            && self.generator == other.generator
    }
}

impl Manifest {
    /// A manifest of nothing.
    pub fn new() -> Self {
        Self { format: FORMAT, sets: Vec::new() }
    }

    /// Read the manifest of a directory.
    ///
    /// # Errors
    /// [`Problem::Manifest`] if it is damaged or of another form, with line and column; otherwise as any file.
    pub fn read(dir: &Path) -> Result<Self, IoError> {
        let path = dir.join(FILE_NAME);
        read(&path).map_err(|problem| problem.at(path))
    }

    /// Put a set in: it replaces the record of the same preset, seed and size, keeping those of its other files that
    /// were made by the same preset and version, and takes over files that another record names.
    pub fn insert(&mut self, mut set: SetRecord) {
        let written: BTreeSet<String> = set.files.iter().map(|f| f.file.clone()).collect();
        for old in &mut self.sets {
            old.files.retain(|f| !written.contains(&f.file));
            if old.made_alike(&set) {
                set.files.append(&mut old.files);
            }
        }
        self.sets.retain(|old| old.key() != set.key() && !old.files.is_empty());
        set.files.sort_by(|a, b| a.file.cmp(&b.file));
        let at = self.sets.partition_point(|old| old.key() < set.key());
        self.sets.insert(at, set);
    }

    /// The manifest's text.
    pub fn to_json(&self) -> String {
        let mut text = serde_json::to_string_pretty(self).expect("a manifest is plain data");
        text.push('\n');
        text
    }
}

impl Default for Manifest {
    fn default() -> Self {
        Self::new()
    }
}

fn read(path: &Path) -> Result<Manifest, Problem> {
    #[derive(Deserialize)]
    struct Form {
        format: u32,
    }
    let damaged = |e: serde_json::Error| Problem::Manifest(e.to_string());
    let file = File::open(path)?;
    if file.metadata()?.is_dir() {
        return Err(Problem::IsADirectory);
    }
    let mut text = Vec::new();
    file.take(MAX_BYTES + 1).read_to_end(&mut text)?;
    if text.len() as u64 > MAX_BYTES {
        return Err(Problem::Manifest(format!("it is larger than {MAX_BYTES} bytes")));
    }
    let form: Form = serde_json::from_slice(&text).map_err(damaged)?;
    if form.format != FORMAT {
        return Err(Problem::Manifest(format!("its form is {}, this version knows {FORMAT}", form.format)));
    }
    let manifest: Manifest = serde_json::from_slice(&text).map_err(damaged)?;
    for file in manifest.sets.iter().flat_map(|set| &set.files) {
        // A name that leaves the directory would make `verify` read files that are nobody's business.
        names::check(&file.file).map_err(|e| Problem::Manifest(e.to_string()))?;
    }
    Ok(manifest)
}

/// Record a set in the manifest of `dir`, beside the sets that are there.
///
/// Processes that do so at once wait for each other (on Unix; elsewhere the last one wins).
///
/// # Errors
/// If there is a manifest that cannot be read (it is not overwritten), or it cannot be written.
pub(super) fn record(dir: &Path, set: SetRecord) -> Result<(), IoError> {
    // The lock ends with the handle. File systems without locks have none to offer: go on.
    #[cfg(unix)]
    let lock = File::open(if dir.as_os_str().is_empty() { Path::new(".") } else { dir });
    #[cfg(unix)]
    let _held = lock.as_ref().map(File::lock);

    let mut manifest = match Manifest::read(dir) {
        Err(IoError { problem: Problem::NotFound, .. }) => Manifest::new(),
        read => read?,
    };
    manifest.insert(set);
    let text = manifest.to_json();
    Aside::write(dir.join(FILE_NAME), |out| Ok(out.write_all(text.as_bytes())?))?.commit()
}

/// How a file compares with its record.
#[derive(Debug)]
pub enum FileStatus {
    /// It is what was written.
    Same,
    /// It is not there.
    Missing,
    /// Its content differs.
    Changed,
    /// It cannot be read.
    Unreadable(Problem),
}

/// One recorded file, compared.
#[derive(Debug)]
pub struct FileCheck {
    /// Name in the directory.
    pub file: String,
    /// How it compares.
    pub status: FileStatus,
}

/// A directory compared with its manifest.
#[derive(Debug)]
pub struct VerifyReport {
    /// Every recorded file, in the order of the manifest.
    pub files: Vec<FileCheck>,
    /// Files that no record names, sorted; they are no fault.
    pub extra: Vec<String>,
}

impl VerifyReport {
    /// Whether every recorded file is what was written.
    pub fn is_same(&self) -> bool {
        self.files.iter().all(|f| matches!(f.status, FileStatus::Same))
    }
}

/// Hash every file that the manifest of `dir` records, in parallel, and compare.
///
/// # Errors
/// If the directory or its manifest cannot be read; faults of the files are in the report.
pub fn verify_dir(dir: &Path) -> Result<VerifyReport, IoError> {
    let manifest = Manifest::read(dir)?;
    let entries: Vec<&ManifestEntry> = manifest.sets.iter().flat_map(|set| &set.files).collect();
    let files = entries
        .par_iter()
        .map(|entry| FileCheck { file: entry.file.clone(), status: compare(&dir.join(&entry.file), entry) })
        .collect();
    let known: BTreeSet<&str> = entries.iter().map(|e| e.file.as_str()).chain([FILE_NAME]).collect();
    let mut extra = Vec::new();
    for found in std::fs::read_dir(dir).map_err(|e| Problem::from(e).at(dir))? {
        let found = found.map_err(|e| Problem::from(e).at(dir))?;
        let name = found.file_name().to_string_lossy().into_owned();
        if !known.contains(name.as_str()) && !found.path().is_dir() {
            extra.push(name);
        }
    }
    extra.sort();
    Ok(VerifyReport { files, extra })
}

fn compare(path: &Path, entry: &ManifestEntry) -> FileStatus {
    let found = File::open(path).and_then(|mut file| hash(&mut file)).map_err(Problem::from);
    match found {
        Ok((_, blake3)) if blake3.to_hex().as_str() == entry.blake3 => FileStatus::Same,
        Ok(_) => FileStatus::Changed,
        Err(Problem::NotFound) => FileStatus::Missing,
        Err(problem) => FileStatus::Unreadable(problem),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Domain;

    fn set(preset: &str, seed: u64, hash: u8, files: &[&str]) -> SetRecord {
        let id = SetId {
            domain: Domain::square(8),
            preset: preset.into(),
            seed,
            preset_hash: [hash; 32],
            optics: Default::default(),
        };
        let file = |f: &&str| ManifestEntry {
            file: (*f).to_owned(),
            format: FileFormat::Png,
            bytes: 3,
            blake3: blake3::hash(f.as_bytes()).to_hex().to_string(),
            compression: None,
            maps: Vec::new(),
        };
        SetRecord { files: files.iter().map(file).collect(), ..SetRecord::new(&id) }
    }

    fn names(manifest: &Manifest) -> Vec<(String, u64, Vec<String>)> {
        let files = |s: &SetRecord| s.files.iter().map(|f| f.file.clone()).collect();
        manifest.sets.iter().map(|s| (s.preset.clone(), s.seed, files(s))).collect()
    }

    #[test]
    fn sets_stand_beside_each_other_in_order() {
        let sets = [set("boa", 1, 0, &["b", "a"]), set("boa", 0, 0, &["c"]), set("ana", 5, 0, &["d"])];
        let of = |order: [usize; 3]| {
            let mut manifest = Manifest::new();
            for i in order {
                manifest.insert(sets[i].clone());
            }
            manifest
        };
        let manifest = of([0, 1, 2]);
        let expected = [("ana", 5, vec!["d"]), ("boa", 0, vec!["c"]), ("boa", 1, vec!["a", "b"])];
        let expected =
            expected.map(|(p, s, f)| (p.to_owned(), s, f.into_iter().map(str::to_owned).collect()));
        assert_eq!(names(&manifest), expected);
        assert_eq!(manifest, of([2, 1, 0]), "whatever the order of writing");
    }

    #[test]
    fn writing_again_keeps_what_still_belongs_and_drops_what_was_overwritten() {
        let mut manifest = Manifest::new();
        manifest.insert(set("boa", 1, 0, &["color", "height"]));
        // More maps of the same set.
        manifest.insert(set("boa", 1, 0, &["height", "normal"]));
        assert_eq!(names(&manifest)[0].2, ["color", "height", "normal"]);
        // The preset was edited: its older files belong to another skin.
        manifest.insert(set("boa", 1, 9, &["color"]));
        assert_eq!(names(&manifest), [("boa".into(), 1, vec!["color".into()])]);
        // Another seed under the same names takes them over.
        manifest.insert(set("boa", 2, 9, &["color"]));
        assert_eq!(names(&manifest), [("boa".into(), 2, vec!["color".into()])]);
    }

    #[test]
    fn text_reads_back_and_damage_is_told_with_its_line() {
        let dir = tempfile::tempdir().unwrap();
        let mut manifest = Manifest::new();
        manifest.insert(set("boa", u64::MAX, 0, &["a.png"]));
        let write = |text: &str| std::fs::write(dir.path().join(FILE_NAME), text).unwrap();
        write(&manifest.to_json());
        assert_eq!(Manifest::read(dir.path()).unwrap(), manifest);
        let message = |text: &str| {
            write(text);
            match Manifest::read(dir.path()).unwrap_err().problem {
                Problem::Manifest(message) => message,
                other => panic!("{other}"),
            }
        };
        let text = manifest.to_json();
        assert!(message(&text[..text.len() / 2]).contains("line"));
        assert!(message(&text.replace("\"seed\"", "\"sead\"")).contains("line 6"));
        assert!(message(&text.replace("\"format\": 1", "\"format\": 2")).contains("form is 2"));
        assert!(message(&text.replace("a.png", "../a.png")).contains("../a.png"));
        assert!(message("").contains("line 1"));
        assert!(message(&"[".repeat(100_000)).contains("line 1"), "deep nesting is refused");
        // A damaged manifest is never overwritten.
        assert!(record(dir.path(), set("boa", 0, 0, &["b.png"])).is_err());
        assert_eq!(std::fs::read_to_string(dir.path().join(FILE_NAME)).unwrap(), "[".repeat(100_000));
    }

    #[test]
    fn verify_tells_missing_changed_and_extra_files() {
        let dir = tempfile::tempdir().unwrap();
        assert!(matches!(verify_dir(dir.path()).unwrap_err().problem, Problem::NotFound));
        let files = ["a", "b", "c"];
        for file in files {
            std::fs::write(dir.path().join(file), file).unwrap();
        }
        record(dir.path(), set("boa", 0, 0, &files)).unwrap();
        let report = verify_dir(dir.path()).unwrap();
        assert!(report.is_same() && report.extra.is_empty() && report.files.len() == 3);
        // One bit.
        std::fs::write(dir.path().join("b"), [b'b' ^ 1]).unwrap();
        std::fs::remove_file(dir.path().join("c")).unwrap();
        std::fs::write(dir.path().join("d"), "d").unwrap();
        let report = verify_dir(dir.path()).unwrap();
        let status: Vec<_> = report.files.iter().map(|f| &f.status).collect();
        assert!(
            matches!(status[..], [FileStatus::Same, FileStatus::Changed, FileStatus::Missing]),
            "{status:?}"
        );
        assert!(!report.is_same());
        assert_eq!(report.extra, ["d"]);
    }

    #[test]
    fn many_writers_at_once_lose_no_set() {
        let dir = tempfile::tempdir().unwrap();
        (0..24u64).into_par_iter().for_each(|seed| {
            record(dir.path(), set("boa", seed, 0, &[&format!("{seed}.png")])).unwrap();
        });
        let sets = Manifest::read(dir.path()).unwrap().sets.len();
        if cfg!(unix) {
            assert_eq!(sets, 24);
        } else {
            println!("SKIPPED: no lock on directories here ({sets} of 24)");
        }
    }
}
