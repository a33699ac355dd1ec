//! `verify`: a directory against its manifest, and against what its presets make.

use std::collections::BTreeMap;
use std::io::Write as _;

use super::args::Verify;
use super::exit::{Exit, Failure};
use super::load::Preset;
use super::{generate, memory};
use crate::base::{Domain, MapKind};
use crate::eval::{self, Control};
use crate::graph::{self, Graph};
use crate::io::{
    Compression, ExrSample, FileFormat, FileStatus, Manifest, ManifestEntry, Output, SampleKind, SetRecord,
    SetWriter, WriteOptions, verify_dir,
};
use crate::maps::{Depth, MapImage, NormalFormat, SetId, assemble};
use crate::plan::Plan;
use crate::preset::builtin;

/// Compare, and say what differs.
pub(super) fn run(args: &Verify) -> Result<Exit, Failure> {
    let report = verify_dir(&args.dir)?;
    let mut out = anstream::stdout();
    for file in &report.files {
        let word = match &file.status {
            FileStatus::Same => continue,
            FileStatus::Missing => "missing".to_owned(),
            FileStatus::Changed => "changed".to_owned(),
            FileStatus::Unreadable(problem) => format!("unreadable: {problem}"),
        };
        writeln!(out, "{}: {word}", file.file)?;
    }
    if !args.quiet {
        let same = report.files.iter().filter(|f| matches!(f.status, FileStatus::Same)).count();
        writeln!(out, "{same} of {} files are what was written", report.files.len())?;
        if !report.extra.is_empty() {
            writeln!(out, "not in the manifest: {}", report.extra.join(", "))?;
        }
    }
    let mut same = report.is_same();
    if args.rebuild {
        same &= rebuild(args)?;
    }
    Ok(if same { Exit::Done } else { Exit::Differs })
}

/// Make every set of the directory again; true if every file has the same bytes.
fn rebuild(args: &Verify) -> Result<bool, Failure> {
    let mut presets: BTreeMap<String, Graph> = BTreeMap::new();
    for file in &args.preset {
        let graph = Preset::open(file, &args.set.settings)?.graph()?;
        presets.insert(graph.name.clone(), graph);
    }
    let mut out = anstream::stdout();
    let (mut same, mut made) = (true, 0);
    for set in &Manifest::read(&args.dir)?.sets {
        let name = &set.preset;
        if !presets.contains_key(name) {
            if builtin::find(name).is_none() {
                let message = format!("the set {name} was made from a preset that is not built in");
                return Err(Failure::usage(message, "name its file by --preset FILE"));
            }
            presets.insert(name.clone(), Preset::open(name, &args.set.settings)?.graph()?);
        }
        let graph = presets[name].clone().with_seed(set.seed);
        let hash = blake3::Hash::from_bytes(graph::preset_hash(&graph)).to_hex();
        if hash.as_str() != set.preset_blake3 {
            writeln!(out, "{name} seed {}: made from another form of the preset (or other --set)", set.seed)?;
            same = false;
            continue;
        }
        for file in differing(set, &graph, args)? {
            writeln!(out, "{file}: differs from what {} makes of it now", env!("CARGO_PKG_NAME"))?;
            same = false;
        }
        made += set.files.len();
    }
    if !args.quiet {
        writeln!(out, "{made} files were made again")?;
    }
    Ok(same)
}

/// The files of a set that come out otherwise.
fn differing(set: &SetRecord, graph: &Graph, args: &Verify) -> Result<Vec<String>, Failure> {
    let [width, height] = set.size;
    let domain = Domain { width, height, girth_mm: graph.girth_mm, length_mm: graph.length_mm };
    let id = SetId::new(graph, domain);
    let mut wanted: Vec<MapKind> = set.files.iter().flat_map(|f| &f.maps).map(|m| m.map).collect();
    wanted.sort();
    wanted.dedup();
    let plan = generate::plan(graph, &wanted, domain, memory::budget(None))?;
    let images = make(&plan, &id)?;
    let mut differing = Vec::new();
    for file in &set.files {
        let options = options_of(file);
        // Aside only: dropped, it leaves nothing.
        let writer = SetWriter::new(&args.dir, id.clone(), wanted.iter().copied(), &options)?;
        let maps: Vec<MapImage> = file
            .maps
            .iter()
            .filter_map(|record| {
                let format = record.normal_format.unwrap_or(NormalFormat::Gl);
                Some(images.get(&record.map)?.clone().to_normal_format(format))
            })
            .collect();
        let layers: Vec<&MapImage> = maps.iter().collect();
        let staged = match (options.outputs.contains(&Output::ExrLayers), layers.first()) {
            (true, _) => writer.write_layers(&layers)?,
            (false, Some(map)) => writer.write_map(map)?.into_iter().next(),
            (false, None) => None,
        };
        if staged.is_none_or(|s| s.entry().blake3 != file.blake3) {
            differing.push(file.file.clone());
        }
    }
    Ok(differing)
}

fn make(plan: &Plan, id: &SetId) -> Result<BTreeMap<MapKind, MapImage>, Failure> {
    let evaluation = eval::run(plan, Control::default()).map_err(|_| Failure::Told(Exit::Interrupted))?;
    Ok(assemble(evaluation, id.clone()).maps)
}

/// The options that a recorded file was written by.
fn options_of(file: &ManifestEntry) -> WriteOptions {
    let mut options = WriteOptions::default();
    let layered = file.maps.len() > 1 || file.maps.iter().any(|m| m.channels.iter().any(|c| c.contains('.')));
    let output = match file.format {
        FileFormat::Png => Output::Png,
        FileFormat::Exr if layered => Output::ExrLayers,
        FileFormat::Exr => Output::Exr,
    };
    options.outputs = [output].into();
    match file.compression {
        Some(Compression::Png(compression)) => options.png = compression,
        Some(Compression::Exr(compression)) => options.exr.compression = compression,
        None => {}
    }
    for map in &file.maps {
        match map.sample {
            SampleKind::U8 => drop(options.encode.depths.insert(map.map, Depth::Eight)),
            SampleKind::U16 => drop(options.encode.depths.insert(map.map, Depth::Sixteen)),
            SampleKind::F16 => drop(options.exr.samples.insert(map.map, ExrSample::Half)),
            SampleKind::F32 => drop(options.exr.samples.insert(map.map, ExrSample::Float)),
        }
    }
    options
}
