//! What an operation says of itself.

/// Kind of the value on an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// One plane.
    Scalar,
    /// Three planes: linear RGB (or a vector).
    Color,
}

impl Kind {
    /// Planes of a value of this kind.
    pub fn lanes(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Color => 3,
        }
    }

    /// The word in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Scalar => "scalar",
            Self::Color => "color",
        }
    }
}

/// What an input accepts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortKind {
    /// A scalar.
    Scalar,
    /// A colour; a scalar is taken as grey.
    Color,
    /// Either: the node runs once per channel, scalars are taken as grey where any other `Any` input is a colour.
    Any,
}

/// What an input reads when the preset does not set it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fallback {
    /// It must be set.
    Required,
    /// A constant scalar.
    Scalar(f32),
    /// A constant linear colour.
    Color([f32; 3]),
}

/// One input.
#[derive(Clone, Copy, Debug)]
pub struct InputSpec {
    /// Key in the preset.
    pub name: &'static str,
    /// What it accepts.
    pub kind: PortKind,
    /// What it reads when unset.
    pub fallback: Fallback,
    /// Least allowed constant.
    pub min: f32,
    /// Greatest allowed constant.
    pub max: f32,
    /// Unit, empty for pure numbers.
    pub unit: &'static str,
    /// The effect first, then sensible values.
    pub doc: &'static str,
}

impl InputSpec {
    /// A required image of either kind.
    pub const fn image(name: &'static str, doc: &'static str) -> Self {
        Self {
            name,
            kind: PortKind::Any,
            fallback: Fallback::Required,
            min: f32::MIN,
            max: f32::MAX,
            unit: "",
            doc,
        }
    }

    /// A required scalar image.
    pub const fn plane(name: &'static str, unit: &'static str, doc: &'static str) -> Self {
        Self {
            name,
            kind: PortKind::Scalar,
            fallback: Fallback::Required,
            min: f32::MIN,
            max: f32::MAX,
            unit,
            doc,
        }
    }

    /// A number that a map may drive.
    pub const fn drive(
        name: &'static str,
        default: f32,
        range: (f32, f32),
        unit: &'static str,
        doc: &'static str,
    ) -> Self {
        Self {
            name,
            kind: PortKind::Scalar,
            fallback: Fallback::Scalar(default),
            min: range.0,
            max: range.1,
            unit,
            doc,
        }
    }

    /// A required colour.
    pub const fn color(name: &'static str, doc: &'static str) -> Self {
        Self {
            name,
            kind: PortKind::Color,
            fallback: Fallback::Required,
            min: f32::MIN,
            max: f32::MAX,
            unit: "",
            doc,
        }
    }

    /// The same input with another fallback (and kind [`PortKind::Any`] or the one it has).
    pub const fn or(mut self, fallback: Fallback) -> Self {
        self.fallback = fallback;
        self
    }
}

/// The coordinate offsets that every generator takes: it is evaluated at (u + du, v + dv).
///
/// Wire the `du`, `dv` outputs of `scale_lattice` here and the pattern is evaluated at the centre of the scale;
/// wire noise and the domain is warped.
pub const OFFSETS: [InputSpec; 2] = [
    InputSpec::drive(
        "du",
        0.0,
        (-1.0, 1.0),
        "tile",
        "Moves the point at which the node is evaluated, around the body.",
    ),
    InputSpec::drive(
        "dv",
        0.0,
        (-1.0, 1.0),
        "tile",
        "Moves the point at which the node is evaluated, along the body.",
    ),
];

/// Kind of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputKind {
    /// One plane.
    Scalar,
    /// Three planes.
    Color,
    /// As the node's `Any` inputs: a colour if any of them is one.
    Same,
}

/// One output.
#[derive(Clone, Copy, Debug)]
pub struct OutputSpec {
    /// Port name: `node.port`; the first output is also `node`.
    pub name: &'static str,
    /// Kind.
    pub kind: OutputKind,
    /// Unit, empty for pure numbers.
    pub unit: &'static str,
    /// What it holds, with its range.
    pub doc: &'static str,
}

impl OutputSpec {
    /// A scalar output.
    pub const fn scalar(name: &'static str, unit: &'static str, doc: &'static str) -> Self {
        Self { name, kind: OutputKind::Scalar, unit, doc }
    }

    /// A colour (or vector) output.
    pub const fn color(name: &'static str, doc: &'static str) -> Self {
        Self { name, kind: OutputKind::Color, unit: "", doc }
    }

    /// An output of the kind of the node's `Any` inputs.
    pub const fn same(name: &'static str, doc: &'static str) -> Self {
        Self { name, kind: OutputKind::Same, unit: "", doc }
    }
}

/// Where an operation stands in the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Category {
    /// Shapes, gradients and noise.
    Generate,
    /// Instances: scales and tiles.
    Place,
    /// An image from an image around it.
    Filter,
    /// An image from several at a point.
    Combine,
    /// Colour.
    Color,
    /// Models of pigment.
    Pattern,
    /// From one physical quantity to another.
    Convert,
    /// From files.
    Input,
}

impl Category {
    /// The word in the reference.
    pub fn name(self) -> &'static str {
        match self {
            Self::Generate => "generate",
            Self::Place => "place",
            Self::Filter => "filter",
            Self::Combine => "combine",
            Self::Color => "color",
            Self::Pattern => "pattern",
            Self::Convert => "convert",
            Self::Input => "input",
        }
    }
}

/// How far around a texel a node reads its inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// The texel itself: runs of such nodes are fused.
    Point,
    /// At most so many texels to each side, through the torus.
    Around {
        /// Texels around the body.
        x: usize,
        /// Texels along the body.
        y: usize,
    },
    /// Anywhere in the inputs, but rows of the output are independent.
    Anywhere,
    /// The whole plane at once.
    Whole,
}

/// What an operation says of itself.
#[derive(Clone, Copy, Debug)]
pub struct Spec {
    /// `op = "…"` in a preset, snake_case.
    pub name: &'static str,
    /// Category.
    pub category: Category,
    /// One sentence.
    pub summary: &'static str,
    /// Inputs, in the order that `eval` sees them.
    pub inputs: &'static [InputSpec],
    /// Outputs, in the order that `eval` sees them; at least one.
    pub outputs: &'static [OutputSpec],
    /// It depends on the texel's position (a generator): it is not folded where its inputs are constant.
    pub positional: bool,
    /// It reads the node's seed: equal sub-graphs under two names are not merged.
    pub random: bool,
    /// Greatest difference (RMS, in units of the output's spread) between 1024 down-sampled and 256 that the
    /// conformance suite accepts; what differs is what a coarse grid cannot hold.
    pub scale_tolerance: f32,
}

impl Spec {
    /// The usual values of the last three fields: not positional, not random, 5 %.
    pub const FILTER: Self = Self {
        name: "",
        category: Category::Filter,
        summary: "",
        inputs: &[],
        outputs: &[],
        positional: false,
        random: false,
        scale_tolerance: 0.05,
    };

    /// The usual values for a generator: positional, not random, 5 %.
    pub const GENERATOR: Self = Self { category: Category::Generate, positional: true, ..Self::FILTER };

    /// Index of the input of this name.
    pub fn input(&self, name: &str) -> Option<usize> {
        self.inputs.iter().position(|i| i.name == name)
    }

    /// Index of the output of this name.
    pub fn output(&self, name: &str) -> Option<usize> {
        self.outputs.iter().position(|o| o.name == name)
    }
}
