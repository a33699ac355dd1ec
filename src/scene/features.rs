//! Which parts a scene needs, so that shaders and reports leave out what is not there.

use super::Scene;
use super::environment::Environment;
use super::light::Light;
use super::material::Material;
use crate::optics::layered::{Albedo, Energy};

/// What a scene has in it. A feature that is false can be left out without a change to the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct SceneFeatures {
    /// A film somewhere: thickness above 0, and an index unlike both of its neighbours'.
    pub film: bool,
    /// A surface that reflects: not the same index everywhere.
    pub interface: bool,
    /// Light outside may be reflected totally: the film or the layer has a lower index.
    pub total_reflection: bool,
    /// The layer below the film absorbs.
    pub absorber: bool,
    /// A base that scatters: an albedo above 0.
    pub base: bool,
    /// Albedos are the base's own somewhere.
    pub intrinsic_albedo: bool,
    /// Energy is shared out by the table somewhere.
    pub coupled_energy: bool,
    /// A base that wraps around: it lights the far side.
    pub wrapped_base: bool,
    /// A base that light of the far side comes through.
    pub translucent_base: bool,
    /// Indices that depend on the wavelength.
    pub dispersion: bool,
    /// Ridges that diffract.
    pub grating: bool,
    /// Roughness 0 somewhere: a mirror.
    pub mirror: bool,
    /// Textures.
    pub maps: bool,
    /// Normals that lean.
    pub normal_map: bool,
    /// Film thickness that varies from texel to texel.
    pub thickness_map: bool,
    /// Heights.
    pub height_map: bool,
    /// Lights that are points on the sky.
    pub point_lights: bool,
    /// Lights that are disks on the sky.
    pub disk_lights: bool,
    /// Rectangles that shine.
    pub area_lights: bool,
    /// The same light from everywhere.
    pub constant_environment: bool,
    /// A picture of all around that is not black.
    pub image_environment: bool,
    /// A lens that blurs what is out of focus.
    pub thin_lens: bool,
}

impl SceneFeatures {
    /// What the scene has, in the materials that objects wear.
    pub fn of(scene: &Scene) -> Self {
        let mut found = Self { thin_lens: scene.camera.aperture > 0.0, ..Self::default() };
        for (i, material) in scene.materials.iter().enumerate() {
            if scene.objects.iter().any(|o| o.material == i && !o.mesh.triangles.is_empty()) {
                found.add_material(material);
            }
        }
        for light in &scene.lights {
            match light {
                Light::Directional { angular_radius_rad, .. } if *angular_radius_rad > 0.0 => {
                    found.disk_lights = true;
                }
                Light::Directional { .. } => found.point_lights = true,
                Light::Area { .. } => found.area_lights = true,
            }
        }
        if !scene.environment.is_black() {
            match scene.environment {
                Environment::Constant(_) => found.constant_environment = true,
                Environment::Image(_) => found.image_environment = true,
            }
        }
        found
    }

    /// What one material has.
    pub fn of_material(material: &Material) -> Self {
        let mut found = Self::default();
        found.add_material(material);
        found
    }

    fn add_material(&mut self, material: &Material) {
        let constant = [material.constant()];
        let texels = material.maps.as_deref().map_or(&constant[..], |maps| &maps.texels);
        let constants = &material.constants;
        let [outside, film, layer] = constants.indices;
        // Indices that are alike at one wavelength are not at another.
        let dispersed = constants.dispersion_nm2 != [0.0; 2];
        let can_film = dispersed || (film != outside && film != layer);
        let has_film = can_film && texels.iter().any(|t| t.thickness_nm > 0.0);
        self.film |= has_film;
        self.interface |= outside != layer || has_film || dispersed;
        self.total_reflection |= layer < outside || (has_film && film < outside);
        self.absorber |= constants.absorption.iter().any(|a| *a > 0.0);
        self.base |= texels.iter().any(|t| t.color.iter().any(|c| *c > 0.0));
        self.intrinsic_albedo |= constants.albedo == Albedo::Intrinsic;
        self.coupled_energy |= constants.energy == Energy::Coupled;
        self.wrapped_base |= constants.base.wraps();
        self.translucent_base |= constants.base.lets_through();
        self.dispersion |= dispersed;
        self.grating |= constants.grating.is_some_and(|g| g.height_nm > 0.0);
        self.mirror |= texels.iter().any(|t| t.roughness <= 0.0);
        self.maps |= material.maps.is_some();
        self.normal_map |= texels.iter().any(|t| t.normal[0] != 0.0 || t.normal[1] != 0.0);
        self.thickness_map |= has_film && texels.iter().any(|t| t.thickness_nm != texels[0].thickness_nm);
        self.height_map |= material.maps.as_ref().is_some_and(|maps| maps.height_mm.is_some());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::LinearRgb;
    use crate::optics::{Base, Grating};
    use crate::scene::{EnvironmentImage, Inputs, SceneSpec, SkinMaps, Texel};
    use glam::Vec3;
    use std::sync::Arc;

    /// A black mirror of one index in the dark, which needs nothing.
    fn nothing() -> Scene {
        let mut spec = SceneSpec::default();
        spec.subject.triangles = 1000;
        spec.environment.kind = crate::scene::spec::Surroundings::None;
        spec.ground.show = false;
        spec.material.n_layer = Some(1.0);
        let mut scene = Scene::build(&spec, &Inputs::default()).expect("it can be built");
        scene.materials[0].color = LinearRgb::default();
        scene
    }

    type Change = (fn(&mut Scene), fn(&mut SceneFeatures));

    /// Each change alone makes its own features true and no other.
    #[test]
    fn what_is_absent_is_false_and_what_is_there_is_true() {
        assert_eq!(SceneFeatures::of(&nothing()), SceneFeatures::default());
        fn light(scene: &mut Scene, angular_radius_rad: f32) {
            let irradiance = LinearRgb([1.0; 3]);
            scene.lights.push(Light::Directional { direction: Vec3::Y, irradiance, angular_radius_rad });
        }
        fn maps(scene: &mut Scene, change: fn(&mut SkinMaps)) {
            let texel = Texel { roughness: 0.3, normal: [0.0, 0.0, 1.0], ..Texel::default() };
            let mut maps =
                SkinMaps { width: 2, height: 1, texels: vec![texel; 2], height_mm: None, size_mm: [1.0; 2] };
            change(&mut maps);
            scene.materials[0].maps = Some(Arc::new(maps));
        }
        let changes: &[Change] = &[
            (|s| s.materials[0].thickness_nm = 300.0, |f| (f.film, f.interface) = (true, true)),
            (|s| s.materials[0].constants.indices = [1.0, 1.0, 1.5], |f| f.interface = true),
            (
                |s| s.materials[0].constants.indices = [1.5, 1.5, 1.3],
                |f| (f.interface, f.total_reflection) = (true, true),
            ),
            (|s| s.materials[0].constants.absorption = [0.0, 0.1, 0.0], |f| f.absorber = true),
            (|s| s.materials[0].color = LinearRgb([0.0, 0.0, 0.2]), |f| f.base = true),
            (|s| s.materials[0].constants.albedo = Albedo::Intrinsic, |f| f.intrinsic_albedo = true),
            (|s| s.materials[0].constants.energy = Energy::Coupled, |f| f.coupled_energy = true),
            (
                |s| {
                    s.materials[0].constants.base = Base::Curved { curvature_per_mm: 0.1, thickness_mm: 99.0 }
                },
                |f| f.wrapped_base = true,
            ),
            (
                |s| s.materials[0].constants.base = Base::Curved { curvature_per_mm: 0.1, thickness_mm: 1.0 },
                |f| (f.wrapped_base, f.translucent_base) = (true, true),
            ),
            (
                |s| s.materials[0].constants.dispersion_nm2 = [0.0, 5890.0],
                |f| (f.dispersion, f.interface) = (true, true),
            ),
            (
                |s| {
                    let [period_nm, height_nm, direction_rad] = [900.0, 50.0, 0.0];
                    let grating = Grating { period_nm, height_nm, direction_rad };
                    s.materials[0].constants.grating = Some(grating);
                },
                |f| f.grating = true,
            ),
            (|s| s.materials[0].roughness = 0.0, |f| f.mirror = true),
            (|s| maps(s, |_| ()), |f| f.maps = true),
            (
                |s| maps(s, |m| m.texels[1].normal = [0.6, 0.0, 0.8]),
                |f| (f.maps, f.normal_map) = (true, true),
            ),
            (
                |s| maps(s, |m| m.texels[1].thickness_nm = 200.0),
                |f| (f.maps, f.thickness_map, f.film, f.interface) = (true, true, true, true),
            ),
            (|s| maps(s, |m| m.height_mm = Some(vec![0.0; 2])), |f| (f.maps, f.height_map) = (true, true)),
            (|s| light(s, 0.0), |f| f.point_lights = true),
            (|s| light(s, 0.01), |f| f.disk_lights = true),
            (
                |s| {
                    let [center, u, v] = [Vec3::Y, Vec3::X, Vec3::Z];
                    s.lights.push(Light::Area { center, u, v, radiance: LinearRgb([1.0; 3]) });
                },
                |f| f.area_lights = true,
            ),
            (
                |s| s.environment = Environment::Constant(LinearRgb([0.0, 0.0, 0.1])),
                |f| f.constant_environment = true,
            ),
            (
                |s| {
                    let image = EnvironmentImage::from_fn(4, 2, |_| LinearRgb([1.0; 3]));
                    s.environment = Environment::Image(Arc::new(image));
                },
                |f| f.image_environment = true,
            ),
            (|s| s.camera.aperture = 0.1, |f| f.thin_lens = true),
        ];
        for (i, (change, expect)) in changes.iter().enumerate() {
            let (mut scene, mut expected) = (nothing(), SceneFeatures::default());
            change(&mut scene);
            expect(&mut expected);
            assert_eq!(SceneFeatures::of(&scene), expected, "change {i}");
        }
        // What nothing wears counts for nothing.
        let mut scene = nothing();
        let mut unused = scene.materials[0].clone();
        unused.thickness_nm = 300.0;
        scene.materials.push(unused);
        assert_eq!(SceneFeatures::of(&scene), SceneFeatures::default());
    }
}
