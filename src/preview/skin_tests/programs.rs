//! Programs without an adapter: every one is whole by naga, holds only what its material has, and agrees with the host.

use std::mem::offset_of;

use super::PROBE;
use crate::optics::Grating;
use crate::optics::layered::{Constants, LEAST_ROUGHNESS, Parts};
use crate::preview::material::{self, MaterialUniform, SkinData};
use crate::preview::program::{SkinOptions, SkinProgram};
use crate::scene::SceneFeatures;

/// Every combination of the features that programs look at, and of options.
fn programs() -> Vec<SkinProgram> {
    let mut all = Vec::new();
    for bits in 0..2048u32 {
        let bit = |i: u32| bits >> i & 1 == 1;
        let features = SceneFeatures {
            interface: bit(0) || bit(1),
            film: bit(1),
            thickness_map: bit(1) && bit(2),
            base: bit(3),
            absorber: bit(4),
            wrapped_base: bit(5),
            coupled_energy: bit(6),
            total_reflection: bit(7),
            translucent_base: bit(5) && bit(8),
            dispersion: bit(9) && (bit(0) || bit(1)),
            grating: bit(10),
            ..SceneFeatures::default()
        };
        for parts in [Parts::All, Parts::Specular, Parts::Diffuse, Parts::Lambert] {
            for footprint in [false, true] {
                let options = SkinOptions { footprint, parts, ..SkinOptions::default() };
                let program = SkinProgram::new(&features, &options);
                if !all.contains(&program) {
                    all.push(program);
                }
            }
        }
    }
    all
}

fn parse(source: &str) -> naga::Module {
    naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)))
}

#[test]
fn every_combination_of_slots_is_a_valid_module() {
    let all = programs();
    assert!(all.len() > 100, "{}", all.len());
    let flags = naga::valid::ValidationFlags::all();
    for program in &all {
        let module = parse(&(program.source() + PROBE));
        let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
        validator.validate(&module).unwrap_or_else(|e| panic!("{program:?}: {e:?}"));
    }
    // The control: a slot left out is missed.
    let whole: Vec<_> = all[all.len() - 1].slots().iter().map(|s| s.source).collect();
    assert!(naga::front::wgsl::parse_str(&whole[1..].join("\n")).is_err());
}

#[test]
fn what_a_material_lacks_is_not_in_its_shader() {
    let none = SkinProgram::new(&SceneFeatures::default(), &SkinOptions::default());
    let module = parse(&none.source());
    let globals =
        |m: &naga::Module| m.global_variables.iter().filter_map(|(_, g)| g.name.clone()).collect::<Vec<_>>();
    assert_eq!(globals(&module), ["material"]);
    assert!(module.functions.iter().all(|(_, f)| f.name.as_deref() != Some("fresnel")));
    assert!(none.constants().is_empty() && none.grating_wavelengths().is_none());
    let film = SceneFeatures { film: true, interface: true, ..SceneFeatures::default() };
    let base = SceneFeatures { base: true, ..film };
    let mapped = SceneFeatures { thickness_map: true, absorber: true, ..base };
    let ridged = SceneFeatures { grating: true, ..base };
    let more = SceneFeatures { dispersion: true, ..ridged };
    let program =
        |features, parts| SkinProgram::new(&features, &SkinOptions { parts, ..SkinOptions::default() });
    for (features, parts, tables, absent) in [
        (film, Parts::All, vec!["fringes_table", "lobe_table"], "below_film"),
        (base, Parts::All, vec!["fringes_table", "lobe_table"], "fringes_integral"),
        (base, Parts::Diffuse, vec!["fringes_table"], "ggx_density"),
        (base, Parts::Lambert, vec![], "film_reflect"),
        (mapped, Parts::All, vec!["below_rows", "fringes_table", "lobe_table"], "base_matt"),
        (
            ridged,
            Parts::All,
            vec!["fringes_table", "order_nodes", "order_shares", "lobe_table"],
            "ggx_density",
        ),
        (ridged, Parts::Diffuse, vec!["fringes_table"], "film_power"),
        (more, Parts::All, vec!["wavelengths", "order_nodes", "order_shares", "lobe_table"], "fringes"),
    ] {
        let program = program(features, parts);
        let module = parse(&program.source());
        assert_eq!(globals(&module)[1..], tables, "{program:?}");
        assert!(module.functions.iter().all(|(_, f)| f.name.as_deref() != Some(absent)), "{program:?}");
        // What the shader reads is what there is.
        let grating = Some(Grating { period_nm: 900.0, height_nm: 50.0, direction_rad: 0.0 });
        let constants = Constants { grating, ..Constants::default() };
        let data = SkinData::new(&constants, 300.0, &program).expect("a material");
        let mut bound: Vec<_> = data.tables.iter().map(|t| (t.name.to_owned(), t.binding)).collect();
        let mut read: Vec<_> = module
            .global_variables
            .iter()
            .skip(1)
            .filter_map(|(_, g)| Some((g.name.clone()?, g.binding.as_ref()?.binding)))
            .collect();
        bound.sort();
        read.sort();
        assert_eq!(bound, read, "{program:?}");
    }
}

#[test]
fn the_uniform_block_lies_in_memory_as_the_shader_reads_it() {
    let module = parse(&programs()[0].source());
    let (_, block) =
        module.types.iter().find(|(_, t)| t.name.as_deref() == Some("Material")).expect("Material");
    let naga::TypeInner::Struct { members, span } = &block.inner else { panic!("no struct") };
    assert_eq!(*span as usize, size_of::<MaterialUniform>());
    let offsets = [
        ("indices", offset_of!(MaterialUniform, indices)),
        ("below_per_nm", offset_of!(MaterialUniform, below_per_nm)),
        ("absorption", offset_of!(MaterialUniform, absorption)),
        ("intrinsic", offset_of!(MaterialUniform, intrinsic)),
        ("clear", offset_of!(MaterialUniform, clear)),
        ("film_dispersion", offset_of!(MaterialUniform, film_dispersion)),
        ("lost", offset_of!(MaterialUniform, lost)),
        ("layer_dispersion", offset_of!(MaterialUniform, layer_dispersion)),
        ("entering", offset_of!(MaterialUniform, entering)),
        ("eta", offset_of!(MaterialUniform, eta)),
        ("layer", offset_of!(MaterialUniform, layer)),
    ];
    let found: Vec<_> =
        members.iter().map(|m| (m.name.as_deref().unwrap_or(""), m.offset as usize)).collect();
    assert_eq!(found, offsets);
}

#[test]
fn constants_of_the_shaders_are_those_of_the_tables() {
    let film = SceneFeatures { film: true, interface: true, ..SceneFeatures::default() };
    let number = |features: SceneFeatures, name: &str| {
        let source = SkinProgram::new(&features, &SkinOptions::default()).source();
        let at = source.find(&format!("const {name} = ")).expect("the constant") + name.len() + 9;
        let digits: String = source[at..].chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
        digits.parse::<f64>().expect("a number")
    };
    for features in [film, SceneFeatures { thickness_map: true, ..film }] {
        assert_eq!(number(features, "FRINGES_PER_NM"), 1.0 / material::FRINGES_STEP_NM);
        assert_eq!(number(features, "FRINGES_LAST"), material::FRINGES as f64);
        assert_eq!(number(features, "LEAST_ROUGHNESS"), LEAST_ROUGHNESS);
    }
}
