//! A snake's body: a section swept along a centre line, closed by a head and the tip of a tail.

mod profile;
mod section;

use std::f64::consts::{PI, TAU};

use glam::{DVec2, Vec2, Vec3};

use self::profile::Profile;
use self::section::Section;
use super::curve::{Curve, Frame};
use super::mesh::Mesh;
use super::pose::{Extent, Pose};
use super::tangents::{self, TangentError};

/// Scales become no smaller than this share of those at midbody, so that the tips do not squeeze endless tiles.
const LEAST_GIRTH: f64 = 0.1;

/// A snake to make a mesh of. Lengths in diameters of the body at its thickest, which are scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snake {
    /// How it lies.
    pub pose: Pose,
    /// Snout to tip of the tail, in [16, 100]; see [`Pose::usual_length_in_diameters`].
    pub length_in_diameters: f32,
    /// The section, in [0, 1]: 0 is round, 1 a loaf with a narrow back and a flat belly. The girth stays.
    pub section: f32,
    /// Triangles wanted, in [1000, 20 million]; the mesh has the nearest number that its grid allows.
    pub triangles: usize,
    /// Size of the texture tile, mm: the girth at midbody, and the length along the body.
    pub tile_mm: [f32; 2],
}

/// Why there is no such snake.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SnakeError {
    /// Too stout, too slender, or no number.
    #[error("a snake is 16 to 100 diameters long, not {0}")]
    Length(f32),
    /// No share.
    #[error("the section is a number from 0, round, to 1, a loaf, not {0}")]
    Section(f32),
    /// Too coarse to be a snake, or too fine for memory.
    #[error("a snake is made of 1000 to 20 million triangles, not {0}")]
    Triangles(usize),
    /// A side that is not finite and positive, or a shape beyond 1:1000.
    #[error("a tile of {0} mm by {1} mm cannot be laid around a body")]
    Tile(f32, f32),
    /// The surface has no tangents; cannot happen for a valid snake.
    #[error(transparent)]
    Tangents(#[from] TangentError),
}

impl Default for Snake {
    fn default() -> Self {
        Self {
            pose: Pose::Coil,
            length_in_diameters: Pose::Coil.usual_length_in_diameters(),
            section: 0.25,
            triangles: 200_000,
            tile_mm: [62.8, 92.4],
        }
    }
}

impl Snake {
    /// Millimetres of one scene unit: girth/pi, so that midbody has the tile's girth.
    pub fn mm_per_unit(&self) -> f32 {
        self.tile_mm[0] / std::f32::consts::PI
    }

    /// The centre line, snout first.
    pub fn curve(&self) -> Result<Curve, SnakeError> {
        self.check()?;
        let length = f64::from(self.length_in_diameters);
        let (profile, section) = (Profile::new(length), Section::new(self.section.into()));
        let extent = |s: f64| {
            let [a, b] = profile.at(s).0;
            Extent { side: a * section.side, up: b * section.up, down: b * section.down }
        };
        self.pose.curve(length, extent).ok_or(SnakeError::Length(self.length_in_diameters))
    }

    /// The mesh: closed, outward, resting on y = 0, with tangents.
    ///
    /// Texture coordinates: u is the share of the girth from the middle of the belly over the left side, the back (0.5) and
    /// the right side; `dv/ds` = tile girth/(local girth x tile length), so that scales keep their proportions.
    pub fn mesh(&self) -> Result<Mesh, SnakeError> {
        let curve = self.curve()?;
        let length = f64::from(self.length_in_diameters);
        let (profile, section) = (Profile::new(length), Section::new(self.section.into()));
        let aspect = f64::from(self.tile_mm[0]) / f64::from(self.tile_mm[1]);
        let along = Along::new(&profile, &section, length, aspect);
        let (around, rings) = grid(self.triangles, along.squares());
        let mut mesh = Mesh::default();
        // The body has the curve's own length: the profile is read in shares of it.
        let stretch = length / curve.length();
        for ring in 0..=rings {
            let (s, v) = along.at(ring as f64 / rings as f64);
            let frame = curve.at(s / stretch);
            let pole = ring == 0 || ring == rings;
            let ring_of = RingOf { frame, v, around };
            if pole {
                let outward = if ring == 0 { -frame.tangent } else { frame.tangent };
                ring_of.pole(outward.as_vec3(), &mut mesh);
            } else {
                ring_of.open(&section, profile.at(s), &mut mesh);
            }
        }
        mesh.triangles = triangles(around as u32, rings as u32);
        let lowest = mesh.positions.iter().fold(f32::INFINITY, |low, p| low.min(p.y));
        for p in &mut mesh.positions {
            p.y -= lowest;
        }
        Ok(tangents::generate(&mesh)?)
    }

    fn check(&self) -> Result<(), SnakeError> {
        if !(16.0..=100.0).contains(&self.length_in_diameters) {
            return Err(SnakeError::Length(self.length_in_diameters));
        }
        if !(0.0..=1.0).contains(&self.section) {
            return Err(SnakeError::Section(self.section));
        }
        if !(1000..=20_000_000).contains(&self.triangles) {
            return Err(SnakeError::Triangles(self.triangles));
        }
        check_tile(self.tile_mm).map_err(|[girth, length]| SnakeError::Tile(girth, length))
    }
}

/// A tile whose sides are positive, finite, and of like size.
pub(super) fn check_tile(tile_mm: [f32; 2]) -> Result<(), [f32; 2]> {
    let [girth, length] = tile_mm;
    let good = (1e-3..=1e6).contains(&girth) && (1e-3..=1e6).contains(&length);
    if good && (1e-3..=1e3).contains(&(girth / length)) { Ok(()) } else { Err(tile_mm) }
}

/// Where rings are, and the texture coordinate there.
struct Along {
    /// Distance from the snout, texture coordinate, and the measure that rings are spaced by.
    stations: Vec<(f64, f64, f64)>,
}

impl Along {
    /// `aspect` = tile girth/tile length.
    fn new(profile: &Profile, section: &Section, length: f64, aspect: f64) -> Self {
        let count = 4096;
        let station = |i: i32| {
            let s = 0.5 * length * (1.0 - libm::cos(PI * f64::from(i) / f64::from(count)));
            let [a, b] = profile.at(s).0;
            (s, a, section.girth(DVec2::new(a, b)))
        };
        let mut last = station(0);
        let (mut v, mut measure) = (0.0, 0.0);
        let mut stations = vec![(0.0, 0.0, 0.0)];
        for i in 1..=count {
            let next = station(i);
            let girth = 0.5 * (last.2 + next.2).max(2.0 * PI * LEAST_GIRTH);
            v += (next.0 - last.0) * aspect / girth;
            // As many rings as keep the quads' shape: by meridian length over girth, but not endless at the tips.
            let meridian =
                ((next.0 - last.0) * (next.0 - last.0) + (next.1 - last.1) * (next.1 - last.1)).sqrt();
            measure += meridian / girth.max(0.3 * PI);
            stations.push((next.0, v, measure));
            last = next;
        }
        Self { stations }
    }

    /// How many times longer than around the grid should be for square quads.
    fn squares(&self) -> f64 {
        self.stations.last().map_or(1.0, |station| station.2)
    }

    /// Distance from the snout and texture coordinate at a share of the rings.
    fn at(&self, share: f64) -> (f64, f64) {
        let measure = share * self.squares();
        let after = self.stations.partition_point(|station| station.2 < measure);
        let after = after.max(1).min(self.stations.len() - 1);
        let ((s0, v0, m0), (s1, v1, m1)) = (self.stations[after - 1], self.stations[after]);
        let t = ((measure - m0) / (m1 - m0)).max(0.0).min(1.0);
        (s0 + (s1 - s0) * t, v0 + (v1 - v0) * t)
    }
}

/// Segments around and intervals along, `2 around (intervals - 1)` triangles: the nearest number to `triangles` among
/// grids whose quads are square within a third.
fn grid(triangles: usize, squares: f64) -> (usize, usize) {
    let ideal = (triangles as f64 * 0.5 / squares).sqrt();
    let ((low, high), ideal) = (((ideal / 1.34) as usize, (ideal * 1.34) as usize), ideal);
    let candidates = (low.max(8)..=high.max(12)).map(|around| {
        let intervals = ((triangles as f64 / (2 * around) as f64).round() as usize).max(8) + 1;
        let error = (2 * around * (intervals - 1)).abs_diff(triangles);
        (error, (around as f64 - ideal).abs(), around, intervals)
    });
    let best = candidates.min_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    best.map_or((8, 9), |(_, _, around, intervals)| (around, intervals))
}

/// One ring of vertices: `around + 1` of them, the seam twice.
struct RingOf {
    frame: Frame,
    v: f64,
    around: usize,
}

impl RingOf {
    /// Vertices that all lie at the end of the centre line; each has the u of the middle of its triangle.
    fn pole(&self, outward: Vec3, mesh: &mut Mesh) {
        for i in 0..=self.around {
            let u = ((i as f64 + 0.5) / self.around as f64).min(1.0);
            mesh.positions.push(self.frame.position.as_vec3());
            mesh.normals.push(outward);
            mesh.uvs.push(Vec2::new(u as f32, self.v as f32));
        }
    }

    /// Vertices at equal distances around the section.
    fn open(&self, section: &Section, (axes, rates): ([f64; 2], [f64; 2]), mesh: &mut Mesh) {
        let Frame { position, tangent, up, right, .. } = self.frame;
        let (axes, rates) = (DVec2::from(axes), DVec2::from(rates));
        let lengths = section.lengths(axes);
        let (segments, girth) = (lengths.len() - 1, lengths[lengths.len() - 1]);
        let mut segment = 0;
        for i in 0..=self.around {
            let u = i as f64 / self.around as f64;
            let wanted = u * girth;
            while segment + 1 < segments && lengths[segment + 1] < wanted {
                segment += 1;
            }
            let t = (wanted - lengths[segment]) / (lengths[segment + 1] - lengths[segment]).max(1e-300);
            // The seam's two vertices are one place, to the bit.
            let angle = if i == self.around { 0.0 } else { TAU * (segment as f64 + t) / segments as f64 };
            let [unit, turn] = section.at(angle);
            let (point, turn, grow) = (unit * axes, turn * axes, unit * rates);
            // Outward in the plane of the section, as u runs from the belly over the left side.
            let outward = DVec2::new(-turn.y, turn.x);
            let advance = 1.0 - self.frame.bend_right * point.x - self.frame.bend_up * point.y;
            let twist = DVec2::new(-point.y, point.x) * self.frame.twist;
            let slope = outward.dot(grow + twist) / advance.max(0.05);
            let normal = right * outward.x + up * outward.y - tangent * slope;
            mesh.positions.push((position + right * point.x + up * point.y).as_vec3());
            mesh.normals.push(normal.normalize_or(up).as_vec3());
            mesh.uvs.push(Vec2::new(u as f32, self.v as f32));
        }
    }
}

/// Triangles of a grid of rings that is closed by poles at both ends.
fn triangles(around: u32, intervals: u32) -> Vec<[u32; 3]> {
    let row = around + 1;
    let mut out = Vec::with_capacity(2 * (around * (intervals - 1)) as usize);
    for ring in 0..intervals {
        for i in 0..around {
            let (a, b) = (ring * row + i, (ring + 1) * row + i);
            if ring > 0 {
                out.push([a, b, a + 1]);
            }
            if ring + 1 < intervals {
                out.push([a + u32::from(ring > 0), b, b + 1]);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::curve::cumulative;
    use glam::DVec3;

    fn snake(pose: Pose) -> Snake {
        let length_in_diameters = pose.usual_length_in_diameters();
        Snake { pose, length_in_diameters, section: 0.0, triangles: 20_000, tile_mm: [60.0, 90.0] }
    }

    #[test]
    fn every_snake_is_closed_valid_and_rests_on_the_ground() {
        for pose in Pose::ALL {
            for section in [0.0, 1.0] {
                let mesh = Snake { section, ..snake(pose) }.mesh().unwrap();
                mesh.check().unwrap();
                assert!(mesh.is_closed(), "{pose:?}");
                assert_eq!(mesh.bounds()[0].y, 0.0);
                assert!(mesh.triangles.len().abs_diff(20_000) < 200);
                assert!(mesh.tangents.iter().all(|t| t.w == 1.0), "{pose:?} is mirrored");
                let mut open = mesh.clone();
                open.triangles.pop();
                assert!(!open.is_closed());
            }
        }
        let (around, rings) = grid(1 << 19, 10.0);
        assert_eq!(2 * around * (rings - 1), 1 << 19);
    }

    #[test]
    fn area_is_that_of_the_profile() {
        // A straight body of round sections: int 2 pi r sqrt(1 + r'^2) ds, head apart, which is flat.
        let snake = Snake { triangles: 100_000, ..snake(Pose::Straight) };
        let mesh = snake.mesh().unwrap();
        let length = f64::from(snake.length_in_diameters);
        let profile = Profile::new(length);
        let (from, to) = (4.0, 20.0);
        let area: f64 = (0..10_000)
            .map(|i| {
                let (r, slope) = profile.at(from + (to - from) * (f64::from(i) + 0.5) / 10_000.0);
                TAU * r[0] * (1.0 + slope[0] * slope[0]).sqrt() * (to - from) / 10_000.0
            })
            .sum();
        // Triangles are counted by their middles: the edge of the part is ragged by less than a ring.
        let snout = mesh.bounds()[0].x;
        let part: f64 = mesh
            .triangles
            .iter()
            .map(|t| t.map(|i| mesh.positions[i as usize].as_dvec3()))
            .filter(|[a, b, c]| (from..to).contains(&((a.x + b.x + c.x) / 3.0 - f64::from(snout))))
            .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
            .sum();
        assert!((part / area - 1.0).abs() < 4e-3, "{part} {area}");
    }

    #[test]
    fn normals_are_those_of_the_triangles() {
        for pose in [Pose::Straight, Pose::Coil] {
            let mesh = Snake { triangles: 60_000, section: 0.5, ..snake(pose) }.mesh().unwrap();
            let (mut sum, mut count, mut far) = (0.0, 0.0, 0.0);
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
                let face = (b - a).cross(c - a).normalize_or_zero();
                let smooth = t.iter().map(|&i| mesh.normals[i as usize]).sum::<Vec3>().normalize();
                sum += f64::from(face.dot(smooth));
                count += 1.0;
                far += f64::from(u8::from(face.dot(smooth) < 0.98));
            }
            // Only at the blunt tips are triangles coarse.
            assert!(far / count < 0.01, "{pose:?}: {far} of {count}");
            assert!(sum / count > 0.999, "{}", sum / count);
        }
    }

    #[test]
    fn parts_of_the_body_do_not_cut_into_each_other() {
        for pose in Pose::ALL {
            let snake = snake(pose);
            let curve = snake.curve().unwrap();
            let profile = Profile::new(f64::from(snake.length_in_diameters));
            let count = 500;
            let at: Vec<(f64, DVec3, [f64; 2])> = (0..=count)
                .map(|i| {
                    let s = curve.length() * f64::from(i) / f64::from(count);
                    (s, curve.at(s).position, profile.at(s).0)
                })
                .collect();
            let mut nearest = f64::INFINITY;
            for (i, (s, p, a)) in at.iter().enumerate() {
                for (t, q, b) in at[i..].iter().filter(|other| other.0 - s > 2.0) {
                    // The head is flatter than it is wide: what counts lies between, by the direction.
                    let lie = (*q - *p).normalize_or_zero().y.abs();
                    let reach = |axes: &[f64; 2]| axes[0] + (axes[1] - axes[0]) * lie * lie;
                    let gap = p.distance(*q) - reach(a) - reach(b);
                    nearest = nearest.min(gap);
                    assert!(gap > -0.03, "{pose:?}: {s} and {t} by {gap}");
                }
            }
            // A coil and a loop do touch.
            assert_eq!(nearest < 0.05, matches!(pose, Pose::Coil | Pose::Loop), "{pose:?} {nearest}");
        }
    }

    #[test]
    fn the_belly_faces_the_ground() {
        for pose in Pose::ALL {
            let curve = snake(pose).curve().unwrap();
            for i in 0..=1000 {
                let frame = curve.at(curve.length() * f64::from(i) / 1000.0);
                let flat = (1.0 - frame.tangent.y * frame.tangent.y).sqrt();
                assert!(frame.up.y > 0.8 * flat, "{pose:?} {i}: {}", frame.up);
                if flat > 0.97 {
                    assert!(frame.up.y > 0.866, "{pose:?} {i}: {}", frame.up);
                }
            }
        }
    }

    #[test]
    fn scales_keep_their_proportions() {
        // On a straight body of round section: du x girth and dv of a quad in mm, beside its sides.
        let snake = Snake { triangles: 60_000, ..snake(Pose::Straight) };
        let (length, tile) = (f64::from(snake.length_in_diameters), snake.tile_mm.map(f64::from));
        let (profile, section) = (Profile::new(length), Section::new(0.0));
        let along = Along::new(&profile, &section, length, tile[0] / tile[1]);
        for share in [0.2, 0.3, 0.5, 0.7, 0.9] {
            let ((s0, v0), (s1, v1)) = (along.at(share), along.at(share + 1e-3));
            let axes = DVec2::from(profile.at(0.5 * (s0 + s1)).0);
            // A square of the texture, one mm by one mm, on the body: wide/long is 1.
            let wide = section.girth(axes) / tile[0];
            let long = (s1 - s0) / ((v1 - v0) * tile[1]);
            assert!((wide / long - 1.0).abs() < 0.01, "{share}: {}", wide / long);
        }
        // Midbody has the tile's girth.
        let girth_mm =
            section.girth(DVec2::from(profile.at(0.5 * length).0)) * f64::from(snake.mm_per_unit());
        assert!((girth_mm / tile[0] - 1.0).abs() < 1e-3, "{girth_mm}");
        // Any section has the girth of the round one.
        let loaf = Section::new(1.0);
        assert!((loaf.girth(DVec2::ONE) / TAU - 1.0).abs() < 1e-9 && loaf.down < 0.85 && loaf.side < 1.2);
    }

    #[test]
    fn a_circle_has_its_curvature_and_its_length() {
        let radius = 2.0;
        let points: Vec<DVec3> = (0..=300)
            .map(|i| {
                let a = 1.5 * PI * f64::from(i) / 300.0;
                DVec3::new(radius * a.cos(), 0.0, radius * a.sin())
            })
            .collect();
        let curve = Curve::through(&points, f64::INFINITY).unwrap();
        assert!((curve.length() / (1.5 * PI * radius) - 1.0).abs() < 1e-4, "{}", curve.length());
        assert!((cumulative(&points).last().unwrap() / curve.length() - 1.0).abs() < 1e-4);
        for share in [0.1, 0.37, 0.5, 0.9] {
            let f = curve.at(share * curve.length());
            assert!((f.bend_right.abs() - 1.0 / radius).abs() < 2e-3, "{}", f.bend_right);
            assert!(f.bend_up.abs() < 1e-9 && f.twist.abs() < 1e-9);
            assert!((f.position.length() - radius).abs() < 1e-4);
            assert!((f.up - DVec3::Y).length() < 1e-12);
        }
    }

    #[test]
    fn a_vertical_curve_has_frames_that_do_not_flip() {
        // Half a hoop that starts and ends flat and is vertical at both sides.
        let points: Vec<DVec3> = (0..=300)
            .map(|i| {
                let a = PI * f64::from(i) / 150.0;
                DVec3::new(2.0 * a.sin(), 2.0 - 2.0 * a.cos(), 0.2 * a)
            })
            .collect();
        let curve = Curve::through(&points, f64::INFINITY).unwrap();
        let frames: Vec<Frame> =
            (0..=2000).map(|i| curve.at(curve.length() * f64::from(i) / 2000.0)).collect();
        for pair in frames.windows(2) {
            assert!(pair[0].up.is_finite() && pair[0].up.dot(pair[1].up) > 0.9);
            assert!(pair[0].up.dot(pair[0].tangent).abs() < 1e-9);
        }
    }

    #[test]
    fn tangents_are_orthonormal_and_run_along_u() {
        let mesh = snake(Pose::Serpentine).mesh().unwrap();
        for (t, n) in mesh.tangents.iter().zip(&mesh.normals) {
            assert!(t.truncate().dot(*n).abs() < 1e-5);
        }
        let mut along = 0;
        for corners in &mesh.triangles {
            let [a, b, c] = *corners;
            let at = |i: u32| (mesh.positions[i as usize], mesh.uvs[i as usize]);
            for ((p, u), (q, w)) in [(at(a), at(b)), (at(b), at(c)), (at(c), at(a))] {
                if u.y == w.y && w.x > u.x && (0.1..0.9).contains(&u.x) {
                    let t = mesh.tangents[a as usize].truncate();
                    assert!((q - p).normalize_or_zero().dot(t) > 0.8 || (q - p).length() < 0.02);
                    along += 1;
                }
            }
        }
        assert!(along > 1000);
    }

    #[test]
    fn what_is_no_snake_is_refused() {
        let good = snake(Pose::Straight);
        let error = |snake: Snake| snake.mesh().unwrap_err();
        assert!(matches!(error(Snake { length_in_diameters: f32::NAN, ..good }), SnakeError::Length(_)));
        assert!(matches!(error(Snake { section: 1.1, ..good }), SnakeError::Section(_)));
        assert_eq!(error(Snake { triangles: 10, ..good }), SnakeError::Triangles(10));
        assert!(matches!(error(Snake { tile_mm: [0.0, 1.0], ..good }), SnakeError::Tile(..)));
        assert!(Pose::ALL.iter().all(|&pose| Pose::from_name(pose.name()) == Some(pose)));
    }
}
