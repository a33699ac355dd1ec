//! OPERATIONS: what a graph is made of. A node is one file plus one line of registration.
//!
//! To add a node, write a file in the folder of its category with
//! 1. a serde struct of its settings (`deny_unknown_fields`, `default`; a doc comment, `range` and `x-unit` per field),
//! 2. `impl Operation`: its [`Spec`] (name, inputs, outputs), [`Operation::reach`], [`Operation::cost_ns`] and
//!    [`Operation::eval`],
//!
//! then add its `mod` line and its line in the category's `OPS`. Parsing, messages, schema, the reference page,
//! benches and the conformance suite follow from that one declaration.
//!
//! Every parameter that an artist would drive by a map is an *input* with a default and a range: in a preset its key
//! takes a number, a colour or the name of another node's output.
//!
//! Contract of every node: toroidal, finite outputs for any finite input, the same bytes at any thread count and
//! SIMD level, lengths in tile fractions, scale counts, mm or nm, never in texels.

pub mod color;
pub mod combine;
pub mod convert;
pub mod draft;
pub mod filter;
pub mod generate;
pub mod input;
pub mod pattern;
pub mod place;
pub mod spec;
mod views;

use std::any::Any;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

use serde::{Serialize, de::DeserializeOwned};

pub use spec::{Category, Fallback, InputSpec, Kind, OutputKind, OutputSpec, PortKind, Reach, Spec};
pub use views::{Asset, Assets, Inputs, OutputLanes, Outputs};

use crate::base::Domain;
pub use crate::base::params::{self, ParamError};

/// What an evaluation knows beside its inputs.
#[derive(Clone, Copy)]
pub struct Cx<'a> {
    /// The grid.
    pub domain: Domain,
    /// The node's own seed: a hash of the set's seed and the node's name.
    pub seed: u32,
    /// Image files that the graph's nodes named.
    pub assets: &'a Assets,
    /// What [`Operation::prepare`] made, if anything.
    pub prepared: Option<&'a Prepared>,
}

impl<'a> Cx<'a> {
    /// The value that [`Operation::prepare`] returned.
    ///
    /// # Panics
    /// If the node prepares nothing or another type: a broken invariant of the node.
    pub fn prepared<T: 'static>(&self) -> &'a T {
        self.prepared
            .and_then(|p| p.downcast_ref())
            .expect("the node's prepare() returns the type that its eval() reads")
    }
}

/// A node's own table, made once for a plan and read by every band.
pub type Prepared = Box<dyn Any + Send + Sync>;

/// A node's settings and behaviour, typed. Implement this; [`Node`] follows.
pub trait Operation:
    Clone
    + Debug
    + PartialEq
    + Default
    + Serialize
    + DeserializeOwned
    + schemars::JsonSchema
    + Send
    + Sync
    + 'static
{
    /// Name, inputs, outputs.
    const SPEC: Spec;

    /// Errors that no single field's range can tell (such as `low > high`).
    fn check(&self) -> Vec<ParamError> {
        Vec::new()
    }

    /// How far around a texel it reads its inputs.
    fn reach(&self, domain: &Domain) -> Reach {
        let _ = domain;
        Reach::Point
    }

    /// Estimated cost, ns per texel on one thread; shown by `ophidian graph`.
    fn cost_ns(&self) -> f32;

    /// Bytes that evaluating `rows` rows takes beside inputs and outputs; the plan's peak counts them. A few rows'
    /// worth need no mention.
    fn own_bytes(&self, domain: &Domain, rows: usize) -> u64 {
        let _ = (domain, rows);
        0
    }

    /// The input that the node passes on unchanged, if its settings make it do that: the planner removes it.
    fn forwards(&self) -> Option<usize> {
        None
    }

    /// The input whose rows the only output may be written over, for a node that reads its own texel only: where nobody else
    /// reads them, one buffer serves both. [`Inputs::is_output`] then tells it so.
    fn overwrites(&self) -> Option<usize> {
        None
    }

    /// Image files it reads.
    fn files(&self) -> Vec<&str> {
        Vec::new()
    }

    /// Make the node's own table, if it needs one, before any row is evaluated.
    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        let _ = cx;
        None
    }

    /// Evaluate `rows` (torus rows, `0 <= rows.start`, `rows.end <= domain.height`) of every wanted output.
    ///
    /// Called once with all rows for [`Reach::Whole`] (parallelise inside, in a fixed order); else called for bands
    /// of rows, in parallel (do not parallelise inside).
    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>);
}

/// An [`Operation`] without its type: what a graph holds.
pub trait Node: Debug + Send + Sync {
    /// Name, inputs, outputs.
    fn spec(&self) -> &'static Spec;
    /// See [`Operation::check`].
    fn check(&self) -> Vec<ParamError>;
    /// See [`Operation::reach`].
    fn reach(&self, domain: &Domain) -> Reach;
    /// See [`Operation::cost_ns`].
    fn cost_ns(&self) -> f32;
    /// See [`Operation::own_bytes`].
    fn own_bytes(&self, domain: &Domain, rows: usize) -> u64;
    /// See [`Operation::forwards`].
    fn forwards(&self) -> Option<usize>;
    /// See [`Operation::overwrites`].
    fn overwrites(&self) -> Option<usize>;
    /// See [`Operation::files`].
    fn files(&self) -> Vec<&str>;
    /// See [`Operation::prepare`].
    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared>;
    /// See [`Operation::eval`].
    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>);
    /// Its settings (without inputs), as they would stand in a preset; defaults included.
    fn settings(&self) -> toml::Table;
}

impl<T: Operation> Node for T {
    fn spec(&self) -> &'static Spec {
        const { &T::SPEC }
    }
    fn check(&self) -> Vec<ParamError> {
        Operation::check(self)
    }
    fn reach(&self, domain: &Domain) -> Reach {
        Operation::reach(self, domain)
    }
    fn cost_ns(&self) -> f32 {
        Operation::cost_ns(self)
    }
    fn own_bytes(&self, domain: &Domain, rows: usize) -> u64 {
        Operation::own_bytes(self, domain, rows)
    }
    fn forwards(&self) -> Option<usize> {
        Operation::forwards(self)
    }
    fn overwrites(&self) -> Option<usize> {
        Operation::overwrites(self)
    }
    fn files(&self) -> Vec<&str> {
        Operation::files(self)
    }
    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        Operation::prepare(self, cx)
    }
    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        Operation::eval(self, cx, rows, ins, outs);
    }
    fn settings(&self) -> toml::Table {
        toml::Table::try_from(self).expect("a node's settings are plain data")
    }
}

/// One entry of the [registry](ops): an operation by name.
pub struct Op {
    /// Name, inputs, outputs.
    pub spec: &'static Spec,
    /// Settings from a TOML value (a table with exactly the settings); errors carry the value's span.
    pub parse: fn(toml::de::ValueDeserializer<'_>) -> Result<Arc<dyn Node>, toml::de::Error>,
    /// JSON Schema of the settings.
    pub schema: fn() -> schemars::Schema,
    /// A node with every setting at its default.
    pub default: fn() -> Arc<dyn Node>,
}

impl Op {
    /// The entry of `T`.
    pub const fn of<T: Operation>() -> Self {
        Self {
            spec: const { &T::SPEC },
            parse: |value| Ok(Arc::new(T::deserialize(value)?)),
            schema: || schemars::schema_for!(T),
            default: || Arc::new(T::default()),
        }
    }
}

/// Every operation, by category, in the order of the reference pages.
pub const REGISTRY: &[&[Op]] = &[
    generate::OPS,
    place::OPS,
    filter::OPS,
    combine::OPS,
    color::OPS,
    pattern::OPS,
    convert::OPS,
    input::OPS,
];

/// Every operation.
pub fn ops() -> impl Iterator<Item = &'static Op> {
    REGISTRY.iter().flat_map(|ops| ops.iter())
}

/// The operation of this name.
pub fn find(name: &str) -> Option<&'static Op> {
    ops().find(|op| op.spec.name == name)
}
