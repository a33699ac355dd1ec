//! `[pattern]`: layers of marks over the ground.

use serde::{Deserialize, Serialize};

use super::lowering::Lowering;
use crate::base::Srgb8;
use crate::node::combine::{Add, Max};
use crate::node::draft::Wire;
use crate::node::filter::{Distance, Invert, Levels, Warp};
use crate::node::generate::{Basis, Fractal, Sum, Worley};
use crate::node::input::Image;
use crate::node::pattern::{
    Activation, BodyStripe, GrayScott, MarkShape, Marks, Reaction, Sides, YoungAutomaton,
};

/// The six classes of snake patterns (Pinheiro and Walter; thesis 3.1.1). It only says what the layers amount to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Class {
    /// One colour.
    #[default]
    Solid,
    /// Stripes from neck to tail.
    LongitudinalStripes,
    /// Rings or bands across the body.
    Rings,
    /// Spots, round, ringed or irregular.
    Spots,
    /// Irregular marks along the body: saddles, blotches, diamonds.
    Simple,
    /// Intricate camouflage.
    Complex,
}

/// What a layer draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LayerKind {
    /// A series of marks along the body: `amount`, `shape`, `sides`, `position`, `reach`, `length`, `taper`.
    #[default]
    Marks,
    /// Rings right round the body: `amount`, `length`.
    Rings,
    /// A stripe along the body, at `row`, `rows` wide; a mirrored pair where `row` is not 0.
    Stripe,
    /// Irregular patches of noise: `size` in scales, `coverage`.
    Irregular,
    /// Round-edged spots, scattered: `size` in scales, `coverage`.
    Spots,
    /// Single scales chosen by chance: `coverage`; `size` gathers them in clusters of that many scales.
    Scatter,
    /// Fine dots within the scales: `size` in scales, `coverage`.
    Speckle,
    /// What a reaction and diffusion of pigment make: `reaction`, `size` (one period) in scales.
    Reaction,
    /// What Young's cellular automaton makes: `activation`, `size` (one period) in scales.
    Automaton,
    /// A drawing of one's own: `file`, bright is mark; it gets the outlines and the distortion of any other layer.
    Sketch,
}

/// One layer of the pattern. Lateral lengths are in flanks: 0 mid-back, 1 the belly's edge, above 1 the belly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Layer {
    /// Name, for overrides and nodes; `layer1`, `layer2` and so on if not set.
    pub name: String,
    /// What it draws.
    pub kind: LayerKind,
    /// Colour of the marks.
    pub color: Srgb8,
    /// Colour of their inside; the same if not set.
    pub inner_color: Option<Srgb8>,
    /// Where the inside begins, from the marks' outline.
    #[schemars(range(min = 0.0, max = 100.0), extend("x-unit" = "row widths"))]
    pub inner: f32,
    /// Colour of the outline around the marks; none if not set.
    pub outline_color: Option<Srgb8>,
    /// Width of the outline.
    #[schemars(range(min = 0.0, max = 20.0), extend("x-unit" = "row widths"))]
    pub outline: f32,
    /// Colour of a second outline around the first; none if not set.
    pub halo_color: Option<Srgb8>,
    /// Width of the second outline.
    #[schemars(range(min = 0.0, max = 20.0), extend("x-unit" = "row widths"))]
    pub halo: f32,
    /// Marks per pattern repeat.
    #[schemars(range(min = 0.05, max = 100.0))]
    pub amount: f32,
    /// Outline of a mark.
    pub shape: MarkShape,
    /// On the mid-back, on both sides, or in turn.
    pub sides: Sides,
    /// Where the series lies, for `both` and `alternate`.
    #[schemars(range(min = 0.0, max = 1.6), extend("x-unit" = "flank"))]
    pub position: f32,
    /// How far a mark reaches to each side of its centre.
    #[schemars(range(min = 0.0, max = 4.0), extend("x-unit" = "flank"))]
    pub reach: f32,
    /// Length of a mark, as a share of its period.
    #[schemars(range(min = 0.0, max = 3.0), extend("x-unit" = "period"))]
    pub length: f32,
    /// Length at the far end against the middle: 1 rectangle, 0 rhomb, 0.5 saddle, above 1 hourglass.
    #[schemars(range(min = 0.0, max = 5.0))]
    pub taper: f32,
    /// Bends a mark into a V.
    #[schemars(range(min = -4.0, max = 4.0), extend("x-unit" = "lengths"))]
    pub chevron: f32,
    /// Rounding of a mark's corners.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roundness: f32,
    /// Moves the series along the body.
    #[schemars(range(min = -1.0, max = 1.0), extend("x-unit" = "period"))]
    pub offset: f32,
    /// Random shift of each mark along the body.
    #[schemars(range(min = 0.0, max = 0.5), extend("x-unit" = "period"))]
    pub jitter: f32,
    /// Random size of each mark.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub jitter_size: f32,
    /// Random shift of a mark's left half against its right.
    #[schemars(range(min = 0.0, max = 0.5), extend("x-unit" = "period"))]
    pub slip: f32,
    /// Neighbouring marks melt together over this distance.
    #[schemars(range(min = 0.0, max = 2.0), extend("x-unit" = "period"))]
    pub blend: f32,
    /// Row of a stripe's middle, counted from the mid-back.
    #[schemars(range(min = 0.0, max = 500.0), extend("x-unit" = "rows"))]
    pub row: f32,
    /// Width of a stripe.
    #[schemars(range(min = 0.0, max = 500.0), extend("x-unit" = "rows"))]
    pub rows: f32,
    /// Size of patches, spots, clusters or dots.
    #[schemars(range(min = 0.02, max = 200.0), extend("x-unit" = "scales"))]
    pub size: f32,
    /// Share of the skin that patches, spots, chosen scales or dots take.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub coverage: f32,
    /// Which reaction; the names are those of the node `gray_scott`, without `custom`.
    pub reaction: Reaction,
    /// Which automaton; the names are those of the node `young_automaton`, without `custom`.
    pub activation: Activation,
    /// Image file of a sketch, relative to the preset: PNG or EXR, spread over the whole tile.
    pub file: String,
    /// Strength of the edges' distortion by noise; the pattern's if not set.
    #[schemars(range(min = 0.0, max = 10.0), extend("x-unit" = "row widths"))]
    pub edge_distortion: Option<f32>,
    /// How far colour keeps to whole scales; the pattern's if not set.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub quantise: Option<f32>,
    /// Half width of the blend across an edge.
    #[schemars(range(min = 0.0, max = 10.0), extend("x-unit" = "row widths"))]
    pub softness: f32,
    /// How much it hides what lies beneath.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub opacity: f32,
    /// It begins here.
    #[schemars(range(min = 0.0, max = 1.6), extend("x-unit" = "flank"))]
    pub from: f32,
    /// It ends here; above 1 it goes on over the belly.
    #[schemars(range(min = 0.0, max = 4.0), extend("x-unit" = "flank"))]
    pub to: f32,
    /// Width of the blend at `from` and `to`.
    #[schemars(range(min = 0.001, max = 2.0), extend("x-unit" = "flank"))]
    pub fade: f32,
    /// Roughness of the marks; as the rest if not set. 0.95 for velvet black.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: Option<f32>,
    /// Only inside (or, negative, outside) what the layer below covers: 1 inside, -1 outside, 0 everywhere.
    #[schemars(range(min = -1, max = 1))]
    pub within: i32,
}

impl Default for Layer {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: LayerKind::Marks,
            color: Srgb8([0x2a, 0x20, 0x18]),
            inner_color: None,
            inner: 1.0,
            outline_color: None,
            outline: 1.0,
            halo_color: None,
            halo: 1.0,
            amount: 1.0,
            shape: MarkShape::Quad,
            sides: Sides::Middle,
            position: 0.6,
            reach: 0.5,
            length: 0.5,
            taper: 0.7,
            chevron: 0.0,
            roundness: 0.4,
            offset: 0.0,
            jitter: 0.06,
            jitter_size: 0.1,
            slip: 0.0,
            blend: 0.0,
            row: 0.0,
            rows: 1.0,
            size: 4.0,
            coverage: 0.3,
            reaction: Reaction::Spots,
            activation: Activation::Spots,
            file: String::new(),
            edge_distortion: None,
            quantise: None,
            softness: 0.15,
            opacity: 1.0,
            from: 0.0,
            to: 1.0,
            fade: 0.04,
            roughness: None,
            within: 0,
        }
    }
}

/// `[pattern]`: the class, what all layers share, and the layers, lowest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Pattern {
    /// What the layers amount to.
    pub class: Class,
    /// How far colour keeps to whole scales: 1 each scale has one colour, 0 the pattern ignores scales.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub quantise: f32,
    /// Strength of the edges' distortion by noise.
    #[schemars(range(min = 0.0, max = 10.0), extend("x-unit" = "row widths"))]
    pub edge_distortion: f32,
    /// Size of the distortion's waves.
    #[schemars(range(min = 0.1, max = 50.0), extend("x-unit" = "scales"))]
    pub edge_scales: f32,
    /// The layers, lowest first.
    pub layers: Vec<Layer>,
}

impl Default for Pattern {
    fn default() -> Self {
        Self {
            class: Class::Solid,
            quantise: 0.8,
            edge_distortion: 0.5,
            edge_scales: 2.5,
            layers: Vec::new(),
        }
    }
}

impl Layer {
    /// From the outside in: halo, outline, mark, inside, those that it has; each with its colour and the depth at which the
    /// distance is cut, row widths.
    fn rings(&self) -> impl Iterator<Item = (&'static str, Srgb8, f32)> {
        let outline = if self.outline_color.is_some() { self.outline } else { 0.0 };
        let halo = if self.halo_color.is_some() { self.halo } else { 0.0 };
        let rings = [
            ("halo", self.halo_color, -(outline + halo)),
            ("outline", self.outline_color, -outline),
            ("mark", Some(self.color), 0.0),
            ("inner", self.inner_color, self.inner),
        ];
        rings.into_iter().filter_map(|(ring, color, depth)| Some((ring, color?, depth)))
    }

    /// Half width of the blend across an edge, mm.
    fn soft_mm(&self, l: &Lowering<'_>) -> f32 {
        (self.softness * l.row_mm).max(1e-4)
    }

    /// Distances to its outline between which its colours change, mm, with room for rounding: what is farther out is not
    /// covered at all, what is deeper inside is covered whole.
    fn matters_mm(&self, l: &Lowering<'_>) -> [f32; 2] {
        let depths = || self.rings().map(|(.., depth)| depth * l.row_mm);
        let (least, greatest) = (depths().fold(0.0, f32::min), depths().fold(0.0, f32::max));
        let soft = self.soft_mm(l);
        let room = 0.01 * soft + 1e-4 * (greatest - least);
        [least - soft - room, greatest + soft + room]
    }
}

/// What the layers add to: colour, pattern mask, and roughness by layer.
pub(super) struct Painted {
    pub(super) color: Wire,
    /// Union of the masks; `None` without layers.
    pub(super) mask: Option<Wire>,
    /// Masks of layers with a roughness of their own.
    pub(super) rough: Vec<(Wire, f32)>,
}

impl Pattern {
    /// Paint the layers that go (`over_belly`) over the belly scutes too, or those that do not, on `under`.
    pub(super) fn paint(&self, l: &mut Lowering<'_>, mut under: Painted, over_belly: bool) -> Painted {
        let mut below: Option<Wire> = None;
        for (i, layer) in self.layers.iter().enumerate() {
            if (layer.to > 1.0) != over_belly {
                continue;
            }
            let name = if layer.name.is_empty() { format!("layer{}", i + 1) } else { layer.name.clone() };
            let mask = self.paint_layer(l, layer, &name, &mut under, below.as_ref());
            below = Some(mask);
        }
        under
    }

    fn paint_layer(
        &self,
        l: &mut Lowering<'_>,
        layer: &Layer,
        name: &str,
        under: &mut Painted,
        below: Option<&Wire>,
    ) -> Wire {
        let quantise = layer.quantise.unwrap_or(self.quantise);
        let distance = self.distance(l, layer, name, quantise);
        let window = window(l, layer, name, below);
        let soft = layer.soft_mm(l);

        let mut outermost: Option<Wire> = None;
        for (ring, color, depth) in layer.rings() {
            let depth_mm = depth * l.row_mm;
            let mut mask = l.add(
                format!("{name}_{ring}_cut"),
                Levels::default(),
                &[
                    ("image", distance.clone()),
                    ("in_low", (depth_mm - soft).into()),
                    ("in_high", (depth_mm + soft).into()),
                    ("out_high", layer.opacity.into()),
                ],
            );
            if let Some(window) = &window {
                mask = l.multiply(format!("{name}_{ring}_mask"), mask, window.clone());
            }
            under.color = l.mix(format!("{name}_{ring}"), under.color.clone(), color.into(), mask.clone());
            outermost.get_or_insert(mask);
        }
        let mask = outermost.unwrap_or(Wire::Scalar(0.0));
        under.mask = Some(match under.mask.take() {
            None => mask.clone(),
            Some(other) => {
                l.add(format!("{name}_union"), Max::default(), &[("a", other), ("b", mask.clone())])
            }
        });
        if let Some(roughness) = layer.roughness {
            under.rough.push((mask.clone(), roughness));
        }
        mask
    }

    /// Signed distance to the layer's outline, mm, positive inside.
    fn distance(&self, l: &mut Lowering<'_>, layer: &Layer, name: &str, quantise: f32) -> Wire {
        let (du, dv) = l.offsets(quantise);
        let at = [("du", du.clone()), ("dv", dv.clone())];
        let scale_mm = (l.pitch_mm * l.row_mm * 2.0).sqrt();
        match layer.kind {
            LayerKind::Marks | LayerKind::Rings => {
                let rings = layer.kind == LayerKind::Rings;
                let count = ((layer.amount * l.repeats as f32).round() as u32).max(1);
                // Marks melt together also where they are not seen.
                let melting_mm = 1.01 * layer.blend * l.length_mm / count as f32;
                let marks = Marks {
                    count,
                    shape: if rings { MarkShape::Quad } else { layer.shape },
                    sides: if rings { Sides::Middle } else { layer.sides },
                    position: layer.position,
                    reach: if rings { 4.0 } else { layer.reach },
                    length: layer.length,
                    taper: if rings { 1.0 } else { layer.taper },
                    chevron: layer.chevron,
                    roundness: if rings { 0.0 } else { layer.roundness },
                    offset: layer.offset,
                    jitter: layer.jitter,
                    jitter_size: layer.jitter_size,
                    slip: layer.slip,
                    blend: layer.blend,
                    belly: l.belly,
                    farthest: self.distortion_mm(l, layer) - layer.matters_mm(l)[0] + melting_mm,
                };
                let marks = l.add(format!("{name}_marks"), marks, &at);
                self.distorted(l, layer, name, "ragged", quantise, marks)
            }
            LayerKind::Stripe => {
                let half = 0.5 * layer.rows;
                let outer = l.lattice.row_position(layer.row + half);
                let inner = if layer.row >= half {
                    l.lattice.row_position(layer.row - half)
                } else {
                    -l.lattice.row_position(half - layer.row)
                };
                let stripe = BodyStripe { position: (0.5 * (outer + inner)).max(0.0), width: outer - inner };
                let stripe = l.add(format!("{name}_stripe"), stripe, &at);
                self.distorted(l, layer, name, "ragged", quantise, stripe)
            }
            LayerKind::Irregular => {
                let size_mm = layer.size * scale_mm;
                let (cells_u, cells_v) = l.cells(2.0 * size_mm);
                let noise = l.add(
                    format!("{name}_noise"),
                    Fractal {
                        basis: Basis::Perlin,
                        sum: Sum::Fbm,
                        cells_u,
                        cells_v,
                        octaves: 4,
                        ..Fractal::default()
                    },
                    &at,
                );
                field_distance(l, name, noise, 1.0 - fbm_quantile(layer.coverage), 2.5 * size_mm)
            }
            LayerKind::Spots => {
                let size_mm = layer.size * scale_mm;
                // Spots of radius r on a jittered grid of cell c cover pi r^2 / c^2.
                let radius = (layer.coverage.min(0.7) / std::f32::consts::PI).sqrt();
                let cell_mm = 0.5 * size_mm / radius.max(0.05);
                let (cells_u, cells_v) = l.cells(cell_mm);
                let f1 =
                    l.add(format!("{name}_cells"), Worley { cells_u, cells_v, ..Worley::default() }, &at);
                let spots = field_distance(l, name, f1, radius, -cell_mm);
                self.distorted(l, layer, name, "spots", quantise, spots)
            }
            LayerKind::Scatter => {
                let random = l.scales.port("random");
                let chosen = if layer.size > 1.0 {
                    // A slow noise lowers the bar where clusters are.
                    let noise = l.patches(&format!("{name}_clusters"), layer.size, 2, 1.0, None);
                    let lift = l.add(
                        format!("{name}_lift"),
                        Levels::default(),
                        &[
                            ("image", noise),
                            ("in_low", 0.3.into()),
                            ("in_high", 0.7.into()),
                            ("out_low", (-layer.coverage).into()),
                            ("out_high", layer.coverage.into()),
                        ],
                    );
                    l.add(format!("{name}_chance"), Add::default(), &[("a", random), ("b", lift)])
                } else {
                    random
                };
                field_distance(l, name, chosen, 1.0 - layer.coverage, 20.0 * l.row_mm)
            }
            LayerKind::Reaction | LayerKind::Automaton => {
                let size_mm = layer.size * scale_mm;
                let cells = ((l.girth_mm.min(l.length_mm) / size_mm).round() as u32).clamp(1, 64);
                let field = if layer.kind == LayerKind::Reaction {
                    let node = GrayScott { reaction: layer.reaction, cells, ..GrayScott::default() };
                    l.add(format!("{name}_reaction"), node, &at)
                } else {
                    let node =
                        YoungAutomaton { activation: layer.activation, cells, ..YoungAutomaton::default() };
                    l.add(format!("{name}_automaton"), node, &at)
                };
                let grown = field_distance(l, name, field, 0.5, 0.5 * size_mm);
                self.distorted(l, layer, name, "grown", quantise, grown)
            }
            LayerKind::Sketch => {
                let image = l.add(
                    format!("{name}_image"),
                    Image { file: layer.file.clone(), ..Image::default() },
                    &[],
                );
                let outside = l.add(
                    format!("{name}_outside_mm"),
                    Distance::default(),
                    &[("mask", image.port("value"))],
                );
                let at_scale = l.add(
                    format!("{name}_at_scale"),
                    Warp::default(),
                    &[("image", outside), ("du", du.clone()), ("dv", dv.clone())],
                );
                // The node's distance is negative inside, a layer's positive.
                let inside = l.multiply(format!("{name}_inside_mm"), at_scale, (-1.0).into());
                self.distorted(l, layer, name, "sketch", quantise, inside)
            }
            LayerKind::Speckle => {
                let (cells_u, cells_v) = l.cells(layer.size * scale_mm);
                let noise = l.add(
                    format!("{name}_noise"),
                    Fractal { cells_u, cells_v, octaves: 3, ..Fractal::default() },
                    &[],
                );
                field_distance(
                    l,
                    name,
                    noise,
                    1.0 - fbm_quantile(layer.coverage),
                    2.5 * layer.size * scale_mm,
                )
            }
        }
    }

    /// How far noise pushes a layer's outline either way, mm.
    fn distortion_mm(&self, l: &Lowering<'_>, layer: &Layer) -> f32 {
        (layer.edge_distortion.unwrap_or(self.edge_distortion) * l.row_mm).max(0.0)
    }

    /// A distance to a layer's outline, mm, whose outline noise pushes about. Where that changes no colour there is no noise.
    fn distorted(
        &self,
        l: &mut Lowering<'_>,
        layer: &Layer,
        name: &str,
        result: &str,
        quantise: f32,
        distance: Wire,
    ) -> Wire {
        let strength = self.distortion_mm(l, layer);
        if strength <= 0.0 {
            return distance;
        }
        let [least, greatest] = layer.matters_mm(l);
        let seen = (distance.clone(), [least - strength, greatest + strength]);
        let noise = l.patches(&format!("{name}_edge_noise"), self.edge_scales, 3, quantise, Some(seen));
        let edge = l.add(
            format!("{name}_edge"),
            Levels::default(),
            &[
                ("image", noise),
                ("in_low", 0.2.into()),
                ("in_high", 0.8.into()),
                ("out_low", (-strength).into()),
                ("out_high", strength.into()),
            ],
        );
        l.add(format!("{name}_{result}"), Add::default(), &[("a", distance), ("b", edge)])
    }
}

/// `(value - threshold) * slope`, so that a field's level becomes a distance, mm; a negative slope turns it inside out.
fn field_distance(l: &mut Lowering<'_>, name: &str, field: Wire, threshold: f32, slope_mm: f32) -> Wire {
    let reach = 4.0;
    l.add(
        format!("{name}_field"),
        Levels::default(),
        &[
            ("image", field),
            ("in_low", (threshold - reach).into()),
            ("in_high", (threshold + reach).into()),
            ("out_low", (-reach * slope_mm).into()),
            ("out_high", (reach * slope_mm).into()),
        ],
    )
}

/// The share of the range above which fBm (about normal, mean 0.5, deviation 0.13) covers `coverage` of the plane,
/// as a distance from the top: a logistic fit of the normal quantile, within 0.01.
fn fbm_quantile(coverage: f32) -> f32 {
    let c = coverage.clamp(1e-4, 1.0 - 1e-4);
    0.5 + 0.13 * 0.5513 * crate::base::num::log2(c / (1.0 - c)) * std::f32::consts::LN_2
}

/// Where the layer may show; `None` for everywhere.
fn window(l: &mut Lowering<'_>, layer: &Layer, name: &str, below: Option<&Wire>) -> Option<Wire> {
    let mut window: Option<Wire> = None;
    let and = |l: &mut Lowering<'_>, window: &mut Option<Wire>, part: Wire, step: &str| {
        *window = Some(match window.take() {
            None => part,
            Some(other) => l.multiply(format!("{name}_{step}"), other, part),
        });
    };
    if layer.from > 0.0 {
        let ramp = l.lateral_ramp(
            &format!("{name}_from"),
            layer.from - 0.5 * layer.fade,
            layer.from + 0.5 * layer.fade,
        );
        and(l, &mut window, ramp, "window_from");
    }
    if layer.to < 1.0 {
        let ramp =
            l.lateral_ramp(&format!("{name}_to"), layer.to + 0.5 * layer.fade, layer.to - 0.5 * layer.fade);
        and(l, &mut window, ramp, "window_to");
    }
    if let (Some(below), true) = (below, layer.within != 0) {
        let part = if layer.within > 0 {
            below.clone()
        } else {
            l.add(format!("{name}_outside"), Invert::default(), &[("image", below.clone())])
        };
        and(l, &mut window, part, "window_within");
    }
    window
}
