#!/usr/bin/env bash
# Whether the program became slower since a commit: quick jobs, done by both builds in turns, pair by pair. What counts
# is processor time, so that other work on the machine counts little. A job became slower where the median of its
# ratios is above 1 by more than 3 % and by more than twice their median deviation; then this exits with 1.
#
#     scripts/bench-guard.sh COMMIT [ROUNDS]
#
# 5 rounds without ROUNDS: minutes after the builds, most of them cubism's. The commit's build is kept in target/guard
# for the next time.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/program_of.sh

readonly folder=$PWD/target/guard
readonly now=$folder/now frames=$folder/frames
readonly output=$frames/frame.####.vdb
readonly rounds=${2:-5}
# Scenes are this checkout's for both programs. A name, and what `hfvdb bake` gets.
readonly jobs=(
    "three at 256: bench/scenes/three.toml --resolution 256 --frames 1"
    "two_hundred at 256: bench/scenes/two_hundred.toml --resolution 256 --frames 1"
    "ball at 512, mostly written: bench/scenes/ball.toml --resolution 512 --frames 1"
    "morph at 96, mostly made ready: bench/scenes/sphere-to-cube.toml --resolution 96 --frames 12"
    "cubism at 128, a frame: scenes/cubism.toml --resolution 128 --frames 24"
    "places that wait: scenes/cube-to-heart.toml --variant late --resolution 128 --frames 10-14"
    "moved by a formula: scenes/displacement.toml --resolution 96 --frames 11-13"
)

fail() {
    printf 'bench-guard: %s\n' "$*" >&2
    exit 2
}

[ $# -ge 1 ] || fail "usage: scripts/bench-guard.sh COMMIT [ROUNDS]"
commit=$(git rev-parse --verify --quiet "$1^{commit}") || fail "there is no commit $1"

build() {
    before=$(program_of "$commit")
    cargo build --release --locked --quiet --bin hfvdb
    cp target/release/hfvdb "$now"
}

# bake PROGRAM ARGUMENTS...: prints the processor seconds.
bake() {
    local TIMEFORMAT='%U %S' program=$1
    shift
    { time "$program" bake "$@" --output "$output" --overwrite >/dev/null 2>&1 </dev/null; } 2>&1 \
        | awk '{ print $1 + $2 }'
}

# One ratio a line in; out their median, the least and the greatest, the noise allowed, and ok or SLOWER.
judge() {
    sort --numeric-sort | awk '
        function median(list, count) { return (list[int((count + 1) / 2)] + list[int(count / 2) + 1]) / 2 }
        { ratio[NR] = $1 }
        END {
            middle = median(ratio, NR)
            for (i = 1; i <= NR; i++) deviation[i] = ratio[i] > middle ? ratio[i] - middle : middle - ratio[i]
            # Ascending, as ratios are few.
            for (i = 2; i <= NR; i++)
                for (j = i; j > 1 && deviation[j] < deviation[j - 1]; j--) {
                    swap = deviation[j]; deviation[j] = deviation[j - 1]; deviation[j - 1] = swap
                }
            noise = 2 * median(deviation, NR)
            if (noise < 0.03) noise = 0.03
            printf "%.3f of the time (%.3f to %.3f, noise %.3f): %s\n", middle, ratio[1], ratio[NR], noise, \
                (middle > 1 + noise ? "SLOWER" : "ok")
        }'
}

# ratios ARGUMENTS...: now ÷ before, the first of a pair in turns.
ratios() {
    local round old new
    for ((round = 0; round < rounds; round++)); do
        if ((round % 2 == 0)); then
            old=$(bake "$before" "$@") && new=$(bake "$now" "$@")
        else
            new=$(bake "$now" "$@") && old=$(bake "$before" "$@")
        fi
        awk -v old="$old" -v new="$new" 'BEGIN { print new / old }'
    done
}

printf 'bench-guard: building %s and this checkout\n' "$(git log -1 --format='%h %s' "$commit")"
build
slower=0
SECONDS=0
for job in "${jobs[@]}"; do
    read -ra arguments <<<"${job#*: }"
    if ! "$before" bake "${arguments[@]}" --output "$output" --overwrite >/dev/null 2>&1 </dev/null; then
        printf '%s: the commit cannot do it\n' "${job%%: *}"
        continue
    fi
    verdict=$(ratios "${arguments[@]}" | judge)
    printf '%s: %s\n' "${job%%: *}" "$verdict"
    [[ $verdict != *SLOWER ]] || slower=1
done
rm -rf "$frames"
printf 'bench-guard: %d rounds took %d s\n' "$rounds" "$SECONDS"
exit "$slower"
