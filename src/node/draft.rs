//! Nodes by name, not yet wired: what the anatomy and a preset's own nodes both become.

use std::ops::Range;
use std::sync::Arc;

use super::{Node, Operation};
use crate::base::{LinearRgb, Srgb8};

/// What an input is set to.
#[derive(Clone, Debug, PartialEq)]
pub enum Wire {
    /// A number.
    Scalar(f32),
    /// A colour, linear.
    Color(LinearRgb),
    /// An output by name: `node` (its first output) or `node.port`.
    Output(String),
}

impl Wire {
    /// Another output of the same node.
    ///
    /// # Panics
    /// If this is a constant: only a node has ports.
    pub fn port(&self, port: &str) -> Self {
        match self {
            Self::Output(name) => {
                let node = name.split('.').next().unwrap_or(name);
                Self::Output(format!("{node}.{port}"))
            }
            _ => panic!("a constant has no port {port}"),
        }
    }
}

impl From<f32> for Wire {
    fn from(v: f32) -> Self {
        Self::Scalar(v)
    }
}

impl From<Srgb8> for Wire {
    fn from(c: Srgb8) -> Self {
        Self::Color(c.into())
    }
}

impl From<LinearRgb> for Wire {
    fn from(c: LinearRgb) -> Self {
        Self::Color(c)
    }
}

impl From<&Self> for Wire {
    fn from(w: &Self) -> Self {
        w.clone()
    }
}

/// One input as it was written.
#[derive(Clone, Debug, PartialEq)]
pub struct InputDraft {
    /// Input name.
    pub name: String,
    /// What it is set to.
    pub wire: Wire,
    /// Where the value stands in the preset, if it does.
    pub span: Option<Range<usize>>,
}

/// One node as it was written.
#[derive(Clone, Debug)]
pub struct NodeDraft {
    /// Unique name; randomness hangs on it.
    pub name: String,
    /// Operation and settings.
    pub node: Arc<dyn Node>,
    /// Inputs that are set.
    pub inputs: Vec<InputDraft>,
    /// Where it stands in the preset, if it does.
    pub span: Option<Range<usize>>,
}

/// An ordered list of nodes with unique names.
#[derive(Clone, Debug, Default)]
pub struct Draft {
    /// The nodes, in the order they were added.
    pub nodes: Vec<NodeDraft>,
}

impl Draft {
    /// Add a node made by the program; returns its first output.
    ///
    /// # Panics
    /// If an input is not in the node's spec or the name is taken: a broken invariant of the lowering.
    pub fn add<T: Operation>(&mut self, name: impl Into<String>, node: T, inputs: &[(&str, Wire)]) -> Wire {
        let name = name.into();
        assert!(self.find(&name).is_none(), "two nodes are named {name}");
        for (input, _) in inputs {
            assert!(T::SPEC.input(input).is_some(), "{} has no input {input}", T::SPEC.name);
        }
        let inputs = inputs
            .iter()
            .map(|(input, wire)| InputDraft { name: (*input).to_owned(), wire: wire.clone(), span: None })
            .collect();
        self.nodes.push(NodeDraft { name: name.clone(), node: Arc::new(node), inputs, span: None });
        Wire::Output(name)
    }

    /// The node of this name.
    pub fn find(&self, name: &str) -> Option<&NodeDraft> {
        self.nodes.iter().find(|n| n.name == name)
    }

    /// Add a node, or replace the one of the same name in place.
    pub fn put(&mut self, draft: NodeDraft) {
        match self.nodes.iter_mut().find(|n| n.name == draft.name) {
            Some(node) => *node = draft,
            None => self.nodes.push(draft),
        }
    }
}
