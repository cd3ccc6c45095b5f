//! glTF 2.0 and GLB: the triangles of the scene's nodes where they stand, base colours, pictures, vertex colours.
//!
//! Our own reader over `serde_json` rather than the crate `gltf`: that one panics on accessors that lie about their
//! buffers, and refuses quantised meshes.

use std::path::{Path, PathBuf};

use base64::Engine;
use glam::{DAffine2, DAffine3, DMat2, DMat3, DMat4, DQuat, DVec2, DVec3};
use serde::Deserialize;
use serde_json::Value;

use super::Problem;
use super::faces::{Faces, VertexPaint};
use super::material::{self, Material, Picture, PicturePlace};
use super::read::{About, Conventions, Imported, Located, Place, Remark, shown};
use super::texture::{Texture, Wrap};
use crate::disk;

/// Values that an accessor without a buffer may announce, all of which are 0.
const MOST_ZEROS: usize = 1 << 22;
/// Extensions that files may require, and that change nothing of what is read or are read.
const KNOWN: [&str; 5] = [
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_lights_punctual",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_xmp_json_ld",
];

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct Root {
    scene: Option<usize>,
    scenes: Vec<Scene>,
    nodes: Vec<Node>,
    meshes: Vec<Mesh>,
    accessors: Vec<Accessor>,
    buffer_views: Vec<View>,
    buffers: Vec<Buffer>,
    materials: Vec<MaterialEntry>,
    textures: Vec<TextureEntry>,
    images: Vec<ImageEntry>,
    samplers: Vec<Sampler>,
    extensions_required: Vec<String>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Scene {
    nodes: Vec<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Node {
    children: Vec<usize>,
    mesh: Option<usize>,
    skin: Option<usize>,
    matrix: Option<[f64; 16]>,
    translation: [f64; 3],
    rotation: Option<[f64; 4]>,
    scale: Option<[f64; 3]>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Mesh {
    primitives: Vec<Primitive>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Primitive {
    attributes: std::collections::BTreeMap<String, usize>,
    indices: Option<usize>,
    material: Option<usize>,
    mode: Option<u32>,
    targets: Vec<Value>,
    extensions: Value,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct Accessor {
    buffer_view: Option<usize>,
    byte_offset: usize,
    component_type: u32,
    normalized: bool,
    count: usize,
    #[serde(rename = "type")]
    kind: String,
    sparse: Option<Sparse>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Sparse {
    count: usize,
    indices: SparsePart,
    values: SparsePart,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct SparsePart {
    buffer_view: usize,
    byte_offset: usize,
    component_type: u32,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct View {
    buffer: usize,
    byte_offset: usize,
    byte_length: usize,
    byte_stride: usize,
    extensions: Value,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct Buffer {
    uri: Option<String>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct MaterialEntry {
    pbr_metallic_roughness: Rough,
    extensions: Value,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct Rough {
    base_color_factor: Option<[f64; 4]>,
    base_color_texture: Option<TextureUse>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct Glossy {
    diffuse_factor: Option<[f64; 4]>,
    diffuse_texture: Option<TextureUse>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct TextureUse {
    index: usize,
    tex_coord: usize,
    extensions: Value,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct TextureTransform {
    offset: [f64; 2],
    rotation: f64,
    scale: Option<[f64; 2]>,
    tex_coord: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct TextureEntry {
    source: Option<usize>,
    sampler: Option<usize>,
    extensions: Value,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct ImageEntry {
    uri: Option<String>,
    buffer_view: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(rename_all = "camelCase", default)]
struct Sampler {
    wrap_s: u32,
    wrap_t: u32,
}

/// Reads the content of a glTF or GLB file. Other files that it names are sought from `folder`.
pub(super) fn parse(content: &[u8], conventions: &Conventions, folder: Option<&Path>) -> Result<Imported, Located> {
    let (root, chunk) = split(content)?;
    if let Some(name) = root.extensions_required.iter().find(|name| !is_known(name)) {
        return Err(unread_extension(name).into());
    }
    let buffers = root.buffers.iter().enumerate();
    let buffers = buffers.map(|(i, buffer)| bytes_of(buffer, i, chunk, folder)).collect::<Result<Vec<_>, _>>()?;
    let file = File { root, buffers, folder };
    let mut remarks = Vec::new();
    let mut painted = Painted::new(&file, &mut remarks);
    let mut collected = Collected::default();
    for (node, map) in file.placed_meshes()? {
        let Some(mesh) = node.mesh.and_then(|mesh| file.root.meshes.get(mesh)) else { continue };
        if node.skin.is_some() {
            collected.skinned += 1;
        }
        for primitive in &mesh.primitives {
            file.add(primitive, &map, &mut painted, &mut collected)?;
        }
    }
    remarks.extend(collected.remarks());
    let Collected { faces, positions, colours, places, .. } = collected;
    let has_paint = !file.root.materials.is_empty();
    let has_colours = colours.iter().any(|colour| *colour != [1.0; 3]);
    let paint = VertexPaint { colours: has_colours.then_some(colours), places: has_paint.then_some(places) };
    let mesh = faces.mesh(positions, paint, conventions, &mut remarks)?;
    let materials = if has_paint { painted.materials } else { Vec::new() };
    Ok(Imported { mesh, materials, remarks })
}

/// The files that one names, of those that are there.
pub(super) fn files(content: &[u8], folder: &Path) -> Vec<PathBuf> {
    let Ok((root, _)) = split(content) else { return Vec::new() };
    let buffers = root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
    let names = buffers.chain(root.images.iter().filter_map(|image| image.uri.as_deref()));
    names.filter(|uri| !uri.starts_with("data:")).filter_map(|uri| material::find(&decoded(uri), folder)).collect()
}

fn is_known(name: &str) -> bool {
    KNOWN.contains(&name) || name.starts_with("KHR_materials_")
}

fn unread_extension(name: &str) -> Problem {
    let what = match name {
        "KHR_draco_mesh_compression" => "is compressed by Draco",
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => "is compressed by meshopt",
        "EXT_texture_webp" => "has WebP pictures",
        "KHR_texture_basisu" => "has Basis pictures",
        "EXT_mesh_gpu_instancing" => "has instances",
        _ => "needs an extension",
    };
    Problem::malformed(format!("{what} (`{}`), which is not read; export it without", shown(name)))
}

/// The document, and of a GLB the bytes that go with it.
fn split(content: &[u8]) -> Result<(Root, Option<&[u8]>), Problem> {
    let broken = |error: serde_json::Error| {
        let mut text = error.to_string();
        text.truncate(text.char_indices().nth(160).map_or(text.len(), |(at, _)| at));
        Problem::malformed(format!("is no glTF document: {}", text.escape_debug()))
    };
    let Some(rest) = content.strip_prefix(b"glTF") else {
        let content = super::read::without_mark(content)?;
        return Ok((serde_json::from_slice(content).map_err(broken)?, None));
    };
    let word = |at: usize| {
        let four = rest.get(at..at + 4).ok_or_else(|| Problem::CutShort("ends in its head".into()))?;
        Ok::<usize, Problem>(u32::from_le_bytes([four[0], four[1], four[2], four[3]]) as usize)
    };
    if word(0)? != 2 {
        return Err(Problem::malformed(format!("is GLB of version {}, and version 2 is read", word(0)?)));
    }
    if word(4)? > content.len() {
        return Err(Problem::CutShort(format!("announces {} bytes and has {}", word(4)?, content.len())));
    }
    let (mut at, mut document, mut chunk) = (8, None, None);
    while at + 8 <= rest.len() && (document.is_none() || chunk.is_none()) {
        let (length, kind) = (word(at)?, word(at + 4)?);
        let bytes = rest.get(at + 8..at + 8 + length);
        let bytes = bytes.ok_or_else(|| Problem::CutShort("ends in the middle of a chunk".into()))?;
        match kind {
            0x4E4F_534A if document.is_none() => document = Some(bytes),
            0x004E_4942 if chunk.is_none() => chunk = Some(bytes),
            _ => {}
        }
        at += 8 + length;
    }
    let document = document.ok_or_else(|| Problem::malformed("is GLB without a document"))?;
    Ok((serde_json::from_slice(document).map_err(broken)?, chunk))
}

fn bytes_of(buffer: &Buffer, number: usize, chunk: Option<&[u8]>, folder: Option<&Path>) -> Result<Vec<u8>, Problem> {
    match &buffer.uri {
        None if number == 0 => Ok(chunk.unwrap_or_default().to_vec()),
        None => Ok(Vec::new()),
        Some(uri) => fetched(uri, folder).map_err(|problem| Problem::malformed(format!("its data: {problem}"))),
    }
}

/// The bytes of an address: written out in it, or of a file.
fn fetched(uri: &str, folder: Option<&Path>) -> Result<Vec<u8>, String> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, text) = data.split_once(";base64,").ok_or("it is written in another way than base64")?;
        let engine = base64::engine::general_purpose::STANDARD;
        return engine.decode(text).map_err(|error| error.to_string());
    }
    let name = decoded(uri);
    let missing = || format!("'{}' is not there", shown(&name));
    let path = folder.and_then(|folder| material::find(&name, folder)).ok_or_else(missing)?;
    disk::read(&path).map_err(|error| format!("'{}': {error}", shown(&name)))
}

/// An address with its escapes (`%20`) resolved.
fn decoded(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let mut out = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let digits = bytes.get(at + 1..at + 3).and_then(|digits| std::str::from_utf8(digits).ok());
        let escaped = digits.filter(|_| bytes[at] == b'%').and_then(|digits| u8::from_str_radix(digits, 16).ok());
        out.push(escaped.unwrap_or(bytes[at]));
        at += if escaped.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&out).into_owned()
}

struct File<'f> {
    root: Root,
    buffers: Vec<Vec<u8>>,
    folder: Option<&'f Path>,
}

/// What was collected from all primitives.
struct Collected {
    faces: Faces,
    positions: Vec<DVec3>,
    colours: Vec<[f32; 3]>,
    places: Vec<PicturePlace>,
    skinned: usize,
    morphed: usize,
    /// Lines and points.
    others: usize,
}

impl Default for Collected {
    fn default() -> Self {
        Self {
            faces: Faces::new(0),
            positions: Vec::new(),
            colours: Vec::new(),
            places: Vec::new(),
            skinned: 0,
            morphed: 0,
            others: 0,
        }
    }
}

impl Collected {
    fn remarks(&self) -> Vec<Remark> {
        let told = |count: usize, text: &str, help: &str| {
            let (text, help) = (text.to_owned(), help.to_owned());
            (count > 0).then_some(Remark { about: About::Faces, place: None, text, help })
        };
        let rest = "it is read in its rest pose";
        [
            told(self.skinned, &format!("the mesh is bound to bones: {rest}"), "apply the pose and export it again"),
            told(self.morphed, &format!("the mesh has morph targets: {rest}"), "apply them and export it again"),
            told(self.others, "lines and points are left out", "only triangles make a surface"),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

impl File<'_> {
    /// The nodes of the scene that is shown, each with its map to the world. Of a file without scenes all are.
    fn placed_meshes(&self) -> Result<Vec<(&Node, DAffine3)>, Problem> {
        let nodes = &self.root.nodes;
        let scene = self.root.scene.unwrap_or(0);
        let tops: Vec<usize> = match self.root.scenes.get(scene) {
            Some(scene) => scene.nodes.clone(),
            None => {
                let mut is_child = vec![false; nodes.len()];
                let children = nodes.iter().flat_map(|node| &node.children);
                children.filter(|child| **child < nodes.len()).for_each(|child| is_child[*child] = true);
                (0..nodes.len()).filter(|node| !is_child[*node]).collect()
            }
        };
        let mut open: Vec<(usize, DAffine3)> = tops.into_iter().rev().map(|top| (top, DAffine3::IDENTITY)).collect();
        let mut seen = vec![false; nodes.len()];
        let mut found = Vec::new();
        while let Some((number, outer)) = open.pop() {
            let node = nodes.get(number).ok_or_else(|| missing("node", number))?;
            if std::mem::replace(&mut seen[number], true) {
                return Err(Problem::malformed(format!(
                    "node {number} stands in two places of the tree, or in itself"
                )));
            }
            let map = outer * node.map();
            open.extend(node.children.iter().rev().map(|child| (*child, map)));
            found.push((node, map));
        }
        Ok(found)
    }

    fn add(
        &self,
        primitive: &Primitive,
        map: &DAffine3,
        painted: &mut Painted,
        out: &mut Collected,
    ) -> Result<(), Located> {
        let mode = primitive.mode.unwrap_or(4);
        if !(4..=6).contains(&mode) {
            out.others += 1;
            return Ok(());
        }
        if primitive.extensions.get("KHR_draco_mesh_compression").is_some() {
            return Err(unread_extension("KHR_draco_mesh_compression").into());
        }
        if !primitive.targets.is_empty() {
            out.morphed += 1;
        }
        let Some(&of_positions) = primitive.attributes.get("POSITION") else { return Ok(()) };
        let positions = self.numbers::<3>(of_positions)?;
        let count = positions.len();
        let attribute = |name: &str| primitive.attributes.get(name).copied();
        let alike = |name: &str, found: usize| match found == count {
            true => Ok(()),
            false => Err(Problem::malformed(format!("a mesh has {count} positions and {found} of `{name}`"))),
        };
        let mut colours = vec![[1.0; 3]; count];
        if let Some(accessor) = attribute("COLOR_0") {
            let kind = self.root.accessors.get(accessor).map_or("", |accessor| &accessor.kind);
            let all: Vec<[f64; 3]> = match kind {
                "VEC4" => self.numbers::<4>(accessor)?.into_iter().map(|[r, g, b, _]| [r, g, b]).collect(),
                _ => self.numbers::<3>(accessor)?,
            };
            alike("COLOR_0", all.len())?;
            for (to, from) in colours.iter_mut().zip(all) {
                // Scene-linear by the format; what is negative or no number is none.
                *to = from.map(|part| if part.is_finite() { part.max(0.0) as f32 } else { 0.0 });
            }
        }
        let number = painted.number_of(primitive.material)?;
        let material = u32::try_from(number).unwrap_or(u32::MAX);
        let (set, turn) = painted.uses[number];
        let mut places = vec![PicturePlace { place: [0.0; 2], material }; count];
        let name = format!("TEXCOORD_{set}");
        if let Some(accessor) = attribute(&name).filter(|_| painted.materials[number].picture.is_some()) {
            let all = self.numbers::<2>(accessor)?;
            alike(&name, all.len())?;
            for (to, from) in places.iter_mut().zip(all) {
                let place = turn.transform_point2(DVec2::from(from)).as_vec2();
                to.place = if place.is_finite() { place.to_array() } else { [0.0; 2] };
            }
        }
        let indices: Vec<u32> = match primitive.indices {
            Some(accessor) => self.indices(accessor)?,
            None => (0..u32::try_from(count).unwrap_or(u32::MAX)).collect(),
        };
        let first = u32::try_from(out.positions.len()).map_err(|_| Problem::TooLarge)?;
        let turned = map.matrix3.determinant() < 0.0;
        let mut push = |[a, b, c]: [u32; 3]| -> Result<(), Problem> {
            let number = |corner: u32| match (corner as usize) < count {
                true => first.checked_add(corner).ok_or(Problem::TooLarge),
                false => Err(Problem::IndexOutOfRange { index: i64::from(corner), vertices: count, first: 0 }),
            };
            let corners = [number(a)?, number(b)?, number(c)?];
            let corners = if turned { [corners[0], corners[2], corners[1]] } else { corners };
            out.faces.push(corners, Place::Face(out.faces.len()));
            Ok(())
        };
        match mode {
            4 => indices.as_chunks::<3>().0.iter().try_for_each(|corners| push(*corners))?,
            5 => indices.windows(3).enumerate().try_for_each(|(i, corners)| {
                push(if i % 2 == 0 {
                    [corners[0], corners[1], corners[2]]
                } else {
                    [corners[1], corners[0], corners[2]]
                })
            })?,
            _ => indices.windows(2).skip(1).try_for_each(|corners| push([indices[0], corners[0], corners[1]]))?,
        }
        out.positions.extend(positions.into_iter().map(|position| map.transform_point3(DVec3::from(position))));
        out.colours.extend(colours);
        out.places.extend(places);
        Ok(())
    }

    /// The values of an accessor of `N` numbers each.
    fn numbers<const N: usize>(&self, accessor: usize) -> Result<Vec<[f64; N]>, Problem> {
        let found = self.root.accessors.get(accessor).ok_or_else(|| missing("accessor", accessor))?;
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        if found.kind != kind {
            return Err(Problem::malformed(format!("accessor {accessor} is `{}`, not {kind}", shown(&found.kind))));
        }
        let size = size_of(found.component_type)?;
        let number = |bytes: &[u8]| component(bytes, found.component_type, found.normalized);
        let mut values = match found.buffer_view {
            Some(view) => {
                let items = self.items(view, found.byte_offset, found.count, N * size)?;
                items.map(|item| std::array::from_fn(|i| number(&item[i * size..]))).collect()
            }
            None if found.count <= MOST_ZEROS => vec![[0.0; N]; found.count],
            None => return Err(Problem::malformed(format!("accessor {accessor} announces {} zeros", found.count))),
        };
        if let Some(Sparse { count, indices, values: changed }) = &found.sparse {
            let wide = size_of(indices.component_type)?;
            let places = self.items(indices.buffer_view, indices.byte_offset, *count, wide)?;
            let changes = self.items(changed.buffer_view, changed.byte_offset, *count, N * size)?;
            for (place, item) in places.zip(changes) {
                let at = component(place, indices.component_type, false) as usize;
                let value = values.get_mut(at).ok_or_else(|| missing("value", at))?;
                *value = std::array::from_fn(|i| number(&item[i * size..]));
            }
        }
        Ok(values)
    }

    fn indices(&self, accessor: usize) -> Result<Vec<u32>, Problem> {
        let kind = self.root.accessors.get(accessor).map_or(0, |accessor| accessor.component_type);
        if ![5121, 5123, 5125].contains(&kind) {
            return Err(Problem::malformed(format!("accessor {accessor} has indices that are no whole numbers")));
        }
        Ok(self.numbers::<1>(accessor)?.into_iter().map(|[number]| number as u32).collect())
    }

    /// So many items of a view, of some bytes each.
    fn items(
        &self,
        view: usize,
        offset: usize,
        count: usize,
        size: usize,
    ) -> Result<impl Iterator<Item = &[u8]>, Problem> {
        let bytes = self.view(view)?;
        let stride = match self.root.buffer_views[view].byte_stride {
            0 => size,
            stride => stride,
        };
        let end = count
            .checked_sub(1)
            .map(|last| last.checked_mul(stride).and_then(|last| last.checked_add(offset)?.checked_add(size)));
        let short = || Problem::CutShort(format!("view {view} is shorter than what is read from it"));
        match end {
            Some(end) if end.is_none_or(|end| end > bytes.len()) => Err(short()),
            _ => Ok((0..count).map(move |i| &bytes[offset + i * stride..offset + i * stride + size])),
        }
    }

    fn view(&self, number: usize) -> Result<&[u8], Problem> {
        let view = self.root.buffer_views.get(number).ok_or_else(|| missing("view", number))?;
        if view.extensions.get("EXT_meshopt_compression").is_some() {
            return Err(unread_extension("EXT_meshopt_compression"));
        }
        let buffer = self.buffers.get(view.buffer).ok_or_else(|| missing("buffer", view.buffer))?;
        let end = view.byte_offset.checked_add(view.byte_length);
        let bytes = end.and_then(|end| buffer.get(view.byte_offset..end));
        bytes.ok_or_else(|| Problem::CutShort(format!("view {number} reaches beyond its buffer")))
    }
}

impl Node {
    fn map(&self) -> DAffine3 {
        match &self.matrix {
            Some(matrix) => DAffine3::from_mat4(DMat4::from_cols_array(matrix)),
            None => {
                let [x, y, z, w] = self.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
                let turn = DQuat::from_xyzw(x, y, z, w);
                let turn = if turn.length() > 0.0 { turn.normalize() } else { DQuat::IDENTITY };
                let matrix = DMat3::from_quat(turn) * DMat3::from_diagonal(self.scale.unwrap_or([1.0; 3]).into());
                DAffine3::from_mat3_translation(matrix, self.translation.into())
            }
        }
    }
}

/// The materials that faces name, and last the one of those that name none.
struct Painted {
    materials: Vec<Material>,
    /// Of each, the set of places in its picture, and how these are moved.
    uses: Vec<(usize, DAffine2)>,
}

impl Painted {
    fn new(file: &File<'_>, remarks: &mut Vec<Remark>) -> Self {
        let mut painted = Self { materials: Vec::new(), uses: Vec::new() };
        let mut decoded: Vec<Option<Result<std::sync::Arc<Texture>, String>>> = vec![None; file.root.images.len()];
        for entry in &file.root.materials {
            let glossy = entry.extensions.get("KHR_materials_pbrSpecularGlossiness");
            let glossy = glossy.map(|value| Glossy::deserialize(value).unwrap_or_default());
            let rough = &entry.pbr_metallic_roughness;
            let (factor, texture) = match &glossy {
                Some(glossy) => (glossy.diffuse_factor, glossy.diffuse_texture.as_ref()),
                None => (rough.base_color_factor, rough.base_color_texture.as_ref()),
            };
            let [r, g, b, _] =
                factor.unwrap_or([1.0; 4]).map(|part| if part.is_finite() { part.max(0.0) } else { 1.0 });
            let mut made = Material { factor: [r as f32, g as f32, b as f32], ..Material::default() };
            let mut of_use = (0, DAffine2::IDENTITY);
            if let Some(texture) = texture {
                of_use = texture.places();
                match file.picture(texture.index, &mut decoded) {
                    Ok((picture, wrap)) => (made.picture, made.wrap) = (Some(Picture::Single(picture)), wrap),
                    Err(problem) => {
                        let text = format!("a picture is not read: {problem}");
                        let help =
                            "export its pictures as PNG or JPEG; its material's plain colour stands for it".into();
                        remarks.push(Remark { about: About::Colours, place: None, text, help });
                    }
                }
            }
            painted.materials.push(made);
            painted.uses.push(of_use);
        }
        painted.materials.push(Material { factor: [1.0; 3], ..Material::default() });
        painted.uses.push((0, DAffine2::IDENTITY));
        painted
    }

    /// The number of a face's material.
    fn number_of(&self, material: Option<usize>) -> Result<usize, Problem> {
        let none = self.materials.len() - 1;
        match material {
            None => Ok(none),
            Some(number) if number < none => Ok(number),
            Some(number) => Err(missing("material", number)),
        }
    }
}

impl TextureUse {
    /// The set of places, and how they are moved (KHR_texture_transform).
    fn places(&self) -> (usize, DAffine2) {
        let Some(value) = self.extensions.get("KHR_texture_transform") else {
            return (self.tex_coord, DAffine2::IDENTITY);
        };
        let transform = TextureTransform::deserialize(value).unwrap_or_default();
        let (sin, cos) = transform.rotation.sin_cos();
        // Counter-clockwise in places that go down.
        let turn = DMat2::from_cols(DVec2::new(cos, -sin), DVec2::new(sin, cos));
        let matrix = turn * DMat2::from_diagonal(transform.scale.unwrap_or([1.0; 2]).into());
        let map = DAffine2::from_mat2_translation(matrix, transform.offset.into());
        (transform.tex_coord.unwrap_or(self.tex_coord), map)
    }
}

type Decoded = Option<Result<std::sync::Arc<Texture>, String>>;

impl File<'_> {
    fn picture(&self, texture: usize, decoded: &mut [Decoded]) -> Result<(std::sync::Arc<Texture>, [Wrap; 2]), String> {
        let entry = self.root.textures.get(texture).ok_or("it is not in the file")?;
        let Some(source) = entry.source else {
            let extension = entry.extensions.as_object().and_then(|all| all.keys().next());
            return Err(
                extension.map_or_else(|| "it has no source".into(), |name| format!("it needs `{}`", shown(name)))
            );
        };
        let known = decoded.get_mut(source).ok_or("its image is not in the file")?;
        let picture = known.get_or_insert_with(|| {
            let image = &self.root.images[source];
            let texture = match (&image.uri, image.buffer_view) {
                (Some(uri), _) => Texture::decode(&fetched(uri, self.folder)?)?,
                (None, Some(view)) => Texture::decode(self.view(view).map_err(|problem| problem.to_string())?)?,
                (None, None) => return Err("it is empty".into()),
            };
            Ok(std::sync::Arc::new(texture))
        });
        let wrap = |kind: u32| match kind {
            33071 => Wrap::Clamp,
            33648 => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        let sampler = entry.sampler.and_then(|sampler| self.root.samplers.get(sampler));
        let wraps = sampler.map_or([Wrap::Repeat; 2], |sampler| [wrap(sampler.wrap_s), wrap(sampler.wrap_t)]);
        Ok((picture.clone()?, wraps))
    }
}

fn missing(what: &str, number: usize) -> Problem {
    Problem::malformed(format!("names {what} {number}, which is not there"))
}

/// Bytes of a component.
fn size_of(kind: u32) -> Result<usize, Problem> {
    match kind {
        5120 | 5121 => Ok(1),
        5122 | 5123 => Ok(2),
        5125 | 5126 => Ok(4),
        _ => Err(Problem::malformed(format!("has numbers of kind {kind}, which there is not"))),
    }
}

/// A number of `bytes`, which are enough of them.
fn component(bytes: &[u8], kind: u32, normalized: bool) -> f64 {
    let share = |value: f64, most: f64| if normalized { (value / most).max(-1.0) } else { value };
    match kind {
        5120 => share(f64::from(bytes[0] as i8), 127.0),
        5121 => share(f64::from(bytes[0]), 255.0),
        5122 => share(f64::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
        5123 => share(f64::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
        5125 => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        _ => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::super::shapes::cube;
    use super::super::{Lookup, TriangleMesh};
    use super::*;

    /// Bytes of a cube with edges of 2: positions, then indices.
    fn bytes() -> (Vec<u8>, usize, usize) {
        let mesh = cube(1.0, 1);
        let positions = mesh.positions().iter().flat_map(|p| p.as_vec3().to_array()).flat_map(f32::to_le_bytes);
        let mut bytes: Vec<u8> = positions.collect();
        let indices = mesh.triangles().iter().flatten().flat_map(|v| (*v as u16).to_le_bytes());
        bytes.extend(indices);
        (bytes, mesh.positions().len(), 3 * mesh.triangles().len())
    }

    fn address(bytes: &[u8]) -> String {
        format!("data:application/octet-stream;base64,{}", base64::engine::general_purpose::STANDARD.encode(bytes))
    }

    /// A file with the cube under one node, `change`d.
    fn document(change: impl FnOnce(&mut Value)) -> Value {
        let (bytes, vertices, indices) = bytes();
        let mut document = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3" },
                { "bufferView": 1, "componentType": 5123, "count": indices, "type": "SCALAR" },
            ],
            "bufferViews": [
                { "buffer": 0, "byteOffset": 0, "byteLength": 12 * vertices },
                { "buffer": 0, "byteOffset": 12 * vertices, "byteLength": 2 * indices },
            ],
            "buffers": [{ "byteLength": bytes.len(), "uri": address(&bytes) }],
        });
        change(&mut document);
        document
    }

    fn read(content: &[u8]) -> Result<Imported, String> {
        parse(content, &Conventions::default(), None).map_err(|located| located.problem.to_string())
    }

    fn mesh(change: impl FnOnce(&mut Value)) -> TriangleMesh {
        read(document(change).to_string().as_bytes()).unwrap_or_else(|problem| panic!("{problem}")).mesh
    }

    #[test]
    fn nodes_stand_where_their_parents_put_them() {
        let placed = mesh(|file| {
            file["nodes"] = json!([
                { "children": [1], "translation": [5, 0, 0], "rotation": [0, 0, 0.5_f64.sqrt(), 0.5_f64.sqrt()] },
                { "mesh": 0, "scale": [-1, 2, 1] },
            ]);
        });
        let found = placed.bounding_box();
        // Twice as long along y, turned a quarter about z, moved along x.
        assert!((found.min - DVec3::new(3.0, -1.0, -1.0)).length() < 1e-6, "{found:?}");
        assert!((found.max - DVec3::new(7.0, 1.0, 1.0)).length() < 1e-6, "{found:?}");
        // Mirrored, and still facing outward.
        assert!((placed.volume() - 16.0).abs() < 1e-5, "{}", placed.volume());
        let by_matrix = mesh(|file| {
            file["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 2, 3, 4, 1]);
        });
        assert_eq!(by_matrix.bounding_box().min, DVec3::new(1.0, 2.0, 3.0));
    }

    #[test]
    fn numbers_of_all_kinds_are_the_same_cube() {
        let whole = mesh(|_| {});
        assert_eq!(whole.volume(), 8.0);
        // Without indices: each corner by itself.
        let plain = cube(1.0, 1);
        let corners: Vec<u8> = (0..plain.triangles().len())
            .flat_map(|t| plain.corners(t))
            .flat_map(|p| p.as_vec3().to_array())
            .flat_map(f32::to_le_bytes)
            .collect();
        let single = mesh(|file| {
            file["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 } });
            file["accessors"][0]["count"] = json!(corners.len() / 12);
            file["bufferViews"] = json!([{ "buffer": 0, "byteLength": corners.len() }]);
            file["buffers"][0]["uri"] = json!(address(&corners));
        });
        assert!(single.volume() == 8.0 && single.topology().is_closed());
        // Positions of signed bytes, as KHR_mesh_quantization allows, four bytes apart.
        let small: Vec<u8> =
            plain.positions().iter().flat_map(|p| [p.x as i8 as u8, p.y as i8 as u8, p.z as i8 as u8, 0]).collect();
        let (bytes, vertices, indices) = bytes();
        let all = [&small[..], &bytes[12 * vertices..]].concat();
        let quantised = mesh(|file| {
            file["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
            file["accessors"][0]["componentType"] = json!(5120);
            file["bufferViews"] = json!([
                { "buffer": 0, "byteLength": small.len(), "byteStride": 4 },
                { "buffer": 0, "byteOffset": small.len(), "byteLength": 2 * indices },
            ]);
            file["buffers"][0]["uri"] = json!(address(&all));
        });
        assert_eq!(quantised.volume(), 8.0);
        // All zero but for what stands in a sparse accessor.
        let places: Vec<u8> = (0..vertices as u8).collect();
        let all = [&bytes[..], &places].concat();
        let sparse = mesh(|file| {
            file["bufferViews"]
                .as_array_mut()
                .unwrap()
                .push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": vertices }));
            file["buffers"][0]["uri"] = json!(address(&all));
            file["accessors"][0] = json!({
                "componentType": 5126, "count": vertices, "type": "VEC3",
                "sparse": {
                    "count": vertices,
                    "indices": { "bufferView": 2, "componentType": 5121 },
                    "values": { "bufferView": 0 },
                },
            });
        });
        assert_eq!(sparse.volume(), 8.0);
    }

    #[test]
    fn materials_have_factors_and_moved_places() {
        let (_, vertices, _) = bytes();
        let places: Vec<u8> = (0..vertices).flat_map(|_| [0.25_f32, 0.0]).flat_map(f32::to_le_bytes).collect();
        let mut picture = std::io::Cursor::new(Vec::new());
        let red_and_blue =
            image::RgbImage::from_fn(2, 1, |x, _| image::Rgb(if x == 0 { [255, 0, 0] } else { [0, 0, 255] }));
        red_and_blue.write_to(&mut picture, image::ImageFormat::Png).unwrap();
        let file = document(|file| {
            let (bytes, vertices, _) = bytes();
            let all = [&bytes[..], &places].concat();
            file["buffers"][0]["uri"] = json!(address(&all));
            let views = file["bufferViews"].as_array_mut().unwrap();
            views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": places.len() }));
            let accessors = file["accessors"].as_array_mut().unwrap();
            accessors.push(json!({ "bufferView": 2, "componentType": 5126, "count": vertices, "type": "VEC2" }));
            let primitive = &mut file["meshes"][0]["primitives"][0];
            primitive["attributes"]["TEXCOORD_1"] = json!(2);
            primitive["material"] = json!(0);
            file["materials"] = json!([{ "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 0.5, 0.25, 1],
                // A quarter turn counter-clockwise takes (0.25, 0) to (0, −0.25), up; then to (0.75, 0.5).
                "baseColorTexture": { "index": 0, "texCoord": 0, "extensions": { "KHR_texture_transform": {
                    "texCoord": 1, "rotation": std::f64::consts::FRAC_PI_2, "offset": [0.75, 0.75],
                } } },
            } }]);
            file["textures"] = json!([{ "source": 0 }]);
            file["images"] = json!([{ "uri": address(picture.get_ref()) }]);
        });
        let imported = read(file.to_string().as_bytes()).unwrap();
        assert_eq!(imported.remarks, []);
        let place = imported.mesh.places().unwrap()[0];
        assert!((place.place[0] - 0.75).abs() < 1e-6 && (place.place[1] - 0.5).abs() < 1e-6, "{place:?}");
        let colour = imported.materials[place.material as usize].colour(place.place, Lookup::Nearest, 0.0);
        assert_eq!(colour, [0.0, 0.0, 0.25]);
    }

    #[test]
    fn what_is_not_read_is_named() {
        let fails = |change: &dyn Fn(&mut Value), part: &str| {
            let problem = read(document(change).to_string().as_bytes()).unwrap_err();
            assert!(problem.contains(part) && problem.len() < 1000, "{problem}");
        };
        fails(&|file| file["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]), "Draco");
        fails(&|file| file["extensionsRequired"] = json!(["EXT_meshopt_compression"]), "meshopt");
        fails(
            &|file| file["extensionsRequired"] = json!(["ACME_\u{1b}[31mred"]),
            "needs an extension (`ACME_\\u{1b}[31mred`)",
        );
        fails(&|file| file["nodes"][0]["children"] = json!([0]), "in itself");
        fails(&|file| file["nodes"][0]["children"] = json!([7]), "node 7, which is not there");
        fails(&|file| file["accessors"][0]["count"] = json!(u32::MAX), "shorter than what is read");
        fails(&|file| file["accessors"][0]["count"] = json!(u64::MAX), "shorter than what is read");
        fails(&|file| file["accessors"][0]["byteOffset"] = json!(u64::MAX), "shorter than what is read");
        fails(&|file| file["accessors"][1]["componentType"] = json!(5126), "no whole numbers");
        fails(&|file| file["bufferViews"][0]["byteLength"] = json!(u64::MAX), "beyond its buffer");
        fails(&|file| file["buffers"][0]["uri"] = json!("gone.bin"), "'gone.bin' is not there");
        fails(
            &|file| file["accessors"][0] = json!({ "componentType": 5126, "count": 1_u64 << 40, "type": "VEC3" }),
            "announces 1099511627776 zeros",
        );
        assert!(read(b"glTF\x02\0\0\0").unwrap_err().contains("ends in its head"));
        assert!(read(b"{ \"asset\": ").unwrap_err().contains("no glTF document"));
    }

    /// Bits flipped and ends cut off, of a file of text and of one of bytes: an error or a mesh, never a panic.
    #[test]
    fn damage_is_an_error_or_a_mesh() {
        let (bytes, ..) = bytes();
        let text = document(|file| file["buffers"][0] = json!({ "byteLength": bytes.len() })).to_string();
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend(((28 + text.len() + bytes.len()) as u32).to_le_bytes());
        for (kind, part) in [(b"JSON", text.as_bytes()), (b"BIN\0", &bytes)] {
            glb.extend((part.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(part);
        }
        assert_eq!(read(&glb).unwrap().mesh.volume(), 8.0);
        let whole = document(|_| {}).to_string().into_bytes();
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize
        };
        for content in [&glb, &whole] {
            for round in 0..300 {
                let mut damaged = content.clone();
                for _ in 0..1 + round % 4 {
                    let at = random() % damaged.len();
                    damaged[at] ^= 1 << (random() % 8);
                }
                if round % 3 == 0 {
                    damaged.truncate(random() % damaged.len());
                }
                let _ = read(&damaged);
            }
        }
    }
}
