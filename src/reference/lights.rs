//! Everything that shines, as one: which light to ask, where on it, and how likely that was.

use glam::Vec3;

use crate::base::LinearRgb;
use crate::scene::light::rectangle::Rectangle;
use crate::scene::{EnvironmentSampler, Light, Scene};

/// The lights of a scene with the chance that each is asked.
pub(super) struct Lights<'a> {
    scene: &'a Scene,
    environment: Option<EnvironmentSampler>,
    /// Of each light that is one and has an area.
    rectangles: Vec<Option<Rectangle>>,
    /// Chance of the environment, then of each light; they sum to 1 where there is any.
    chances: Vec<f32>,
}

/// A direction to a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Unit vector to it.
    pub(super) direction: Vec3,
    /// How far: infinity for the environment and directional lights.
    pub(super) distance: f32,
    /// What comes from there.
    pub(super) radiance: LinearRgb,
    /// Density over solid angle, the chance of the light included; of a delta light, its chance alone.
    pub(super) pdf: f32,
    /// A single direction: nothing else can find it, and `radiance` is an irradiance.
    pub(super) delta: bool,
    /// From the environment.
    pub(super) environment: bool,
}

/// Light that a ray runs into.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    /// What comes from there.
    pub(super) radiance: LinearRgb,
    /// Density with which [`Lights::sample`] finds this direction.
    pub(super) pdf: f32,
}

impl<'a> Lights<'a> {
    /// Weigh the lights by the light that they throw at the middle of the scene.
    pub(super) fn new(scene: &'a Scene) -> Self {
        let environment = EnvironmentSampler::new(&scene.environment);
        let center = middle(scene);
        let of = |light: &Light| match light {
            Light::Directional { irradiance, .. } => irradiance.luminance(),
            Light::Area { center: place, u, v, radiance } => {
                let area = 4.0 * u.cross(*v).length();
                let away = (*place - center).length_squared().max(area);
                radiance.luminance() * area / away
            }
        };
        // What a ball would get, as a rule of thumb.
        let sky = scene.environment.mean_radiance().luminance() * std::f32::consts::PI;
        let sky = if environment.is_some() { sky } else { 0.0 };
        let mut chances: Vec<f32> = std::iter::once(sky).chain(scene.lights.iter().map(of)).collect();
        let shining = chances.iter().filter(|c| **c > 0.0).count();
        let total: f32 = chances.iter().sum();
        for chance in &mut chances {
            if *chance > 0.0 {
                // None so rare that its noise shows.
                *chance = 0.5 * *chance / total + 0.5 / shining as f32;
            }
        }
        let rectangle = |light: &Light| match *light {
            Light::Directional { .. } => None,
            Light::Area { center, u, v, .. } => Rectangle::new(center, u, v),
        };
        let rectangles = scene.lights.iter().map(rectangle).collect();
        Self { scene, environment, rectangles, chances }
    }

    /// A direction to some light from `place`; `pick` chooses which.
    #[inline(always)]
    pub(super) fn sample(&self, place: Vec3, u: [f32; 2], mut pick: f32) -> Option<Sample> {
        let mut index = 0;
        let mut chance = 0.0;
        for (i, &c) in self.chances.iter().enumerate() {
            if c > 0.0 {
                (index, chance) = (i, c);
                if pick < c {
                    break;
                }
                pick -= c;
            }
        }
        if chance == 0.0 {
            return None;
        }
        if index == 0 {
            let s = self.environment.as_ref()?.sample(u);
            return Some(Sample {
                direction: s.direction,
                distance: f32::INFINITY,
                radiance: s.radiance,
                pdf: s.pdf * chance,
                delta: false,
                environment: true,
            });
        }
        let s = match (&self.scene.lights[index - 1], &self.rectangles[index - 1]) {
            (Light::Area { radiance, .. }, Some(rectangle)) => rectangle.sample(place, *radiance, u)?,
            (light, _) => light.sample(place, u)?,
        };
        Some(Sample {
            direction: s.direction,
            distance: s.distance,
            radiance: s.radiance,
            pdf: if s.delta { chance } else { s.pdf * chance },
            delta: s.delta,
            environment: false,
        })
    }

    /// The first light with a surface on the way, nearer than `limit`. Its density is computed only if `pdf_wanted`.
    #[inline(always)]
    pub(super) fn hit(&self, origin: Vec3, direction: Vec3, limit: f32, pdf_wanted: bool) -> Option<Found> {
        let mut found: Option<(usize, f32)> = None;
        for (i, light) in self.scene.lights.iter().enumerate() {
            let nearest = found.map_or(limit, |f| f.1);
            if let Some(distance) = distance(light, origin, direction).filter(|d| *d < nearest) {
                found = Some((i, distance));
            }
        }
        let (i, _) = found?;
        let light = &self.scene.lights[i];
        // The density wants the solid angle of the whole light.
        let pdf = if pdf_wanted { light.hit(origin, direction).map_or(0.0, |h| h.pdf) } else { 0.0 };
        let Light::Area { radiance, .. } = light else { return None };
        Some(Found { radiance: *radiance, pdf: pdf * self.chances[i + 1] })
    }

    /// The light that rays from the eye meet: the first one with a surface that is nearer than a limit, or, where that is
    /// infinite, all that is far away.
    #[inline(always)]
    pub(super) fn seen<const N: usize>(
        &self,
        origins: &[Vec3; N],
        directions: &[Vec3; N],
        limits: &[f32; N],
    ) -> [Option<[f32; 3]>; N] {
        let mut skies = [LinearRgb([0.0; 3]); N];
        if self.environment.is_some() && limits.contains(&f32::INFINITY) {
            skies = self.scene.environment.radiances(directions);
        }
        let mut colors = [None; N];
        for i in 0..N {
            colors[i] = match self.hit(origins[i], directions[i], limits[i], false) {
                Some(found) => Some(found.radiance.0),
                None if limits[i] < f32::INFINITY => None,
                None => Some(self.suns(directions[i]).fold(skies[i].0, |sum, sun| {
                    let more = sun.radiance.0;
                    [sum[0] + more[0], sum[1] + more[1], sum[2] + more[2]]
                })),
            };
        }
        colors
    }

    /// What comes from the environment in a direction. Its density is computed only if `pdf_wanted`.
    #[inline(always)]
    pub(super) fn sky(&self, direction: Vec3, pdf_wanted: bool) -> Option<Found> {
        let environment = self.environment.as_ref()?;
        if pdf_wanted {
            let (radiance, pdf) = environment.look(direction);
            return Some(Found { radiance, pdf: pdf * self.chances[0] });
        }
        Some(Found { radiance: self.scene.environment.radiance(direction), pdf: 0.0 })
    }

    /// What comes from far away in a direction: the environment, and discs of directional lights. Densities are computed
    /// only if `pdf_wanted`.
    #[inline(always)]
    pub(super) fn far(&self, direction: Vec3, pdf_wanted: bool) -> impl Iterator<Item = Found> {
        self.sky(direction, pdf_wanted).into_iter().chain(self.suns(direction))
    }

    /// What comes from discs of directional lights in a direction.
    #[inline(always)]
    fn suns(&self, direction: Vec3) -> impl Iterator<Item = Found> {
        self.scene.lights.iter().zip(&self.chances[1..]).filter_map(move |(light, chance)| {
            if matches!(light, Light::Area { .. }) {
                return None;
            }
            let hit = light.hit(Vec3::ZERO, direction)?;
            Some(Found { radiance: hit.radiance, pdf: hit.pdf * chance })
        })
    }
}

/// How far along a ray the shining side of a rectangle is met.
#[inline(always)]
fn distance(light: &Light, origin: Vec3, direction: Vec3) -> Option<f32> {
    let Light::Area { center, u, v, .. } = light else { return None };
    let normal = u.cross(*v);
    let towards = -normal.dot(direction);
    let distance = -normal.dot(*center - origin) / towards;
    if !(towards > 0.0 && distance > 0.0) {
        return None;
    }
    let place = origin + direction * distance - *center;
    let within = |side: Vec3| place.dot(side).abs() <= side.length_squared();
    (within(*u) && within(*v)).then_some(distance)
}

/// Middle of all objects but endless floors: of the first one, the subject.
fn middle(scene: &Scene) -> Vec3 {
    let Some(object) = scene.objects.first() else { return Vec3::ZERO };
    let positions = &object.mesh.positions;
    positions.iter().sum::<Vec3>() / positions.len().max(1) as f32
}
