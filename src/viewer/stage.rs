//! What stands where, in which light, as the window chooses it.

use std::sync::Arc;

use super::desk::OpenedScene;
use crate::preview::enough_triangles;
use crate::scene::spec::{EnvironmentSpec, Surroundings};
use crate::scene::{EnvironmentImage, SceneSpec};

/// Columns and rows that triangles are enough for; windows may be larger.
const USUAL: [usize; 2] = [1280, 960];

/// The light of a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Lighting {
    /// The scene's own.
    #[default]
    Own,
    /// A clear sky with its sun.
    Daylight,
    /// A grey sky.
    Overcast,
    /// Soft boxes in a light room.
    Studio,
    /// Strips of light in a dark room.
    DarkStudio,
    /// The same from everywhere.
    Even,
}

impl Lighting {
    /// Every one.
    pub(super) const ALL: [Self; 6] =
        [Self::Own, Self::Daylight, Self::Overcast, Self::Studio, Self::DarkStudio, Self::Even];

    /// Its name in the window.
    pub(super) fn label(self) -> &'static str {
        match self {
            Self::Own => "As the scene",
            Self::Daylight => "Daylight",
            Self::Overcast => "Overcast",
            Self::Studio => "Studio",
            Self::DarkStudio => "Dark studio",
            Self::Even => "Even",
        }
    }

    fn surroundings(self) -> Option<Surroundings> {
        match self {
            Self::Own => None,
            Self::Daylight => Some(Surroundings::Daylight),
            Self::Overcast => Some(Surroundings::Overcast),
            Self::Studio => Some(Surroundings::Studio),
            Self::DarkStudio => Some(Surroundings::DarkStudio),
            Self::Even => Some(Surroundings::Even),
        }
    }
}

/// A scene in a light.
#[derive(Clone, Debug)]
pub(super) struct Stage {
    /// The scene.
    pub(super) spec: SceneSpec,
    /// The picture of its environment.
    pub(super) picture: Option<Arc<EnvironmentImage>>,
}

impl Stage {
    /// A scene with this light, turned around the vertical.
    pub(super) fn new(scene: &OpenedScene, lighting: Lighting, turn_deg: f32) -> Self {
        let mut spec = scene.spec.clone();
        let enough = enough_triangles(USUAL, spec.subject.displacement > 0.0);
        spec.subject.triangles = spec.subject.triangles.min(enough);
        if let Some(kind) = lighting.surroundings() {
            spec.environment = EnvironmentSpec { kind, ..EnvironmentSpec::default() };
            spec.light.clear();
        }
        let turned = |deg: f32| (deg + turn_deg + 180.0).rem_euclid(360.0) - 180.0;
        spec.environment.turn_deg = turned(spec.environment.turn_deg);
        spec.light.iter_mut().for_each(|lamp| lamp.azimuth_deg = turned(lamp.azimuth_deg));
        Self { spec, picture: scene.picture.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    fn coil() -> OpenedScene {
        OpenedScene { spec: builtin::scene("coil").expect("a built-in scene"), picture: None }
    }

    #[test]
    fn the_scene_keeps_its_own_light_or_gets_one_alone() {
        let own = Stage::new(&coil(), Lighting::Own, 0.0).spec;
        assert_eq!((own.environment, own.light), (coil().spec.environment, coil().spec.light));
        for lighting in Lighting::ALL.into_iter().skip(1) {
            let other = Stage::new(&coil(), lighting, 0.0).spec;
            assert_eq!(Some(other.environment.kind), lighting.surroundings());
            assert!(other.light.is_empty());
            assert_eq!(other.camera, coil().spec.camera);
        }
    }

    #[test]
    fn all_light_turns_together() {
        let turned = Stage::new(&coil(), Lighting::Own, 170.0).spec;
        assert_eq!(turned.environment.turn_deg, 170.0);
        assert_eq!(turned.light[0].azimuth_deg, coil().spec.light[0].azimuth_deg + 170.0);
        let back = Stage::new(&coil(), Lighting::Own, 360.0).spec;
        assert_eq!(back.light, coil().spec.light);
    }
}
