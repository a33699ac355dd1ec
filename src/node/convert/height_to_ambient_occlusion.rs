//! Ambient occlusion of a height in mm, from horizons.

use std::f32::consts::TAU;
use std::ops::Range;

use super::{STEEPEST, limit_slope, slope};
use crate::base::{Domain, Rows, num};
use crate::multiversion;
use crate::node::{Category, Cx, InputSpec, Inputs, Operation, OutputSpec, Outputs, Reach, Spec};

/// Share of an evenly lit sky that a point of the surface sees, weighted by the cosine to its normal.
///
/// In each of `directions` the highest horizon within `radius` is sought at `steps` distances; the light between
/// it and the tangent plane is taken away exactly. A plane, level or tilted, gives 1 exactly.
///
/// Source: the cosine-weighted integral over a slice of Jimenez et al., "Practical Real-Time Strategies for
/// Accurate Indirect Occlusion" (2016), rewritten for the angle above the tangent plane.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HeightToAmbientOcclusion {
    /// How far walls cast their shade: about one scale's width darkens gaps and overlaps, less only creases.
    #[schemars(range(min = 0.0, max = 100.0), extend("x-unit" = "mm"))]
    pub radius: f32,
    /// Fades walls with the square of their distance: 1 to nothing at `radius`, 0 not at all (the physical answer).
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = ""))]
    pub falloff: f32,
    /// Directions around the point: 16 is smooth on skin, 8 is a draft.
    #[schemars(range(min = 4, max = 64), extend("x-unit" = ""))]
    pub directions: u32,
    /// Distances in each direction, closer together near the point: 8 suffices for scales.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = ""))]
    pub steps: u32,
}

impl Default for HeightToAmbientOcclusion {
    fn default() -> Self {
        Self { radius: 1.0, falloff: 1.0, directions: 16, steps: 8 }
    }
}

const HEIGHT: usize = 0;
const STRENGTH: usize = 1;

/// One place to look at, relative to the texel.
struct Step {
    /// Offset in whole texels, and the rest in [0, 1).
    x: i64,
    y: i64,
    tx: f32,
    ty: f32,
    /// 1 / distance, 1/mm.
    per_mm: f32,
    /// What the falloff leaves of a wall here.
    weight: f32,
}

impl HeightToAmbientOcclusion {
    /// Distance of step `i`, mm: closer together near the point, the last below the radius.
    fn distance(&self, i: u32) -> f32 {
        let t = (i as f32 + 1.0) / (self.steps as f32 + 0.5);
        self.radius * t * t
    }

    /// The steps of a direction given by its cosine and sine.
    fn walk(&self, domain: &Domain, (cos, sin): (f32, f32)) -> Vec<Step> {
        let step = |i| {
            let d = self.distance(i);
            let (x, y) = (d * cos / domain.texel_u_mm(), d * sin / domain.texel_v_mm());
            let (fx, fy) = (x.floor(), y.floor());
            let t = d / self.radius;
            Step {
                x: fx as i64,
                y: fy as i64,
                tx: x - fx,
                ty: y - fy,
                per_mm: 1.0 / d,
                weight: 1.0 - self.falloff * t * t,
            }
        };
        // A radius of 0 sees no wall. Nearer than a texel there is only what interpolation makes up; where even the
        // radius is, the last step stands for all.
        let count = if self.radius > 1e-9 { self.steps } else { 0 };
        let first = (0..count).find(|&i| self.distance(i) >= domain.texel_mm());
        (first.unwrap_or(count.saturating_sub(1))..count).map(step).collect()
    }
}

impl Operation for HeightToAmbientOcclusion {
    const SPEC: Spec = Spec {
        name: "height_to_ambient_occlusion",
        category: Category::Convert,
        summary: "Makes ambient occlusion from a height in mm.",
        inputs: &[
            InputSpec::plane("height", "mm", "Height of the surface."),
            InputSpec::drive(
                "strength",
                1.0,
                (0.0, 4.0),
                "",
                "Multiplies the darkening: 1 is physical, 0 is none, 2 reads bolder.",
            ),
        ],
        outputs: &[OutputSpec::scalar("ambient_occlusion", "", "1 is open, 0 sees no sky.")],
        // Coarse texels are as wide as the default radius: of gentle shade the half is lost.
        scale_tolerance: 0.5,
        ..Spec::FILTER
    };

    fn reach(&self, domain: &Domain) -> Reach {
        let texels = |mm: f32| (self.radius / mm).ceil() as usize + 1;
        Reach::Around { x: texels(domain.texel_u_mm()), y: texels(domain.texel_v_mm()) }
    }

    fn cost_ns(&self) -> f32 {
        self.directions as f32 * (1.2 + 0.3 * self.steps as f32)
    }

    fn eval(&self, cx: &Cx<'_>, rows: Range<i64>, ins: &Inputs<'_>, outs: &mut Outputs<'_>) {
        let height = ins.scalar(HEIGHT);
        if height.constant().is_some() {
            rows.for_each(|y| outs.only(y).fill(1.0));
            return;
        }
        let turns = |k| (k as f32 + 0.5) / self.directions as f32;
        let ways: Vec<_> = (0..self.directions)
            .map(|k| (num::cos_turns(turns(k)), num::sin_turns(turns(k))))
            .map(|way| (way, self.walk(&cx.domain, way)))
            .collect();
        let (per_u, per_v) = (0.5 / cx.domain.texel_u_mm(), 0.5 / cx.domain.texel_v_mm());
        let n = outs.width();
        let mut scratch = vec![0.0f32; 5 * n];
        let [slope_u, slope_v, tangent, excess, sum] = {
            let mut parts = scratch.chunks_exact_mut(n);
            [(); 5].map(|()| parts.next().expect("five parts were allocated"))
        };
        for y in rows {
            slopes(height.row(y - 1), height.row(y), height.row(y + 1), per_u, per_v, slope_u, slope_v);
            sum.fill(0.0);
            for ((cos, sin), walk) in &ways {
                along(slope_u, slope_v, *cos, *sin, tangent);
                excess.fill(0.0);
                for step in walk {
                    look(&height, y, step, tangent, excess);
                }
                darken(tangent, excess, sum);
            }
            let share = 0.5 / self.directions as f32;
            finish(slope_u, slope_v, sum, ins.row(STRENGTH, y), share, outs.only(y));
        }
    }
}

/// Raise `excess` (height of the horizon above the tangent plane, per mm) by what stands at `step` of row `y`.
fn look(height: &Rows<'_>, y: i64, step: &Step, tangent: &[f32], excess: &mut [f32]) {
    let here = height.row(y);
    let (r0, r1) = (height.row(y + step.y), height.row(y + step.y + 1));
    let n = here.len();
    // Texel x looks between columns x + shift and x + shift + 1: contiguous in two parts, and one texel whose
    // columns are the last and the first.
    let shift = step.x.rem_euclid(n as i64) as usize;
    let seam = n - 1 - shift;
    let &Step { tx, ty, per_mm, weight, .. } = step;
    let mut part = |to: Range<usize>, left: usize, right: usize| {
        let (l, r) = (left..left + to.len(), right..right + to.len());
        let (h, t, e) = (&here[to.clone()], &tangent[to.clone()], &mut excess[to]);
        rise(&r0[l.clone()], &r0[r.clone()], &r1[l], &r1[r], h, t, tx, ty, per_mm, weight, e);
    };
    part(0..seam, shift, shift + 1);
    part(seam..seam + 1, n - 1, 0);
    part(seam + 1..n, 0, 1);
}

multiversion! {
    fn rise(
        r0_left: &[f32],
        r0_right: &[f32],
        r1_left: &[f32],
        r1_right: &[f32],
        here: &[f32],
        tangent: &[f32],
        tx: f32,
        ty: f32,
        per_mm: f32,
        weight: f32,
        excess: &mut [f32],
    ) {
        let n = excess.len();
        let (r0_left, r0_right) = (&r0_left[..n], &r0_right[..n]);
        let (r1_left, r1_right) = (&r1_left[..n], &r1_right[..n]);
        let (here, tangent) = (&here[..n], &tangent[..n]);
        for x in 0..n {
            let a = num::lerp(r0_left[x], r0_right[x], tx);
            let b = num::lerp(r1_left[x], r1_right[x], tx);
            let rise = (num::lerp(a, b, ty) - here[x]) * per_mm - tangent[x];
            // `max` keeps the old value where heights near the largest f32 overflow to NaN.
            excess[x] = excess[x].max(rise * weight);
        }
    }
}

multiversion! {
    /// Slopes of the surface along u and v.
    fn slopes(
        up: &[f32],
        here: &[f32],
        down: &[f32],
        per_u: f32,
        per_v: f32,
        slope_u: &mut [f32],
        slope_v: &mut [f32],
    ) {
        let n = here.len();
        for x in 1..n.saturating_sub(1) {
            slope_u[x] = slope(here[x - 1], here[x + 1], per_u);
        }
        for x in [0, n - 1] {
            slope_u[x] = slope(here[(x + n - 1) % n], here[(x + 1) % n], per_u);
        }
        for ((s, up), down) in slope_v.iter_mut().zip(up).zip(down) {
            *s = slope(*up, *down, per_v);
        }
    }
}

multiversion! {
    /// Slope of the tangent plane in a direction.
    fn along(slope_u: &[f32], slope_v: &[f32], cos: f32, sin: f32, tangent: &mut [f32]) {
        for ((t, u), v) in tangent.iter_mut().zip(slope_u).zip(slope_v) {
            *t = limit_slope(u * cos + v * sin);
        }
    }
}

multiversion! {
    /// Add the light that a horizon hides. With `delta` the angle from the tangent plane (slope g) to the horizon,
    /// the slice's integral loses `1 - cos 2 delta + g (sin 2 delta - 2 delta)`, over the length of (g_u, g_v, 1).
    fn darken(tangent: &[f32], excess: &[f32], sum: &mut [f32]) {
        for ((sum, g), e) in sum.iter_mut().zip(tangent).zip(excess) {
            let e = e.min(STEEPEST);
            // (x, y) points along delta: tan delta = e / (1 + g (g + e)).
            let (x, y) = (1.0 + g * (g + e), e);
            let inv = 1.0 / (x * x + y * y);
            let delta = TAU * num::atan2_turns(y, x);
            *sum += 2.0 * y * y * inv + g * (2.0 * x * y * inv - 2.0 * delta);
        }
    }
}

multiversion! {
    fn finish(
        slope_u: &[f32],
        slope_v: &[f32],
        sum: &[f32],
        strength: &[f32],
        share: f32,
        out: &mut [f32],
    ) {
        let n = out.len();
        let (slope_u, slope_v) = (&slope_u[..n], &slope_v[..n]);
        let (sum, strength) = (&sum[..n], &strength[..n]);
        for x in 0..n {
            let length = (1.0 + slope_u[x] * slope_u[x] + slope_v[x] * slope_v[x]).sqrt();
            let occluded = num::saturate(sum[x] * share / length);
            out[x] = num::saturate(1.0 - strength[x].max(0.0) * occluded);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Plane;
    use crate::eval::{Input, run_node};
    use crate::node::Assets;

    fn run(node: &HeightToAmbientOcclusion, domain: &Domain, height: &Plane) -> Plane {
        run_node(node, domain, 0, &[Input::Plane(height)], &Assets::new(), 5).remove(0)
    }

    /// No falloff, and finer than the default: closed forms apply.
    fn exact(radius: f32) -> HeightToAmbientOcclusion {
        HeightToAmbientOcclusion { radius, falloff: 0.0, directions: 64, steps: 64 }
    }

    /// 60 mm around at 0.1 mm, and short along: the profiles below do not depend on v.
    const LONG: Domain = Domain { width: 600, height: 4, girth_mm: 60.0, length_mm: 0.4 };

    #[test]
    fn a_plane_level_or_tilted_is_fully_open() {
        let node = HeightToAmbientOcclusion { radius: 2.0, ..Default::default() };
        let flat = Plane::filled(32, 32, 0.7);
        assert!(run(&node, &Domain::square(32), &flat).data().iter().all(|&v| v == 1.0));
        // A tilted plane cannot close on the torus: look away from the seam.
        let tilted = Plane::from_fn(600, 4, |x, _| 0.125 * x as f32);
        let ao = run(&node, &LONG, &tilted);
        assert!((ao.at(300, 2) - 1.0).abs() < 1e-5, "{}", ao.at(300, 2));
    }

    /// A step wall of height h at distance d hides `(1 - d / sqrt(d^2 + h^2)) / 2` of the floor's sky.
    #[test]
    fn the_floor_before_a_wall_has_the_known_form_factor() {
        // The wall top lies at 20 .. 40 mm; walls beyond the radius are not seen, which costs at most 1 %.
        let h = 1.0f32;
        let height = Plane::from_fn(600, 4, |x, _| if (200..400).contains(&x) { h } else { 0.0 });
        let ao = run(&exact(12.0), &LONG, &height);
        for texels in [5, 10, 20, 40] {
            let d = 0.1 * texels as f32;
            let expected = 0.5 * (1.0 + d / (d * d + h * h).sqrt());
            let seen = ao.at(200 - texels, 1);
            assert!((seen - expected).abs() < 0.012, "d {d}: {seen}, expected {expected}");
        }
        // The negative control: the level top of the wall is open.
        assert_eq!(ao.at(300, 1), 1.0);
    }

    /// The bottom of a V-groove whose walls rise at angle beta sees cos(beta) of the sky.
    #[test]
    fn the_bottom_of_a_groove_sees_the_cosine_of_its_slope() {
        for tan in [0.25f32, 0.5, 1.0, 2.0] {
            let height = Plane::from_fn(600, 4, |x, _| tan * 0.1 * (x as f32 - 300.0).abs());
            let ao = run(&exact(25.0), &LONG, &height).at(300, 2);
            let expected = 1.0 / (1.0 + tan * tan).sqrt();
            assert!((ao - expected).abs() < 0.004, "tan {tan}: {ao}, expected {expected}");
        }
    }

    /// For a profile that does not change along v, a point sees (sin a + sin b) / 2 of its sky, a and b being the
    /// angles from its normal to the two horizons.
    #[test]
    fn a_corrugated_surface_agrees_with_its_profile_in_f64() {
        let f = |mm: f64| 0.8 * (std::f64::consts::TAU * mm / 6.0).sin();
        let height = Plane::from_fn(600, 4, |x, _| f(0.1 * x as f64) as f32);
        let ao = run(&exact(28.0), &LONG, &height);
        for x in (0..60).step_by(3) {
            let at = 0.1 * f64::from(x);
            let normal = std::f64::consts::FRAC_PI_2 + ((f(at + 0.1) - f(at - 0.1)) / 0.2).atan();
            let seen = |side: f64| {
                let rise = |i: u32| (f(at + side * 0.02 * f64::from(i)) - f(at)) / (0.02 * f64::from(i));
                let horizon = (1..1400).map(rise).fold(f64::NEG_INFINITY, f64::max).atan();
                let horizon = if side > 0.0 { horizon } else { std::f64::consts::PI - horizon };
                (normal - horizon).abs().min(std::f64::consts::FRAC_PI_2).sin()
            };
            let expected = 0.5 * (seen(1.0) + seen(-1.0));
            let got = f64::from(ao.at(i64::from(x), 1));
            assert!((got - expected).abs() < 0.01, "{x}: {got}, expected {expected}");
        }
    }

    #[test]
    fn falloff_and_a_small_radius_lighten_and_radius_0_is_open() {
        let height = Plane::from_fn(600, 4, |x, _| if (200..400).contains(&x) { 1.0 } else { 0.0 });
        let at = |node: HeightToAmbientOcclusion| run(&node, &LONG, &height).at(195, 1);
        let full = at(exact(5.0));
        assert!(at(HeightToAmbientOcclusion { falloff: 1.0, ..exact(5.0) }) > full);
        assert_eq!(at(exact(0.3)), 1.0);
        assert_eq!(at(exact(0.0)), 1.0);
    }

    #[test]
    fn wild_heights_stay_in_range() {
        for scale in [1e-40, 1.0, 1e30, f32::MAX] {
            let height = Plane::from_fn(24, 24, |x, y| if (x * 7 + y * 5) % 9 < 4 { scale } else { -scale });
            let node = HeightToAmbientOcclusion { radius: 20.0, ..Default::default() };
            let ao = run(&node, &Domain::square(24), &height);
            assert!(ao.data().iter().all(|v| (0.0..=1.0).contains(v)), "{scale}");
        }
        assert_eq!(run(&exact(10.0), &Domain::square(1), &Plane::filled(1, 1, 2.0)).at(0, 0), 1.0);
    }

    #[test]
    fn a_shift_of_the_height_shifts_the_occlusion() {
        let height = Plane::from_fn(31, 17, |x, y| ((x * x + 5 * y * x + y) % 13) as f32);
        let node = HeightToAmbientOcclusion { radius: 40.0, ..Default::default() };
        let domain = Domain { width: 31, height: 17, girth_mm: 60.0, length_mm: 34.0 };
        let ao = run(&node, &domain, &height);
        assert_eq!(ao.shifted(11, -6), run(&node, &domain, &height.shifted(11, -6)));
    }
}
