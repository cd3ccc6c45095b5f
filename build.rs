//! Builds the C++ side of the OpenVDB border and links the library.

use std::env;
use std::path::{Path, PathBuf};

/// The C++ sources, and the headers among them.
const SOURCES: [&str; 4] = ["cpp/build.cpp", "cpp/encode.cpp", "cpp/morph.cpp", "cpp/nano.cpp"];
const HEADERS: [&str; 2] = ["cpp/border.h", "cpp/grids.h"];
const BRIDGE: &str = "src/vdb/bridge.rs";
/// Where a system's headers stand when `OPENVDB_ROOT` names no other place.
const ROOTS: [&str; 2] = ["/usr", "/usr/local"];

fn main() {
    let root = env::var_os("OPENVDB_ROOT").map(PathBuf::from);
    println!("cargo::rerun-if-env-changed=OPENVDB_ROOT");
    for file in SOURCES.iter().chain(&HEADERS).chain([&"build.rs", &BRIDGE]) {
        println!("cargo::rerun-if-changed={file}");
    }

    let (root, version) = find_openvdb(root.as_deref()).unwrap_or_else(|message| fail(&message));
    println!("cargo::rerun-if-changed={}", version_header(&root).display());
    let includes: Vec<PathBuf> = [("tbb", "libtbb-dev"), ("Imath", "libimath-dev")]
        .into_iter()
        .flat_map(|(name, package)| probe(name, package).unwrap_or_else(|message| fail(&message)))
        .collect();
    if ![root.as_path(), Path::new("/usr")].iter().any(|root| root.join("include/boost/uuid/uuid.hpp").exists()) {
        fail("OpenVDB's headers need Boost's, which are missing: install the Debian package libboost-dev");
    }

    let nano = [root.as_path(), Path::new("/usr")].map(|root| root.join("include/nanovdb/util/OpenToNanoVDB.h"));
    nano.iter().for_each(|header| println!("cargo::rerun-if-changed={}", header.display()));
    if !(version.starts_with("10.") && nano.iter().any(|header| header.exists())) {
        println!(
            "cargo::warning=no NanoVDB of OpenVDB 10 here, so .nvdb will not be written: install the Debian package \
             libnanovdb-dev"
        );
    }

    let mut build = cxx_build::bridge(BRIDGE);
    let mut flags = Vec::new();
    if root != Path::new("/usr") {
        flags.push(format!("-isystem{}", root.join("include").display()));
        println!("cargo::rustc-link-search=native={}", root.join("lib").display());
    }
    // Naming the compiler's own folder a second time would hide the C headers from the C++ ones.
    let others = includes.iter().filter(|include| include.as_path() != Path::new("/usr/include"));
    flags.extend(others.map(|include| format!("-isystem{}", include.display())));
    flags.iter().for_each(|flag| _ = build.flag(flag));
    println!("cargo::metadata=includes={}", flags.join(" "));
    println!("cargo::rustc-env=HFVDB_OPENVDB_HEADER_VERSION={version}");
    if lints() {
        return;
    }
    // Always optimised: a debug build of OpenVDB's templates is tens of times slower. No assertions: they would end
    // the process where an error is wanted. No contraction: the same bits on every machine.
    build
        .files(SOURCES)
        .include("cpp")
        .std("c++17")
        .opt_level(3)
        .debug(false)
        .define("NDEBUG", None)
        .flag("-ffp-contract=off")
        .warnings(true)
        .extra_warnings(true)
        .compile("hfvdb-border");
    // Blosc and zlib compress the grids of NanoVDB, which is headers alone.
    for library in ["openvdb", "blosc", "z"] {
        println!("cargo::rustc-link-lib={library}");
    }
}

/// Whether this is for `cargo clippy`, which links nothing, so that it needs no C++ compiled.
fn lints() -> bool {
    let wrapper = env::var_os("RUSTC_WORKSPACE_WRAPPER");
    wrapper.is_some_and(|wrapper| Path::new(&wrapper).file_stem().is_some_and(|name| name == "clippy-driver"))
}

/// Ends the build with a message and no backtrace.
fn fail(message: &str) -> ! {
    println!("cargo::error={}", message.replace('\n', " "));
    std::process::exit(1);
}

fn version_header(root: &Path) -> PathBuf {
    root.join("include/openvdb/version.h")
}

/// The folder that holds `include/openvdb`, and the version its header states.
fn find_openvdb(named: Option<&Path>) -> Result<(PathBuf, String), String> {
    let candidates: Vec<PathBuf> = match named {
        Some(root) => vec![root.to_path_buf()],
        None => ROOTS.iter().map(PathBuf::from).collect(),
    };
    let Some(root) = candidates.iter().find(|root| version_header(root).exists()) else {
        let looked: Vec<String> = candidates.iter().map(|root| version_header(root).display().to_string()).collect();
        return Err(format!(
            "OpenVDB's headers are missing (looked for {}): install the Debian package libopenvdb-dev, \
             or set OPENVDB_ROOT to the folder that holds include/openvdb",
            looked.join(", ")
        ));
    };
    let header = version_header(root);
    let text = std::fs::read_to_string(&header).map_err(|error| format!("{}: {error}", header.display()))?;
    let part = |name: &str| {
        let line =
            text.lines().find(|line| line.starts_with(&format!("#define OPENVDB_LIBRARY_{name}_VERSION_NUMBER")));
        line.and_then(|line| line.split_whitespace().nth(2)).and_then(|number| number.parse::<u32>().ok())
    };
    let (Some(major), Some(minor), Some(patch)) = (part("MAJOR"), part("MINOR"), part("PATCH")) else {
        return Err(format!("{} states no version: reinstall the Debian package libopenvdb-dev", header.display()));
    };
    if !(10..=12).contains(&major) {
        return Err(format!(
            "{} is of OpenVDB {major}.{minor}.{patch}, and hfvdb needs 10, 11 or 12, the versions that write file \
             format 224: install the Debian package libopenvdb-dev, or set OPENVDB_ROOT to another OpenVDB",
            header.display()
        ));
    }
    Ok((root.clone(), format!("{major}.{minor}.{patch}")))
}

/// A library that has a pkg-config file: links it and gives its include folders.
fn probe(name: &str, package: &str) -> Result<Vec<PathBuf>, String> {
    match pkg_config::Config::new().probe(name) {
        Ok(library) => Ok(library.include_paths),
        Err(pkg_config::Error::Command { .. }) => {
            Err("pkg-config does not run: install the Debian package pkg-config".into())
        }
        Err(_) => Err(format!("pkg-config does not find {name}: install the Debian package {package}")),
    }
}
