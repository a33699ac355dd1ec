//! Which files make the shader of an object: the frame's around those of its material; see [`super::program`].
//!
//! | Part | Files |
//! | --- | --- |
//! | maps | `maps_none`, or `maps` with the next three |
//! | their level | `maps_bias`, `maps_level` |
//! | their texels | `texels_half`, `texels_byte` |
//! | variation of the film | `width_none`, `width_map` |
//! | film under maps | the material's own, or `film_table` in its place |
//! | suns | `suns_none`, `suns` |
//! | rectangles | `rectangles_none`, or `rectangles` with `places_shared`, `places_lobe`, or `places_each` and the next |
//! | colours of small lights | `tints_middle`, `tints_each` |
//! | light from all around | `sky_none`, `sky_even`, or `sky_image` with the next |
//! | what gloss sends of it | `sky_split`, `sky_lobe`, or of a grating `sky_orders` |
//! | directions of a lobe | `visible_facets` for `places_lobe` or `sky_lobe` |
//! | what hides it | `open_all`, or `open_screen` with the passes of occlusion.rs |
//! | who is shaded | `forward`: triangles; `deferred`: pixels that `gbuffer` recorded |
//! | where triangles read maps | `relief_none`, `relief` |

use super::Gpu;
use super::program::{SkinProgram, Slot};

macro_rules! slots {
    ($($name:literal),* $(,)?) => {
        [$(Slot { name: $name, source: include_str!(concat!("shaders/", $name, ".wgsl")) }),*]
    };
}
pub(super) use slots;

/// What lights objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lit {
    /// Suns.
    pub(super) suns: bool,
    /// How rectangles do, if there are any.
    pub(super) rectangles: Option<Places>,
    /// Light from all around.
    pub(super) sky: Sky,
    /// Whether the picture's depths hide some of it.
    pub(super) hidden: bool,
}

/// The small lights of rectangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Places {
    /// Four quarters, whose shadows neighbouring pixels share.
    Shared,
    /// Each by its own shadow, all in one colour.
    Middle,
    /// Each in its own colour, and directions of a lobe where there is one.
    Each,
}

/// Light from all around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sky {
    /// None.
    Dark,
    /// The same from everywhere.
    Even,
    /// A picture's.
    Image,
    /// A picture's, in which gloss looks in many directions.
    Sampled,
}

/// What a surface has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Has {
    /// Maps.
    pub(super) maps: bool,
    /// Its film as a table.
    pub(super) film_table: bool,
    /// A film that varies below a texel.
    pub(super) film_width: bool,
    /// A record of what its pixels show.
    pub(super) recorded: bool,
    /// Maps of bytes.
    pub(super) bytes: bool,
    /// A height map whose relief is seen.
    pub(super) relief: bool,
}

/// The files, in the order in which they are joined.
pub(super) fn files(program: &SkinProgram, has: Has, lit: Lit) -> Vec<Slot> {
    let [frame, surface, shade] = slots!["frame", "surface", "shade"];
    let [forward, deferred, bias, level] = slots!["forward", "deferred", "maps_bias", "maps_level"];
    let [plain, maps, width, no_width] = slots!["maps_none", "maps", "width_map", "width_none"];
    let [suns, no_suns] = slots!["suns", "suns_none"];
    let [rectangles, no_rectangles] = slots!["rectangles", "rectangles_none"];
    let [dark, even, image] = slots!["sky_none", "sky_even", "sky_image"];
    let sky = match lit.sky {
        Sky::Dark => dark,
        Sky::Even => even,
        Sky::Image | Sky::Sampled => image,
    };
    let mut files = vec![frame];
    let series = |slot: &&Slot| {
        ["film_series", "film_dispersed", "fringes", "beyond"]
            .iter()
            .any(|start| slot.name.starts_with(start))
    };
    let grating = program.has("gloss_grating");
    if has.film_table {
        // A grating asks for wavelengths, not for colours.
        let needless = |slot: &&Slot| series(slot) || (slot.name == "airy" && !grating);
        files.extend(program.slots().iter().filter(|slot| !needless(slot)));
        files.extend(slots!["film_table"]);
    } else {
        files.extend_from_slice(program.slots());
    }
    if has.maps {
        files.extend([maps, if has.recorded { level } else { bias }]);
        let [half, byte] = slots!["texels_half", "texels_byte"];
        files.push(if has.bytes { byte } else { half });
        files.push(if has.film_width { width } else { no_width });
    } else {
        files.push(plain);
    }
    let suns = if lit.suns { suns } else { no_suns };
    files.extend([surface, suns]);
    let [each, shared, middle_tint, each_tint] =
        slots!["places_each", "places_shared", "tints_middle", "tints_each"];
    let lobe = program.has("gloss_ggx");
    let sampled = lit.sky == Sky::Sampled && lobe;
    if lobe && (sampled || lit.rectangles == Some(Places::Each)) {
        files.extend(slots!["visible_facets"]);
    }
    match lit.rectangles {
        Some(Places::Shared) => files.extend([rectangles, shared]),
        Some(Places::Middle) => files.extend([rectangles, middle_tint, each]),
        Some(Places::Each) if lobe => files.extend([rectangles, slots!["places_lobe"][0]]),
        Some(Places::Each) => files.extend([rectangles, each_tint, each]),
        None => files.push(no_rectangles),
    }
    let [all, screen] = slots!["open_all", "open_screen"];
    files.extend([if lit.hidden { screen } else { all }, sky]);
    match lit.sky {
        Sky::Dark | Sky::Even => {}
        Sky::Sampled if sampled => files.extend(slots!["sky_lobe"]),
        Sky::Image | Sky::Sampled => {
            let [split, orders] = slots!["sky_split", "sky_orders"];
            files.push(if grating { orders } else { split });
        }
    }
    files.push(shade);
    if has.recorded {
        files.push(deferred);
    } else {
        files.extend([relief(has.relief), forward]);
    }
    files
}

/// Those that record what a surface shows before it is shaded.
pub(super) fn recorder(has_relief: bool) -> Vec<Slot> {
    let [frame, surface, gbuffer] = slots!["frame", "surface", "gbuffer"];
    vec![frame, surface, relief(has_relief), gbuffer]
}

/// Where triangles read maps.
fn relief(seen: bool) -> Slot {
    let [none, relief] = slots!["relief_none", "relief"];
    if seen { relief } else { none }
}

/// Files as one text.
pub(super) fn join(files: &[Slot]) -> String {
    files.iter().map(|slot| slot.source).collect::<Vec<_>>().join("\n")
}

/// Files, and constants that they lack, as a module on the device.
pub(super) fn module(gpu: &Gpu, name: &str, files: &[Slot], constants: &str) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl((join(files) + constants).into());
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source })
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;
    use crate::preview::constants;
    use crate::preview::frame::FrameUniform;
    use crate::preview::lamps::{Disc, Lamps, MOST_LAMPS, MOST_PLACES, Rectangle, Sun};
    use crate::preview::program::SkinOptions;
    use crate::preview::textures::PlainUniform;
    use crate::scene::SceneFeatures;

    /// With constants of lights where there are any.
    fn whole(files: &[Slot]) -> String {
        let mut lamps = Lamps::default();
        let has = |name: &str| files.iter().any(|f| f.name == name);
        lamps.suns.extend(has("suns").then(Sun::default));
        lamps.rectangles.extend(has("rectangles").then(Rectangle::default));
        join(files) + &constants::text(&lamps)
    }

    fn parse(source: &str) -> naga::Module {
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)))
    }

    fn validate(module: &naga::Module) -> Result<naga::valid::ModuleInfo, String> {
        let flags = naga::valid::ValidationFlags::all();
        let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
        validator.validate(module).map_err(|e| format!("{:?}", e.into_inner()))
    }

    fn features() -> [SceneFeatures; 6] {
        let film = SceneFeatures { film: true, interface: true, base: true, ..SceneFeatures::default() };
        let map = SceneFeatures { thickness_map: true, absorber: true, ..film };
        let dispersed = SceneFeatures { dispersion: true, ..map };
        let ridges = |features| SceneFeatures { grating: true, ..features };
        [SceneFeatures::default(), film, map, dispersed, ridges(map), ridges(dispersed)]
    }

    fn all() -> Vec<Vec<Slot>> {
        let mut all = Vec::new();
        for features in features() {
            let program = SkinProgram::new(&features, &SkinOptions::default());
            for maps in [false, true] {
                for bits in 0..8 {
                    let suns = bits & 1 == 1;
                    let rectangles =
                        [None, Some(Places::Shared), Some(Places::Middle), Some(Places::Each)][bits / 2];
                    for sky in [Sky::Dark, Sky::Even, Sky::Image, Sky::Sampled] {
                        let hidden = sky != Sky::Dark && (suns ^ maps);
                        let lit = Lit { suns, rectangles, sky, hidden };
                        let has = Has { maps, ..Has::default() };
                        all.push(files(&program, has, lit));
                        let recorded = Has { recorded: true, bytes: suns, film_width: maps && suns, ..has };
                        all.push(files(&program, recorded, Lit { hidden: false, ..lit }));
                        if maps && features.film {
                            all.push(files(&program, Has { film_width: true, relief: suns, ..has }, lit));
                            all.push(files(&program, Has { film_table: true, film_width: suns, ..has }, lit));
                        }
                    }
                }
            }
        }
        let [frame, background, even, image] =
            slots!["frame", "background", "surroundings_even", "surroundings_image"];
        let [lamp, shadow, depth, edges] = slots!["lamp", "shadow", "depth", "edges"];
        let [facing, search, mean] = slots!["facing", "occlusion", "occlusion_mean"];
        all.extend([vec![frame, depth], vec![edges], vec![frame, facing], vec![frame, search], vec![mean]]);
        all.extend([recorder(false), recorder(true)]);
        let [down, up, first, next, meter] =
            slots!["bloom_down", "bloom_up", "meter_first", "meter_next", "meter"];
        all.extend([vec![down], vec![up], vec![meter, first], vec![meter, next]]);
        let develop = slots!["develop", "exposure_fixed", "exposure_mean"];
        for tone in slots!["tone_clamp", "tone_reinhard", "tone_aces", "tone_agx", "tone_neutral"] {
            all.extend([vec![tone, develop[1], develop[0]], vec![tone, develop[2], develop[0]]]);
        }
        all.extend([
            vec![frame, even, background],
            vec![frame, image, background],
            vec![frame, lamp],
            vec![shadow],
            slots!["whole"].to_vec(),
        ]);
        all
    }

    /// Each module is whole, and without its first file it is not.
    #[test]
    fn all_modules_are_valid_and_hold_only_what_is_used() {
        for files in all() {
            let module = parse(&whole(&files));
            validate(&module).unwrap_or_else(|e| panic!("{files:?}: {e}"));
            if files.len() > 1 {
                assert!(naga::front::wgsl::parse_str(&whole(&files[1..])).is_err(), "{files:?}");
            }
            let bound =
                |name: &str| module.global_variables.iter().any(|(_, g)| g.name.as_deref() == Some(name));
            for (variable, file) in [
                ("suns", "suns"),
                ("sun_maps", "suns"),
                ("rectangles", "rectangles"),
                ("rectangle_maps", "rectangles"),
                ("width_map", "width_map"),
                ("sky", "sky_image"),
                ("openings", "open_screen"),
                ("color_map", "maps"),
                ("tangents", "deferred"),
                ("relief_map", "relief"),
                ("film_table", "film_table"),
                ("order_shares", "gloss_grating"),
                ("picture", "surroundings_image"),
            ] {
                assert_eq!(bound(variable), files.iter().any(|f| f.name == file), "{variable} in {files:?}");
            }
            // Directions of a lobe are there for those that look in them.
            let facets = module.functions.iter().any(|(_, f)| f.name.as_deref() == Some("visible_facet"));
            let looks = files.iter().any(|f| ["sky_lobe", "places_lobe"].contains(&f.name));
            assert_eq!(facets, looks, "{files:?}");
        }
    }

    #[test]
    fn blocks_lie_in_memory_as_shaders_read_them() {
        let program = SkinProgram::new(&features()[1], &SkinOptions::default());
        let lit = Lit { suns: true, rectangles: Some(Places::Middle), sky: Sky::Dark, hidden: false };
        let skin = parse(&whole(&files(&program, Has::default(), lit)));
        let [frame, even, background] = slots!["frame", "surroundings_even", "background"];
        let background = parse(&whole(&[frame, even, background]));
        let check = |module: &naga::Module, name: &str, size: usize, offsets: &[(&str, usize)]| {
            let (_, block) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).expect(name);
            let naga::TypeInner::Struct { members, span } = &block.inner else { panic!("{name}: no struct") };
            assert_eq!(*span as usize, size, "{name}");
            let found: Vec<_> =
                members.iter().map(|m| (m.name.as_deref().unwrap_or(""), m.offset as usize)).collect();
            assert_eq!(found, offsets, "{name}");
        };
        macro_rules! block {
            ($module:expr, $name:literal, $type:ty, $($field:ident),*) => {
                check($module, $name, size_of::<$type>(), &[$((stringify!($field), offset_of!($type, $field))),*])
            };
        }
        block!(
            &skin,
            "Frame",
            FrameUniform,
            clip,
            eye,
            sky_layers,
            forward,
            discs,
            right,
            first_place,
            up,
            place_step,
            even,
            sharper,
            place_shift,
            sample,
            near
        );
        block!(&skin, "Sun", Sun, direction, spread, irradiance, texel, shadow);
        block!(
            &skin,
            "Rectangle",
            Rectangle,
            x,
            first,
            y,
            count,
            z,
            spread,
            center,
            texel,
            light,
            scale,
            depth,
            cell,
            pivot,
            over,
            padding,
            corner,
            half_sides,
            low_steps,
            high_steps
        );
        block!(&skin, "Plain", PlainUniform, albedo, roughness, thickness);
        block!(&background, "Disc", Disc, direction, chord_2, radiance, padding);
        let first = MOST_LAMPS * size_of::<Rectangle>();
        let all = first + MOST_PLACES * size_of::<[f32; 4]>();
        check(&skin, "Rectangles", all, &[("rectangles", 0), ("places", first)]);
    }
}
