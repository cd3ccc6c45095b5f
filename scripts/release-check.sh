#!/usr/bin/env bash
# What is run before a release, beyond scripts/test.sh: every built-in scene in full, at 256 voxels, by the release
# build; each file read by OpenVDB's Python module, and each sequence opened in Blender. Takes minutes to an hour.
set -euo pipefail
cd "$(dirname "$0")/.."

readonly folder=out/release-check
blender_python=${HFVDB_BLENDER_PYTHON:-.venv/bin/python}

scripts/install.sh --tests
cargo build --release --locked
# Damaged files of every kind, 300 variants of each of 27: 8,100. What fails is kept in target/damage.
HFVDB_DAMAGE=300 HFVDB_DAMAGE_SEED="${RANDOM}" cargo test --locked --all-features --lib damaged_files_end_in_words
rm -rf "$folder"
mkdir -p "$folder"
scene=
trap 'echo "release-check: scene $scene is not good; what was found stands above" >&2' ERR
for file in scenes/*.toml; do
    scene=$(basename "$file" .toml)
    printf '\n== %s\n' "$scene"
    mkdir "$folder/$scene"
    target/release/hfvdb bake "$scene" --resolution 256 --output "$folder/$scene/$scene.####.vdb" >/dev/null </dev/null
    frames=("$folder/$scene"/*.vdb)
    /usr/bin/python3 tests/check_frames.py "${frames[@]}"
    sequence=()
    [ ${#frames[@]} -eq 1 ] || sequence=(--sequence)
    "$blender_python" scripts/check_blender.py "${frames[@]}" "${sequence[@]}"
    target/release/hfvdb preview "${frames[@]}" --output "$folder/$scene.png" </dev/null
done
printf '\nAll scenes are good. Look at the contact sheets: %s/*.png\n' "$PWD/$folder"
