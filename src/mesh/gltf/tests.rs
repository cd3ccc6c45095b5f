use serde_json::{Value, json};

use super::super::shapes::cube;
use super::super::{Lookup, NumberOf, TriangleMesh};
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
        let places = json!({ "KHR_texture_transform": {
            "texCoord": 1, "rotation": std::f64::consts::FRAC_PI_2, "offset": [0.75, 0.75],
        } });
        file["materials"] = json!([{ "pbrMetallicRoughness": {
            "roughnessFactor": 0.5,
            "metallicFactor": 0.25,
            "metallicRoughnessTexture": { "index": 0, "texCoord": 0, "extensions": places },
            "baseColorFactor": [0.5, 0.5, 0.25, 1],
            // A quarter turn counter-clockwise takes (0.25, 0) to (0, −0.25), up; then to (0.75, 0.5).
            "baseColorTexture": { "index": 0, "texCoord": 0, "extensions": places },
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
    // Green is the roughness, blue the metalness.
    let material = &imported.materials[place.material as usize];
    let number = |which| material.number(which, place.place, Lookup::Nearest, 0.0);
    assert_eq!((number(NumberOf::Roughness), number(NumberOf::Metallic)), (Some(0.0), Some(0.25)));
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
