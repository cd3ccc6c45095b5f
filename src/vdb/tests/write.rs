use std::fs;
use std::os::unix::fs::PermissionsExt;

use glam::IVec3;
use serde_json::json;

use super::support::*;
use crate::disk;
use crate::grid::*;
use crate::vdb::*;

fn frame<'a>(band: &'a Band, colour: &'a Channel<[f32; 3]>) -> Frame<'a> {
    Frame { grids: vec![Grid::level_set("surface", band), Grid::colour(band, colour)], metadata: Metadata::new() }
}

fn without_identifier(path: &std::path::Path) -> Vec<u8> {
    let mut bytes = fs::read(path).unwrap();
    bytes[21..57].fill(0);
    bytes
}

#[test]
fn another_reader_finds_every_voxel_as_it_was_given() {
    let folder = tempfile::tempdir().unwrap();
    let (path, band) = (folder.path().join("ball.0001.vdb"), ball());
    let colour_channel = ball_colour(&band, "Cd");
    let mut frame = frame(&band, &colour_channel);
    frame.metadata = [
        ("creator".into(), "hfvdb test".into()),
        ("frame".into(), 17.into()),
        ("big".into(), (1_i64 << 40).into()),
        ("ratio".into(), 0.5_f32.into()),
        ("fps".into(), 23.976_f64.into()),
        ("looped".into(), true.into()),
    ]
    .into();
    frame.grids[1].metadata.insert("color_space".into(), "lin_rec709".into());
    let written = write(&path, &frame, &WriteOptions::default()).unwrap();
    assert_eq!(written.bytes, fs::metadata(&path).unwrap().len());

    let seen = judge(&path, folder.path());
    assert_eq!(
        seen["metadata"],
        json!({"creator": "hfvdb test", "frame": 17, "big": 1_i64 << 40, "ratio": 0.5, "fps": 23.976, "looped": true})
    );
    let (surface, cd) = (&seen["grids"]["surface"], &seen["grids"]["Cd"]);
    for grid in [surface, cd] {
        assert_eq!(grid["voxel_size"], json!([VOXEL_SIZE, VOXEL_SIZE, VOXEL_SIZE]));
        assert_eq!(grid["origin"], json!([0.0, 0.0, 0.0]));
        assert_eq!(grid["active"], json!(band.active_voxels()));
        assert_eq!(grid["leaves"], json!(band.origins.len()));
        assert_eq!(grid["metadata"]["file_voxel_count"], json!(band.active_voxels()));
        assert_eq!(grid["metadata"]["file_compression"], json!("blosc + active values"));
        for key in ["file_bbox_min", "file_bbox_max", "file_mem_bytes"] {
            assert!(!grid["metadata"][key].is_null(), "no {key}");
        }
    }
    assert_eq!((&surface["name"], &surface["type"]), (&json!("surface"), &json!("float")));
    assert_eq!((&surface["class"], &surface["background"]), (&json!("level set"), &json!(band.background())));
    assert_eq!((&cd["name"], &cd["type"], &cd["class"]), (&json!("Cd"), &json!("vec3s"), &json!("unknown")));
    assert_eq!((&cd["vector_type"], &cd["background"]), (&json!("invariant"), &json!([0.25, 0.5, 0.75])));
    assert_eq!(cd["metadata"]["color_space"], json!("lin_rec709"));

    let (values, active) = dumped(folder.path(), "surface");
    let (colours, colour_active) = dumped(folder.path(), "Cd");
    assert_eq!(active, colour_active);
    let background = band.background();
    for (place, voxel) in box_voxels().enumerate() {
        let exact = distance(voxel);
        assert_eq!(active[place], exact.abs() < background, "{voxel}");
        assert_eq!(values[place], -exact.clamp(-background, background), "{voxel}");
        let expected = if active[place] { colour(voxel) } else { colour_channel.background };
        assert_eq!(colours[3 * place..3 * place + 3], expected, "{voxel}");
    }
}

#[test]
fn the_bytes_are_those_of_the_librarys_own_writer() {
    let folder = tempfile::tempdir().unwrap();
    let (path, band) = (folder.path().join("ball.vdb"), ball());
    let channel = ball_colour(&band, "Cd");
    for half in [false, true] {
        let mut frame = frame(&band, &channel);
        frame.grids.reverse(); // the judge reads grids in the order of their names
        frame.grids.iter_mut().for_each(|grid| grid.half = half);
        write(&path, &frame, &WriteOptions { overwrite: true, ..Default::default() }).unwrap();
        judge(&path, folder.path());
        assert!(without_identifier(&path) == without_identifier(&folder.path().join("again.vdb")), "half: {half}");
    }
}

#[test]
fn any_number_of_threads_writes_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let band = ball();
    let channel = ball_colour(&band, "Cd");
    let files = [1, 2, 5].map(|threads| {
        set_threads(threads).unwrap();
        let path = folder.path().join(format!("{threads}.vdb"));
        write(&path, &frame(&band, &channel), &WriteOptions::default()).unwrap();
        without_identifier(&path)
    });
    assert!(files[0] == files[1] && files[1] == files[2]);
}

#[test]
fn floats_and_velocities_with_active_tiles() {
    let folder = tempfile::tempdir().unwrap();
    let (path, band) = (folder.path().join("ball.vdb"), ball());
    let channel = ball_colour(&band, "vel");
    let density = even(&band, "density", 0.5);
    let mut fog = Values::over(&band, &density);
    let ones = vec![1.0; band.inside_tiles.len()];
    fog.tiles = Tiles { places: &band.inside_tiles, values: &ones };
    let motion =
        Content::Vectors { values: Values::over(&band, &channel), vector_type: VectorType::ContravariantRelative };
    let frame = Frame {
        grids: vec![
            Grid::new("density", Content::Floats { values: fog, class: Class::FogVolume }),
            Grid::new("vel", motion),
        ],
        metadata: Metadata::new(),
    };
    for compression in [Compression::Blosc, Compression::Zip, Compression::None] {
        write(&path, &frame, &WriteOptions { compression, overwrite: true }).unwrap();
        let seen = judge(&path, folder.path());
        assert_eq!(seen["grids"]["density"]["class"], json!("fog volume"));
        assert_eq!(
            seen["grids"]["density"]["active"],
            json!(band.active_voxels() + 512 * band.inside_tiles.len() as u64)
        );
        assert_eq!(seen["grids"]["vel"]["vector_type"], json!("contravariant relative"));
        let (values, active) = dumped(folder.path(), "density");
        for (place, voxel) in box_voxels().enumerate() {
            let inside = band.inside_tiles.iter().any(|tile| tile.origin == block_origin(voxel));
            let expected = if inside {
                1.0
            } else if active[place] {
                0.5
            } else {
                0.0
            };
            assert_eq!(values[place], expected, "{voxel}");
        }
    }
}

#[test]
fn another_reader_in_rust_agrees() {
    let folder = tempfile::tempdir().unwrap();
    let (path, mut band) = (folder.path().join("ball.vdb"), ball());
    band.inside_tiles.push(InsideTile { origin: IVec3::splat(4096), edge: 4096 });
    band.inside_tiles.push(InsideTile { origin: IVec3::splat(256), edge: 128 });
    let channel = ball_colour(&band, "Cd");
    for compression in [Compression::Blosc, Compression::Zip, Compression::None] {
        write(&path, &frame(&band, &channel), &WriteOptions { compression, overwrite: true }).unwrap();
        let (_, grids) = OpenVDB_rs::io::read_file(&path).expect("the other reader reads it");
        assert_eq!(grids.len(), 2);
        for grid in &grids {
            assert_eq!(grid.active_voxel_count(), band.active_voxels());
        }
    }
}

#[test]
fn what_makes_no_grid_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bad.vdb");
    let band = ball();
    let refusal = |band: &Band| {
        let error = write(
            &path,
            &Frame { grids: vec![Grid::level_set("surface", band)], ..Default::default() },
            &WriteOptions::default(),
        );
        let text = error.expect_err("refused").to_string();
        assert!(text.starts_with("grid 'surface': "), "{text}");
        text
    };
    let changed = |change: fn(&mut Band)| {
        let mut band = band.clone();
        change(&mut band);
        refusal(&band)
    };
    assert!(changed(|band| band.origins.swap(0, 1)).contains("sort them"));
    assert!(changed(|band| band.origins[0].x += 1).contains("multiple of 8"));
    assert!(changed(|band| band.distances.truncate(1)).contains("do not fit together"));
    assert!(changed(|band| band.half_width = f32::NAN).contains("half-width"));
    assert!(changed(|band| band.inside_tiles[0].edge = 16).contains("no tile of 16"));
    assert!(changed(|band| band.inside_tiles[0].origin = band.origins[3]).contains("tiles where it has blocks"));
    assert!(changed(|band| band.lattice.voxel_size = VoxelSize::new(1e-6).unwrap()).contains("too small"));
    let nan = changed(|band| {
        let place = band.active[2].iter().position(|word| *word != 0).unwrap();
        band.distances[2][place * 64 + band.active[2][place].trailing_zeros() as usize] = f32::NAN;
    });
    assert!(nan.contains("not a finite number at voxel ("), "{nan}");
    let mut short = ball_colour(&band, "surface");
    short.values[2] = short.values[2][1..].into();
    let grids = vec![Grid::colour(&band, &short)];
    let text = write(&path, &Frame { grids, ..Default::default() }, &WriteOptions::default()).expect_err("refused");
    assert!(text.to_string().contains("active voxels and "), "{text}");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "something was left behind");
}

#[test]
fn half_precision_refuses_what_it_cannot_hold() {
    let band = ball();
    let mut channel = ball_colour(&band, "Cd");
    channel.values[1][0] = [1e5, 0.0, 0.0];
    let mut grid = Grid::colour(&band, &channel);
    grid.half = true;
    let frame = Frame { grids: vec![grid], ..Default::default() };
    assert!(encode(&frame, Compression::Blosc).expect_err("refused").to_string().contains("32 bits"));
}

#[test]
fn an_existing_file_stays_unless_overwriting_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let (path, band) = (folder.path().join("ball.vdb"), ball());
    fs::write(&path, "precious").unwrap();
    let frame = Frame { grids: vec![Grid::level_set("surface", &band)], ..Default::default() };
    let error = write(&path, &frame, &WriteOptions::default()).expect_err("refused");
    assert!(matches!(error, Error::Disk(disk::Error::Exists { .. })), "{error}");
    assert_eq!(fs::read(&path).unwrap(), b"precious");
    write(&path, &frame, &WriteOptions { overwrite: true, ..Default::default() }).unwrap();
    assert_eq!(&fs::read(&path).unwrap()[..4], b" BDV");
    assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o600, 0o600);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn an_error_of_the_system_names_the_file_and_the_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let band = ball();
    let frame = Frame { grids: vec![Grid::level_set("surface", &band)], ..Default::default() };
    let attempt =
        |path: &std::path::Path| write(path, &frame, &WriteOptions::default()).expect_err("fails").to_string();
    let text = attempt(&folder.path().join("missing/ball.vdb"));
    assert!(text.contains("missing") && text.contains("make its folder first"), "{text}");
    let text = attempt(folder.path());
    assert!(text.contains("name a file"), "{text}");
    fs::write(folder.path().join("file"), "").unwrap();
    let text = attempt(&folder.path().join("file/ball.vdb"));
    assert!(text.contains("choose another folder"), "{text}");
    // A file system that nobody may write to.
    let text = attempt(std::path::Path::new("/proc/ball.vdb"));
    assert!(text.starts_with("/proc/ball.vdb: cannot "), "{text}");
}
