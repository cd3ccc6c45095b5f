//! Damaged files of every kind that is read, through a scene as users' files come: an error or a sound result, in time, and in
//! words that fit a terminal. Seeded, so that a variant that fails fails again: what failed is kept beside the message.
//! `HFVDB_DAMAGE` says how many variants of each file are tried, `HFVDB_DAMAGE_SEED` what they start from.

use std::fmt::Write;
use std::fs;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{DVec3, IVec3, Vec3};
use rayon::prelude::*;

use super::assets::Assets;
use super::id::Stage;
use super::solid::Solids;
use super::*;
use crate::attribute::Colour;
use crate::field::{BATCH, Field, Points};
use crate::grid::{Band, Channel, Lattice, VoxelSize, block_order};
use crate::node::attributes::TheColour;
use crate::shot::PrepareOptions;
use crate::text::problem::Problem;
use crate::text::{Overrides, builtin_text};
use crate::vdb::{self, Compression, Content, Frame, Grid, Values};

/// Variants of each file in the ordinary run.
const VARIANTS: u64 = 100;
/// What one may take, beside others on a busy machine.
const LONGEST: Duration = Duration::from_secs(10);
/// The longest message of one problem, in bytes, without the scene's text around it.
const LONGEST_MESSAGE: usize = 1024;

/// A file that is read, the scene that reads it, and what else stands beside it.
struct Sample {
    name: &'static str,
    bytes: Vec<u8>,
    scene: String,
    beside: Vec<(&'static str, Vec<u8>)>,
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    fn one_of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// Some bytes in another state: cut, flipped, with lying counts, numbers that are none, names that lead elsewhere.
fn damaged(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(out.len());
        let end = (at + 1 + random.below(40)).min(out.len());
        match random.below(9) {
            0 => out.truncate(at),
            1 if !out.is_empty() => out[at] ^= 1 << random.below(8),
            2 if !out.is_empty() => out[at] = random.next() as u8,
            3 => {
                let lies: [&[u8]; 7] = [
                    &[0xff; 4],
                    &[0xff; 8],
                    &[0; 4],
                    &[0xff, 0xff, 0xff, 0x7f],
                    &[0x7f, 0xff, 0xff, 0xff],
                    &[0, 0, 0xc0, 0x7f],
                    &[0, 0, 0, 0x80],
                ];
                let lie = *random.one_of(&lies);
                let end = (at + lie.len()).min(out.len());
                out[at..end].copy_from_slice(&lie[..end - at]);
            }
            4 => drop(out.drain(at..end)),
            5 => {
                let again = out[at..end].to_vec();
                out.splice(at..at, again);
            }
            6 => {
                // A number of a text.
                let numbers =
                    ["nan", "inf", "1e999", "-1", "0", "4294967296", "99999999999999999999", "1e-320", "x", ""];
                let start = (at..out.len()).find(|&i| out[i].is_ascii_digit()).unwrap_or(at);
                let stop = (start..out.len()).find(|&i| !out[i].is_ascii_digit()).unwrap_or(out.len());
                out.splice(start..stop, random.one_of(&numbers).bytes());
            }
            7 => out[at..end].iter_mut().for_each(|byte| *byte = random.next() as u8),
            _ => {
                let long = "n".repeat(5000);
                let names = [
                    "../../../../etc/passwd",
                    "/dev/zero",
                    "/dev/stdin",
                    "\0",
                    "\u{1b}[2J",
                    "a.#####.png",
                    long.as_str(),
                ];
                let is_name = |i: &usize| out[*i..].starts_with(b"skin.png") || out[*i..].starts_with(b"skin.mtl");
                if let Some(start) = (0..out.len()).find(is_name) {
                    out.splice(start..start + 8, random.one_of(&names).bytes());
                }
            }
        }
        if out.is_empty() {
            break;
        }
    }
    out
}

/// A picture of small squares, in some format.
fn picture(format: image::ImageFormat) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    image::RgbImage::from_fn(16, 16, |x, y| image::Rgb([(x * 16) as u8, (y * 16) as u8, 128]))
        .write_to(&mut out, format)
        .unwrap();
    out.into_inner()
}

fn exr() -> Vec<u8> {
    use exr::prelude::{Image, SpecificChannels, WritableImage};
    let colour = |at: exr::math::Vec2<usize>| (at.x() as f32, at.y() as f32, 0.5_f32);
    let mut out = Cursor::new(Vec::new());
    Image::from_channels((16, 16), SpecificChannels::rgb(colour)).write().to_buffered(&mut out).unwrap();
    out.into_inner()
}

const CORNERS: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn ply(format: &str) -> Vec<u8> {
    let mut head = format!("ply\nformat {format} 1.0\ncomment a\nelement vertex 4\n");
    for property in ["float x", "float y", "float z", "uchar red", "uchar green", "uchar blue"] {
        writeln!(head, "property {property}").unwrap();
    }
    head += "element face 4\nproperty list uchar int vertex_indices\nend_header\n";
    let mut out = head.into_bytes();
    let number = |value: [u8; 4]| match format {
        "binary_big_endian" => value.into_iter().rev().collect::<Vec<u8>>(),
        _ => value.to_vec(),
    };
    for corner in CORNERS {
        if format == "ascii" {
            out.extend(format!("{} {} {} 200 100 50\n", corner[0], corner[1], corner[2]).into_bytes());
            continue;
        }
        corner.iter().for_each(|along| out.extend(number(along.to_le_bytes())));
        out.extend([200, 100, 50]);
    }
    for face in FACES {
        if format == "ascii" {
            out.extend(format!("3 {} {} {}\n", face[0], face[1], face[2]).into_bytes());
            continue;
        }
        out.push(3);
        face.iter().for_each(|corner| out.extend(number(corner.to_le_bytes())));
    }
    out
}

fn stl(is_text: bool) -> Vec<u8> {
    let mut text = String::from("solid a\n");
    let mut out = vec![0; 80];
    out.extend((FACES.len() as u32).to_le_bytes());
    for face in FACES {
        text += "facet normal 0 0 0\nouter loop\n";
        out.extend([0; 12]);
        for corner in face.map(|corner| CORNERS[corner as usize]) {
            writeln!(text, "vertex {} {} {}", corner[0], corner[1], corner[2]).unwrap();
            corner.iter().for_each(|along| out.extend(along.to_le_bytes()));
        }
        text += "endloop\nendfacet\n";
        out.extend([0; 2]);
    }
    text += "endsolid a\n";
    if is_text { text.into_bytes() } else { out }
}

/// A tetrahedron with places in a picture; its buffer inside of the file, or by a name.
fn gltf(is_binary: bool) -> (Vec<u8>, Vec<u8>) {
    let mut buffer: Vec<u8> = Vec::new();
    CORNERS.iter().flatten().for_each(|along| buffer.extend(along.to_le_bytes()));
    CORNERS.iter().for_each(|corner| corner[..2].iter().for_each(|along| buffer.extend(along.to_le_bytes())));
    FACES.iter().flatten().for_each(|corner| buffer.extend(corner.to_le_bytes()));
    let picture = picture(image::ImageFormat::Png);
    let image = match is_binary {
        true => "{\"bufferView\":3,\"mimeType\":\"image/png\"}",
        false => "{\"uri\":\"skin.png\"}",
    };
    let uri = if is_binary { "" } else { "\"uri\":\"skin.bin\"," };
    if is_binary {
        buffer.extend(&picture);
    }
    let json = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0]}}],\
         \"nodes\":[{{\"mesh\":0,\"children\":[1]}},{{\"translation\":[3,0,0],\"rotation\":[0,0,0,1],\"mesh\":0}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":{{\"POSITION\":0,\"TEXCOORD_0\":1}},\"indices\":2,\"material\":0}}]}}],\
         \"materials\":[{{\"pbrMetallicRoughness\":{{\"baseColorTexture\":{{\"index\":0}},\"baseColorFactor\":[1,0.5,1,1]}}}}],\
         \"textures\":[{{\"source\":0,\"sampler\":0}}],\"samplers\":[{{\"wrapS\":33071}}],\"images\":[{image}],\
         \"buffers\":[{{{uri}\"byteLength\":{}}}],\"bufferViews\":[{{\"buffer\":0,\"byteLength\":48}},\
         {{\"buffer\":0,\"byteOffset\":48,\"byteLength\":32}},{{\"buffer\":0,\"byteOffset\":80,\"byteLength\":48}}{}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}},\
         {{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"}},\
         {{\"bufferView\":2,\"componentType\":5125,\"count\":12,\"type\":\"SCALAR\"}}]}}",
        buffer.len(),
        if is_binary {
            format!(",{{\"buffer\":0,\"byteOffset\":128,\"byteLength\":{}}}", picture.len())
        } else {
            String::new()
        },
    );
    if !is_binary {
        return (json.into_bytes(), buffer);
    }
    let padded = |mut bytes: Vec<u8>, with: u8| {
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, buffer) = (padded(json.into_bytes(), b' '), padded(buffer, 0));
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend((28 + json.len() as u32 + buffer.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", buffer)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    (out, Vec::new())
}

/// A ball's level set with colours.
fn voxels(compression: Compression) -> Vec<u8> {
    let lattice = Lattice { voxel_size: VoxelSize::new(0.125).unwrap() };
    let mut origins: Vec<IVec3> = (0..8).map(|i| (IVec3::new(i >> 2, i >> 1 & 1, i & 1) - 1) * 8).collect();
    origins.sort_by_key(|origin| block_order(*origin));
    let place = |i: usize| IVec3::new(i as i32 >> 6, i as i32 >> 3 & 7, i as i32 & 7);
    let at = |origin: IVec3, i: usize| (origin + place(i)).as_vec3() * 0.125;
    let distance = |origin: &IVec3| std::array::from_fn(|i| (0.7 - at(*origin, i).length()).clamp(-0.375, 0.375));
    let (distances, active) = (origins.iter().map(distance).collect(), vec![[u64::MAX; 8]; origins.len()]);
    let colour = |origin: &IVec3| std::array::from_fn(|i| (at(*origin, i) * 0.3 + 0.5).to_array());
    let colours = Channel::of_blocks("Cd", &active, origins.iter().map(colour), [0.5; 3]);
    let band = Band { lattice, half_width: 3.0, origins, distances, active, inside_tiles: vec![] };
    let colours = Content::Vectors { values: Values::over(&band, &colours), vector_type: vdb::VectorType::Invariant };
    let grids = vec![Grid::level_set("surface", &band), Grid::new("Cd", colours)];
    vdb::encode(&Frame { grids, metadata: [].into() }, compression).unwrap().concat()
}

fn samples() -> Vec<Sample> {
    let sample = |name: &'static str, bytes: Vec<u8>, scene: &str| Sample {
        name,
        bytes,
        scene: format!("[shape.a]\n{scene}\n[output]\ngrids = ['surface', 'Cd']\n"),
        beside: Vec::new(),
    };
    let obj = "mtllib skin.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\n\
               f 1/1 3/2 2/3\nf 1/1 2/2 4/3\nf 1/1 4/2 3/3\nf -3/1 -2/2 -1/3\n";
    let mtl = "newmtl a\nKd 0.5 0.5 0.5\nmap_Kd -clamp on skin.png\n";
    let png = || picture(image::ImageFormat::Png);
    let mesh = |name: &'static str, bytes: Vec<u8>| sample(name, bytes, &format!("mesh = '{name}'\nsign = 'winding'"));
    let skin = |name: &'static str, bytes: Vec<u8>| {
        let beside = vec![("a.obj", obj.into()), ("skin.mtl", mtl.replace("skin.png", name).into_bytes())];
        Sample { beside, ..sample(name, bytes, "mesh = 'a.obj'") }
    };
    let (text, buffer) = gltf(false);
    vec![
        Sample { beside: vec![("skin.mtl", mtl.into()), ("skin.png", png())], ..mesh("a.obj", obj.into()) },
        Sample {
            beside: vec![("a.obj", obj.into()), ("skin.png", png())],
            ..sample("skin.mtl", mtl.into(), "mesh = 'a.obj'")
        },
        mesh("ascii.ply", ply("ascii")),
        mesh("little.ply", ply("binary_little_endian")),
        mesh("big.ply", ply("binary_big_endian")),
        mesh("text.stl", stl(true)),
        mesh("binary.stl", stl(false)),
        Sample { beside: vec![("skin.bin", buffer.clone()), ("skin.png", png())], ..mesh("a.gltf", text.clone()) },
        Sample {
            beside: vec![("a.gltf", text), ("skin.png", png())],
            ..sample("skin.bin", buffer, "mesh = 'a.gltf'\nsign = 'winding'")
        },
        mesh("a.glb", gltf(true).0),
        skin("skin.png", png()),
        skin("skin.jpg", picture(image::ImageFormat::Jpeg)),
        skin("skin.exr", exr()),
        sample("points.ply", ply("binary_little_endian"), "points = 'points.ply'\nradius = 0.1"),
        sample("points.xyz", b"0 0 0 0.1\n1 0 0 0.1\n0 1 0 0.2 \n".to_vec(), "points = 'points.xyz'\nradius = 0.2"),
        sample(
            "points.csv",
            b"x,y,z,r,g,b\n0,0,0,1,0.5,0\n1,0,0,0,0,1\n".to_vec(),
            "points = 'points.csv'\nradius = 0.2",
        ),
        sample("blosc.vdb", voxels(Compression::Blosc), "vdb = 'blosc.vdb'"),
        sample("zip.vdb", voxels(Compression::Zip), "vdb = 'zip.vdb'"),
        sample("none.vdb", voxels(Compression::None), "vdb = 'none.vdb'"),
        sample("colours.vdb", voxels(Compression::None), "sphere = 0.7\ncolor = { vdb = 'colours.vdb' }"),
        sample("logo.svg", include_bytes!("../../scenes/logo.svg").to_vec(), "extrude = { svg = 'logo.svg' }"),
        sample("image.png", png(), "extrude = { image = 'image.png' }"),
        sample("heights.png", png(), "height_field = 'heights.png'"),
        sample("places.csv", b"0,0,0\n1,0,0,2\n0,1,0,10,20,30\n".to_vec(), "sphere = 0.2\nplaces = 'places.csv'"),
        sample(
            "letters.ttf",
            include_bytes!("../../fonts/noto-sans-semibold.ttf").to_vec(),
            "extrude = { text = 'ag', font = 'letters.ttf' }",
        ),
        Sample { scene: String::new(), ..sample("scene.toml", builtin_text("heart").unwrap().into(), "") },
        Sample {
            scene: String::new(),
            ..sample(
                "scene.json",
                b"{\"hfvdb\":1,\"frames\":\"1-3\",\"shape\":{\"a\":{\"sphere\":\"1+t\",\"color\":[1,0,0]}}}".to_vec(),
                "",
            )
        },
    ]
}

/// What a file in this state becomes; the words of an error.
fn used(folder: &Path, sample: &Sample, bytes: &[u8]) -> Result<(), String> {
    fs::write(folder.join(sample.name), bytes).unwrap();
    if sample.scene.is_empty() {
        let source = Source::Path(folder.join(sample.name));
        return load(&source, &Overrides::default()).map(drop).map_err(|problems| longest(&problems.to_string()));
    }
    let source = Source::Text { name: "scene.toml".into(), text: sample.scene.clone(), folder: folder.into() };
    let model = load(&source, &Overrides::default()).map_err(|problems| longest(&problems.to_string()))?;
    if sample.name.ends_with(".vdb") {
        // Finding the box of voxels takes a second, and is the same whatever file they come from.
        return read_alone(&Arc::new(model)).map_err(|problem| longest(&problem.0.message));
    }
    let options = PrepareOptions { resolution: Some(8), memory_limit: Some(256 << 20), ..PrepareOptions::default() };
    let prepared = Arc::new(model).prepare(&options).map_err(|error| longest(&error.to_string()))?;
    let content = prepared.frame(1).map_err(|error| longest(&error.to_string()))?;
    ask(content.field.as_ref(), content.colour.as_deref());
    Ok(())
}

/// A shape's file and what it makes of it, without its box.
fn read_alone(model: &Arc<Model>) -> Result<(), Problem> {
    let id = ShapeId(0);
    let assets = Assets::load(model, &[id], Some(256 << 20))?;
    let mut solids = Solids::new(model, &Arc::new(assets), model.moment(1.0), 8.0, &Arc::default());
    let colour = solids.paint(TheColour, id, Stage::Placed, 0.1)?;
    let field = solids.values(id)?;
    ask(&field, colour.as_ref().map(|paint| paint.attribute.as_ref()));
    Ok(())
}

/// What is sound has numbers everywhere.
fn ask(field: &dyn Field, colour: Option<&Colour>) {
    let mut points = Points::new(DVec3::ZERO);
    (0..8).for_each(|i| points.push(Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 0.7 - 0.2));
    let mut values = Box::new([0.0; BATCH]);
    field.evaluator().values(&points, &mut values);
    assert!(values[..points.len].iter().all(|value| !value.is_nan()), "F is no number");
    if let Some(colour) = colour {
        let mut colours = Box::new([[0.0; 3]; BATCH]);
        colour.sampler().sample(&points, &mut colours);
        assert!(colours[..points.len].as_flattened().iter().all(|part| part.is_finite()), "a colour is no number");
    }
}

/// The longest line: of a message that has places the others show the scene.
fn longest(text: &str) -> String {
    text.lines().max_by_key(|line| line.len()).unwrap_or_default().to_owned()
}

fn variable(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

#[test]
fn damaged_files_end_in_words() {
    let samples = samples();
    let variants = variable("HFVDB_DAMAGE").unwrap_or(VARIANTS);
    let seed = variable("HFVDB_DAMAGE_SEED").unwrap_or(1);
    let folder = tempfile::tempdir().unwrap();
    // As it is each can be used.
    for sample in &samples {
        let own = folder.path().join(format!("{} whole", sample.name));
        fs::create_dir(&own).unwrap();
        sample.beside.iter().for_each(|(name, bytes)| fs::write(own.join(name), bytes).unwrap());
        used(&own, sample, &sample.bytes).unwrap_or_else(|problem| panic!("{}: {problem}", sample.name));
    }
    let kept = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/target/damage"));
    let wrong: Vec<String> = samples
        .par_iter()
        .enumerate()
        .flat_map(|(row, sample)| (0..variants).into_par_iter().map(move |variant| (row, sample, variant)))
        .filter_map(|(row, sample, variant)| {
            let mut random = Random(seed ^ (row as u64) << 48 ^ variant << 8);
            let bytes = damaged(&sample.bytes, &mut random);
            let own = folder.path().join(format!("{row} {variant}"));
            fs::create_dir(&own).unwrap();
            sample.beside.iter().for_each(|(name, bytes)| fs::write(own.join(name), bytes).unwrap());
            let start = Instant::now();
            let found = catch_unwind(AssertUnwindSafe(|| used(&own, sample, &bytes)));
            let problem = match found {
                Err(_) => "panics".into(),
                _ if start.elapsed() > LONGEST => format!("takes {:.1?}", start.elapsed()),
                Ok(Err(line)) if line.len() > LONGEST_MESSAGE => format!("says {} bytes: {line:.200}", line.len()),
                Ok(Err(line)) if line.contains(|c: char| c.is_control()) => format!("says {line:?}"),
                _ => {
                    let _ = fs::remove_dir_all(&own);
                    return None;
                }
            };
            let copy = kept.join(format!("{variant}-{}", sample.name));
            let _ = fs::create_dir_all(&kept).and_then(|()| fs::write(&copy, &bytes));
            Some(format!("{}, seed {seed}, variant {variant}, {}: {problem}", sample.name, copy.display()))
        })
        .collect();
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), samples.len() as u64 * variants, wrong.join("\n"));
}
