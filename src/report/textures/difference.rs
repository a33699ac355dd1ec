//! How far two maps are apart: in the map's own unit, and as an eye or a light sees it.

use crate::base::MapKind;
use crate::eval::MapPlanes;
use crate::optics::cie;
use crate::report::metric::quantile;

/// The texels of a map, channel by channel.
#[derive(Clone, Debug)]
pub(super) struct Texels {
    pub(super) kind: MapKind,
    pub(super) width: usize,
    pub(super) channels: Vec<Vec<f64>>,
}

impl Texels {
    /// Those of an evaluated map.
    pub(super) fn of(kind: MapKind, map: &MapPlanes) -> Self {
        let wide = |data: &[f32]| data.iter().map(|v| f64::from(*v)).collect();
        let channels = map.planes.iter().map(|plane| wide(plane.data())).collect();
        Self { kind, width: map.planes[0].width(), channels }
    }

    /// Number of texels.
    pub(super) fn len(&self) -> usize {
        self.channels[0].len()
    }

    /// A texel as a colour or a vector.
    fn triple(&self, i: usize) -> [f64; 3] {
        std::array::from_fn(|c| self.channels[c.min(self.channels.len() - 1)][i])
    }
}

/// A difference as it is seen, over all texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Seen {
    /// `dE2000` of colours, `degrees` between normals.
    pub(super) unit: &'static str,
    pub(super) mean: f64,
    /// What 99 of 100 texels stay within.
    pub(super) most: f64,
    pub(super) worst: f64,
}

/// How far one map is from another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Difference {
    /// Greatest difference of a channel, in the map's unit; of ids 1 where any differs.
    pub(super) max: f64,
    /// Root of the mean square over texels and channels; of ids the root of the share that differs.
    pub(super) rms: f64,
    /// Of colours and normals.
    pub(super) seen: Option<Seen>,
}

impl Difference {
    /// Of two maps of one kind and size.
    pub(super) fn between(ours: &Texels, truth: &Texels) -> Self {
        // Ids are names: how far apart two are means nothing.
        let apart = |a: f64, b: f64| match ours.kind {
            MapKind::ScaleId => f64::from(u8::from(a != b)),
            _ => (a - b).abs(),
        };
        let (mut max, mut squares) = (0.0f64, 0.0);
        for (a, b) in ours.channels.iter().zip(&truth.channels) {
            for (a, b) in a.iter().zip(b) {
                let e = apart(*a, *b);
                // A NaN is the worst of all, and `max` would lose it.
                max = if e.is_nan() { f64::INFINITY } else { max.max(e) };
                squares += e * e;
            }
        }
        let count = ours.len() * ours.channels.len();
        Self { max, rms: (squares / count.max(1) as f64).sqrt(), seen: seen(ours, truth) }
    }

    /// Whether there is none.
    pub(super) fn is_none(&self) -> bool {
        self.max == 0.0
    }
}

fn seen(ours: &Texels, truth: &Texels) -> Option<Seen> {
    let unit = match ours.kind {
        MapKind::Color => "dE2000",
        MapKind::Normal => "degrees",
        _ => return None,
    };
    let apart = |a, b| match ours.kind {
        MapKind::Normal => degrees(a, b),
        _ => cie::delta_e_2000(cie::lab(a), cie::lab(b)),
    };
    let each = |i: usize| {
        let (a, b) = (ours.triple(i), truth.triple(i));
        if a == b { 0.0 } else { apart(a, b) }
    };
    let all: Vec<f64> = (0..ours.len()).map(each).collect();
    let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
    Some(Seen { unit, mean, most: quantile(&all, 0.99), worst: quantile(&all, 1.0) })
}

/// Angle between two vectors, degrees: exact for the smallest, too.
fn degrees(a: [f64; 3], b: [f64; 3]) -> f64 {
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let length = cross.iter().map(|v| v * v).sum::<f64>().sqrt();
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    libm::atan2(length, dot).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(kind: MapKind, channels: &[&[f64]]) -> Texels {
        Texels { kind, width: channels[0].len(), channels: channels.iter().map(|c| c.to_vec()).collect() }
    }

    #[test]
    fn max_and_rms_are_those_of_the_definitions() {
        let a = map(MapKind::Height, &[&[1.0, 2.0, 3.0, 4.0]]);
        let b = map(MapKind::Height, &[&[1.0, 2.0, 3.3, 3.6]]);
        let found = Difference::between(&a, &b);
        assert!((found.max - 0.4).abs() < 1e-12 && (found.rms - 0.25).abs() < 1e-12, "{found:?}");
        assert_eq!(found.seen, None);
        assert!(Difference::between(&a, &a).is_none() && !found.is_none());
        let none = map(MapKind::Height, &[&[f64::NAN, 2.0, 3.0, 4.0]]);
        assert_eq!(Difference::between(&none, &a).max, f64::INFINITY);
    }

    #[test]
    fn normals_are_apart_by_their_angle() {
        let turned = |degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            map(MapKind::Normal, &[&[sin], &[0.0], &[cos]])
        };
        for angle in [1e-6, 0.5, 30.0, 90.0, 179.0] {
            let seen = Difference::between(&turned(angle), &turned(0.0)).seen.expect("normals are seen");
            assert!((seen.mean / angle - 1.0).abs() < 1e-9 && seen.unit == "degrees", "{angle}: {seen:?}");
        }
    }

    /// Of greys CIEDE2000 is the difference of lightness over 1 + 0.015 (L - 50)^2 / sqrt(20 + (L - 50)^2).
    #[test]
    fn colours_are_apart_by_ciede2000() {
        let grey = |v: f64| map(MapKind::Color, &[&[v], &[v], &[v]]);
        let lightness = |v: f64| 116.0 * v.cbrt() - 16.0;
        for (a, b) in [(0.2, 0.21), (0.5, 0.9)] {
            let (la, lb) = (lightness(a), lightness(b));
            let middle = ((la + lb) * 0.5 - 50.0).powi(2);
            let expected = (la - lb).abs() / (1.0 + 0.015 * middle / (20.0 + middle).sqrt());
            let seen = Difference::between(&grey(a), &grey(b)).seen.expect("colours are seen");
            assert!((seen.worst - expected).abs() < 1e-6 && seen.mean == seen.worst, "{seen:?} {expected}");
        }
    }

    #[test]
    fn of_ids_only_equality_counts() {
        let (a, b) = (
            map(MapKind::ScaleId, &[&[1.0, 2.0, 3.0, 4.0]]),
            map(MapKind::ScaleId, &[&[1.0, 2.0, 3.0, 9e3]]),
        );
        let found = Difference::between(&a, &b);
        assert_eq!((found.max, found.rms), (1.0, 0.5));
    }
}
