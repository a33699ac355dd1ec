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

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use fearless_simd::{Level, dispatch};

    use super::*;
    use crate::base::hash;
    use crate::reference::bvh::Bvh;
    use crate::reference::tests::{floor, matt, scene, skin};
    use crate::scene::{Camera, Mesh, Object};

    const SIZE: [usize; 2] = [24, 17];

    /// Splinters around (0, 0, -5), from much smaller than a pixel to a quarter of the picture, and one sheet on edge.
    fn splinters() -> Scene {
        let mut scene = scene(skin(matt(), 0.5, 0.3, 0.0), vec![], 1.0);
        let mut count = 0;
        let mut vector = || {
            Vec3::from_array([(); 3].map(|()| {
                count += 1;
                hash::signed(hash::pcg(count))
            }))
        };
        let mut positions = Vec::new();
        for size in [0.001, 0.01, 0.1, 0.5].repeat(4) {
            let at = vector() * Vec3::new(1.5, 1.0, 1.0) - 5.0 * Vec3::Z;
            positions.extend([(); 3].map(|()| at + size * vector()));
        }
        let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        let mut sheet = floor(0.4);
        sheet.positions.iter_mut().for_each(|p| p.z -= 5.0);
        let object = |name: &str, mesh| Object { name: name.into(), mesh, material: 0 };
        scene.objects = vec![object("splinters", mesh), object("sheet", sheet)];
        scene
    }

    fn cameras() -> Vec<Camera> {
        let camera = |position, target, up, field_of_view_rad| Camera {
            position,
            target,
            up,
            field_of_view_rad,
            aperture: 0.0,
            focus_distance: 1.0,
        };
        vec![
            camera(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, 0.7),
            // Rolled, and much beside the picture.
            camera(Vec3::ZERO, Vec3::new(0.3, 0.2, -1.0), Vec3::new(1.0, 1.0, 0.0), 0.4),
            // From above, wide.
            camera(Vec3::new(0.5, 4.0, -5.0), Vec3::new(0.0, 0.0, -5.0), Vec3::Z, 1.9),
            // So near that splinters are large, so far that all is a pixel.
            camera(Vec3::new(0.0, 0.0, -2.0), Vec3::new(0.0, 0.0, -5.0), Vec3::Y, 1.2),
            camera(Vec3::new(900.0, 20.0, 300.0), Vec3::new(0.0, 0.0, -5.0), Vec3::Y, 0.01),
        ]
    }

    /// Rays that meet an object in a pixel that should show none, of 256 in each such pixel.
    fn hidden(may: &[bool], bvh: &Bvh, eye: &View) -> usize {
        let [width, height] = SIZE;
        let meets = |x: usize, y: usize, ray: u32| {
            // Corners, edges and the inside of the pixel.
            let [u, v] = [ray % 16, ray / 16].map(|i| i as f32 / 15.0);
            let (origin, direction) =
                eye.ray((x as f32 + u) / width as f32, (y as f32 + v) / height as f32, [0.5; 2]);
            dispatch!(Level::new(), simd => bvh.is_blocked(simd, &mut bvh.stack(), origin, direction, f32::INFINITY))
        };
        let empty = (0..width * height).filter(|i| !may[*i]);
        empty.map(|i| (0..256).filter(|ray| meets(i % width, i / width, *ray)).count()).sum()
    }

    #[test]
    fn no_ray_of_a_pixel_that_is_left_out_meets_an_object() {
        let scene = splinters();
        let bvh = Bvh::new(&scene.objects);
        let sheet = Scene { objects: vec![scene.objects[1].clone()], ..scene.clone() };
        for camera in cameras() {
            let eye = camera.view(SIZE[0] as f32 / SIZE[1] as f32);
            let may = pixels(&scene, &eye, SIZE).expect("all is before the eye");
            assert_eq!(hidden(&may, &bvh, &eye), 0, "{camera:?}");
            let shown = may.iter().filter(|m| **m).count();
            assert!(shown > 0 && shown < may.len(), "{shown}, {camera:?}");
        }
        // The comparison finds objects that are left out.
        let eye = cameras()[0].view(SIZE[0] as f32 / SIZE[1] as f32);
        let may = pixels(&sheet, &eye, SIZE).expect("before the eye");
        assert!(hidden(&may, &bvh, &eye) > 100);
    }

    #[test]
    fn a_lens_or_something_beside_the_eye_has_no_silhouette() {
        let scene = splinters();
        let camera = cameras()[0];
        let of = |camera: Camera| pixels(&scene, &camera.view(1.0), SIZE);
        assert!(of(camera).is_some());
        assert_eq!(of(Camera { aperture: 0.1, ..camera }), None);
        assert_eq!(
            of(Camera { position: Vec3::new(0.0, 0.0, -5.0), target: Vec3::new(0.0, 0.0, -6.0), ..camera }),
            None
        );
    }
}
