//! Meshes to voxels and back, with colours, against OpenVDB: a closed mesh of 102,400 triangles with colours at its
//! vertices becomes a coloured band, against `meshToVolume` with the closest polygons' colours; and a coloured frame
//! becomes polygons, against `volumeToMesh` with colours sampled at its vertices. On two threads.
//!
//! `cargo bench -p hfvdb-bench --bench meshes [-- RESOLUTION...]`

use std::f64::consts::TAU;
use std::path::Path;

use glam::{DVec3, IVec3};
use hfvdb::bake::{Bytes, Computed, Existing, Identity, Output, Sequence, output};
use hfvdb::node::Source;
use hfvdb::shot::Prepared;
use hfvdb::vdb::{Compression, WriteOptions, write};
use hfvdb_bench::clock::{pairs, timed};
use hfvdb_bench::report::{Goal, Row};
use hfvdb_bench::scenes::{self, Sampling};
use hfvdb_bench::{bake, rivals, threads};

const PAIRS: usize = 5;
/// Quads around and along the ring.
const AROUND: [u32; 2] = [320, 160];

/// A bumpy ring, in the box [-1, 1]³, with colours as bytes of sRGB.
struct Mesh {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    colours: Vec<[u8; 3]>,
}

impl Mesh {
    fn ring() -> Self {
        let [along, around] = AROUND;
        let mut mesh = Self { positions: vec![], triangles: vec![], colours: vec![] };
        for i in 0..along {
            for j in 0..around {
                let [u, v] = [(i, along), (j, around)].map(|(k, count)| TAU * f64::from(k) / f64::from(count));
                let radius = 0.28 + 0.03 * (9.0 * u).sin() * (5.0 * v).cos();
                let out = 0.65 + radius * v.cos();
                mesh.positions.push(DVec3::new(out * u.cos(), out * u.sin(), radius * v.sin()));
                mesh.colours.push([u, 2.0 * v, u + 3.0 * v].map(|angle| (127.5 + 100.0 * angle.sin()) as u8));
                let at = |i: u32, j: u32| i % along * around + j % around;
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        mesh
    }

    fn write(&self, path: &Path) {
        let mut bytes = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             property uchar red\nproperty uchar green\nproperty uchar blue\nelement face {}\n\
             property list uchar int vertex_indices\nend_header\n",
            self.positions.len(),
            self.triangles.len()
        )
        .into_bytes();
        for (position, colour) in self.positions.iter().zip(&self.colours) {
            position.as_vec3().to_array().iter().for_each(|along| bytes.extend(along.to_le_bytes()));
            bytes.extend(colour);
        }
        for triangle in &self.triangles {
            bytes.push(3);
            triangle.iter().for_each(|vertex| bytes.extend(vertex.to_le_bytes()));
        }
        std::fs::write(path, bytes).expect("a file");
    }
}

/// From the file of a mesh to a band with colours.
fn to_voxels(resolution: u32) {
    let folder = tempfile::tempdir().expect("a folder");
    let mesh = Mesh::ring();
    mesh.write(&folder.path().join("ring.ply"));
    let text = "hfvdb = 1\n[shape.ring]\nmesh = \"ring.ply\"\n".to_owned();
    let source = Source::Text { name: "ring.toml".into(), text, folder: folder.path().into() };
    let ours = || {
        let prepared = scenes::prepare_source(&source, Sampling::OfSolid(resolution));
        let computed = bake::compute(&prepared, 1);
        (prepared, computed)
    };
    let positions: Vec<f32> = mesh.positions.iter().flat_map(|position| position.as_vec3().to_array()).collect();
    let colours: Vec<f32> = mesh.colours.iter().flatten().map(|part| f32::from(*part) / 255.0).collect();
    let (prepared, computed) = ours();
    let voxel = prepared.lattice.voxel_size.get();
    let theirs =
        || rivals::mesh_to_volume(&positions, mesh.triangles.as_flattened(), &colours, voxel).expect("the rival runs");
    let row = Row("mesh-voxels", "ring", resolution);
    println!("{} triangles, {} active voxels", mesh.triangles.len(), computed.band.active_voxels());
    row.value("largest_difference_in_voxels", difference(&computed, &theirs()), Goal::None);
    let pairs = pairs(PAIRS, || timed(ours).0, || timed(theirs).0);
    row.compare("a mesh's file to a coloured band, against meshToVolume with colours", Goal::AtLeast(3.0), &pairs);
    let known: Vec<_> = (0..PAIRS).map(|_| [timed(|| bake::compute(&prepared, 1)).0, timed(theirs).0]).collect();
    Row("mesh-voxels-ready", "ring", resolution).compare("the same, the mesh read", Goal::None, &known);
    to_polygons(&prepared, &computed, "ring", resolution);
}

/// How far the rival's distances are from ours at most.
fn difference(computed: &Computed, theirs: &rivals::ColouredGrid) -> f64 {
    let band = &computed.band;
    let blocks = band.origins.iter().zip(&band.distances).zip(&band.active);
    let mut most = 0.0_f32;
    for ((origin, distances), active) in blocks {
        for (place, distance) in (0..).zip(distances).filter(|(place, _)| active[place / 64] >> (place % 64) & 1 == 1) {
            let IVec3 { x, y, z } = *origin + IVec3::new(place as i32 >> 6, place as i32 >> 3 & 7, place as i32 & 7);
            let found = -theirs.value(x, y, z);
            // What only one of the two has at its band's end says nothing.
            if found.abs() < 0.99 * band.background() && distance.abs() < 0.99 * band.background() {
                most = most.max((found - distance).abs());
            }
        }
    }
    f64::from(most) / band.lattice.voxel_size.get()
}

/// From a frame to polygons with colours.
fn to_polygons(prepared: &Prepared, computed: &Computed, scene: &str, resolution: u32) {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("frame.vdb");
    write(&file, &bake::grids(computed), &WriteOptions::default()).expect("it is written");
    let grid = rivals::read_coloured(file.to_str().expect("UTF-8")).expect("the rival reads it");
    let polygons = |adaptivity: f64| {
        let compression = Compression::Blosc;
        let sampling = hfvdb::bake::Sampling::Resolution(resolution);
        let identity = Identity::new(String::new(), sampling, scenes::HALF_WIDTH, Vec::new(), compression);
        let pattern = output::pattern(&folder.path().join("frame.ply")).expect("a pattern");
        let output = Output {
            sequence: Sequence { pattern },
            format: output::format_of(Path::new("frame.ply")).expect("a format"),
            identity: Identity { adaptivity, ..identity },
            compression,
            existing: Existing::Overwrite,
            allow_empty: false,
            max_memory: Bytes(u64::MAX),
        };
        let frame = output::Frame { prepared, number: 1, computed, output: &output };
        output.format.encode(&frame).unwrap_or_else(|error| panic!("{error}"))
    };
    let count = polygons(0.1).polygons.expect("counts");
    let merged = [0.0, 0.01].map(|adaptivity| rivals::volume_to_mesh(&grid, adaptivity).expect("the rival runs"));
    println!("{scene}: {} triangles, 0.1 leaves {}; volumeToMesh: {merged:?}", count.unmerged, count.triangles);
    for (number, ours, theirs, goal) in
        [("polygons", 0.0, 0.0, Goal::AtLeast(1.0)), ("polygons-merged", 0.1, 0.01, Goal::None)]
    {
        let ours = || timed(|| polygons(ours)).0;
        let theirs = || timed(|| rivals::volume_to_mesh(&grid, theirs).expect("the rival runs")).0;
        let what = "a coloured frame to polygons' bytes, against volumeToMesh and colours";
        Row(number, scene, resolution).compare(what, goal, &pairs(PAIRS, ours, theirs));
    }
}

fn main() {
    for resolution in hfvdb_bench::resolutions(&[512]) {
        threads(2).install(|| {
            to_voxels(resolution);
            for scene in ["ball", "three"] {
                let prepared = scenes::prepare(scene, Sampling::OfSolid(resolution));
                let computed = bake::compute(&prepared, 1);
                to_polygons(&prepared, &computed, scene, resolution);
            }
        });
    }
}
