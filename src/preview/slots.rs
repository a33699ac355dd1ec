//! Which files make the shader of an object: the frame's around those of its material; see [`super::program`].
//!
//! | Part | Files |
//! | --- | --- |
//! | maps | `maps_none`, `maps` |
//! | film under maps | the material's own series, or `film_table` in its place |
//! | suns and rectangles | `lamps_none`, `lamps` |
//! | light from all around | `sky_none`, `sky_even`, `sky_image` |

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
    /// Suns or rectangles.
    pub(super) lamps: bool,
    /// Light from all around.
    pub(super) sky: Sky,
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
}

/// The files, in the order in which they are joined.
pub(super) fn files(program: &SkinProgram, mapped: bool, film_table: bool, lit: Lit) -> Vec<Slot> {
    let [frame, surface, shade] = slots!["frame", "surface", "shade"];
    let [plain, maps, no_lamps, lamps] = slots!["maps_none", "maps", "lamps_none", "lamps"];
    let [dark, even, image] = slots!["sky_none", "sky_even", "sky_image"];
    let sky = match lit.sky {
        Sky::Dark => dark,
        Sky::Even => even,
        Sky::Image => image,
    };
    let mut files = vec![frame];
    let series =
        |slot: &&Slot| ["film_series", "fringes", "beyond"].iter().any(|start| slot.name.starts_with(start));
    if film_table {
        files.extend(program.slots().iter().filter(|slot| !series(slot)));
        files.extend(slots!["film_table"]);
    } else {
        files.extend_from_slice(program.slots());
    }
    files.extend([
        if mapped { maps } else { plain },
        surface,
        if lit.lamps { lamps } else { no_lamps },
        sky,
        shade,
    ]);
    files
}

/// Files as one text.
pub(super) fn join(files: &[Slot]) -> String {
    files.iter().map(|slot| slot.source).collect::<Vec<_>>().join("\n")
}

/// Files as a module on the device.
pub(super) fn module(gpu: &Gpu, name: &str, files: &[Slot]) -> wgpu::ShaderModule {
    let source = wgpu::ShaderSource::Wgsl(join(files).into());
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor { label: Some(name), source })
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;
    use crate::preview::frame::FrameUniform;
    use crate::preview::lamps::{Disc, Lamp, LampSample, MOST_LAMPS, MOST_SAMPLES};
    use crate::preview::program::SkinOptions;
    use crate::preview::textures::PlainUniform;
    use crate::scene::SceneFeatures;

    fn parse(source: &str) -> naga::Module {
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)))
    }

    fn validate(module: &naga::Module) -> Result<naga::valid::ModuleInfo, String> {
        let flags = naga::valid::ValidationFlags::all();
        let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
        validator.validate(module).map_err(|e| format!("{:?}", e.into_inner()))
    }

    fn features() -> [SceneFeatures; 3] {
        let film = SceneFeatures { film: true, interface: true, base: true, ..SceneFeatures::default() };
        let map = SceneFeatures { thickness_map: true, absorber: true, ..film };
        [SceneFeatures::default(), film, map]
    }

    fn all() -> Vec<Vec<Slot>> {
        let mut all = Vec::new();
        for features in features() {
            let program = SkinProgram::new(&features, &SkinOptions::default());
            for mapped in [false, true] {
                for lamps in [false, true] {
                    for sky in [Sky::Dark, Sky::Even, Sky::Image] {
                        all.push(files(&program, mapped, false, Lit { lamps, sky }));
                        if mapped && features.film {
                            all.push(files(&program, mapped, true, Lit { lamps, sky }));
                        }
                    }
                }
            }
        }
        let [frame, background, even, image] =
            slots!["frame", "background", "surroundings_even", "surroundings_image"];
        let [lamp, shadow, depth] = slots!["lamp", "shadow", "depth"];
        all.extend([vec![frame, depth]]);
        all.extend([
            vec![frame, even, background],
            vec![frame, image, background],
            vec![frame, lamp],
            vec![shadow],
        ]);
        all
    }

    /// Each module is whole, and without its first file it is not.
    #[test]
    fn all_modules_are_valid_and_hold_only_what_is_used() {
        for files in all() {
            let module = parse(&join(&files));
            validate(&module).unwrap_or_else(|e| panic!("{files:?}: {e}"));
            if files.len() > 1 {
                assert!(naga::front::wgsl::parse_str(&join(&files[1..])).is_err(), "{files:?}");
            }
            let bound =
                |name: &str| module.global_variables.iter().any(|(_, g)| g.name.as_deref() == Some(name));
            for (variable, file) in [
                ("lamps", "lamps"),
                ("shadow_maps", "lamps"),
                ("sky", "sky_image"),
                ("color_map", "maps"),
                ("film_table", "film_table"),
                ("picture", "surroundings_image"),
            ] {
                assert_eq!(bound(variable), files.iter().any(|f| f.name == file), "{variable} in {files:?}");
            }
        }
    }

    #[test]
    fn blocks_lie_in_memory_as_shaders_read_them() {
        let program = SkinProgram::new(&features()[1], &SkinOptions::default());
        let skin = parse(&join(&files(&program, false, false, Lit { lamps: true, sky: Sky::Dark })));
        let [frame, even, background] = slots!["frame", "surroundings_even", "background"];
        let background = parse(&join(&[frame, even, background]));
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
            lamps,
            right,
            discs,
            up,
            padding,
            even,
            padding_2
        );
        block!(&skin, "Lamp", Lamp, first, count, spread, padding);
        block!(&skin, "Sample", LampSample, at, light, texel, normal, padding, shadow);
        block!(&skin, "Plain", PlainUniform, albedo, roughness, thickness);
        block!(&background, "Disc", Disc, direction, chord_2, radiance, padding);
        let samples = MOST_LAMPS * size_of::<Lamp>();
        check(
            &skin,
            "Lamps",
            samples + MOST_SAMPLES * size_of::<LampSample>(),
            &[("lamps", 0), ("samples", samples)],
        );
    }
}
