//! A texture set into a directory: every file aside first, then all renamed, then the manifest.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::atomic::{Aside, make_dir};
use super::exr::channel_names;
use super::manifest::{
    self, Compression, Encoding, FileFormat, Manifest, ManifestEntry, MapRecord, SampleKind, SetRecord,
};
use super::stream::MapHead;
use super::{
    ExrCompression, ExrOptions, ExrSample, IoError, NameError, NameTemplate, PngCompression, Problem, exr,
    png,
};
use crate::base::MapKind;
use crate::base::watch::{Watch, Watched};
use crate::maps::{Depth, EncodeOptions, MapImage, MapTold, NormalFormat, SetId, TextureSet};

/// What files a set becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Output {
    /// A PNG per map.
    Png,
    /// An OpenEXR file per map.
    Exr,
    /// One OpenEXR file with a layer per map.
    ExrLayers,
}

/// How a set is written.
#[derive(Clone, Debug, PartialEq)]
pub struct WriteOptions {
    /// Which files; PNG unless set otherwise.
    pub outputs: BTreeSet<Output>,
    /// Their names.
    pub names: NameTemplate,
    /// Depth and dither of integers.
    pub encode: EncodeOptions,
    /// Compression of PNG.
    pub png: PngCompression,
    /// Samples and compression of OpenEXR.
    pub exr: ExrOptions,
    /// Decode every file and compare every sample before it is renamed.
    pub verify: bool,
}

impl Default for WriteOptions {
    fn default() -> Self {
        Self {
            outputs: [Output::Png].into(),
            names: NameTemplate::default(),
            encode: EncodeOptions::default(),
            png: PngCompression::default(),
            exr: ExrOptions::default(),
            verify: false,
        }
    }
}

/// A file that is written and checked, but not yet in its place. Dropped, it leaves nothing.
#[derive(Debug)]
pub struct Staged {
    aside: Aside,
    entry: ManifestEntry,
    extremes: Option<[f32; 2]>,
}

impl Staged {
    /// What the manifest will say of it.
    pub fn entry(&self) -> &ManifestEntry {
        &self.entry
    }

    /// Least and greatest finite value of the map, in its unit; `None` of files of floats, which hold any.
    pub fn extremes(&self) -> Option<[f32; 2]> {
        self.extremes
    }
}

/// Writes the maps of one set as they become ready, from any thread.
///
/// Nothing appears under its name before [`SetWriter::finish`]; dropped before it, nothing is left.
#[derive(Clone, Debug)]
pub struct SetWriter<'a> {
    pub(super) dir: PathBuf,
    set: SetId,
    pub(super) options: &'a WriteOptions,
    pub(super) watch: Option<&'a dyn Watch>,
}

impl<'a> SetWriter<'a> {
    /// Make the directory, and refuse early what must fail later: names that collide or leave it, a damaged manifest.
    ///
    /// `maps` are the maps that will be written.
    ///
    /// # Errors
    /// If the directory cannot be made, a name is illegal, or there is a manifest that cannot be read.
    pub fn new(
        dir: &Path,
        set: SetId,
        maps: impl IntoIterator<Item = MapKind>,
        options: &'a WriteOptions,
    ) -> Result<Self, IoError> {
        let mut seen = BTreeSet::new();
        let maps: Vec<MapKind> = maps.into_iter().collect();
        let bad = |e: NameError| Problem::from(e).at(dir);
        for output in &options.outputs {
            let each: Vec<_> = match output {
                Output::ExrLayers => vec![None],
                _ => maps.iter().map(|&m| Some((m, None))).collect(),
            };
            for map in each {
                let name = options.names.file_name(&set, map, extension(*output)).map_err(bad)?;
                // Names that differ by case only are one file on many systems.
                if !seen.insert(name.to_lowercase()) {
                    return Err(bad(NameError::Twice(name)));
                }
            }
        }
        make_dir(dir)?;
        // A manifest that cannot be read will not be overwritten: say so before the work is done.
        match Manifest::read(dir) {
            Err(IoError { problem: Problem::NotFound, .. }) | Ok(_) => {}
            Err(error) => return Err(error),
        }
        Ok(Self { dir: dir.to_owned(), set, options, watch: None })
    }

    /// The same, telling of every piece of work.
    pub fn watched_by(self, watch: Option<&'a dyn Watch>) -> Self {
        Self { watch, ..self }
    }

    /// Write one map aside, in every format that has a file per map.
    ///
    /// # Errors
    /// If a file cannot be written, or does not read back as it was written; nothing is left of it.
    pub fn write_map(&self, map: &MapImage) -> Result<Vec<Staged>, IoError> {
        let per_map = [Output::Png, Output::Exr];
        per_map
            .into_iter()
            .filter(|o| self.options.outputs.contains(o))
            .map(|o| self.stage(o, &[map]))
            .collect()
    }

    /// Write the file of all maps aside, if it is wanted.
    ///
    /// # Errors
    /// As [`SetWriter::write_map`].
    pub fn write_layers(&self, maps: &[&MapImage]) -> Result<Option<Staged>, IoError> {
        let wanted = self.options.outputs.contains(&Output::ExrLayers) && !maps.is_empty();
        wanted.then(|| self.stage(Output::ExrLayers, maps)).transpose()
    }

    /// Rename every file to its place and record the set; what was recorded is returned, by file name.
    ///
    /// # Errors
    /// If a file cannot be renamed or the manifest cannot be written.
    pub fn finish(self, staged: Vec<Staged>) -> Result<Vec<ManifestEntry>, IoError> {
        let mut record = SetRecord::new(&self.set);
        for file in staged {
            file.aside.commit()?;
            record.files.push(file.entry);
        }
        record.files.sort_by(|a, b| a.file.cmp(&b.file));
        let entries = record.files.clone();
        manifest::record(&self.dir, record)?;
        Ok(entries)
    }

    fn stage(&self, output: Output, maps: &[&MapImage]) -> Result<Staged, IoError> {
        let options = self.options;
        let layered = output == Output::ExrLayers;
        let map = (!layered).then(|| (maps[0].kind, maps[0].normal_format));
        let file = self.file_name(output, map)?;
        let path = self.dir.join(&file);
        let mut told = None;
        let watched = Watched { name: &file, by: self.watch };
        let mut aside = Aside::write_watched(path, watched, |out| match output {
            Output::Png => {
                told = Some(png::write(maps[0], &options.encode, options.png, watched, out)?);
                Ok(())
            }
            Output::Exr | Output::ExrLayers => exr::write(maps, layered, &options.exr, watched, out),
        })?;
        if options.verify {
            aside = aside.verify(|file| match output {
                Output::Png => png::verify(maps[0], &options.encode, file),
                Output::Exr | Output::ExrLayers => exr::verify(maps, layered, &options.exr, file),
            })?;
        }
        let head = |map: &&MapImage| {
            let MapImage { kind, range, normal_format, .. } = **map;
            MapHead { kind, range, normal_format }
        };
        let heads: Vec<MapHead> = maps.iter().map(head).collect();
        Ok(self.staged(output, file, aside, &heads, told))
    }

    /// Name of a file of the set; `None` is the one of all maps.
    pub(super) fn file_name(
        &self,
        output: Output,
        map: Option<(MapKind, Option<NormalFormat>)>,
    ) -> Result<String, IoError> {
        let name = self.options.names.file_name(&self.set, map, extension(output));
        name.map_err(|e| Problem::from(e).at(&self.dir))
    }

    /// A file that is written, with what the manifest will say of it.
    pub(super) fn staged(
        &self,
        output: Output,
        file: String,
        aside: Aside,
        maps: &[MapHead],
        told: Option<MapTold>,
    ) -> Staged {
        let entry = ManifestEntry {
            file,
            format: if output == Output::Png { FileFormat::Png } else { FileFormat::Exr },
            bytes: aside.bytes,
            blake3: aside.blake3.to_hex().to_string(),
            compression: self.compression(output),
            maps: maps.iter().map(|map| self.record(output, map, told)).collect(),
        };
        Staged { aside, entry, extremes: told.map(|t| t.extremes) }
    }

    /// What the manifest says of the compression: nothing where it is the usual one.
    fn compression(&self, output: Output) -> Option<Compression> {
        match output {
            Output::Png => (self.options.png != PngCompression::default()).then_some(self.options.png.into()),
            _ => (self.options.exr.compression != ExrCompression::default())
                .then_some(self.options.exr.compression.into()),
        }
    }

    fn record(&self, output: Output, map: &MapHead, told: Option<MapTold>) -> MapRecord {
        let kind = map.kind;
        let (channels, sample, encoding, error) = if output == Output::Png {
            let channels = if kind.channels() == 3 { "RGB" } else { "Y" };
            let sample = match self.options.encode.depth(kind) {
                Depth::Eight => SampleKind::U8,
                Depth::Sixteen => SampleKind::U16,
            };
            let encoding = match kind {
                MapKind::Color => Encoding::Srgb,
                MapKind::ScaleId if told.is_some_and(|told| told.wraps_ids()) => Encoding::IdLow16,
                MapKind::ScaleId => Encoding::Value,
                _ => Encoding::Linear,
            };
            // Of ids only equality counts: an error in their unit would mean nothing.
            let error = told.filter(|_| kind != MapKind::ScaleId).map(|told| told.error);
            (channels.chars().map(String::from).collect(), sample, encoding, error)
        } else {
            let sample = match self.options.exr.sample(kind) {
                ExrSample::Half => SampleKind::F16,
                ExrSample::Float => SampleKind::F32,
            };
            (channel_names(kind, output == Output::ExrLayers), sample, Encoding::Value, None)
        };
        let (unit, normal_format) = (kind.unit().to_owned(), map.normal_format);
        MapRecord { map: kind, channels, sample, encoding, unit, range: map.range, normal_format, error }
    }
}

fn extension(output: Output) -> &'static str {
    match output {
        Output::Png => "png",
        Output::Exr | Output::ExrLayers => "exr",
    }
}

/// Write a set into `dir`: maps in parallel on the current rayon pool, with the same bytes on any number of threads.
///
/// `written` is called, from any thread, for each file once it is complete. Either every file of the set is put in its
/// place and the manifest says so, or an error is returned and the directory is as it was.
///
/// # Errors
/// The first file, in the order of the maps, that cannot be written, with its path.
pub fn write_set(
    set: &TextureSet,
    dir: &Path,
    options: &WriteOptions,
    written: &(dyn Fn(&ManifestEntry) + Sync),
) -> Result<Vec<ManifestEntry>, IoError> {
    let writer = SetWriter::new(dir, set.id(), set.maps.keys().copied(), options)?;
    let tell = |file: Staged| {
        written(&file.entry);
        file
    };
    let maps: Vec<&MapImage> = set.maps.values().collect();
    let staged: Vec<Result<Vec<Staged>, IoError>> = maps
        .par_iter()
        .with_max_len(1)
        .map(|map| Ok(writer.write_map(map)?.into_iter().map(tell).collect()))
        .collect();
    let mut files = Vec::new();
    for staged in staged {
        files.extend(staged?);
    }
    files.extend(writer.write_layers(&maps)?.map(tell));
    writer.finish(files)
}

/// Encode one map as PNG, on the current rayon pool, into anything; returns what it found out in passing.
///
/// # Errors
/// If the map has more texels to a side than the format allows, or `out` fails.
pub fn encode_png(
    map: &MapImage,
    options: &EncodeOptions,
    compression: PngCompression,
    out: impl std::io::Write + Send,
) -> Result<MapTold, IoError> {
    let watched = Watched { name: map.kind.name(), by: None };
    png::write(map, options, compression, watched, out).map_err(|p| p.at(Path::new(map.kind.name())))
}

/// Encode one map as OpenEXR, on the current rayon pool, into anything.
///
/// # Errors
/// If the map has more texels to a side than the format allows, or `out` fails.
pub fn encode_exr(
    map: &MapImage,
    options: &ExrOptions,
    out: impl std::io::Write + std::io::Seek,
) -> Result<(), IoError> {
    let watched = Watched { name: map.kind.name(), by: None };
    exr::write(&[map], false, options, watched, out).map_err(|p| p.at(Path::new(map.kind.name())))
}

/// Write a text file, whole or not at all.
pub fn write_text(path: &Path, text: &str) -> Result<(), IoError> {
    Aside::write(path.to_owned(), |out| Ok(std::io::Write::write_all(out, text.as_bytes())?))?.commit()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Domain, Plane, hash};
    use crate::io::{FileStatus, verify_dir};
    use std::collections::BTreeMap;
    use std::sync::Mutex;

    fn set(width: usize, height: usize) -> TextureSet {
        let domain = Domain { width, height, girth_mm: 50.0, length_mm: 75.0 };
        let plane = |kind: MapKind, c: usize| {
            let noise = move |x, y| hash::unit(hash::hash2(kind as u32 * 3 + c as u32, x as u32, y as u32));
            match kind {
                MapKind::ScaleId => Plane::from_fn(width, height, |x, y| (x / 5 + 100 * (y / 7)) as f32),
                _ => Plane::from_fn(width, height, noise),
            }
        };
        let map = |kind: MapKind| MapImage::new(kind, (0..kind.channels()).map(|c| plane(kind, c)).collect());
        let maps = MapKind::ALL.into_iter().map(|kind| (kind, map(kind))).collect();
        TextureSet {
            domain,
            maps,
            preset: "boa".into(),
            seed: 3,
            preset_hash: [7; 32],
            optics: Default::default(),
        }
    }

    fn everything() -> WriteOptions {
        WriteOptions {
            outputs: [Output::Png, Output::Exr, Output::ExrLayers].into(),
            verify: true,
            ..WriteOptions::default()
        }
    }

    /// Every file of a directory, hidden ones too.
    fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
        let read = |e: std::io::Result<std::fs::DirEntry>| {
            let e = e.unwrap();
            (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap_or_default())
        };
        std::fs::read_dir(dir).unwrap().map(read).collect()
    }

    fn write(set: &TextureSet, dir: &Path, options: &WriteOptions) -> Result<Vec<ManifestEntry>, IoError> {
        write_set(set, dir, options, &|_| {})
    }

    #[test]
    fn one_and_two_threads_write_the_same_bytes() {
        let set = set(97, 140);
        let at = |threads| {
            let dir = tempfile::tempdir().unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| write(&set, dir.path(), &everything())).unwrap();
            files(dir.path())
        };
        let one = at(1);
        assert_eq!(one.len(), 10 + 10 + 1 + 1);
        assert!(one == at(2), "the files differ");
        assert!(one == at(7), "the files differ");
    }

    #[test]
    fn a_set_of_one_texel_is_written() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(write(&set(1, 1), dir.path(), &everything()).unwrap().len(), 21);
        assert!(verify_dir(dir.path()).unwrap().is_same());
    }

    #[test]
    fn the_manifest_says_what_the_files_are() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("new/deep");
        let mut set = set(20, 30);
        let normal = set.maps.remove(&MapKind::Normal).unwrap().with_normal_format(NormalFormat::Dx);
        set.maps.insert(MapKind::Normal, normal);
        let height = set.maps.remove(&MapKind::Height).unwrap().with_range([-0.25, 1.5]);
        set.maps.insert(MapKind::Height, height);
        let told = Mutex::new(Vec::new());
        let entries =
            write_set(&set, &out, &WriteOptions::default(), &|e| told.lock().unwrap().push(e.file.clone()))
                .unwrap();
        let mut told = told.into_inner().unwrap();
        told.sort();
        assert_eq!(told, entries.iter().map(|e| e.file.clone()).collect::<Vec<_>>());
        let manifest = Manifest::read(&out).unwrap();
        assert_eq!(manifest.sets.len(), 1);
        let record = &manifest.sets[0];
        assert_eq!(
            (&record.preset[..], record.seed, record.size, record.size_mm),
            ("boa", 3, [20, 30], [50.0, 75.0])
        );
        assert_eq!((&record.preset_blake3, &record.files), (&"07".repeat(32), &entries));
        let of = |name: &str| &record.files.iter().find(|f| f.file == name).unwrap().maps[0];
        let height = of("boa_height.png");
        assert_eq!((height.range, &height.unit[..], height.sample), ([-0.25, 1.5], "mm", SampleKind::U16));
        // Half a step of 16 bits over the range, and the slack of f32.
        assert!(height.error.unwrap().max <= 1.75 / 65535.0 * 0.51);
        let normal = of("boa_nor_dx.png");
        assert_eq!((normal.normal_format, normal.encoding), (Some(NormalFormat::Dx), Encoding::Linear));
        assert_eq!(
            (of("boa_color.png").encoding, of("boa_scale_id.png").encoding),
            (Encoding::Srgb, Encoding::Value)
        );
        for file in &record.files {
            let bytes = std::fs::read(out.join(&file.file)).unwrap();
            assert_eq!(
                (file.bytes, &file.blake3[..]),
                (bytes.len() as u64, &blake3::hash(&bytes).to_hex()[..])
            );
        }
    }

    #[test]
    fn ids_beyond_16_bits_are_told() {
        let dir = tempfile::tempdir().unwrap();
        let mut set = set(4, 4);
        let ids = vec![Plane::from_fn(4, 4, |x, y| (65_530 + x + 4 * y) as f32)];
        set.maps = [(MapKind::ScaleId, MapImage::new(MapKind::ScaleId, ids))].into();
        let outputs = [Output::Png, Output::Exr].into();
        let entries = write(&set, dir.path(), &WriteOptions { outputs, ..WriteOptions::default() }).unwrap();
        let encodings: Vec<_> = entries.iter().map(|e| (e.format, e.maps[0].encoding)).collect();
        assert_eq!(encodings, [(FileFormat::Exr, Encoding::Value), (FileFormat::Png, Encoding::IdLow16)]);
    }

    #[test]
    fn one_changed_bit_is_found() {
        let dir = tempfile::tempdir().unwrap();
        write(&set(16, 16), dir.path(), &WriteOptions::default()).unwrap();
        assert!(verify_dir(dir.path()).unwrap().is_same());
        let path = dir.path().join("boa_height.png");
        let mut bytes = std::fs::read(&path).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 16;
        std::fs::write(&path, bytes).unwrap();
        let report = verify_dir(dir.path()).unwrap();
        let bad: Vec<_> = report.files.iter().filter(|f| !matches!(f.status, FileStatus::Same)).collect();
        assert!(
            matches!(bad[..], [f] if f.file == "boa_height.png" && matches!(f.status, FileStatus::Changed))
        );
    }

    #[test]
    fn seeds_share_a_directory_and_partial_sets_add_up() {
        let dir = tempfile::tempdir().unwrap();
        let options =
            WriteOptions { names: "{preset}_{seed}_{map}.{ext}".parse().unwrap(), ..WriteOptions::default() };
        for seed in [2, 1] {
            let mut set = TextureSet { seed, ..set(8, 8) };
            let rest = set.maps.split_off(&MapKind::Roughness);
            write(&set, dir.path(), &options).unwrap();
            write(&TextureSet { maps: rest, ..set }, dir.path(), &options).unwrap();
        }
        let manifest = Manifest::read(dir.path()).unwrap();
        let sets: Vec<_> = manifest.sets.iter().map(|s| (s.seed, s.files.len())).collect();
        assert_eq!(sets, [(1, 10), (2, 10)]);
        let report = verify_dir(dir.path()).unwrap();
        assert!(report.is_same() && report.files.len() == 20 && report.extra.is_empty());
    }

    #[test]
    fn names_that_collide_or_leave_are_refused_before_anything_is_made() {
        let dir = tempfile::tempdir().unwrap();
        let out = dir.path().join("out");
        let with = |names: &str| WriteOptions { names: names.parse().unwrap(), ..everything() };
        for names in ["{preset}.{ext}", "{preset}_{map}"] {
            let error = write(&set(4, 4), &out, &with(names)).unwrap_err();
            assert!(matches!(error.problem, Problem::Name(NameError::Twice(_))), "{error}");
        }
        let escaping = TextureSet { preset: "../boa".into(), ..set(4, 4) };
        let error = write(&escaping, &out, &everything()).unwrap_err();
        assert!(matches!(error.problem, Problem::Name(NameError::Illegal(_))), "{error}");
        assert!(files(dir.path()).is_empty());
    }

    #[test]
    fn a_directory_that_is_a_file_or_read_only_is_named_and_nothing_is_left() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("file");
        std::fs::write(&file, b"mine").unwrap();
        let error = write(&set(4, 4), &file, &everything()).unwrap_err();
        assert!(matches!(error.problem, Problem::NotADirectory) && error.path == file, "{error}");
        assert_eq!(files(dir.path()), [("file".to_owned(), b"mine".to_vec())].into());

        let locked = dir.path().join("locked");
        std::fs::create_dir(&locked).unwrap();
        let mut permissions = std::fs::metadata(&locked).unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(&locked, permissions).unwrap();
        if std::fs::write(locked.join("probe"), b"").is_ok() {
            println!("SKIPPED: this user may write into read-only directories");
            return;
        }
        let error = write(&set(4, 4), &locked, &everything()).unwrap_err();
        assert!(matches!(error.problem, Problem::Denied), "{error}");
        assert!(files(&locked).is_empty());
    }

    #[test]
    fn if_one_map_fails_no_map_is_left() {
        let dir = tempfile::tempdir().unwrap();
        // A directory where the last map should go.
        let blocked = dir.path().join("boa_pattern_mask.png");
        std::fs::create_dir(&blocked).unwrap();
        std::fs::write(dir.path().join("boa_color.png"), b"old").unwrap();
        let before = files(dir.path());
        let error = write(&set(40, 40), dir.path(), &everything()).unwrap_err();
        assert!(matches!(error.problem, Problem::IsADirectory), "{error}");
        assert!(error.path.ends_with("boa_pattern_mask.png"));
        assert_eq!(files(dir.path()), before);
        // A manifest that is not ours to overwrite.
        std::fs::remove_dir(&blocked).unwrap();
        std::fs::write(dir.path().join("manifest.json"), b"{\"name\": \"an app\"}").unwrap();
        let before = files(dir.path());
        let error = write(&set(40, 40), dir.path(), &everything()).unwrap_err();
        assert!(matches!(error.problem, Problem::Manifest(_)), "{error}");
        assert_eq!(files(dir.path()), before);
    }

    /// The test runs itself in a shell that limits the size of files, so that the system refuses a write midway.
    #[test]
    fn a_write_that_the_system_refuses_midway_leaves_nothing() {
        const DIR: &str = "OPHIDIAN_TEST_LIMITED_DIR";
        if let Some(dir) = std::env::var_os(DIR) {
            let error = write(&set(128, 128), Path::new(&dir), &WriteOptions::default()).unwrap_err();
            assert!(matches!(error.problem, Problem::DiskFull), "{error}");
            return;
        }
        let dir = tempfile::tempdir().unwrap();
        let name = "io::write::tests::a_write_that_the_system_refuses_midway_leaves_nothing";
        // SIGXFSZ ignored, the write returns an error; 16 blocks of 512 or 1024 bytes.
        let script = r#"trap "" XFSZ; ulimit -f 16 || exit 77; exec "$0" --exact "$1" --nocapture"#;
        let run = std::process::Command::new("sh")
            .args(["-c", script])
            .arg(std::env::current_exe().unwrap())
            .arg(name)
            .env(DIR, dir.path())
            .output();
        match run {
            Ok(output) if output.status.code() == Some(77) => {
                println!("SKIPPED: file sizes cannot be limited here")
            }
            Err(error) => println!("SKIPPED: no shell: {error}"),
            Ok(output) => {
                let said = String::from_utf8_lossy(&output.stdout);
                assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
                assert!(said.contains("1 passed"), "{said}");
                assert!(files(dir.path()).is_empty(), "{:?}", files(dir.path()).keys());
            }
        }
    }
}
