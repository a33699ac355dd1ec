//! File names from a template.

use std::fmt::Write as _;
use std::str::FromStr;

use crate::base::MapKind;
use crate::maps::{NormalFormat, SetId};

/// A file name with placeholders, `{preset}_{map}.{ext}` unless set otherwise.
///
/// | Placeholder | Becomes |
/// | --- | --- |
/// | `{preset}` | the preset's name |
/// | `{map}` | the map's name; `nor_gl` or `nor_dx` for normals, `maps` for a file that holds all of them |
/// | `{seed}` | the seed |
/// | `{size}` | `1024x2048`, width by height; one number if they are equal |
/// | `{ext}` | `png` or `exr` |
///
/// Whoever writes several seeds or sizes into one directory puts `{seed}` or `{size}` in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NameTemplate(Vec<Part>);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Part {
    Text(String),
    Preset,
    Map,
    Seed,
    Size,
    Ext,
}

const PLACEHOLDERS: [(&str, Part); 5] = [
    ("preset", Part::Preset),
    ("map", Part::Map),
    ("seed", Part::Seed),
    ("size", Part::Size),
    ("ext", Part::Ext),
];

/// Longest file name, bytes: the limit of every common file system less the ending of a file that is being written.
const MAX_BYTES: usize = 200;

/// Why a template or a file name is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// A placeholder that does not exist.
    #[error(
        "unknown placeholder {{{0}}} in the file name template: use {{preset}}, {{map}}, {{seed}}, {{size}} or {{ext}}"
    )]
    Unknown(String),
    /// A brace without its partner.
    #[error("unmatched brace in the file name template {0:?}")]
    Brace(String),
    /// The name would leave the directory, or some file system does not take it.
    #[error(
        "{0:?} is no file name: no / \\ : * ? \" < > | or control characters, no dot or space first or last, 200 bytes at most"
    )]
    Illegal(String),
    /// The name of the manifest.
    #[error("{0:?} is the manifest's own name")]
    Reserved(String),
    /// Two files of one set with the same name.
    #[error("two files of the set are named {0:?}: the template lacks {{map}} or {{ext}}")]
    Twice(String),
}

impl FromStr for NameTemplate {
    type Err = NameError;

    fn from_str(text: &str) -> Result<Self, NameError> {
        let brace = || NameError::Brace(text.chars().take(80).collect());
        let mut parts = Vec::new();
        let mut rest = text;
        while let Some(at) = rest.find(['{', '}']) {
            if at > 0 {
                parts.push(Part::Text(rest[..at].to_owned()));
            }
            let inside = rest[at..].strip_prefix('{').ok_or_else(brace)?;
            let (name, after) = inside.split_once('}').ok_or_else(brace)?;
            let known = PLACEHOLDERS.into_iter().find(|(n, _)| *n == name);
            parts.push(known.ok_or_else(|| NameError::Unknown(name.chars().take(40).collect()))?.1);
            rest = after;
        }
        if !rest.is_empty() {
            parts.push(Part::Text(rest.to_owned()));
        }
        // With harmless values the name must be legal: a bad template is refused before anything is evaluated.
        let template = Self(parts);
        check(&template.fill("a", "a", 0, (1, 1), "a"))?;
        Ok(template)
    }
}

impl Default for NameTemplate {
    fn default() -> Self {
        let text = |s: &str| Part::Text(s.to_owned());
        Self(vec![Part::Preset, text("_"), Part::Map, text("."), Part::Ext])
    }
}

impl NameTemplate {
    /// The file name of one map (`None`: of a file that holds all maps) of a set.
    ///
    /// # Errors
    /// If the name is not legal on every common file system, or the manifest's.
    pub fn file_name(
        &self,
        set: &SetId,
        map: Option<(MapKind, Option<NormalFormat>)>,
        ext: &str,
    ) -> Result<String, NameError> {
        let map = match map {
            Some((MapKind::Normal, format)) => format.unwrap_or_default().suffix(),
            Some((kind, _)) => kind.name(),
            None => "maps",
        };
        let name = self.fill(&set.preset, map, set.seed, (set.domain.width, set.domain.height), ext);
        check(&name)?;
        Ok(name)
    }

    fn fill(&self, preset: &str, map: &str, seed: u64, (width, height): (usize, usize), ext: &str) -> String {
        let mut name = String::new();
        for part in &self.0 {
            let _ = match part {
                Part::Text(text) => name.write_str(text),
                Part::Preset => name.write_str(preset),
                Part::Map => name.write_str(map),
                Part::Seed => write!(name, "{seed}"),
                Part::Size if width == height => write!(name, "{width}"),
                Part::Size => write!(name, "{width}x{height}"),
                Part::Ext => name.write_str(ext),
            };
        }
        name
    }
}

/// Refuse what leaves the directory or what Windows does not take, so that a set can be copied anywhere.
pub(super) fn check(name: &str) -> Result<(), NameError> {
    let illegal = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
    let edge = |c: char| c == '.' || c == ' ';
    if name.is_empty()
        || name.len() > MAX_BYTES
        || name.contains(illegal)
        || name.starts_with(edge)
        || name.ends_with(edge)
    {
        return Err(NameError::Illegal(name.chars().take(80).collect()));
    }
    if name.eq_ignore_ascii_case(super::manifest::FILE_NAME) {
        return Err(NameError::Reserved(name.to_owned()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Domain;

    fn set(preset: &str) -> SetId {
        let domain = Domain { width: 32, height: 64, girth_mm: 50.0, length_mm: 100.0 };
        SetId { domain, preset: preset.into(), seed: 7, preset_hash: [0; 32], optics: Default::default() }
    }

    fn name(template: &str, map: MapKind) -> Result<String, NameError> {
        template.parse::<NameTemplate>()?.file_name(&set("boa"), Some((map, None)), "png")
    }

    #[test]
    fn placeholders_are_filled() {
        assert_eq!("{preset}_{map}.{ext}".parse(), Ok(NameTemplate::default()));
        let all = "{preset}-{seed}@{size} {map}.{ext}";
        assert_eq!(name(all, MapKind::AmbientOcclusion).unwrap(), "boa-7@32x64 ambient_occlusion.png");
        let normal = |f| NameTemplate::default().file_name(&set("boa"), Some((MapKind::Normal, f)), "png");
        assert_eq!(normal(Some(NormalFormat::Dx)).unwrap(), "boa_nor_dx.png");
        assert_eq!(normal(None).unwrap(), "boa_nor_gl.png");
        assert_eq!(NameTemplate::default().file_name(&set("boa"), None, "exr").unwrap(), "boa_maps.exr");
    }

    #[test]
    fn bad_templates_and_names_are_refused() {
        assert_eq!(name("{preset}_{mapp}.{ext}", MapKind::Color), Err(NameError::Unknown("mapp".into())));
        for bad in ["{preset", "preset}", "{{map}}", "{"] {
            let error = name(bad, MapKind::Color);
            assert!(matches!(error, Err(NameError::Brace(_) | NameError::Unknown(_))), "{bad} {error:?}");
        }
        for bad in ["../{map}", "a/{map}", "a\\{map}", "C:{map}", ".{map}", "{map}.", "", "{map}\n", "{map}?"]
        {
            assert!(matches!(name(bad, MapKind::Color), Err(NameError::Illegal(_))), "{bad}");
        }
        assert!(matches!(name("Manifest.json", MapKind::Color), Err(NameError::Reserved(_))));
        for bad in ["../boa", "a/b", "", &"x".repeat(300)] {
            let name = "{preset}".parse::<NameTemplate>().unwrap().file_name(&set(bad), None, "png");
            assert!(matches!(name, Err(NameError::Illegal(_))), "{bad}");
        }
    }
}
