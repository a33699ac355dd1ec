//! Numbers of the first sun and the first rectangle as constants of a shader: a driver on a CPU takes as long to read a block
//! as to compute what most of it is for. Lights do not move, so that no shader is made anew.

use std::fmt::Write as _;

use super::lamps::{Lamps, Rectangle, Sun};

/// `FIRST_SUN` of suns.wgsl and `FIRST_RECTANGLE` of rectangles.wgsl, where there are any.
pub(super) fn text(lamps: &Lamps) -> String {
    let sun = lamps.suns.first().map(|sun| {
        let Sun { direction, spread, irradiance, texel, shadow } = sun;
        let shadow: Vec<String> = shadow.iter().map(|column| vector(column)).collect();
        let ends = [vector(direction), number(*spread), vector(irradiance), number(*texel)].join(", ");
        format!("const FIRST_SUN = Sun({ends}, mat4x4f({}));\n", shadow.join(", "))
    });
    let rectangle = lamps.rectangles.first().map(|rectangle| {
        let Rectangle { x, first, y, count, z, spread, center, texel, light, scale, .. } = rectangle;
        let Rectangle {
            depth, cell, pivot, over, padding, corner, half_sides, low_steps, high_steps, ..
        } = rectangle;
        let members = [
            vector(x),
            format!("{first}u"),
            vector(y),
            format!("{count}u"),
            vector(z),
            number(*spread),
            vector(center),
            number(*texel),
            vector(light),
            number(*scale),
            vector(depth),
            vector(cell),
            vector(pivot),
            number(*over),
            number(*padding),
            vector(corner),
            vector(half_sides),
            vector(low_steps),
            vector(high_steps),
        ];
        format!("const FIRST_RECTANGLE = Rectangle({});\n", members.join(", "))
    });
    sun.into_iter().chain(rectangle).collect()
}

/// A number that WGSL reads as the same one; what is none is 0.
fn number(x: f32) -> String {
    let finite = if x.is_nan() { 0.0 } else { x.clamp(f32::MIN, f32::MAX) };
    format!("{finite:?}f")
}

fn vector(v: &[f32]) -> String {
    let mut text = format!("vec{}f(", v.len());
    for (i, x) in v.iter().enumerate() {
        let comma = if i > 0 { ", " } else { "" };
        // Text grows without fail.
        let _ = write!(text, "{comma}{}", number(*x));
    }
    text + ")"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_one_of_wgsl() {
        for (x, is) in [(0.0, "0.0f"), (-1.5, "-1.5f"), (1e-30, "1e-30f"), (f32::NAN, "0.0f")] {
            assert_eq!(number(x), is);
        }
        let most = [f32::INFINITY, f32::NEG_INFINITY, 1e-45, 16_777_217.0];
        let source = format!("const A = {};\nfn f() -> vec4f {{ return A; }}", vector(&most));
        naga::front::wgsl::parse_str(&source).expect("it is WGSL");
        assert!(naga::front::wgsl::parse_str(&source.replace("16777216.0f", "inff")).is_err());
    }
}
