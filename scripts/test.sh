#!/usr/bin/env bash
# Everything that must hold before a change is merged; what the CI runs. Goes on after a failure, so that one run tells
# all; exits with 1 if any step failed.
set -uo pipefail
cd "$(dirname "$0")/.." || exit

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

step "install" scripts/install.sh --tests
[ "$failed" -eq 0 ] || finish
# Without it the tests in Blender would be skipped. (The step above would take it for a Blender that is there already.)
export HFVDB_BLENDER_PYTHON=${HFVDB_BLENDER_PYTHON:-$PWD/.venv/bin/python}
step "format" cargo fmt --all --check
# Those that macros declare, which the step above does not see.
step "format of rows" rustfmt --check --edition 2024 src/field/op/*.rs src/node/*/*.rs
# The benches too, and what they compare with.
step "lint" cargo clippy --locked --workspace --all-targets --all-features -- -D warnings
# The library alone, without the program and what only the program needs.
step "library" cargo clippy --locked --no-default-features --lib -- -D warnings
step "types of houdini_examples" .venv-houdini/bin/mypy --strict --cache-dir=.venv-houdini/cache houdini_examples/*.py
# With the same features as above, so that the C++ side is compiled once.
step "tests" cargo test --locked --all-features
finish
