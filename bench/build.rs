//! Builds what the benches compare with, in C++.

use std::env;

const BRIDGE: &str = "src/rivals.rs";
const SOURCES: [&str; 3] = ["cpp/rivals.cpp", "cpp/rivals_distance.cpp", "cpp/rivals_mesh.cpp"];

fn main() {
    for file in SOURCES.iter().chain(&["build.rs", "cpp/rivals.h", BRIDGE]) {
        println!("cargo::rerun-if-changed={file}");
    }
    let mut build = cxx_build::bridge(BRIDGE);
    // Where the library found OpenVDB's headers; it links OpenVDB, too.
    for flag in env::var("DEP_HFVDB_BORDER_INCLUDES").unwrap_or_default().split_whitespace() {
        build.flag(flag);
    }
    build.files(SOURCES).include("cpp").std("c++17").opt_level(3).debug(false).define("NDEBUG", None);
    build.flag("-ffp-contract=off").compile("hfvdb-rivals");
}
