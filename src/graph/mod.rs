//! MEANING: a graph with every name resolved, every default filled and every kind checked.

mod build;
pub mod dot;
mod from_document;
mod hash;
mod print;
pub mod read;
pub mod reference;
pub mod schema;

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::base::MapKind;
use crate::node::{Assets, Kind, Node, OutputKind};
use crate::optics::SkinOptics;

pub use build::{BuildError, MapDraft, Sketch, resolve};
pub use dot::{needed_by, to_dot, to_json, to_mermaid};
pub use from_document::{ABOUT, about, from_document};
pub use hash::preset_hash;
pub use print::to_toml;
pub use read::build;
pub use schema::schema;

/// An output of a node: indices into [`Graph::nodes`] and into its spec's outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OutputRef {
    /// Index of the node.
    pub node: usize,
    /// Index of the output in its spec.
    pub port: usize,
}

/// What an input reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// A number.
    Scalar(f32),
    /// A linear colour.
    Color([f32; 3]),
    /// A node's output.
    Output(OutputRef),
}

/// A node of a graph.
#[derive(Clone, Debug)]
pub struct GraphNode {
    /// Unique name.
    pub name: String,
    /// Operation and settings.
    pub node: Arc<dyn Node>,
    /// One source per input of its spec.
    pub inputs: Vec<Source>,
    /// Kind of its `Same` outputs: [`Kind::Color`] runs it once per channel.
    pub kind: Kind,
    /// Its own seed.
    pub seed: u32,
}

impl GraphNode {
    /// Kind of output `port`.
    pub fn output_kind(&self, port: usize) -> Kind {
        match self.node.spec().outputs[port].kind {
            OutputKind::Scalar => Kind::Scalar,
            OutputKind::Color => Kind::Color,
            OutputKind::Same => self.kind,
        }
    }
}

/// A map of the texture set: where it comes from and what integer files record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapSource {
    /// What it shows.
    pub source: Source,
    /// Physical values that integer files map to 0 and 1.
    pub range: [f32; 2],
}

/// A graph: nothing left to resolve.
#[derive(Clone, Debug)]
pub struct Graph {
    /// Name of the preset.
    pub name: String,
    /// The set's seed: the individual.
    pub seed: u64,
    /// Physical width of the tile, mm.
    pub girth_mm: f32,
    /// Physical height of the tile, mm.
    pub length_mm: f32,
    /// Nodes; each reads only earlier ones.
    pub nodes: Vec<GraphNode>,
    /// Maps that the preset defines.
    pub maps: BTreeMap<MapKind, MapSource>,
    /// What the skin is made of, for whoever renders it; no map depends on it.
    pub optics: SkinOptics,
    /// Image files that nodes read, filled by whoever has a file system.
    pub assets: Assets,
}

impl Graph {
    /// Index of the node of this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.nodes.iter().position(|n| n.name == name)
    }

    /// Image files that its nodes name, each once, in order of first use.
    pub fn files(&self) -> Vec<&str> {
        let mut files: Vec<&str> = Vec::new();
        for file in self.nodes.iter().flat_map(|n| n.node.files()) {
            if !file.is_empty() && !files.contains(&file) {
                files.push(file);
            }
        }
        files
    }

    /// `node` or `node.port`, as a preset would write it.
    pub fn output_name(&self, output: OutputRef) -> String {
        let node = &self.nodes[output.node];
        if output.port == 0 {
            node.name.clone()
        } else {
            format!("{}.{}", node.name, node.node.spec().outputs[output.port].name)
        }
    }
}

#[cfg(test)]
mod tests;
