//! GLB (glTF 2.0): the surface as triangles, in metres, y up, with scene-linear colours and attributes of each vertex.

use std::path::Path;

use glam::{DVec3, Vec3};
use serde_json::{Value, json};

use super::{Encoded, Format, Frame, polygons};
use crate::bake::{Error, Output};
use crate::node::Model;
use crate::node::keys::metres;

/// The format of `.glb` files.
#[derive(Debug)]
pub struct Glb;

/// What stands before the document: three words of the file, two of the chunk.
const HEAD: usize = 20;

impl Format for Glb {
    fn extension(&self) -> &'static str {
        "glb"
    }

    fn check(&self, model: &Model, output: &Output) -> Result<(), String> {
        polygons::check(model, output)?;
        polygons::check_still(model)
    }

    fn encode(&self, frame: &Frame<'_>) -> Result<Encoded, Error> {
        let surface = polygons::of_frame(frame)?;
        let model = frame.prepared.model();
        let scale = metres(model.unit);
        let turned = |p: &DVec3| match model.up {
            "y" => (*p * scale).as_vec3(),
            _ => (DVec3::new(p.x, p.z, -p.y) * scale).as_vec3(),
        };
        let positions: Vec<Vec3> = surface.positions.iter().map(turned).collect();
        let least = positions.iter().copied().reduce(Vec3::min).unwrap_or_default();
        let most = positions.iter().copied().reduce(Vec3::max).unwrap_or_default();
        let mut file = Parts::default();
        let mut attributes = serde_json::Map::new();
        let of_positions = file.add(positions.iter().flat_map(Vec3::to_array), positions.len(), "VEC3");
        file.accessors[of_positions]["min"] = json!(least.to_array());
        file.accessors[of_positions]["max"] = json!(most.to_array());
        attributes.insert("POSITION".into(), json!(of_positions));
        if let Some(colours) = &surface.colours {
            let colours = file.add(colours.iter().flatten().copied(), positions.len(), "VEC3");
            attributes.insert("COLOR_0".into(), json!(colours));
        }
        for (name, values) in &surface.scalars {
            // Names of one's own begin with an underscore, by the format.
            let accessor = file.add(values.iter().copied(), positions.len(), "SCALAR");
            attributes.insert(format!("_{}", name.to_ascii_uppercase()), json!(accessor));
        }
        let indices = file.add_indices(&surface.triangles);
        let document = json!({
            "asset": { "version": "2.0", "generator": frame.output.identity.program },
            "scene": 0,
            "scenes": [{ "nodes": [0], "extras": { "hfvdb_frame": frame.number } }],
            "nodes": [{ "mesh": 0, "name": "surface" }],
            "meshes": [{ "name": "surface", "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] }],
            "materials": [{ "name": "surface", "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 0.6 } }],
            "accessors": file.accessors,
            "bufferViews": file.views,
            "buffers": [{ "byteLength": file.bytes.len() }],
        });
        let mut document = document.to_string().into_bytes();
        document.resize(document.len().next_multiple_of(4), b' ');
        let whole = HEAD + document.len() + 8 + file.bytes.len();
        let word = |value: usize| {
            u32::try_from(value).map_err(|_| Error::Encode("a .glb holds 4 GiB at most: take larger voxels".into()))
        };
        let mut head = b"glTF".to_vec();
        for value in [2, word(whole)?, word(document.len())?, 0x4E4F_534A] {
            head.extend(value.to_le_bytes());
        }
        head.extend(document);
        for value in [word(file.bytes.len())?, 0x004E_4942] {
            head.extend(value.to_le_bytes());
        }
        Ok(Encoded { pieces: vec![head, file.bytes], polygons: surface.merged })
    }

    /// The head says how long the whole is.
    fn read_back(&self, pieces: &[Vec<u8>], path: &Path) -> Result<(), Error> {
        let whole: usize = pieces.iter().map(Vec::len).sum();
        let told = pieces.first().and_then(|head| head.get(8..12)).and_then(|word| word.try_into().ok());
        match told.map(u32::from_le_bytes) {
            Some(told) if told as usize == whole => Ok(()),
            _ => Err(Error::Encode(format!("{}: is not as long as its head says", path.display()))),
        }
    }
}

/// The bytes of a file, and what they are.
#[derive(Default)]
struct Parts {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Parts {
    /// Numbers of each vertex.
    fn add(&mut self, numbers: impl Iterator<Item = f32>, count: usize, kind: &str) -> usize {
        let start = self.bytes.len();
        numbers.for_each(|number| self.bytes.extend(number.to_le_bytes()));
        self.view(start, 34962);
        self.accessors
            .push(json!({ "bufferView": self.views.len() - 1, "componentType": 5126, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    fn add_indices(&mut self, triangles: &[[u32; 3]]) -> usize {
        let start = self.bytes.len();
        triangles.iter().flatten().for_each(|vertex| self.bytes.extend(vertex.to_le_bytes()));
        self.view(start, 34963);
        let count = 3 * triangles.len();
        self.accessors.push(
            json!({ "bufferView": self.views.len() - 1, "componentType": 5125, "count": count, "type": "SCALAR" }),
        );
        self.accessors.len() - 1
    }

    fn view(&mut self, start: usize, target: u32) {
        let length = self.bytes.len() - start;
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": target }));
    }
}
