//! Skies in closed form: clear daylight with a sun, and overcast.
//!
//! A sky is scaled so that a white sheet lying flat in it has radiance 1: the weather changes colours and shadows, not the
//! exposure.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::environment::EnvironmentImage;
use super::light::Light;
use crate::base::LinearRgb;
use crate::optics::cie;

/// Texels of a sky.
const SIZE: (usize, usize) = (512, 256);

/// Half the angle of the sun, radians: 0.533 degrees across.
pub const SUN_RADIUS_RAD: f32 = 0.004_65;

/// A clear sky. See [`Daylight::sky`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Daylight {
    /// The sun above the horizon, degrees, in [0, 90].
    pub elevation_deg: f32,
    /// The sun around the vertical, degrees: 0 is behind a viewer on +z, 90 to the right.
    pub azimuth_deg: f32,
    /// Haze, in [2, 10]: 2 very clear, 3 clear, 6 warm and moist, 10 hazy.
    pub turbidity: f32,
    /// Albedo of the ground, the lower half of the picture, in [0, 1].
    pub ground_albedo: f32,
}

impl Default for Daylight {
    fn default() -> Self {
        Self { elevation_deg: 50.0, azimuth_deg: -40.0, turbidity: 3.0, ground_albedo: 0.2 }
    }
}

/// A unit vector at an elevation above the horizon and an azimuth, degrees: azimuth 0 is +z, 90 is +x.
pub fn towards(elevation_deg: f32, azimuth_deg: f32) -> Vec3 {
    let [e, a] = [elevation_deg, azimuth_deg].map(|deg| f64::from(deg) * (PI / 180.0));
    DVec3::new(libm::sin(a) * libm::cos(e), libm::sin(e), libm::cos(a) * libm::cos(e)).as_vec3()
}

impl Daylight {
    /// The sky without its sun, and the sun. Settings out of range are moved into it.
    ///
    /// Sky: Preetham, Shirley & Smits, "A practical analytic model for daylight", SIGGRAPH 1999, appendix A. Sun: 133.3 klx
    /// (Darula, Kittler & Gueymard 2005) of a black body of 5772 K, dimmed by Rayleigh scattering and aerosol (the same
    /// paper, appendix A.1; without ozone, gases and water, a few per cent) through the air mass of Kasten & Young 1989;
    /// the spectrum that is dimmed is taken to be D65's.
    pub fn sky(&self) -> (EnvironmentImage, Light) {
        let within =
            |x: f32, low: f32, high: f32| f64::from(if x.is_nan() { low } else { x.max(low).min(high) });
        let elevation = within(self.elevation_deg, 0.0, 90.0);
        let direction = towards(elevation as f32, self.azimuth_deg);
        let sun = sun_klx(elevation, within(self.turbidity, 2.0, 10.0));
        let preetham = Preetham::new(PI / 180.0 * (90.0 - elevation), within(self.turbidity, 2.0, 10.0));
        let sky = EnvironmentImage::from_fn(SIZE.0, SIZE.1, |d| {
            if d.y <= 0.0 {
                return LinearRgb::default();
            }
            let cos_gamma = f64::from(d.dot(direction)).max(-1.0).min(1.0);
            LinearRgb(preetham.radiance(f64::from(d.y), cos_gamma).map(|c| c as f32))
        });
        let from_sky = horizontal_irradiance(&sky);
        let total: [f32; 3] = std::array::from_fn(|c| from_sky[c] + sun[c] * direction.y);
        // Luminous, so that colours are the weather's.
        let scale = std::f32::consts::PI / LinearRgb(total).luminance();
        let albedo = within(self.ground_albedo, 0.0, 1.0) as f32;
        let ground = total.map(|e| e * scale * albedo / std::f32::consts::PI);
        let light = Light::Directional {
            direction,
            irradiance: LinearRgb(sun.map(|e| e * scale)),
            angular_radius_rad: SUN_RADIUS_RAD,
        };
        (with_ground(sky.scaled(scale), ground), light)
    }
}

/// The standard overcast sky, three times as bright at the zenith as at the horizon: `L = L_z (1 + 2 sin(elevation))/3`
/// (Moon & Spencer 1942; CIE S 011), over ground of an albedo in [0, 1]. White as D65.
pub fn overcast(ground_albedo: f32) -> EnvironmentImage {
    // A horizontal sheet gets 7 pi/9 of the zenith's radiance.
    let zenith = 9.0 / 7.0;
    let albedo = if ground_albedo.is_nan() { 0.0 } else { ground_albedo.max(0.0).min(1.0) };
    EnvironmentImage::from_fn(SIZE.0, SIZE.1, |d| {
        let l = if d.y > 0.0 { zenith * (1.0 + 2.0 * d.y) / 3.0 } else { albedo };
        LinearRgb([l; 3])
    })
}

/// Irradiance on a horizontal surface that looks up.
fn horizontal_irradiance(image: &EnvironmentImage) -> [f32; 3] {
    let mut sum = [0.0_f64; 3];
    let edge = |y: usize| {
        let cos = libm::cos(PI * y as f64 / image.height as f64).max(0.0);
        0.5 * cos * cos
    };
    for (y, row) in image.texels.chunks_exact(image.width).enumerate() {
        // The integral of cos over a row of the upper half.
        let weight = 2.0 * PI * (edge(y) - edge(y + 1)) / image.width as f64;
        row.iter().for_each(|texel| (0..3).for_each(|c| sum[c] += weight * f64::from(texel[c])));
    }
    sum.map(|s| s as f32)
}

/// The lower half of the picture in one colour.
fn with_ground(mut image: EnvironmentImage, ground: [f32; 3]) -> EnvironmentImage {
    let half = image.width * (image.height / 2);
    image.texels[half..].fill(ground);
    image
}

/// Illuminance of the sun through the air, klx, on a surface that faces it.
fn sun_klx(elevation_deg: f64, turbidity: f64) -> [f32; 3] {
    // Chromaticity of a black body of 5772 K (Kim et al. 2002).
    let (x, y) = (0.32647, 0.33585);
    let xyz = [x / y, 1.0, (1.0 - x - y) / y];
    let outside = cie::XYZ_TO_SRGB.map(|row| row.iter().zip(xyz).map(|(m, c)| m * c).sum::<f64>());
    let air_mass = 1.0
        / (libm::sin(elevation_deg * (PI / 180.0)) + 0.505_72 * libm::pow(elevation_deg + 6.079_95, -1.6364));
    let beta = 0.046_08 * turbidity - 0.045_86;
    let through = cie::integrate(|nm| {
        let um = nm * 1e-3;
        let depth = 0.008_735 * libm::pow(um, -4.08) + beta * libm::pow(um, -1.3);
        libm::exp(-depth * air_mass)
    });
    std::array::from_fn(|c| (133.3 * outside[c] * through[c]).max(0.0) as f32)
}

/// The sky's luminance and chromaticity: Perez's formula with the paper's coefficients.
struct Preetham {
    /// For Y (kcd/m^2), x and y: coefficients A to E, and the zenith's value over Perez's there.
    parts: [([f64; 5], f64); 3],
}

impl Preetham {
    /// `sun` is the angle from the zenith, radians.
    fn new(sun: f64, t: f64) -> Self {
        let line = |slope: [f64; 5], at0: [f64; 5]| std::array::from_fn(|i| slope[i] * t + at0[i]);
        let coefficients: [[f64; 5]; 3] = [
            line([0.1787, -0.3554, -0.0227, 0.1206, -0.0670], [-1.4630, 0.4275, 5.3251, -2.5771, 0.3703]),
            line([-0.0193, -0.0665, -0.0004, -0.0641, -0.0033], [-0.2592, 0.0008, 0.2125, -0.8989, 0.0452]),
            line([-0.0167, -0.0950, -0.0079, -0.0441, -0.0109], [-0.2608, 0.0092, 0.2102, -1.6537, 0.0529]),
        ];
        let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * sun);
        let luminance = (4.0453 * t - 4.9710) * libm::tan(chi) - 0.2155 * t + 2.4192;
        let cubic = |[a, b, c, d]: [f64; 4]| ((a * sun + b) * sun + c) * sun + d;
        let chromaticity = |m: [[f64; 4]; 3]| (cubic(m[0]) * t + cubic(m[1])) * t + cubic(m[2]);
        let zenith = [
            luminance,
            chromaticity([
                [0.00166, -0.00375, 0.00209, 0.0],
                [-0.02903, 0.06377, -0.03202, 0.00394],
                [0.11693, -0.21196, 0.06052, 0.25886],
            ]),
            chromaticity([
                [0.00275, -0.00610, 0.00317, 0.0],
                [-0.04214, 0.08970, -0.04153, 0.00516],
                [0.15346, -0.26756, 0.06670, 0.26688],
            ]),
        ];
        let parts = std::array::from_fn(|i| {
            (coefficients[i], zenith[i] / perez(&coefficients[i], 1.0, libm::cos(sun)))
        });
        Self { parts }
    }

    /// Linear sRGB, kcd/m^2, by the cosines from the zenith and from the sun.
    fn radiance(&self, cos: f64, cos_gamma: f64) -> [f64; 3] {
        let [luminance, x, y] = [0, 1, 2].map(|i| self.parts[i].1 * perez(&self.parts[i].0, cos, cos_gamma));
        let (luminance, y) = (luminance.max(0.0), y.max(0.01));
        let xyz = [x * luminance / y, luminance, (1.0 - x - y) * luminance / y];
        cie::XYZ_TO_SRGB.map(|row| row.iter().zip(xyz).map(|(m, c)| m * c).sum::<f64>())
    }
}

/// `(1 + A e^(B/cos)) (1 + C e^(D gamma) + E cos^2 gamma)`.
fn perez([a, b, c, d, e]: &[f64; 5], cos: f64, cos_gamma: f64) -> f64 {
    let gamma = libm::acos(cos_gamma.max(-1.0).min(1.0));
    (1.0 + a * libm::exp(b / cos.max(1e-3))) * (1.0 + c * libm::exp(d * gamma) + e * cos_gamma * cos_gamma)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn irradiance(sky: &EnvironmentImage, light: &Light) -> f32 {
        let Light::Directional { direction, irradiance, .. } = light else { panic!("the sun") };
        LinearRgb(horizontal_irradiance(sky)).luminance() + irradiance.luminance() * direction.y
    }

    #[test]
    fn a_white_sheet_has_radiance_one_in_every_weather() {
        for (elevation_deg, turbidity) in [(0.0, 2.0), (5.0, 6.0), (50.0, 3.0), (90.0, 10.0)] {
            let day = Daylight { elevation_deg, turbidity, ..Daylight::default() };
            let (sky, sun) = day.sky();
            assert!((irradiance(&sky, &sun) / std::f32::consts::PI - 1.0).abs() < 1e-4, "{day:?}");
            let ground = LinearRgb(sky.texels[512 * 200]).luminance();
            assert!((ground - 0.2).abs() < 1e-4, "{ground}");
            assert!(sky.texels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
        }
        let cloudy = overcast(0.5);
        assert!((horizontal_irradiance(&cloudy)[1] / std::f32::consts::PI - 1.0).abs() < 1e-4);
        // Three to one, and closed form: mean over the sphere of (1 + 2 cos)/3 * 9/7 above and albedo below.
        assert!((cloudy.texels[0][0] / cloudy.texels[127 * 512][0] - 3.0).abs() < 0.05);
        assert!((cloudy.mean_radiance().0[0] - (0.5 * 9.0 / 7.0 * 2.0 / 3.0 + 0.25)).abs() < 1e-3);
    }

    /// The paper's zenith by hand for turbidity 2 and a sun 45 degrees high: chi = (4/9 - 1/60) pi/2, luminance 6.5.
    #[test]
    fn the_zenith_is_the_papers() {
        let sky = Preetham::new(0.25 * PI, 2.0);
        let chi = (4.0 / 9.0 - 2.0 / 120.0) * 0.5 * PI;
        let expected = 3.1196 * chi.tan() + 1.9882;
        let rgb = sky.radiance(1.0, (0.25 * PI).cos());
        let luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
        assert!((luminance / expected - 1.0).abs() < 1e-3, "{luminance} {expected}");
        assert!(rgb[2] > 1.5 * rgb[0], "the zenith is blue: {rgb:?}");
    }

    /// A clear noon has about 100 klx from the sun and 10 to 20 klx from the sky; a low sun is dim and red.
    #[test]
    fn the_sun_is_bright_at_noon_and_red_at_the_horizon() {
        let noon = LinearRgb(sun_klx(60.0, 2.5));
        assert!((85.0..115.0).contains(&noon.luminance()), "{noon:?}");
        let low = LinearRgb(sun_klx(2.0, 2.5));
        assert!(low.luminance() < 0.2 * noon.luminance() && low.0[0] > 3.0 * low.0[2], "{low:?}");
        let (sky, _) = Daylight { elevation_deg: 60.0, turbidity: 2.5, ..Daylight::default() }.sky();
        let share = LinearRgb(horizontal_irradiance(&sky)).luminance() / std::f32::consts::PI;
        assert!((0.05..0.3).contains(&share), "the sky gives {share}");
    }

    #[test]
    fn the_sky_is_brightest_around_its_sun() {
        let day = Daylight { elevation_deg: 30.0, azimuth_deg: 70.0, ..Daylight::default() };
        let (sky, sun) = day.sky();
        let Light::Directional { direction, .. } = sun else { panic!("the sun") };
        assert!(direction.x > 0.7 && direction.y > 0.49);
        let at = |d: Vec3| sky.radiance(d).luminance();
        let brightest = sky.texels.iter().map(|t| LinearRgb(*t).luminance()).fold(0.0, f32::max);
        assert!(at(direction) > 0.9 * brightest);
        assert!(at(direction) > 3.0 * at(Vec3::new(-direction.x, direction.y, -direction.z)));
        let odd = Daylight { elevation_deg: f32::NAN, turbidity: -3.0, ..Daylight::default() }.sky().0;
        assert!(odd.texels.iter().flatten().all(|c| c.is_finite()));
    }
}
