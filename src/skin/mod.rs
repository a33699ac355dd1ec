//! ANATOMY: a preset's typed sections, in the words of a herpetologist and a texture artist, lowered to nodes.
//!
//! `[body]`, `[scales]`, `[pattern]`, `[color]`, `[belly]`, `[surface]` and `[iridescence]` are structs, one file each,
//! with a default, a unit and a range for every field. [`lower`] turns them into a [`Draft`] of nodes and the maps
//! that they define; nothing after it knows what a snake is.

use std::collections::BTreeMap;

use crate::base::MapKind;
use crate::node::ParamError;
use crate::node::draft::{Draft, Wire};

/// A preset's anatomy: every section.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Skin {}

/// The names of the anatomy's sections: the top-level keys of a preset that [`Skin`] reads.
pub const SECTIONS: &[&str] = &["body", "scales", "pattern", "color", "belly", "surface", "iridescence"];

/// What the anatomy becomes.
#[derive(Clone, Debug)]
pub struct Lowered {
    /// Nodes by name.
    pub draft: Draft,
    /// Maps: what each shows, and the physical values that integer files map to 0 and 1.
    pub maps: BTreeMap<MapKind, (Wire, [f32; 2])>,
    /// Physical size of the tile, mm: girth, length.
    pub size_mm: [f32; 2],
}

/// Lower the anatomy to nodes.
///
/// # Errors
/// Settings that contradict each other; [`ParamError::key`] is a path such as `scales.rows` or `pattern.layers[1].rows`.
pub fn lower(skin: &Skin) -> Result<Lowered, Vec<ParamError>> {
    let _ = skin;
    Ok(Lowered { draft: Draft::default(), maps: BTreeMap::new(), size_mm: [100.0, 100.0] })
}
