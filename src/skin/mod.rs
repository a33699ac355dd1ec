//! ANATOMY: a preset's typed sections, in the words of a herpetologist and a texture artist, lowered to nodes.
//!
//! `[body]`, `[scales]`, `[pattern]`, `[color]`, `[belly]`, `[surface]` and `[iridescence]` are structs, one file each,
//! with a default, a unit and a range for every field. [`lower`] turns them into a [`Draft`] of nodes and the maps
//! that they define; nothing after it knows what a snake is.
//!
//! Table 5.1 of the thesis, parameter by parameter: Seed → `seed`; ScaleType → `scales.shape`; ScaleAmount →
//! `scales.rows` and `body.scale_pitch_mm`; ScaleSize → `scales.size`; ScaleKeeled → `scales.keel`; PatternType →
//! `pattern.class` and a layer's `kind`; PatternAmount → a layer's `amount`; PatternSize → its `reach`, `length` or
//! `size`; PatternOutlineSize → its `outline`; EdgeDistortion → `pattern.edge_distortion`; BellySize → `belly.width`.

mod belly;
mod body;
mod color;
mod iridescence;
mod lowering;
mod pattern;
mod scales;
mod surface;

use std::collections::BTreeMap;

use crate::base::MapKind;
use crate::node::convert::{
    HeightToAmbientOcclusion, HeightToCurvature, HeightToNormal, HeightToTranslucency,
};
use crate::node::draft::{Draft, Wire};
use crate::node::pattern::{Activation, Reaction};
use crate::node::{Operation, ParamError};

pub use belly::{Belly, BellyPattern};
pub use body::Body;
pub use color::Color;
pub use iridescence::Iridescence;
pub use pattern::{Class, Layer, LayerKind, Pattern};
pub use scales::Scales;
pub use surface::Surface;

use lowering::Lowering;

/// A preset's anatomy: every section.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Skin {
    /// The tile's physical size.
    pub body: Body,
    /// Form and lattice of the scales.
    pub scales: Scales,
    /// Layers of marks.
    pub pattern: Pattern,
    /// Ground colour and what each scale wears.
    pub color: Color,
    /// Width and colours of the belly.
    pub belly: Belly,
    /// Gloss and micro-relief.
    pub surface: Surface,
    /// The film on the scales.
    pub iridescence: Iridescence,
}

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
/// Settings that contradict each other; [`ParamError::key`] is a path such as `scales.rows` or `pattern.layers[1].name`.
pub fn lower(skin: &Skin) -> Result<Lowered, Vec<ParamError>> {
    let lattice = skin.scales.lattice(&skin.body, &skin.belly);
    let errors = check(skin, &lattice.check());
    if !errors.is_empty() {
        return Err(errors);
    }
    let body = &skin.body;
    let has_scutes = lattice.ventrals > 0;
    let belly = if has_scutes { skin.belly.width } else { 0.0 };
    let mut draft = Draft::default();
    let scales = draft.add("scales", lattice.clone(), &[]);
    let mut l = Lowering {
        draft: &mut draft,
        scales,
        girth_mm: body.girth_mm(),
        length_mm: body.length_mm(),
        row_mm: body.girth_mm() * (1.0 - belly) / lattice.rows as f32,
        pitch_mm: body.scale_pitch_mm,
        belly,
        repeats: body.repeats,
        lattice,
    };

    // Colour: ground, layers of the back, belly, layers that go round, then what each scale wears.
    let ground = skin.color.ground(&mut l);
    let painted = pattern::Painted { color: ground, mask: None, rough: Vec::new() };
    let mut painted = skin.pattern.paint(&mut l, painted, false);
    painted.color = skin.belly.paint(&mut l, painted.color);
    if let Some(mask) = painted.mask.take() {
        painted.mask = Some(l.dorsal_only("pattern_back", mask));
    }
    let painted = skin.pattern.paint(&mut l, painted, true);
    let color = skin.color.dress(&mut l, painted.color);

    // Surface and what follows from its height.
    let height = skin.surface.height(&mut l);
    let roughness = skin.surface.roughness(&mut l, &painted.rough);
    let film = skin.iridescence.film(&mut l);
    let from_height = |h: &Wire| vec![("height", h.clone())];
    let normal = l.add("normal", HeightToNormal::default(), &from_height(&height));
    // Lengths of both follow the scale, so that they mean the same on a worm snake and on a python.
    let occlusion = HeightToAmbientOcclusion {
        radius: 0.8 * l.pitch_mm.min(100.0),
        falloff: 0.5,
        directions: 8,
        steps: 6,
    };
    let occlusion = l.add(
        "ambient_occlusion",
        occlusion,
        &[("height", height.clone()), ("strength", skin.surface.occlusion.into())],
    );
    let curvature = HeightToCurvature { radius: (0.03 * l.row_mm).min(20.0) };
    let curvature = l.add("curvature", curvature, &from_height(&height));
    let translucency = l.add(
        "translucency",
        HeightToTranslucency::default(),
        &[
            ("height", height.clone()),
            ("mean_free_path", (0.6 * l.lattice.relief.max(0.01) * l.pitch_mm).into()),
        ],
    );

    let max_mm = max_height_mm(&l, &skin.surface);
    let scale_count = l.lattice.rows * l.lattice.count + l.lattice.ventrals;
    let id = l.scales.port("id");
    // A rim's bend over the blur above; keels and rough presets stay below it.
    let curvature_max = 30.0 / l.row_mm;
    let maps = BTreeMap::from([
        (MapKind::Color, (color, [0.0, 1.0])),
        (MapKind::Height, (height, [0.0, max_mm])),
        (MapKind::Normal, (normal, [-1.0, 1.0])),
        (MapKind::Roughness, (roughness, [0.0, 1.0])),
        (MapKind::Iridescence, (film, [0.0, skin.iridescence.max_nm()])),
        (MapKind::AmbientOcclusion, (occlusion, [0.0, 1.0])),
        (MapKind::Curvature, (curvature, [-curvature_max, curvature_max])),
        (MapKind::Translucency, (translucency, [0.0, 1.0])),
        (MapKind::ScaleId, (id, [0.0, scale_count as f32])),
        (MapKind::PatternMask, (painted.mask.unwrap_or(Wire::Scalar(0.0)), [0.0, 1.0])),
    ]);
    Ok(Lowered { size_mm: [body.girth_mm(), body.length_mm()], draft, maps })
}

/// Greatest height that scales, keels, micro-relief and wrinkles can add up to, mm.
fn max_height_mm(l: &Lowering<'_>, surface: &Surface) -> f32 {
    let relief = l.lattice.relief * l.pitch_mm;
    let ventral = if l.lattice.ventrals > 0 {
        l.lattice.ventral_relief * l.length_mm / l.lattice.ventrals as f32
    } else {
        0.0
    };
    let jitter = 1.0 + l.lattice.jitter_height;
    let widest = l.lattice.lowest.max(l.lattice.vertebral).max(1.0);
    let dorsal = relief * jitter + l.lattice.keel * l.row_mm * widest;
    (dorsal.max(ventral * jitter) + relief * (surface.micro_relief + surface.skin_wrinkles)).max(1e-4)
}

fn check(skin: &Skin, lattice: &[ParamError]) -> Vec<ParamError> {
    let mut errors: Vec<ParamError> = lattice
        .iter()
        .map(|e| {
            ParamError::new(
                "scales.rows",
                e.message.clone(),
                "lower `scales.rows`, `body.repeats` or `body.period_scales`",
            )
        })
        .collect();
    let mut names: Vec<&str> = Vec::new();
    for (i, layer) in skin.pattern.layers.iter().enumerate() {
        let key = format!("pattern.layers[{i}]");
        let sound = layer.name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_');
        if !sound || layer.name.len() > 40 {
            errors.push(ParamError::new(
                &format!("{key}.name"),
                format!("layer name {:?} cannot name nodes", layer.name),
                "use up to 40 of a-z, 0-9 and _",
            ));
        }
        if !layer.name.is_empty() && names.contains(&layer.name.as_str()) {
            errors.push(ParamError::new(
                &format!("{key}.name"),
                format!("two layers are named {:?}", layer.name),
                "give each layer a name of its own",
            ));
        }
        names.push(&layer.name);
        let custom = (layer.kind == LayerKind::Reaction && layer.reaction == Reaction::Custom)
            || (layer.kind == LayerKind::Automaton && layer.activation == Activation::Custom);
        if custom {
            errors.push(ParamError::new(
                &format!("{key}.kind"),
                "a layer takes a named reaction or automaton, not `custom`",
                "for rates of your own add a node `gray_scott` or `young_automaton` and wire it in",
            ));
        }
        if layer.kind == LayerKind::Sketch && layer.file.is_empty() {
            errors.push(ParamError::new(
                &format!("{key}.kind"),
                "a sketch needs its image",
                "set `file = \"sketch.png\"`, relative to the preset",
            ));
        }
        if layer.from >= layer.to {
            errors.push(ParamError::new(
                &format!("{key}.from"),
                format!("from = {} is not before to = {}", layer.from, layer.to),
                "a layer shows between `from` and `to`: 0 is the mid-back, 1 the belly's edge",
            ));
        }
    }
    errors
}
