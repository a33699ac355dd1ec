//! A picture from a file.

use std::ops::Range;

use super::resample::{Tap, shrink};
use crate::base::color::srgb_to_linear;
use crate::base::{Domain, Plane, num};
use crate::multiversion;
use crate::node::spec::OFFSETS;
use crate::node::{Asset, Category, Cx, Inputs, Operation, OutputSpec, Outputs, Prepared, Spec};

/// How the picture covers the tile.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Fit {
    /// Once, stretched to the tile.
    #[default]
    Stretch,
    /// `repeats_u` times `repeats_v` times.
    Tile,
}

/// What the numbers in the file mean.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Encoding {
    /// Linear for `.exr`, sRGB for all else.
    #[default]
    Auto,
    /// Encoded for a screen: drawings and photographs.
    Srgb,
    /// The numbers themselves: masks, heights and other data.
    Linear,
}

/// Which number of the picture is its `value`.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Relative luminance (Rec. 709 weights).
    #[default]
    Luminance,
    /// Mean of red, green and blue.
    Average,
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Coverage; 1 where the file has none.
    Alpha,
}

/// A picture from a PNG or EXR file: a drawn shape, a mask, a height or a pattern of your own.
///
/// Where the picture is finer than the texture it is averaged over each texel's area, else read bilinearly. Averages
/// are of linear light, weighted by coverage, so that what lies under transparent texels does not bleed out.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Image {
    /// The file, relative to the preset: `"mask.png"`.
    pub file: String,
    /// How the picture covers the tile: `stretch` once, or `tile` by the repeats. Only a picture that itself tiles is
    /// seamless.
    pub fit: Fit,
    /// Pictures around the body, with `fit = "tile"`.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = ""))]
    pub repeats_u: u32,
    /// Pictures along the body, with `fit = "tile"`.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = ""))]
    pub repeats_v: u32,
    /// What the numbers in the file mean: `srgb` for pictures, `linear` for masks and heights, `auto` by the file's
    /// ending.
    pub encoding: Encoding,
    /// Which number of the picture is its `value`: `luminance`, `average`, `red`, `green`, `blue` or `alpha`.
    pub channel: Channel,
}

impl Default for Image {
    fn default() -> Self {
        Self {
            file: String::new(),
            fit: Fit::default(),
            repeats_u: 1,
            repeats_v: 1,
            encoding: Encoding::default(),
            channel: Channel::default(),
        }
    }
}

const DU: usize = 0;
const DV: usize = 1;
const COLOR: usize = 0;
const VALUE: usize = 1;
const ALPHA: usize = 2;

/// The picture, linear and no finer than the texture.
struct Picture {
    width: usize,
    height: usize,
    /// Grey, or R G B; multiplied by the coverage where there is one.
    channels: Vec<Plane>,
    alpha: Option<Plane>,
}

impl Picture {
    /// Red, green, blue and coverage at a tap.
    fn read(&self, tap: &Tap) -> ([f32; 3], f32) {
        let one = |k: usize| tap.read(self.channels[k].data());
        let mut color = if self.channels.len() == 3 { [one(0), one(1), one(2)] } else { [one(0); 3] };
        let Some(alpha) = &self.alpha else { return (color, 1.0) };
        let coverage = num::saturate(tap.read(alpha.data()));
        // Under no coverage there is no colour to know.
        color = if coverage > 0.0 { color.map(|c| finite(c / coverage)) } else { [0.0; 3] };
        (color, coverage)
    }
}

impl Image {
    fn repeats(&self) -> (usize, usize) {
        match self.fit {
            Fit::Stretch => (1, 1),
            Fit::Tile => (self.repeats_u.max(1) as usize, self.repeats_v.max(1) as usize),
        }
    }

    fn is_srgb(&self) -> bool {
        match self.encoding {
            Encoding::Srgb => true,
            Encoding::Linear => false,
            Encoding::Auto => !self.file.to_ascii_lowercase().ends_with(".exr"),
        }
    }

    /// The picture of an asset; `None` where its planes do not fit together.
    fn picture(&self, asset: &Asset, domain: &Domain) -> Option<Picture> {
        let first = asset.channels.first()?;
        let (w, h) = (first.width(), first.height());
        let fits = |p: &Plane| (p.width(), p.height()) == (w, h);
        if w * h == 0 || !asset.channels.iter().chain(&asset.alpha).all(fits) {
            return None;
        }
        // Texels of the texture under one picture.
        let (ru, rv) = self.repeats();
        let size = (domain.width.div_ceil(ru), domain.height.div_ceil(rv));
        let mut channels = Vec::new();
        for channel in asset.channels.iter().take(if asset.channels.len() >= 3 { 3 } else { 1 }) {
            let mut plane = channel.clone();
            decode(self.is_srgb(), plane.data_mut());
            if let Some(alpha) = &asset.alpha {
                cover(alpha.data(), plane.data_mut());
            }
            channels.push(shrink(plane, size.0, size.1));
        }
        let alpha = asset.alpha.clone().map(|a| shrink(a, size.0, size.1));
        Some(Picture { width: channels[0].width(), height: channels[0].height(), channels, alpha })
    }

    /// The `value` output.
    fn value(&self, [r, g, b]: [f32; 3], alpha: f32) -> f32 {
        match self.channel {
            Channel::Luminance => 0.2126 * r + 0.7152 * g + 0.0722 * b,
            Channel::Average => r / 3.0 + g / 3.0 + b / 3.0,
            Channel::Red => r,
            Channel::Green => g,
            Channel::Blue => b,
            Channel::Alpha => alpha,
        }
    }
}

impl Operation for Image {
    const SPEC: Spec = Spec {
        name: "image",
        category: Category::Input,
        summary: "Reads a picture from a PNG or EXR file.",
        inputs: &[OFFSETS[0], OFFSETS[1]],
        outputs: &[
            OutputSpec::color("color", "The picture, linear RGB; 0 where it is wholly transparent."),
            OutputSpec::scalar("value", "", "One number of the picture, by `channel`."),
            OutputSpec::scalar("alpha", "", "Coverage, 0 to 1; 1 where the file has none."),
        ],
        ..Spec::GENERATOR
    };

    fn cost_ns(&self) -> f32 {
        45.0
    }

    fn files(&self) -> Vec<&str> {
        vec![&self.file]
    }

    fn prepare(&self, cx: &Cx<'_>) -> Option<Prepared> {
        let picture = cx.assets.get(&self.file).and_then(|asset| self.picture(asset, &cx.domain));
        Some(Box::new(picture))
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let n = outs.width();
        let picture = cx.prepared::<Option<Picture>>();
        let (ru, rv) = self.repeats();
        let mut texels = vec![([0.0f32; 3], 0.0f32); n];
        for y in rows {
            // A file that is not there reads as 0; who loads the files reports it.
            if let Some(picture) = picture {
                let (du, dv) = (ins.row(DU, y), ins.row(DV, y));
                let (width, height) = (picture.width, picture.height);
                for (x, texel) in texels.iter_mut().enumerate() {
                    // Wrapped twice: the repeats must not multiply an offset of many tiles.
                    let u = num::fract(num::fract(cx.domain.u(x) + du[x]) * ru as f32);
                    let v = num::fract(num::fract(cx.domain.v(y) + dv[x]) * rv as f32);
                    *texel = picture.read(&Tap::new(u * width as f32, v * height as f32, width, height));
                }
            }
            if let Some([r, g, b]) = outs.color_row(COLOR, y) {
                for (x, (color, _)) in texels.iter().enumerate() {
                    [r[x], g[x], b[x]] = *color;
                }
            }
            if let Some(out) = outs.row(VALUE, y) {
                for (o, (color, alpha)) in out.iter_mut().zip(&texels) {
                    *o = self.value(*color, *alpha);
                }
            }
            if let Some(out) = outs.row(ALPHA, y) {
                for (o, (_, alpha)) in out.iter_mut().zip(&texels) {
                    *o = *alpha;
                }
            }
        }
    }
}

/// Largest value that a file may hold here: sums of a few stay finite.
const LARGEST: f32 = 1e37;

/// `x` within [`LARGEST`]; NaN reads as 0.
#[inline(always)]
fn finite(x: f32) -> f32 {
    let x = if x.is_nan() { 0.0 } else { x };
    x.max(-LARGEST).min(LARGEST)
}

multiversion! {
    /// Values as stored to linear light; values that are not finite, as float files may hold, become so.
    fn decode(srgb: bool, texels: &mut [f32]) {
        for t in texels.iter_mut() {
            let x = finite(*t);
            *t = if srgb { srgb_to_linear(num::saturate(x)) } else { x };
        }
    }
}

multiversion! {
    /// Multiply by the coverage.
    fn cover(alpha: &[f32], texels: &mut [f32]) {
        for (t, a) in texels.iter_mut().zip(alpha) {
            *t *= num::saturate(*a);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    fn node(file: &str) -> Image {
        Image { file: file.into(), encoding: Encoding::Linear, ..Default::default() }
    }

    fn assets(channels: Vec<Plane>, alpha: Option<Plane>) -> Assets {
        Assets::from([("a.png".to_owned(), Arc::new(Asset { channels, alpha }))])
    }

    /// Lanes r, g, b, value, alpha.
    fn run(node: &Image, domain: Domain, assets: &Assets, offset: (f32, f32)) -> Vec<Plane> {
        run_node(node, &domain, 0, &[Input::Value(offset.0), Input::Value(offset.1)], assets, 3)
    }

    fn ramp(w: usize, h: usize) -> Plane {
        Plane::from_fn(w, h, |x, y| (x + w * y) as f32 / 64.0)
    }

    #[test]
    fn at_its_own_size_the_picture_comes_through_as_it_is() {
        let p = ramp(8, 8);
        let out = run(&node("a.png"), Domain::square(8), &assets(vec![p.clone()], None), (0.0, 0.0));
        for k in 0..3 {
            assert_eq!(out[k], p);
        }
        assert!(out[4].data().iter().all(|&a| a == 1.0));
        // Grey has its own luminance, but for the rounding of the weights.
        assert!(out[3].data().iter().zip(p.data()).all(|(a, b)| (a - b).abs() < 1e-6));
    }

    #[test]
    fn offsets_shift_it_on_the_torus() {
        let p = ramp(8, 8);
        let out = run(&node("a.png"), Domain::square(8), &assets(vec![p.clone()], None), (0.25, -0.125));
        assert_eq!(out[0], p.shifted(-2, 1));
    }

    #[test]
    fn a_finer_picture_is_averaged_over_each_texel() {
        // Checks of one texel would alias to all black or all white.
        let p = Plane::from_fn(64, 64, |x, y| ((x + y) % 2) as f32);
        let out = run(&node("a.png"), Domain::square(8), &assets(vec![p], None), (0.0, 0.0));
        assert!(out[0].data().iter().all(|&v| (v - 0.5).abs() < 1e-6));
        let out = run(&node("a.png"), Domain::square(4), &assets(vec![ramp(8, 8)], None), (0.0, 0.0));
        assert_eq!(out[0], ramp(8, 8).halved());
    }

    #[test]
    fn repeats_tile_it() {
        let p = ramp(4, 8);
        let tiled = Image { fit: Fit::Tile, repeats_u: 4, repeats_v: 2, ..node("a.png") };
        let out = run(&tiled, Domain::square(16), &assets(vec![p.clone()], None), (0.0, 0.0));
        assert_eq!(out[0], Plane::from_fn(16, 16, |x, y| p.at(x as i64, y as i64)));
    }

    #[test]
    fn srgb_is_decoded_before_it_is_averaged_and_exr_is_not_decoded() {
        let p = Plane::from_vec(2, 1, vec![0.0, 1.0]);
        let one = Domain { width: 1, height: 1, girth_mm: 1.0, length_mm: 1.0 };
        let auto = Image { encoding: Encoding::Auto, ..node("a.png") };
        // Averaged first it would be the decoded 0.5, that is 0.214.
        let out = run(&auto, one, &assets(vec![p.clone()], None), (0.0, 0.0));
        assert!((out[0].at(0, 0) - 0.5).abs() < 1e-6);
        let grey = Plane::filled(1, 1, 0.5);
        let out = run(&auto, one, &assets(vec![grey.clone()], None), (0.0, 0.0));
        assert!((out[0].at(0, 0) - 0.214_041).abs() < 1e-5);
        let exr = Assets::from([("b.EXR".to_owned(), Arc::new(Asset { channels: vec![grey], alpha: None }))]);
        assert_eq!(run(&Image { file: "b.EXR".into(), ..auto }, one, &exr, (0.0, 0.0))[0].at(0, 0), 0.5);
    }

    #[test]
    fn what_lies_under_transparent_texels_does_not_bleed() {
        let red = Plane::from_vec(2, 1, vec![1.0, 0.0]);
        let green = Plane::from_vec(2, 1, vec![0.0, 1.0]);
        let blue = Plane::filled(2, 1, 0.0);
        let alpha = Plane::from_vec(2, 1, vec![0.5, 0.0]);
        let assets = assets(vec![red, green, blue], Some(alpha));
        let domain = Domain { width: 1, height: 1, girth_mm: 1.0, length_mm: 1.0 };
        let out = run(&node("a.png"), domain, &assets, (0.0, 0.0));
        assert_eq!([0, 1, 2, 4].map(|k| out[k].at(0, 0)), [1.0, 0.0, 0.0, 0.25]);
        // And a wholly transparent texel has no colour.
        let out = run(&node("a.png"), Domain { width: 2, ..domain }, &assets, (0.0, 0.0));
        assert_eq!([0, 1, 2, 4].map(|k| out[k].at(1, 0)), [0.0; 4]);
    }

    #[test]
    fn each_channel_is_its_definition() {
        let lanes = [0.3, 0.6, 0.15].map(|v| Plane::filled(1, 1, v)).to_vec();
        let assets = assets(lanes, Some(Plane::filled(1, 1, 0.5)));
        for (channel, expected) in [
            (Channel::Luminance, 0.503_73),
            (Channel::Average, 0.35),
            (Channel::Red, 0.3),
            (Channel::Green, 0.6),
            (Channel::Blue, 0.15),
            (Channel::Alpha, 0.5),
        ] {
            let node = Image { channel, ..node("a.png") };
            let got = run(&node, Domain::square(1), &assets, (0.0, 0.0))[3].at(0, 0);
            assert!((got - expected).abs() < 1e-6, "{channel:?}: {got}");
        }
    }

    #[test]
    fn a_missing_or_broken_file_reads_as_0() {
        let none = run(&node("a.png"), Domain::square(4), &Assets::new(), (0.0, 0.0));
        assert!(none.iter().all(|p| p.data().iter().all(|&v| v == 0.0)));
        for broken in [
            assets(Vec::new(), None),
            assets(vec![Plane::default()], None),
            assets(vec![ramp(4, 4)], Some(ramp(2, 2))),
        ] {
            let out = run(&node("a.png"), Domain::square(4), &broken, (0.0, 0.0));
            assert!(out.iter().all(|p| p.data().iter().all(|&v| v == 0.0)));
        }
        assert_eq!(Operation::files(&node("a.png")), ["a.png"]);
    }

    #[test]
    fn wild_texels_and_offsets_stay_finite() {
        let wild = Plane::from_vec(3, 2, vec![f32::NAN, f32::INFINITY, f32::MAX, -f32::MAX, 1e-40, 1e30]);
        let faint = Plane::filled(3, 2, 1e-40);
        for (alpha, size) in [(None, 1), (None, 7), (Some(faint.clone()), 1), (Some(faint), 7)] {
            let assets = assets(vec![wild.clone()], alpha);
            for offset in [0.0, 1e30, -1e30, 1e-40, f32::MAX] {
                let out = run(&node("a.png"), Domain::square(size), &assets, (offset, -offset));
                assert!(out.iter().all(|p| p.data().iter().all(|v| v.is_finite())), "{offset} {out:?}");
            }
        }
    }
}
