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
    # The middle of the morph, where shapes and colours are furthest from both ends. The profile is that of the tests,
    # whose dependencies are built already.
    cargo run --locked --profile test --quiet -- \
        bake cubism --resolution 128 --frames 20-29 --output "$frames_folder/cubism.####.vdb"
}

step "install" scripts/install.sh --tests
[ "$failed" -eq 0 ] || finish
step "format" cargo fmt --check
step "lint" cargo clippy --locked --all-targets -- -D warnings
step "tests" cargo test --locked
step "bake ten frames" bake_for_blender
step "open them in Blender" "${HFVDB_BLENDER_PYTHON:-.venv/bin/python}" scripts/check_blender.py \
    "$frames_folder"/cubism.00{20..29}.vdb --sequence
finish
