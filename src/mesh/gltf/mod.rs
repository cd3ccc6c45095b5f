//! glTF 2.0 and GLB: the triangles of the scene's nodes where they stand, base colours, pictures, vertex colours.
//!
//! Our own reader over `serde_json` rather than the crate `gltf`: that one panics on accessors that lie about their
//! buffers, and refuses quantised meshes.

mod accessor;
mod document;
mod paint;

use std::path::{Path, PathBuf};

use base64::Engine;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec2, DVec3};

use super::Problem;
use super::faces::{Faces, VertexPaint};
use super::material::{self, PicturePlace};
use super::read::{About, Conventions, Imported, Located, Place, Remark, shown};
use crate::disk;
use document::{Buffer, Node, Primitive, Root};
use paint::Painted;

/// Extensions that files may require, and that change nothing of what is read or are read.
const KNOWN: [&str; 5] = [
    "KHR_texture_transform",
    "KHR_mesh_quantization",
    "KHR_lights_punctual",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_xmp_json_ld",
];

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
        if let Some(accessor) = attribute(&name).filter(|_| painted.materials[number].has_picture()) {
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

fn missing(what: &str, number: usize) -> Problem {
    Problem::malformed(format!("names {what} {number}, which is not there"))
}

#[cfg(test)]
mod tests;
