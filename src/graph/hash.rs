//! The identity of a preset: what it evaluates to, not how it is written.

use super::{Graph, to_toml};

/// BLAKE3 of a graph, whatever its seed and name: its text as nodes, then the images that it reads.
pub fn preset_hash(graph: &Graph) -> [u8; 32] {
    let mut plain = Graph { name: String::new(), seed: 0, ..graph.clone() };
    plain.assets.clear();
    let mut hasher = blake3::Hasher::new();
    hasher.update(b"ophidian preset 1\0");
    hasher.update(to_toml(&plain).as_bytes());
    for (file, asset) in &graph.assets {
        hasher.update(file.as_bytes());
        for plane in asset.channels.iter().chain(&asset.alpha) {
            hasher.update(&(plane.width() as u64).to_le_bytes());
            for values in plane.data().chunks(1 << 12) {
                let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_bits().to_le_bytes()).collect();
                hasher.update(&bytes);
            }
        }
    }
    hasher.finalize().into()
}
