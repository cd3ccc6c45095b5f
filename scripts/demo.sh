#!/usr/bin/env bash
# From a fresh checkout to a baked morph: installs, builds, bakes the built-in scene `cubism`, makes its contact sheet.
#
#   scripts/demo.sh              the scene's 48 frames, 256 voxels along its longest side
#   scripts/demo.sh OPTION...    options for `hfvdb bake`, such as --resolution 128 or --frames 1-48x4
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install.sh
cargo build --release --locked
mkdir -p out
frames=$(target/release/hfvdb bake cubism --output 'out/cubism.####.vdb' --overwrite "$@")
# One path a line, and no blanks in them.
# shellcheck disable=SC2086
target/release/hfvdb preview $frames --output out/cubism.png --pictures 12 >/dev/null

cat <<END

Done.
  $PWD/out/cubism.####.vdb    one file a frame: surface (signed distance) and Cd (colour)
  $PWD/out/cubism.png         a contact sheet of the morph

Next: open the frames in Blender (README.md, "Open it in Blender"), or make the scene your own:
  target/release/hfvdb scenes cubism > mine.toml
  target/release/hfvdb bake mine.toml --output 'out/mine.####.vdb'
END
