#!/usr/bin/env bash
# Kills bakes at random moments and looks at what they leave: no broken file under a final name, no finished frame baked
# again, nothing left after the next run.
#
#   scripts/kill-test.sh              1000 kills
#   scripts/kill-test.sh COUNT SEED   so many, at the moments of that seed
set -euo pipefail
cd "$(dirname "$0")/.."

HFVDB_KILLS=${1:-1000} HFVDB_KILL_SEED=${2:-1} cargo test --locked --all-features --test kill -- --nocapture
