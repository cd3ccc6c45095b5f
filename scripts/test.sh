#!/usr/bin/env bash
# Everything that must hold before a change is merged; what the CI runs. Goes on after a failure, so that one run tells
# all; exits with 1 if any step failed.
set -uo pipefail
cd "$(dirname "$0")/.." || exit

readonly frames_folder=target/blender-check
summary=()
failed=0

# step NAME COMMAND...: runs the command, and keeps its result and time for the summary.
step() {
    local name=$1 start=$SECONDS result=ok
    shift
    printf '\n== %s\n' "$name"
    "$@" </dev/null || {
        result=FAILED
        failed=1
    }
    summary+=("$(printf '%-8s %5d s  %s' "$result" $((SECONDS - start)) "$name")")
}

finish() {
    printf '\n== summary\n'
    printf '%s\n' "${summary[@]}"
    exit "$failed"
}

# shellcheck disable=SC2317 # Called by `step`.
bake_for_blender() {
    rm -rf "$frames_folder"
    mkdir -p "$frames_folder"
    # Around the middle of the morphs, where shapes and colours are furthest from both ends. The profile is that of the
    # tests, whose dependencies are built already.
    local scene
    for scene in cubism cube-to-heart; do
        cargo run --locked --profile test --quiet -- \
            bake "$scene" --resolution 128 --frames 12-21 --output "$frames_folder/$scene.####.vdb" || return
    done
}

step "install" scripts/install.sh --tests
[ "$failed" -eq 0 ] || finish
step "format" cargo fmt --check
step "lint" cargo clippy --locked --all-targets -- -D warnings
step "tests" cargo test --locked
step "bake ten frames of two morphs" bake_for_blender
for scene in cubism cube-to-heart; do
    step "open $scene in Blender" "${HFVDB_BLENDER_PYTHON:-.venv/bin/python}" scripts/check_blender.py \
        "$frames_folder/$scene".00{12..21}.vdb --sequence
done
finish
