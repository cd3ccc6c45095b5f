#!/usr/bin/env bash
# Measures everything that docs/performance.md states, three times, and writes that page anew. On a machine with nothing
# else running: about an hour on two cores, 16 GB of memory. The logs stay in target/performance.
#
#     scripts/performance.sh              measures, then writes the page
#     scripts/performance.sh --page       writes the page from the logs that are there
set -euo pipefail
# Every run measures for itself.
export HFVDB_CACHE=
cd "$(dirname "$0")/.."

readonly logs=target/performance
readonly runs=3
readonly benches=(band evaluate leaves sparse redistance handover frames morphing meshes stages bound)

# program NAME ARGUMENTS...: a line with seconds by the clock, of the processor, and peak memory in bytes; and a line with
# the most memory in use in each tenth of the time.
program() {
    python3 -c '
import os, subprocess, sys, time
name, *command = sys.argv[1:]
page = os.sysconf("SC_PAGE_SIZE")
start = time.monotonic()
process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
samples = []
while True:
    done, status, used = os.wait4(process.pid, os.WNOHANG)
    if done:
        break
    with open(f"/proc/{process.pid}/statm") as statm:
        samples.append((time.monotonic() - start, int(statm.read().split()[1]) * page))
    time.sleep(0.05)
if status != 0:
    sys.exit(f"performance: {command} failed")
seconds = time.monotonic() - start
print("PROGRAM", name, f"{seconds:.1f} {used.ru_utime + used.ru_stime:.1f} {used.ru_maxrss * 1024}")
tenths = [[memory for at, memory in samples if tenth <= 10 * at / seconds < tenth + 1] for tenth in range(10)]
print("MEMORY", name, *(max(tenth) for tenth in tenths))
' "$@"
}

measure() {
    local run bench
    cargo build --release --locked --bin hfvdb
    cargo build --release --locked --benches --package hfvdb-bench
    mkdir -p "$logs"
    rm -f "$logs"/*.txt
    for ((run = 1; run <= runs; run++)); do
        scripts/performance.py --machine >>"$logs/$run.txt"
        for bench in "${benches[@]}"; do
            printf '== run %d of %d: %s\n' "$run" "$runs" "$bench"
            cargo bench --quiet --locked --package hfvdb-bench --bench "$bench" | tee -a "$logs/$run.txt"
        done
    done
    cargo bench --quiet --locked --package hfvdb-bench --bench growth | tee -a "$logs/1.txt"
    program cubism-256 target/release/hfvdb bake cubism --output "$logs/m.####.vdb" --overwrite | tee -a "$logs/1.txt"
    program cubism-1024 target/release/hfvdb bake cubism --resolution 1024 --frames 24 --output "$logs/one.vdb" --overwrite \
        | tee -a "$logs/1.txt"
    rm -f "$logs"/*.vdb
}

case "${1:-}" in
    "") measure ;;
    --page) ;;
    *)
        echo "usage: scripts/performance.sh [--page]" >&2
        exit 2
        ;;
esac
scripts/performance.py "$logs"/*.txt >docs/performance.md.new
mv docs/performance.md.new docs/performance.md
