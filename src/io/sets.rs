//! Texture sets read back from a directory, by its manifest.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::read::ExrLayer;
use super::{Encoding, FileFormat, IoError, Manifest, MapRecord, Problem, SetRecord, read_image};
use crate::base::{Domain, MapKind, Plane, color};
use crate::maps::{MapImage, NormalFormat, TextureSet};

/// Read the set of a directory, with those of `wanted` that it has. Of a map in several files the most exact is taken:
/// floats before integers.
///
/// # Errors
/// If there is no manifest, it names no set or several, or a file cannot be read or is not what the manifest says.
pub fn read_set(dir: &Path, wanted: &[MapKind]) -> Result<TextureSet, IoError> {
    let manifest = Manifest::read(dir)?;
    let [set] = manifest.sets.as_slice() else {
        let names: Vec<String> =
            manifest.sets.iter().map(|s| format!("{} seed {}", s.preset, s.seed)).collect();
        let message =
            format!("there must be one set to read, and there are {}: {}", names.len(), names.join(", "));
        return Err(Problem::Manifest(message).at(dir.join(super::FILE_NAME)));
    };
    let mut maps = BTreeMap::new();
    for &kind in wanted {
        let mut files: Vec<_> = set
            .files
            .iter()
            .flat_map(|file| file.maps.iter().map(move |map| (file, map)))
            .filter(|(_, map)| map.map == kind)
            .collect();
        files.sort_by_key(|(file, _)| file.format == FileFormat::Png);
        let Some((file, record)) = files.first() else { continue };
        let path = dir.join(&file.file);
        let image = match file.format {
            FileFormat::Png => read_png(&path, set, record)?,
            FileFormat::Exr => read_exr(&path, set, record)?,
        };
        maps.insert(kind, image.to_normal_format(NormalFormat::Gl));
    }
    let [width, height] = set.size;
    let [girth_mm, length_mm] = set.size_mm;
    let hash = blake3::Hash::from_hex(&set.preset_blake3).map_or([0; 32], |h| *h.as_bytes());
    Ok(TextureSet {
        domain: Domain { width, height, girth_mm, length_mm },
        maps,
        preset: set.preset.clone(),
        seed: set.seed,
        preset_hash: hash,
        optics: set.material,
    })
}

/// A map of planes that have been checked against the manifest.
fn image(path: &Path, set: &SetRecord, record: &MapRecord, planes: Vec<Plane>) -> Result<MapImage, IoError> {
    let fits = planes.len() == record.map.channels()
        && planes.iter().all(|p| [p.width(), p.height()] == set.size)
        && planes.iter().all(|p| p.data().iter().all(|v| v.is_finite()));
    if !fits {
        let message = format!("it is not the {} map that the manifest says", record.map);
        return Err(Problem::ReadBack(message).at(path));
    }
    let image = MapImage::new(record.map, planes).with_range(record.range);
    Ok(image.with_normal_format(record.normal_format.unwrap_or_default()))
}

fn read_png(path: &Path, set: &SetRecord, record: &MapRecord) -> Result<MapImage, IoError> {
    let [low, high] = record.range;
    let value = |sample: f32| match record.encoding {
        Encoding::Srgb => color::srgb_to_linear(sample),
        Encoding::Linear | Encoding::Value => low + (high - low) * sample,
        Encoding::IdLow16 => (sample * 65_535.0 + 0.5).floor(),
    };
    let planes = read_image(path)?.channels.into_iter().map(|p| {
        let (width, height) = (p.width(), p.height());
        Plane::from_vec(width, height, p.into_vec().into_iter().map(value).collect())
    });
    image(path, set, record, planes.collect())
}

fn read_exr(path: &Path, set: &SetRecord, record: &MapRecord) -> Result<MapImage, IoError> {
    let planes = || -> Result<Vec<Plane>, Problem> {
        let mut layer = ExrLayer::read(BufReader::new(File::open(path)?))?;
        record.channels.iter().map(|name| layer.take(name)).collect()
    };
    image(path, set, record, planes().map_err(|problem| problem.at(path))?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{Output, WriteOptions, write_set};

    #[test]
    fn a_set_reads_back_within_its_quantisation_and_several_are_refused() {
        let wave = |k: f32| Plane::from_fn(16, 8, |x, y| 0.5 + 0.4 * (k * (x + 3 * y) as f32).sin());
        let domain = Domain { width: 16, height: 8, girth_mm: 20.0, length_mm: 10.0 };
        let mut height = MapImage::new(MapKind::Height, vec![wave(0.3)]);
        height.range = [0.0, 2.0];
        let color = MapImage::new(MapKind::Color, vec![wave(0.1), wave(0.2), wave(0.3)]);
        let mut set = TextureSet {
            domain,
            maps: [(MapKind::Height, height), (MapKind::Color, color)].into(),
            preset: "wave".into(),
            seed: 3,
            preset_hash: [7; 32],
            optics: crate::optics::SkinOptics { n_layer: Some(1.7), ..Default::default() },
        };
        for (output, tolerance) in [(Output::Png, 0.02), (Output::Exr, 1e-3), (Output::ExrLayers, 1e-3)] {
            let dir = tempfile::tempdir().expect("a directory");
            let options = WriteOptions { outputs: [output].into(), ..WriteOptions::default() };
            write_set(&set, dir.path(), &options, &|_| ()).expect("written");
            let kinds = [MapKind::Color, MapKind::Height, MapKind::Normal];
            let read = read_set(dir.path(), &kinds).expect("read");
            assert_eq!((read.id(), read.maps.len()), (set.id(), 2));
            for (kind, map) in &read.maps {
                for (a, b) in map.planes.iter().zip(&set.maps[kind].planes) {
                    let worst = a.data().iter().zip(b.data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                    assert!(worst <= tolerance, "{output:?} {kind} {worst}");
                }
            }
            // Other names: of the same ones the later set would take the place of the earlier.
            set.preset = "other".into();
            write_set(&set, dir.path(), &options, &|_| ()).expect("written");
            assert!(read_set(dir.path(), &kinds).is_err());
            set.preset = "wave".into();
        }
    }
}
