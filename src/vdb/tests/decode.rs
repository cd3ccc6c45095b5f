//! What is read of files against OpenVDB's own reader, bit for bit: `tests/data/openvdb_files.cpp`, compiled here, writes
//! files of all kinds with what OpenVDB finds in them.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use crate::vdb::blosc;
use crate::vdb::*;

/// A folder of such files.
static FILES: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("openvdb_files");
    let run = |command: &mut Command| {
        let output = command.output().expect("it starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let others = run(Command::new("pkg-config").args(["--cflags", "--libs", "Imath", "tbb", "blosc"]));
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/openvdb_files.cpp");
    let mut compiler = Command::new("c++");
    if let Some(root) = std::env::var_os("OPENVDB_ROOT").map(std::path::PathBuf::from) {
        compiler.arg("-I").arg(root.join("include")).arg("-L").arg(root.join("lib"));
    }
    run(compiler.args(["-std=c++17", source, "-lopenvdb", "-o"]).arg(&program).args(others.split_whitespace()));
    run(Command::new(&program).arg(folder.path()));
    folder
});

/// The paths of all files of a kind, sorted.
fn files(extension: &str) -> Vec<std::path::PathBuf> {
    let paths = fs::read_dir(FILES.path()).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<_> = paths.filter(|path| path.extension().is_some_and(|end| end == extension)).collect();
    paths.sort();
    paths
}

/// A grid as the program writes what OpenVDB finds.
fn found(grid: &StoredGrid) -> Vec<u8> {
    let mut out = Vec::new();
    let matrix = match &grid.transform {
        Transform::Affine(matrix) => matrix.to_cols_array(),
        Transform::Frustum => [0.0; 16],
    };
    out.extend(matrix.iter().flat_map(|number| number.to_le_bytes()));
    match &grid.voxels {
        Voxels::Floats(blocks) => put_blocks(&mut out, blocks, |value| [*value]),
        Voxels::Vectors(blocks) => put_blocks(&mut out, blocks, |value| *value),
    }
    out
}

fn put_blocks<T, const N: usize>(out: &mut Vec<u8>, blocks: &SparseBlocks<T>, components: impl Fn(&T) -> [f32; N]) {
    let put_value = |out: &mut Vec<u8>, value: &T| out.extend(components(value).iter().flat_map(|c| c.to_le_bytes()));
    let put_origin = |out: &mut Vec<u8>, origin: glam::IVec3| {
        out.extend(origin.to_array().iter().flat_map(|along| along.to_le_bytes()));
    };
    put_value(out, &blocks.background);
    out.extend((blocks.origins.len() as u64).to_le_bytes());
    for ((origin, mask), values) in blocks.origins.iter().zip(&blocks.active).zip(&blocks.values) {
        put_origin(out, *origin);
        out.extend(mask.iter().flat_map(|word| word.to_le_bytes()));
        values.iter().for_each(|value| put_value(out, value));
    }
    out.extend((blocks.tiles.len() as u64).to_le_bytes());
    for tile in &blocks.tiles {
        put_origin(out, tile.origin);
        out.extend(tile.edge.to_le_bytes());
        out.extend(i32::from(tile.active).to_le_bytes());
        put_value(out, &tile.value);
    }
}

/// Compares what is read with what OpenVDB found, grid by grid.
fn check(contents: &Contents, expected: &[u8], name: &str) {
    let mut rest = expected;
    for grid in &contents.grids {
        let own = found(grid);
        let theirs = &rest[..own.len().min(rest.len())];
        let differs = own.iter().zip(theirs).position(|(own, theirs)| own != theirs);
        assert!(own == theirs, "{name}: grid '{}' differs from byte {differs:?} of {}", grid.name, own.len());
        rest = &rest[own.len()..];
    }
    assert!(rest.is_empty(), "{name}: {} bytes more", rest.len());
}

#[test]
fn every_kind_of_file_is_read_as_by_the_library() {
    let paths = files("vdb");
    assert_eq!(paths.len(), 7);
    for path in paths {
        let contents = read(&path).unwrap();
        assert_eq!((contents.grids.len(), contents.skipped.len()), (19, 2));
        check(&contents, &fs::read(path.with_extension("found")).unwrap(), &path.display().to_string());
    }
}

#[test]
fn all_formats_are_read_alike() {
    let path = FILES.path().join("blosc active.vdb");
    let (mut bytes, expected) = (fs::read(&path).unwrap(), fs::read(path.with_extension("found")).unwrap());
    for format in 222_u32..=225 {
        bytes[8..12].copy_from_slice(&format.to_le_bytes());
        let copy = tempfile::NamedTempFile::new().unwrap();
        fs::write(copy.path(), &bytes).unwrap();
        check(&read(copy.path()).unwrap(), &expected, &format.to_string());
    }
}

#[test]
fn chunks_of_any_blocks_are_decompressed() {
    let paths = files("chunk");
    assert_eq!(paths.len(), 5 * 6 * 4 * 2);
    for path in paths {
        let (chunk, bytes) = (fs::read(&path).unwrap(), fs::read(path.with_extension("bytes")).unwrap());
        let mut out = vec![0; bytes.len()];
        blosc::check(&chunk, out.len()).unwrap();
        assert!(
            blosc::decompress(&chunk, &mut Vec::new(), &mut out).is_ok_and(|()| out == bytes),
            "{}",
            path.display()
        );
    }
}

#[test]
fn a_chunk_of_another_codec_is_refused_by_its_name() {
    let path = FILES.path().join("blosc active.vdb");
    let mut bytes = fs::read(&path).unwrap();
    // The heads of all chunks: shuffled by LZ4, of values of four bytes.
    let heads: Vec<usize> =
        (0..bytes.len() - 4).filter(|at| matches!(bytes[*at..*at + 4], [2, 1, 0x21 | 0x31, 4])).collect();
    assert!(heads.len() > 100, "{}", heads.len());
    heads.iter().for_each(|at| bytes[at + 2] ^= (1 ^ 4) << 5);
    let error = |bytes: &[u8]| {
        let opened = Opened::from_bytes(bytes.to_vec(), Path::new("other.vdb")).unwrap();
        opened.grid(&opened.layout.grids[0]).unwrap_err()
    };
    let refused = error(&bytes);
    assert!(matches!(refused, Error::Unsupported { .. }), "{refused}");
    assert!(refused.to_string().contains("Zstandard"), "{refused}");
    heads.iter().for_each(|at| bytes[at + 2] = 0x25);
    assert!(error(&bytes).to_string().contains("bits"));
}
