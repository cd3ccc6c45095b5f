#!/usr/bin/env bash
# Whether the program writes the same voxels as at a commit, bit for bit: all built-in scenes and their variants, all
# frames, both builds. Files are compared as a whole but for OpenVDB's random identifier. Exits with 1 where any differs.
#
#     scripts/same-voxels.sh COMMIT|PROGRAM [RESOLUTION]
#
# 128 voxels without RESOLUTION: a quarter of an hour on two cores. The commit's build is kept in target/guard, its frames
# in target/same. PROGRAM stands for a build of the commit that is there already.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/program_of.sh

readonly resolution=${2:-128}
[ $# -ge 1 ] || { echo "usage: scripts/same-voxels.sh COMMIT|PROGRAM [RESOLUTION]" >&2; exit 2; }

if [ -x "$1" ]; then before=$1; else before=$(program_of "$1"); fi
cargo build --release --locked --quiet --bin hfvdb

# bake_all PROGRAM FOLDER
bake_all() {
    local name variant variants
    mkdir -p "$2"
    for name in $("$1" scenes --quiet | awk 'NF == 0 { exit } { print $1 }'); do
        variants=$("$1" scenes "$name" | sed -n 's/^\[variants\?\.\([a-z0-9-]*\).*/\1/p' | sort -u)
        for variant in "" $variants; do
            "$1" bake "$name" ${variant:+--variant "$variant"} --resolution "$resolution" --quiet --overwrite \
                --output "$2/$name${variant:+-$variant}.####.vdb" >/dev/null
        done
    done
}

folder=target/same/$(sha256sum "$before" | cut -c1-16)-$resolution
if [ ! -e "$folder/done" ]; then
    bake_all "$before" "$folder"
    touch "$folder/done"
fi
rm -rf target/same/now
bake_all target/release/hfvdb target/same/now

python3 - "$folder" target/same/now <<'EOF'
import pathlib
import sys

before, now = (pathlib.Path(folder) for folder in sys.argv[1:])
names = [{path.name for path in folder.glob("*.vdb")} for folder in (before, now)]
bad = sorted(names[0] ^ names[1])
for name in sorted(names[0] & names[1]):
    # The identifier stands in the bytes 21 to 56.
    one, other = (bytearray((folder / name).read_bytes()) for folder in (before, now))
    one[21:57] = other[21:57] = b""
    if one != other:
        bad.append(name)
print(f"{len(names[0] & names[1])} files compared, {len(bad)} differ", *bad[:20])
sys.exit(bool(bad))
EOF
