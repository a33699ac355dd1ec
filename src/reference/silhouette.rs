//! Which pixels may show an object at all: the others need no tree.

use crate::scene::{Scene, camera::View};

/// One flag for each pixel of a picture, row by row from the top: false only where no ray of the pixel meets an object.
/// `None` where nothing can be said: with a lens, or if something is beside or behind the eye.
///
/// The box of each projected triangle counts, with a pixel around it for rounding.
pub(super) fn pixels(scene: &Scene, eye: &View, [width, height]: [usize; 2]) -> Option<Vec<bool>> {
    if eye.aperture > 0.0 {
        return None;
    }
    let mut may = vec![false; width * height];
    for mesh in scene.objects.iter().map(|o| &o.mesh) {
        let mut projected = Vec::with_capacity(mesh.positions.len());
        for &position in &mesh.positions {
            let to = position - eye.origin;
            let depth = to.dot(eye.forward);
            // So near the plane of the eye the projection is all rounding.
            if depth <= 1e-3 * to.length() {
                return None;
            }
            let x = to.dot(eye.right) / (depth * eye.half_size.x);
            let y = to.dot(eye.up) / (depth * eye.half_size.y);
            projected.push([0.5 * (1.0 + x) * width as f32, 0.5 * (1.0 - y) * height as f32]);
        }
        for corners in mesh.triangles.iter().map(|t| t.map(|i| projected[i as usize])) {
            let range = |c: usize, n: usize| {
                let [a, b, d] = corners.map(|p| p[c]);
                let low = a.min(b).min(d) - 1.0;
                let high = a.max(b).max(d) + 2.0;
                // Casts limit what is outside of the picture.
                (low.max(0.0) as usize).min(n)..(high.max(0.0) as usize).min(n)
            };
            for y in range(1, height) {
                may[y * width..][range(0, width)].fill(true);
            }
        }
    }
    Some(may)
}
