//! The built-in presets say what they are, and agree with the published counts of their species.

use std::collections::{BTreeMap, BTreeSet};

use ophidian::base::MapKind;
use ophidian::graph::{self, about};
use ophidian::maps::plane_hash;
use ophidian::preset::builtin::{self, BUILTIN};
use ophidian::skin::{SECTIONS, Skin};

use crate::made;

/// Published ranges: name, dorsal rows at midbody, ventrals, total length in mm (keys and field guides), and the
/// midbody diameter in mm of a usual adult (an estimate).
type Fact = (&'static str, [u32; 2], [u32; 2], [f32; 2], f32);

const FACTS: &[Fact] = &[
    ("acrochordus_javanicus", [100, 150], [0, 0], [600.0, 2430.0], 70.0),
    ("atheris_hispida", [15, 19], [149, 166], [400.0, 730.0], 17.0),
    ("bitis_gabonica", [28, 46], [124, 140], [1200.0, 1800.0], 95.0),
    ("bitis_nasicornis", [31, 43], [117, 140], [600.0, 1200.0], 62.0),
    ("bothrops_alternatus", [25, 35], [155, 190], [800.0, 1690.0], 38.0),
    ("bungarus_fasciatus", [15, 15], [200, 234], [1200.0, 2250.0], 38.0),
    ("crotalus_atrox", [23, 29], [173, 196], [910.0, 2130.0], 45.0),
    ("dendroaspis_viridis", [13, 15], [211, 225], [1400.0, 2400.0], 26.0),
    ("drymarchon_couperi", [17, 17], [182, 195], [1500.0, 2630.0], 48.0),
    ("epicrates_cenchria", [41, 54], [223, 275], [1300.0, 2000.0], 40.0),
    ("erythrolamprus_miliaris", [15, 19], [141, 168], [400.0, 1000.0], 17.0),
    ("lampropeltis_triangulum", [19, 23], [182, 214], [600.0, 1320.0], 17.0),
    ("leiopython_albertisii", [45, 55], [258, 290], [1500.0, 2400.0], 48.0),
    ("malayopython_reticulatus", [69, 79], [297, 332], [3000.0, 6500.0], 120.0),
    ("micrurus_diastema", [15, 15], [190, 230], [450.0, 900.0], 11.0),
    ("morelia_viridis", [49, 64], [219, 254], [1200.0, 1800.0], 40.0),
    ("pantherophis_guttatus", [25, 29], [203, 245], [760.0, 1830.0], 30.0),
    ("phalotris_lemniscatus", [15, 15], [180, 225], [300.0, 680.0], 9.0),
    ("philodryas_aestiva", [19, 21], [180, 206], [700.0, 1100.0], 13.0),
    ("philodryas_olfersii", [19, 19], [170, 205], [1000.0, 1500.0], 15.0),
    ("ptychophis_flavovirgatus", [17, 17], [135, 165], [350.0, 650.0], 14.0),
    ("python_regius", [53, 63], [191, 207], [900.0, 1820.0], 58.0),
    ("thamnophis_sirtalis", [17, 21], [138, 172], [450.0, 1300.0], 17.0),
    ("xenopeltis_unicolor", [15, 15], [164, 196], [750.0, 1300.0], 24.0),
];

/// The anatomy of a built-in preset, read another way than the library reads it.
fn skin(text: &str) -> Skin {
    let mut table: toml::Table = text.parse().expect("TOML");
    table.retain(|key, _| SECTIONS.contains(&key));
    toml::Value::Table(table).try_into().expect("an anatomy")
}

#[test]
fn presets_name_themselves_and_are_sound() {
    for (name, text) in BUILTIN {
        let document = builtin::document(name).expect("a document");
        for key in ["common_name", "description"] {
            let about = about(&document, key).unwrap_or_default();
            assert!(about.len() > 5, "{name}: {key} is {about:?}");
        }
        let table: toml::Table = text.parse().expect("TOML");
        assert!(table["pattern"].get("class").is_some(), "{name} has no pattern class");
        let (graph, warnings) = graph::build(&document).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(warnings.is_empty(), "{name}: {warnings:?}");
        assert_eq!(graph.maps.keys().copied().collect::<Vec<_>>(), MapKind::ALL, "{name}");
        assert_eq!(graph.name, *name);
    }
    let common: BTreeSet<String> = BUILTIN
        .iter()
        .filter_map(|(name, _)| about(&builtin::document(name).ok()?, "common_name").map(str::to_lowercase))
        .collect();
    assert_eq!(common.len(), BUILTIN.len(), "two presets share a common name");
}

#[test]
fn all_six_classes_of_patterns_are_used() {
    let mut classes: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for (name, text) in BUILTIN {
        classes.entry(format!("{:?}", skin(text).pattern.class)).or_default().push(name);
    }
    assert_eq!(classes.len(), 6, "{classes:?}");
}

#[test]
fn counts_and_sizes_are_the_species_own() {
    let named: Vec<&str> = FACTS.iter().map(|f| f.0).collect();
    assert_eq!(named, BUILTIN.iter().map(|(name, _)| *name).collect::<Vec<_>>());
    for ((name, text), (_, rows, ventrals, total_mm, diameter_mm)) in BUILTIN.iter().zip(FACTS) {
        let skin = skin(text);
        let body = &skin.body;
        assert!((rows[0]..=rows[1]).contains(&skin.scales.rows), "{name}: {} rows", skin.scales.rows);
        let off = body.diameter_mm / diameter_mm;
        assert!((0.75..1.33).contains(&off), "{name}: {} mm thick", body.diameter_mm);
        assert_eq!(body.dorsals_per_ventral > 0.0, ventrals[1] > 0, "{name}: scutes");
        if ventrals[1] > 0 {
            // The scales of a row, laid end to end, make a snake without its tail, which is 5 to 35 % of it.
            let scutes = 0.5 * (ventrals[0] + ventrals[1]) as f32;
            let snout_vent = body.scale_pitch_mm * body.dorsals_per_ventral * scutes;
            let (least, most) = (0.65 * total_mm[0], 0.95 * total_mm[1]);
            assert!((least..=most).contains(&snout_vent), "{name}: {snout_vent} mm from snout to vent");
        }
        assert!((3..=8).contains(&body.repeats), "{name}: {} repeats", body.repeats);
    }
}

#[test]
fn a_tile_is_the_girth_by_whole_scales() {
    for (name, text) in BUILTIN {
        let (graph, body) = (made::graph(name, &[]), skin(text).body);
        let girth = std::f32::consts::PI * body.diameter_mm;
        assert!((graph.girth_mm / girth - 1.0).abs() < 1e-6, "{name}: {} mm round", graph.girth_mm);
        let scales = graph.length_mm / body.scale_pitch_mm;
        assert!((scales - scales.round()).abs() < 1e-3 && scales >= 1.0, "{name}: {scales} scales long");
        let repeats = scales / body.period_scales;
        let slack = 0.5 / body.period_scales + 1e-3;
        assert!((repeats - body.repeats as f32).abs() <= slack, "{name}: {repeats} repeats long");
    }
}

#[test]
fn another_seed_is_another_individual_of_the_same_species() {
    let name = "lampropeltis_triangulum";
    let graph = made::graph(name, &[]);
    let kinds = [MapKind::Color, MapKind::PatternMask, MapKind::Height, MapKind::ScaleId];
    let sets = [1, 2].map(|seed| {
        let graph = graph.clone().with_seed(seed);
        made::make(&graph, &kinds, made::domain(&graph, 512))
    });
    for kind in kinds {
        let [a, b] = [0, 1].map(|i| plane_hash(&sets[i].maps[&kind]));
        assert_ne!(a, b, "{kind}");
    }
    assert_eq!(sets[0].domain, sets[1].domain);
    // Every scale is seen, in both.
    let ids = sets.each_ref().map(|set| -> BTreeSet<u32> {
        set.maps[&MapKind::ScaleId].planes[0]
            .data()
            .iter()
            .map(|id| *id as u32)
            .filter(|id| *id > 0)
            .collect()
    });
    assert_eq!(ids[0], ids[1]);
    assert_eq!(ids[0].len(), graph.maps[&MapKind::ScaleId].range[1] as usize);
    // The pattern takes about the same share of the skin.
    let share = sets.each_ref().map(|set| {
        let data = set.maps[&MapKind::PatternMask].planes[0].data();
        data.iter().sum::<f32>() / data.len() as f32
    });
    assert!(share[0] > 0.1 && (share[0] / share[1] - 1.0).abs() < 0.2, "{share:?}");
}
