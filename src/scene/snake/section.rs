//! Across the body: the form of its section.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

/// The section of unit girth radius: a closed convex curve of girth 2 pi.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    shape: f64,
    scale: f64,
    /// Half the width.
    pub(super) side: f64,
    /// From the centre line to the back, and to the belly.
    pub(super) up: f64,
    pub(super) down: f64,
}

impl Section {
    pub(super) fn new(shape: f64) -> Self {
        let mut section = Self { shape, scale: 1.0, side: 1.0, up: 1.0, down: 1.0 };
        section.scale = TAU / section.girth(DVec2::ONE);
        section.side = section.points(DVec2::ONE).fold(0.0, |most, p| f64::max(most, p.x));
        section.up = section.at(PI)[0].y;
        section.down = -section.at(0.0)[0].y;
        section
    }

    /// The point (right, up) and its derivative at an angle from the belly over the left side.
    pub(super) fn at(&self, angle: f64) -> [DVec2; 2] {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        let k = self.shape;
        // Narrower towards the back, and the belly pressed flat: y (1 - 0.3 k y^2) below the middle.
        let (width, flat) = (1.0 + 0.22 * k * cos, 0.3 * k * cos.max(0.0) * cos.max(0.0));
        let point = DVec2::new(-sin * width, -cos * (1.0 - flat));
        let rate = DVec2::new(-cos * width + 0.22 * k * sin * sin, sin * (1.0 - 3.0 * flat));
        [point * self.scale, rate * self.scale]
    }

    fn points(&self, axes: DVec2) -> impl Iterator<Item = DVec2> {
        let count = 512;
        (0..=count).map(move |i| self.at(TAU * f64::from(i) / f64::from(count))[0] * axes)
    }

    /// Length around, of the section with these half axes.
    pub(super) fn girth(&self, axes: DVec2) -> f64 {
        *self.lengths(axes).last().unwrap_or(&0.0)
    }

    /// Lengths along the section from the belly.
    pub(super) fn lengths(&self, axes: DVec2) -> Vec<f64> {
        let mut last = None;
        let mut total = 0.0;
        self.points(axes)
            .map(|p| {
                total += last.map_or(0.0, |q: DVec2| q.distance(p));
                last = Some(p);
                total
            })
            .collect()
    }
}
