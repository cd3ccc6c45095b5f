//! PLY: the surface as triangles, binary, with colours as sRGB bytes and attributes as numbers of each vertex.

use std::path::Path;

use super::{Encoded, Format, Frame, polygons};
use crate::attribute::to_srgb;
use crate::bake::{Error, Output};
use crate::node::Model;

/// The format of `.ply` files.
#[derive(Debug)]
pub struct Ply;

impl Format for Ply {
    fn extension(&self) -> &'static str {
        "ply"
    }

    fn check(&self, model: &Model, output: &Output) -> Result<(), String> {
        polygons::check(model, output)?;
        polygons::check_still(model)
    }

    fn encode(&self, frame: &Frame<'_>) -> Result<Encoded, Error> {
        let surface = polygons::of_frame(frame)?;
        let mut head = String::from("ply\nformat binary_little_endian 1.0\n");
        head += &format!("comment {}, frame {}\n", frame.output.identity.program, frame.number);
        head += &format!("comment unit {}, {} up\n", frame.prepared.model().unit, frame.prepared.model().up);
        head += &format!("element vertex {}\n", surface.positions.len());
        for axis in ["x", "y", "z"] {
            head += &format!("property float {axis}\n");
        }
        if surface.colours.is_some() {
            for channel in ["red", "green", "blue"] {
                head += &format!("property uchar {channel}\n");
            }
        }
        for (name, _) in &surface.scalars {
            head += &format!("property float {name}\n");
        }
        head +=
            &format!("element face {}\nproperty list uchar int vertex_indices\nend_header\n", surface.triangles.len());
        let mut body = Vec::with_capacity(surface.positions.len() * 16 + surface.triangles.len() * 13);
        for (i, position) in surface.positions.iter().enumerate() {
            position.as_vec3().to_array().iter().for_each(|along| body.extend(along.to_le_bytes()));
            if let Some(colours) = &surface.colours {
                body.extend(to_srgb(colours[i]).map(|part| (part.clamp(0.0, 1.0) * 255.0).round() as u8));
            }
            surface.scalars.iter().for_each(|(_, values)| body.extend(values[i].to_le_bytes()));
        }
        for triangle in &surface.triangles {
            body.push(3);
            triangle.iter().for_each(|vertex| body.extend(vertex.to_le_bytes()));
        }
        Ok(Encoded { pieces: vec![head.into_bytes(), body], polygons: surface.merged })
    }

    /// The header says how long the rest is.
    fn read_back(&self, pieces: &[Vec<u8>], path: &Path) -> Result<(), Error> {
        let damaged = || Error::Encode(format!("{}: is not as long as its header says", path.display()));
        let [head, body] = pieces else { return Err(damaged()) };
        let head = std::str::from_utf8(head).map_err(|_| damaged())?;
        let count = |element: &str| {
            let line = head.lines().find_map(|line| line.strip_prefix(element))?;
            line.trim().parse::<usize>().ok()
        };
        let (vertices, faces) = count("element vertex").zip(count("element face")).ok_or_else(damaged)?;
        let floats = head.matches("property float").count();
        let bytes = head.matches("property uchar").count();
        if body.len() == vertices * (4 * floats + bytes) + 13 * faces { Ok(()) } else { Err(damaged()) }
    }
}
