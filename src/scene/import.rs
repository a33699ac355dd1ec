//! Meshes of one's own, from the bytes of an OBJ or GLB file.
//!
//! Only forms are read: positions, texture coordinates, normals. Files may be hostile: whatever they hold, the answer is a
//! valid mesh or an error.

use glam::{Mat4, Vec2, Vec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::{Accessor, Semantic};

use super::displace::smooth_normals;
use super::mesh::{Mesh, MeshError};
use super::tangents::{self, TangentError};

/// Bytes that a file may have.
pub const MOST_BYTES: usize = 1 << 30;
/// Triangles, and vertices, that a file may have, instances counted.
const MOST: usize = 20_000_000;

/// Why a file gives no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ImportError {
    /// Not such a file, or a damaged one.
    #[error("not a readable {format} file: {message}")]
    Format {
        /// What it should be.
        format: &'static str,
        /// What is wrong.
        message: String,
    },
    /// It is larger than a mesh may be.
    #[error("a mesh may have {MOST_BYTES} bytes and {MOST} triangles and vertices; this one has more")]
    TooLarge,
    /// No triangle in it.
    #[error("there is no triangle in the file")]
    Empty,
    /// Points and lines have no surface.
    #[error("mesh `{mesh}` is made of {what}; a skin wants triangles, so take them out and export again")]
    NoSurface {
        /// Which mesh.
        mesh: String,
        /// What it is made of.
        what: &'static str,
    },
    /// Without texture coordinates no skin can be laid on it.
    #[error(
        "mesh `{0}` has no texture coordinates; unwrap it in a modelling program (u once around the body, v along it) \
         and export it with UVs"
    )]
    NoTextureCoordinates(String),
    /// Its numbers or indices are wrong.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// No tangents can be made for it.
    #[error(transparent)]
    Tangents(#[from] TangentError),
}

/// Reads all objects of an OBJ file as one mesh; polygons become triangles, materials are ignored. v, which goes up in OBJ,
/// is turned over.
pub fn obj(bytes: &[u8]) -> Result<Mesh, ImportError> {
    let damaged = |message: String| ImportError::Format { format: "OBJ", message };
    if bytes.len() > MOST_BYTES {
        return Err(ImportError::TooLarge);
    }
    if let Some(line) = wild_index(bytes) {
        return Err(damaged(format!("an index in line {line} is out of range")));
    }
    let options =
        tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let (models, _) = tobj::load_obj_buf(&mut &*bytes, &options, |_| Err(tobj::LoadError::OpenFileFailed))
        .map_err(|error| damaged(error.to_string()))?;
    let mut parts = Parts::default();
    for model in models.into_iter().filter(|model| !model.mesh.indices.is_empty()) {
        let triple = |values: &[f32]| -> Vec<Vec3> {
            values.chunks_exact(3).map(|p| Vec3::new(p[0], p[1], p[2])).collect()
        };
        let part = Part {
            positions: triple(&model.mesh.positions),
            normals: triple(&model.mesh.normals),
            uvs: model.mesh.texcoords.chunks_exact(2).map(|t| Vec2::new(t[0], 1.0 - t[1])).collect(),
            triangles: model.mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
            name: model.name,
        };
        parts.add(part)?;
    }
    parts.finish()
}

/// The first line, from 1, with an index that the reader would compute with unchecked: none, 0, huge, or reaching back
/// before the first vertex.
fn wild_index(bytes: &[u8]) -> Option<usize> {
    let mut counts = [0i64; 3];
    for (number, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let mut words = line.split(|b| b.is_ascii_whitespace()).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => counts[0] += 1,
            Some(b"vt") => counts[1] += 1,
            Some(b"vn") => counts[2] += 1,
            Some(b"f" | b"l" | b"p") => {
                let wild = |(place, index): (usize, &[u8])| {
                    let known = counts.get(place).copied().unwrap_or(0);
                    let text = str::from_utf8(index).unwrap_or("");
                    let good = |i: i64| (1..1_000_000_000).contains(&i) || (-known..0).contains(&i);
                    !(place > 0 && index.is_empty() || text.parse().is_ok_and(good))
                };
                if words.any(|word| word.split(|&b| b == b'/').enumerate().any(wild)) {
                    return Some(number + 1);
                }
            }
            _ => {}
        }
    }
    None
}

/// Reads all triangles of the scene in a self-contained GLB file as one mesh, instances and transforms applied; materials,
/// skins and animations are ignored.
pub fn glb(bytes: &[u8]) -> Result<Mesh, ImportError> {
    let damaged = |message: &str| ImportError::Format { format: "GLB", message: message.to_owned() };
    if bytes.len() > MOST_BYTES {
        return Err(ImportError::TooLarge);
    }
    let stated = bytes.get(8..12).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes);
    if !bytes.starts_with(b"glTF") || (stated as usize) < 12 {
        return Err(damaged("no header of a binary glTF 2 file"));
    }
    let file = gltf::Gltf::from_slice(bytes).map_err(|error| damaged(&error.to_string()))?;
    let blob = file.blob.as_deref().unwrap_or(&[]);
    let scene = file.default_scene().or_else(|| file.scenes().next()).ok_or(ImportError::Empty)?;
    let mut parts = Parts::default();
    let mut waiting: Vec<_> = scene.nodes().map(|node| (node, Mat4::IDENTITY)).collect();
    let mut visits = file.nodes().len();
    while let Some((node, parent)) = waiting.pop() {
        // Each node has one parent: more visits than nodes are a circle.
        visits = visits.checked_sub(1).ok_or_else(|| damaged("its nodes are no tree"))?;
        let transform = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
        waiting.extend(node.children().map(|child| (child, transform)));
        let Some(mesh) = node.mesh() else { continue };
        for primitive in mesh.primitives() {
            let name = format!("#{}", mesh.index());
            let surface = match primitive.mode() {
                Mode::Triangles => Surface::Triangles,
                Mode::TriangleStrip => Surface::Strip,
                Mode::TriangleFan => Surface::Fan,
                Mode::Points => return Err(ImportError::NoSurface { mesh: name, what: "points" }),
                Mode::Lines | Mode::LineLoop | Mode::LineStrip => {
                    return Err(ImportError::NoSurface { mesh: name, what: "lines" });
                }
            };
            let read = |semantic: Semantic| -> Result<Option<Vec<Vec<f32>>>, ImportError> {
                primitive.get(&semantic).map(|accessor| numbers(&accessor, blob)).transpose()
            };
            let triple = |rows: Vec<Vec<f32>>| rows.iter().map(|p| Vec3::new(p[0], p[1], p[2])).collect();
            let wide = |rows: Option<Vec<Vec<f32>>>, width: usize| {
                let rows = rows.unwrap_or_default();
                let fits = rows.iter().all(|row| row.len() == width);
                if fits { Ok(rows) } else { Err(damaged("an attribute has the wrong type")) }
            };
            let positions: Vec<Vec3> = triple(wide(read(Semantic::Positions)?, 3)?);
            let indices: Vec<u32> = match primitive.indices() {
                Some(accessor) => integers(&accessor, blob)?,
                None => (0..positions.len() as u32).collect(),
            };
            let mut part = Part {
                name,
                normals: triple(wide(read(Semantic::Normals)?, 3)?),
                uvs: wide(read(Semantic::TexCoords(0))?, 2)?.iter().map(|t| Vec2::new(t[0], t[1])).collect(),
                triangles: surface.triangles(&indices),
                positions,
            };
            part.place(transform);
            parts.add(part)?;
        }
    }
    parts.finish()
}

/// How indices make triangles.
#[derive(Clone, Copy, Debug)]
enum Surface {
    Triangles,
    Strip,
    Fan,
}

impl Surface {
    /// Corners in the order of glTF 2.0, 3.7.2.1. Triangles of a strip that name a vertex twice only join its parts.
    fn triangles(self, indices: &[u32]) -> Vec<[u32; 3]> {
        let joins = |&[a, b, c]: &[u32; 3]| a == b || b == c || c == a;
        match self {
            Self::Triangles => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
            Self::Strip => {
                let turned = |(i, t): (usize, &[u32])| {
                    if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] }
                };
                indices.windows(3).enumerate().map(turned).filter(|t| !joins(t)).collect()
            }
            Self::Fan => match indices {
                [hub, rim @ ..] => rim.windows(2).map(|t| [t[0], t[1], *hub]).collect(),
                [] => Vec::new(),
            },
        }
    }
}

/// The bytes of each element of an accessor, checked to lie in the file.
fn elements<'a>(
    accessor: &Accessor,
    blob: &'a [u8],
) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>, ImportError> {
    let damaged = |message: &str| ImportError::Format { format: "GLB", message: message.to_owned() };
    let (count, size) = (accessor.count(), accessor.size());
    if count > MOST {
        return Err(ImportError::TooLarge);
    }
    if accessor.sparse().is_some() {
        return Err(damaged("sparse accessors are not read; export without them"));
    }
    let view = accessor.view().ok_or_else(|| damaged("an accessor has no data"))?;
    if !matches!(view.buffer().source(), gltf::buffer::Source::Bin) {
        return Err(damaged("its data is in another file; export as one self-contained GLB"));
    }
    let stride = view.stride().unwrap_or(size).max(1);
    let end = view.offset().checked_add(view.length()).filter(|&end| end <= blob.len());
    let data = end.map(|end| &blob[view.offset()..end]).and_then(|data| data.get(accessor.offset()..));
    let data = data.ok_or_else(|| damaged("a view reaches beyond the file"))?;
    let needed = count.checked_sub(1).map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size));
    if needed.is_none_or(|needed| needed > data.len()) {
        return Err(damaged("an accessor reaches beyond its view"));
    }
    Ok((0..count).map(move |i| &data[i * stride..i * stride + size]))
}

/// An accessor of vectors as floating-point numbers; normalised integers are shares of their range.
fn numbers(accessor: &Accessor, blob: &[u8]) -> Result<Vec<Vec<f32>>, ImportError> {
    let width = match accessor.dimensions() {
        Dimensions::Vec2 => 2,
        Dimensions::Vec3 => 3,
        _ => 1,
    };
    let kind = accessor.data_type();
    let step = kind.size();
    let number = move |b: &[u8]| match kind {
        DataType::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        DataType::U8 => f32::from(b[0]) / 255.0,
        DataType::U16 => f32::from(u16::from_le_bytes([b[0], b[1]])) / 65535.0,
        DataType::I8 => (f32::from(b[0] as i8) / 127.0).max(-1.0),
        DataType::I16 => (f32::from(i16::from_le_bytes([b[0], b[1]])) / 32767.0).max(-1.0),
        DataType::U32 => f32::NAN,
    };
    let rows = elements(accessor, blob)?;
    Ok(rows.map(|row| row.chunks_exact(step).take(width).map(number).collect()).collect())
}

/// An accessor of indices.
fn integers(accessor: &Accessor, blob: &[u8]) -> Result<Vec<u32>, ImportError> {
    let kind = accessor.data_type();
    let rows = elements(accessor, blob)?;
    let index = |b: &[u8]| match kind {
        DataType::U8 => Some(u32::from(b[0])),
        DataType::U16 => Some(u32::from(u16::from_le_bytes([b[0], b[1]]))),
        DataType::U32 => Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        _ => None,
    };
    let scalar = accessor.dimensions() == Dimensions::Scalar;
    let all: Option<Vec<u32>> = rows.map(|row| if scalar { index(row) } else { None }).collect();
    all.ok_or_else(|| ImportError::Format { format: "GLB", message: "indices are no whole numbers".into() })
}

/// One object of a file, as read.
struct Part {
    name: String,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<[u32; 3]>,
}

impl Part {
    /// Moves the part; a reflection turns the triangles' order over, so that outside stays outside.
    fn place(&mut self, transform: Mat4) {
        let [x, y, z] = [transform.x_axis, transform.y_axis, transform.z_axis].map(|axis| axis.truncate());
        let mirrored = x.cross(y).dot(z) < 0.0;
        let sign = if mirrored { -1.0 } else { 1.0 };
        for p in &mut self.positions {
            *p = transform.transform_point3(*p);
        }
        // The cofactors: the inverse transpose but for length.
        for n in &mut self.normals {
            *n = (y.cross(z) * n.x + z.cross(x) * n.y + x.cross(y) * n.z) * sign;
        }
        if mirrored {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
    }
}

/// All objects so far.
#[derive(Default)]
struct Parts {
    mesh: Mesh,
}

impl Parts {
    fn add(&mut self, mut part: Part) -> Result<(), ImportError> {
        let (vertices, first) = (part.positions.len(), self.mesh.positions.len());
        if first + vertices > MOST || self.mesh.triangles.len() + part.triangles.len() > MOST {
            return Err(ImportError::TooLarge);
        }
        if part.uvs.is_empty() {
            return Err(ImportError::NoTextureCoordinates(part.name));
        }
        for (triangle, corners) in part.triangles.iter_mut().enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= vertices) {
                return Err(MeshError::Index { triangle, vertex, vertices }.into());
            }
        }
        if let Some(vertex) =
            part.positions.iter().position(|p| !p.is_finite() || p.abs().max_element() >= 1e12)
        {
            return Err(MeshError::NotFinite(first + vertex).into());
        }
        let usable = part.normals.len() == vertices
            && part.normals.iter().all(|n| n.is_finite() && n.try_normalize().is_some());
        if usable {
            part.normals.iter_mut().for_each(|n| *n = n.normalize());
        } else {
            let mut places = std::collections::BTreeMap::new();
            let own: Vec<usize> = (0..vertices)
                .map(|i| *places.entry((part.positions[i] + 0.0).to_array().map(f32::to_bits)).or_insert(i))
                .collect();
            part.normals = smooth_normals(&part.positions, &part.triangles, &own, None);
        }
        self.mesh.positions.append(&mut part.positions);
        self.mesh.normals.append(&mut part.normals);
        self.mesh.uvs.append(&mut part.uvs);
        self.mesh.triangles.extend(part.triangles.into_iter().map(|t| t.map(|i| i + first as u32)));
        self.mesh.check_shape()?;
        Ok(())
    }

    fn finish(self) -> Result<Mesh, ImportError> {
        if self.mesh.triangles.is_empty() {
            return Err(ImportError::Empty);
        }
        Ok(tangents::generate(&self.mesh)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n";

    #[test]
    fn a_quad_in_obj_becomes_two_triangles_with_v_turned_over() {
        let mesh = obj(format!("{QUAD}f 1/1 2/2 3/3 4/4\n").as_bytes()).unwrap();
        mesh.check().unwrap();
        assert_eq!((mesh.triangles.len(), mesh.positions.len()), (2, 4));
        assert!((mesh.area() - 1.0).abs() < 1e-6);
        for ((p, n), (uv, t)) in
            mesh.positions.iter().zip(&mesh.normals).zip(mesh.uvs.iter().zip(&mesh.tangents))
        {
            assert_eq!((uv.x, uv.y), (p.x, 1.0 - p.y));
            assert!((*n - Vec3::Z).length() < 1e-6);
            // The bitangent is up the picture: +y.
            assert!((t.truncate() - Vec3::X).length() < 1e-5 && t.w == 1.0);
        }
        let relative = obj(format!("{QUAD}f -4/-4 -3/-3 -2/-2 -1/-1\n").as_bytes()).unwrap();
        assert_eq!(relative, mesh);
    }

    #[test]
    fn a_damaged_obj_is_an_error() {
        let error = |faces: &str| obj(format!("{QUAD}{faces}\n").as_bytes()).unwrap_err();
        for faces in [
            "f 1/1 2/2 9/3",
            "f 1/1 2/2 3/9",
            "f 0/1 2/2 3/3",
            "f /1 2/2 3/3",
            "f -5/1 2/2 3/3",
            "f 9223372036854775807/1 2/2 3/3",
            "f 1/1 2/2 x",
            "f 1/1/1/1 2/2 3/3",
        ] {
            assert!(matches!(error(faces), ImportError::Format { .. }), "{faces}: {:?}", error(faces));
        }
        assert_eq!(error(""), ImportError::Empty);
        assert_eq!(error("f 1/1 2/2"), ImportError::Empty);
        assert!(matches!(obj(b"\xff\xfe\nv"), Err(ImportError::Format { .. })));
        let bare = obj(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap_err();
        assert!(matches!(bare, ImportError::NoTextureCoordinates(_)));
        let nan = b"v nan 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
        assert!(matches!(obj(nan), Err(ImportError::Mesh(MeshError::NotFinite(_)))));
    }

    /// A GLB with one triangle; `edit` changes its JSON.
    fn triangle(edit: impl Fn(String) -> String) -> Vec<u8> {
        let floats = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
        let mut bin: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
        bin.extend([0u16, 1, 2, 0].iter().flat_map(|i| i.to_le_bytes()));
        let json = r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
            "nodes":[{"mesh":0,"scale":[-2,2,2]}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2}]}],
            "buffers":[{"byteLength":68}],
            "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},
                {"buffer":0,"byteOffset":60,"byteLength":6}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
                {"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},
                {"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}]}"#;
        let mut json = edit(json.to_owned()).into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let total = 28 + json.len() + bin.len();
        let mut out = b"glTF".to_vec();
        out.extend([2, total as u32, json.len() as u32].iter().flat_map(|x| x.to_le_bytes()));
        out.extend(b"JSON");
        out.extend(json);
        out.extend((bin.len() as u32).to_le_bytes());
        out.extend(b"BIN\0");
        out.extend(bin);
        out
    }

    #[test]
    fn a_mirrored_triangle_in_glb_keeps_its_outside() {
        let mesh = glb(&triangle(|json| json)).unwrap();
        mesh.check().unwrap();
        assert!((mesh.area() - 2.0).abs() < 1e-6);
        assert!(mesh.normals.iter().all(|n| (*n - Vec3::Z).length() < 1e-6));
        assert!(mesh.positions.iter().all(|p| p.x <= 0.0));
        // v is down in glTF as it is here.
        assert!(mesh.positions.iter().zip(&mesh.uvs).all(|(p, uv)| uv.y * 2.0 == p.y && uv.x * -2.0 == p.x));
    }

    #[test]
    fn strips_and_fans_become_triangles_and_points_and_lines_are_named() {
        let strip = |indices: &[u32]| Surface::Strip.triangles(indices);
        assert_eq!(strip(&[0, 1, 2, 3, 4]), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        // Two strips in one, joined by triangles without area.
        assert_eq!(strip(&[0, 1, 2, 3, 3, 5, 5, 6, 7]), [[0, 1, 2], [1, 3, 2], [5, 6, 7]]);
        assert_eq!(Surface::Fan.triangles(&[0, 1, 2, 3]), [[1, 2, 0], [2, 3, 0]]);
        for surface in [Surface::Triangles, Surface::Strip, Surface::Fan] {
            assert!((0..3).all(|n| surface.triangles(&[0, 1][..n]).is_empty()));
        }

        // Of one triangle all forms are the same mesh.
        let of = |mode: u32| {
            glb(&triangle(|json| json.replace("\"indices\":2", &format!("\"indices\":2,\"mode\":{mode}"))))
        };
        let plain = of(4).unwrap();
        assert_eq!(of(5).unwrap().area(), plain.area());
        assert_eq!(of(5).unwrap().normals, plain.normals);
        assert_eq!(of(6).unwrap().normals, plain.normals);
        for (mode, what) in [(0, "points"), (1, "lines"), (2, "lines"), (3, "lines")] {
            assert_eq!(of(mode), Err(ImportError::NoSurface { mesh: "#0".into(), what }));
        }
    }

    #[test]
    fn a_damaged_glb_is_an_error() {
        let edits = [
            ("\"count\":3,\"type\":\"VEC2\"", "\"count\":4,\"type\":\"VEC2\""),
            ("\"count\":3,\"type\":\"VEC2\"", "\"count\":2,\"type\":\"VEC2\""),
            ("\"count\":3,\"type\":\"VEC2\"", "\"count\":18446744073709551615,\"type\":\"VEC2\""),
            ("\"count\":3,\"type\":\"VEC2\"", "\"count\":3,\"type\":\"VEC3\""),
            ("\"byteOffset\":36", "\"byteOffset\":18446744073709551610"),
            ("\"mesh\":0", "\"mesh\":0,\"children\":[0]"),
            ("\"mesh\":0", "\"mesh\":7"),
            ("\"scale\":[-2,2,2]", "\"scale\":[1e38,1e38,1e38]"),
            (",\"TEXCOORD_0\":1", ""),
            ("\"byteOffset\":60", "\"byteOffset\":20"),
            ("\"byteLength\":68}", "\"byteLength\":68,\"uri\":\"other.bin\"}"),
        ];
        for (from, to) in edits {
            let bytes = triangle(|json| {
                assert!(json.contains(from));
                json.replace(from, to)
            });
            assert!(glb(&bytes).is_err(), "{to}");
        }
        let whole = triangle(|json| json);
        assert!((0..whole.len()).all(|length| glb(&whole[..length]).is_err()));
        assert!(glb(b"glTF\x02\0\0\0\0\0\0\0").is_err());
    }
}
