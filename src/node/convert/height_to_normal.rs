//! Tangent-space normals from a height in mm.

use std::ops::Range;

use super::{limit_slope, slope};
use crate::base::Domain;
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// Which way green points.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum NormalFormat {
    /// Green points up the image (+Y up): Blender, Unity, glTF.
    #[default]
    Opengl,
    /// Green points down the image (+Y down): Unreal, 3ds Max.
    Directx,
}

/// Unit normals of the surface `z = height`, from physical slopes, so that they are right at any resolution.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HeightToNormal {
    /// Which way green points: `opengl` up the image, `directx` down it. The wrong one turns bumps into dents.
    pub format: NormalFormat,
}

const HEIGHT: usize = 0;
const STRENGTH: usize = 1;

impl Operation for HeightToNormal {
    const SPEC: Spec = Spec {
        name: "height_to_normal",
        category: Category::Convert,
        summary: "Makes tangent-space normals from a height in mm.",
        inputs: &[
            InputSpec::plane("height", "mm", "Height of the surface."),
            InputSpec::drive(
                "strength",
                1.0,
                (-16.0, 16.0),
                "",
                "Multiplies the slopes: 1 is physical, 2 reads bolder, 0 is flat, negative is carved in.",
            ),
        ],
        outputs: &[OutputSpec::color(
            "normal",
            "Unit normal (x, y, z), each in [-1, 1], not yet encoded; flat is (0, 0, 1).",
        )],
        // A difference over two texels loses 2.5 % of the slope of a wave of 16 texels.
        scale_tolerance: 0.1,
        ..Spec::FILTER
    };

    fn reach(&self, _: &Domain) -> Reach {
        Reach::Around { x: 1, y: 1 }
    }

    fn cost_ns(&self) -> f32 {
        2.0
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let height = ins.scalar(HEIGHT);
        let per_u = 0.5 / cx.domain.texel_u_mm();
        // Rows go down, so a height that grows with y falls towards +Y up: its normal leans up, which is positive.
        let per_v = match self.format {
            NormalFormat::Opengl => 0.5,
            NormalFormat::Directx => -0.5,
        } / cx.domain.texel_v_mm();
        for y in rows {
            let Some([nx, ny, nz]) = outs.color_row(0, y) else { return };
            let (up, here, down) = (height.row(y - 1), height.row(y), height.row(y + 1));
            kernel(up, here, down, ins.row(STRENGTH, y), per_u, per_v, nx, ny, nz);
        }
    }
}

/// Normal of a texel from its four neighbours.
#[inline(always)]
fn normal(left: f32, right: f32, up: f32, down: f32, strength: f32, per_u: f32, per_v: f32) -> [f32; 3] {
    let x = limit_slope(-strength * slope(left, right, per_u));
    let y = limit_slope(strength * slope(up, down, per_v));
    let inv = 1.0 / (1.0 + x * x + y * y).sqrt();
    [x * inv, y * inv, inv]
}

multiversion! {
    fn kernel(
        up: &[f32],
        here: &[f32],
        down: &[f32],
        strength: &[f32],
        per_u: f32,
        per_v: f32,
        nx: &mut [f32],
        ny: &mut [f32],
        nz: &mut [f32],
    ) {
        let n = here.len();
        let (up, down, strength) = (&up[..n], &down[..n], &strength[..n]);
        let (nx, ny, nz) = (&mut nx[..n], &mut ny[..n], &mut nz[..n]);
        // The inside first: its neighbours need no wrapping.
        for x in 1..n.saturating_sub(1) {
            let v = normal(here[x - 1], here[x + 1], up[x], down[x], strength[x], per_u, per_v);
            [nx[x], ny[x], nz[x]] = v;
        }
        for x in [0, n - 1] {
            let (left, right) = (here[(x + n - 1) % n], here[(x + 1) % n]);
            [nx[x], ny[x], nz[x]] = normal(left, right, up[x], down[x], strength[x], per_u, per_v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Plane;
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    fn run(node: &HeightToNormal, domain: &Domain, height: &Plane, strength: f32) -> Vec<Plane> {
        run_node(node, domain, 0, &[Input::Plane(height), Input::Value(strength)], &Assets::new(), 3)
    }

    /// 40 x 20 mm at 4 texels a mm around and 2 along.
    const DOMAIN: Domain = Domain { width: 160, height: 40, girth_mm: 40.0, length_mm: 20.0 };

    #[test]
    fn a_ramp_rising_to_the_right_leans_left_by_its_slope() {
        // 0.75 mm per mm: the normal is (-3, 0, 4) / 5.
        let h = Plane::from_fn(160, 40, |x, _| 0.75 * 0.25 * x as f32);
        let n = run(&HeightToNormal::default(), &DOMAIN, &h, 1.0);
        for (plane, expected) in n.iter().zip([-0.6, 0.0, 0.8]) {
            assert!((plane.at(80, 20) - expected).abs() < 1e-5, "{}", plane.at(80, 20));
        }
    }

    #[test]
    fn a_ramp_rising_downward_is_green_up_in_opengl_and_down_in_directx() {
        let h = Plane::from_fn(160, 40, |_, y| 0.75 * 0.5 * y as f32);
        for (format, sign) in [(NormalFormat::Opengl, 1.0), (NormalFormat::Directx, -1.0)] {
            let n = run(&HeightToNormal { format }, &DOMAIN, &h, 1.0);
            assert!((n[0].at(80, 20)).abs() < 1e-6);
            assert!((n[1].at(80, 20) - sign * 0.6).abs() < 1e-5, "{format:?}");
        }
    }

    #[test]
    fn strength_multiplies_the_slope() {
        let h = Plane::from_fn(160, 40, |x, _| 0.375 * 0.25 * x as f32);
        let n = run(&HeightToNormal::default(), &DOMAIN, &h, 2.0);
        assert!((n[0].at(80, 20) + 0.6).abs() < 1e-5);
        let flat = run(&HeightToNormal::default(), &DOMAIN, &h, 0.0);
        assert!(flat[2].data().iter().all(|&z| z == 1.0));
    }

    #[test]
    fn normals_have_unit_length_and_are_finite_for_any_height() {
        for scale in [1.0, 1e-40, 1e30, f32::MAX] {
            let h = Plane::from_fn(160, 40, |x, y| if (x * 7 + y * 13) % 11 < 5 { scale } else { -scale });
            let n = run(&HeightToNormal::default(), &DOMAIN, &h, 16.0);
            for i in 0..h.data().len() {
                let [x, y, z] = [0, 1, 2].map(|k| n[k].data()[i]);
                let length = (x * x + y * y + z * z).sqrt();
                assert!((length - 1.0).abs() < 1e-5, "{scale}: {x} {y} {z}");
            }
        }
    }

    #[test]
    fn one_texel_is_flat() {
        let n = run(&HeightToNormal::default(), &Domain::square(1), &Plane::filled(1, 1, 3.0), 1.0);
        assert_eq!([n[0].at(0, 0), n[1].at(0, 0), n[2].at(0, 0)], [0.0, 0.0, 1.0]);
    }

    #[test]
    fn a_shift_of_the_height_shifts_the_normals() {
        let h = Plane::from_fn(160, 40, |x, y| ((x * x + 3 * y * x) % 17) as f32 * 0.1);
        let node = HeightToNormal::default();
        let (n, moved) = (run(&node, &DOMAIN, &h, 1.0), run(&node, &DOMAIN, &h.shifted(7, -3), 1.0));
        for k in 0..3 {
            assert_eq!(n[k].shifted(7, -3), moved[k]);
        }
    }
}
