//! Ophidian makes snake-skin textures: a preset and a seed go in, a set of maps comes out that tiles, whose maps fit
//! each other texel by texel, and whose bytes do not depend on the machine.
//!
//! Each step is a type and a function of its own, and data flows one way:
//!
//! ```text
//!  preset.toml ─► preset ─► skin ──► graph ──► plan ──► eval ──► maps ──► io   (png / exr / manifest)
//!   text          spanned   anatomy  typed,    live,    planes   named,
//!                 document  lowered  checked   ordered, (f32)    encoded
//!                           to nodes           fused
//! ```
//!
//! # A tour
//!
//! ```
//! use ophidian::base::{Domain, MapKind};
//! use ophidian::{eval, graph, plan::Plan, preset::builtin};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Text to tables that know their places, for messages.
//! let document = builtin::document("lampropeltis_triangulum")?;
//!
//! // Anatomy and own nodes to one graph: names resolved, defaults filled, everything checked.
//! let graph = graph::from_document(&document, None)?;
//!
//! // The tile is as large as the animal's counts say; the longer side gets 64 texels.
//! let domain = Domain::from_longer_side(64, graph.girth_mm, graph.length_mm);
//!
//! // Only what these maps need, in order, with its memory known beforehand.
//! let plan = Plan::new(&graph, &[MapKind::Color, MapKind::Height], domain, None)?;
//! assert!(plan.steps.len() < graph.nodes.len());
//!
//! // Planes of f32: three for a colour, one for a height in mm.
//! let evaluation = eval::run(&plan, eval::Control::default())?;
//! let [color, height] = [MapKind::Color, MapKind::Height].map(|kind| &evaluation.maps[&kind].planes);
//! assert_eq!((color.len(), height.len()), (3, 1));
//! assert_eq!((height[0].width(), height[0].height()), (domain.width, 64));
//! # Ok(())
//! # }
//! ```
//!
//! From there [`maps::assemble`] names the planes and gives them their ranges, and `io::write_set` (feature `files`)
//! writes them. `examples/` has this as a program, and also one node alone, an operation of one's own, and a graph
//! built in Rust.
//!
//! # Rooms
//!
//! A room is a folder with one door, its `mod.rs`, on which its contract is written. It imports only rooms above its
//! own line; `tests/suite/layers.rs` holds this table.
//!
//! | Room | What it is | Imports |
//! | --- | --- | --- |
//! | [`base`] | ground floor: plane, domain, hash, numbers, colour, kinds of maps | nothing of ours |
//! | [`optics`] | physics: Fresnel, thin films and their colours, absorption, GGX; it knows no images | `base` |
//! | [`node`] | operations: a file per node, and the registry of all | `base` |
//! | [`preset`] | text: documents with places, includes, overrides, diagnostics, the built-in presets | `base` |
//! | [`skin`] | anatomy: `[scales]`, `[pattern]` and the other sections, lowered to nodes | `base` `node` |
//! | [`graph`] | meaning: everything resolved and checked; JSON Schema, reference pages, drawings | `base` `optics` `node` `preset` `skin` |
//! | [`plan`] | what is needed: live steps, fused, with buffers and bytes | `base` `node` `graph` |
//! | [`eval`] | doing it: the only loops over whole planes | `base` `node` `plan` |
//! | [`maps`] | the texture set, and its values as integers | `base` `optics` `graph` `eval` |
//! | `io` | files: PNG, OpenEXR, manifest, all or nothing (feature `files`) | `base` `optics` `node` `maps` |
//! | `scene` | what renderers see: meshes, materials, lights, cameras (feature `render`) | `base` `optics` `preset` `maps` |
//! | `preview` | the picture now: a scene drawn on a GPU (feature `preview`) | `base` `optics` `scene` |
//! | `reference` | ground truth: a spectral path tracer (feature `render`) | `base` `optics` `scene` |
//! | `report` | what every shortcut costs: errors against times, as a page (feature `render`) | `base` `optics` `node` `graph` `plan` `eval` `maps` `io` `scene` `preview` `reference` |
//! | `viewer` | the window: a snake that turns, and sliders (feature `viewer`) | `base` `preset` `graph` `plan` `eval` `maps` `scene` `preview` |
//! | `cli` | the command (feature `cli`); imported by nothing | all of them |
//!
//! Files are touched in `io` and `cli` only, the environment in `cli`, a clock in `cli`, `report` and `viewer`. `cli`
//! makes the threads, and `viewer` those that keep its window free; every other room works on the rayon pool that calls it.
//! `preview` asks drivers.
//!
//! # Where things are decided
//!
//! - What a value means: coordinates are shares of the tile, `u` around the body (mid-back at 0.5, middle of the belly at
//!   0 = 1) and `v` along it, tail-ward. Lengths are mm, nm, shares of the tile or scales, never texels, so that one
//!   preset at two sizes is the same skin. See [`Domain`](base::Domain).
//! - Where a scale is: `scale_lattice` places every scale once. Height, colour, gloss, film and ids read that one table,
//!   so maps fit each other by construction.
//! - What chance does: [`base::hash`] of (seed, name of the node, place). A node added elsewhere changes nothing.
//! - What is the same everywhere: the planes, at any thread count, SIMD level and platform. Kernels use [`base::num`]
//!   in place of the platform's `sin`, `exp` and `pow`, and no fused multiply-add.
//! - How a node is added: see [`node`].
//!
//! # Features
//!
//! `cli` (default) is the command and needs `files`, which is PNG, OpenEXR and manifests, and `render`, which is scenes, the
//! path tracer and the reports; `preview` (default) draws on a GPU and is what takes longest to build, but for
//! `viewer`, the window. Without any, the library touches no file system and also builds for
//! WebAssembly.
#![warn(unreachable_pub)]

pub mod base;
#[cfg(feature = "cli")]
pub mod cli;
pub mod eval;
pub mod graph;
#[cfg(feature = "files")]
pub mod io;
pub mod maps;
pub mod node;
pub mod optics;
pub mod plan;
pub mod preset;
#[cfg(feature = "preview")]
pub mod preview;
#[cfg(feature = "render")]
pub mod reference;
#[cfg(feature = "render")]
pub mod report;
#[cfg(feature = "render")]
pub mod scene;
pub mod skin;
#[cfg(feature = "viewer")]
pub mod viewer;
