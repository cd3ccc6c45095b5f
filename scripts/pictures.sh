#!/usr/bin/env bash
# Makes all pictures of the documentation anew, in docs/images: the program's own contact sheets, and those rendered in
# Blender (Cycles). Many minutes on two cores; what is baked for it stays in out/pictures.
set -euo pipefail
cd "$(dirname "$0")/.."

readonly folder=out/pictures images=docs/images
blender_python=${HFVDB_BLENDER_PYTHON:-.venv/bin/python}

scripts/install.sh --tests
cargo build --release --locked
rm -rf "$folder"
mkdir -p "$folder"/{cubism,hsv,rgb}
hfvdb() { target/release/hfvdb "$@" </dev/null; }
picture() { hfvdb preview --quality final "$@"; }
hfvdb bake cubism --output "$folder/cubism/cubism.####.vdb"
hfvdb bake cube-to-heart --resolution 160 --output "$folder/hsv/cube-to-heart.####.vdb"
hfvdb bake cube-to-heart --variant rgb --resolution 160 --output "$folder/rgb/cube-to-heart.####.vdb"

picture cubism --pictures 12 --output "$images/cubism.png"
picture cubism --slice z=0.1 --frames 24 --size 400 --output "$images/cubism-inside.png"
picture cube-to-heart --pictures 12 --size 170 --output "$images/cube-to-heart.png"
picture cube-to-heart --variant rgb --pictures 12 --size 170 --output "$images/cube-to-heart-rgb.png"
picture cube-to-heart --variant linear --pictures 12 --size 170 --output "$images/cube-to-heart-linear.png"
picture cube-to-heart --variant paper --pictures 12 --size 170 --output "$images/cube-to-heart-paper.png"
picture cube-to-heart --variant openvdb --pictures 12 --size 170 --output "$images/cube-to-heart-openvdb.png"
picture three-ways --pictures 12 --size 170 --output "$images/three-ways.png"
picture displacement --pictures 8 --output "$images/displacement.png"
picture microstructure --pictures 8 --output "$images/microstructure.png"
picture partitions --pictures 8 --output "$images/partitions.png"
picture octopus --pictures 8 --output "$images/octopus.png"
picture bat-to-robot --pictures 8 --output "$images/bat-to-robot.png"
picture wood-morph --pictures 8 --output "$images/wood-morph.png"
picture conformal-ell --size 480 --output "$images/conformal-ell.png"
picture boot --size 480 --view front --output "$images/boot.png"
for variant in air weights; do
    picture boot --variant "$variant" --size 480 --view front --output "$images/boot-$variant.png"
done
picture graded --size 480 --view front --output "$images/graded.png"
picture horn --size 480 --view front --output "$images/horn.png"
picture crawl --pictures 6 --output "$images/crawl.png"
picture in-turn --pictures 8 --columns 4 --output "$images/in-turn.png"
picture covid --size 480 --output "$images/covid.png"
for scene in bat treble-clef snowflake robot heart-slabs marble aitch; do
    hfvdb bake "$scene" --quiet --output "$folder/$scene.vdb"
done
hfvdb bake heart-slabs --variant sphere --quiet --output "$folder/sphere-slabs.vdb"
hfvdb bake marble --variant torus --quiet --output "$folder/marble-torus.vdb"
for variant in axis diffusion interior; do
    hfvdb bake aitch --variant "$variant" --quiet --output "$folder/aitch-$variant.vdb"
done
picture "$folder"/{bat,treble-clef,snowflake,robot}.vdb --columns 4 --size 240 --output "$images/flat.png"
picture "$folder"/{heart-slabs,sphere-slabs,marble,marble-torus,aitch,aitch-axis}.vdb --columns 3 --size 240 \
    --output "$images/grain.png"
picture "$folder"/aitch-{diffusion,interior}.vdb --view front --size 300 --output "$images/wood-inside.png"
picture red-blue --frames 7 --vary alpha=0.05,0.3,3 --vary beta=0.15,0.5,0.85 --output "$images/red-blue.png"
field() { picture bat --size 320 "$@"; }
outline() { field --set output.shape=outline --slice z=0 "$@"; }
picture star-inside --set output.shape=outline --slice z=0 --slice-of way --size 320 --output "$images/star-inside.png"
outline --slice-of f --output "$images/field-frep.png"
outline --slice-of distance --output "$images/field-sdf.png"
outline --set 'output.distance={ adf = 8 }' --slice-of distance --output "$images/field-adf.png"
field --set 'shape.bat.attribute.body={ diffusion = [[0, 0.4, 0]] }' --slice y=0 --slice-of body --output "$images/field-idf.png"
outline --set 'output.distance={ adf = 7, restore = "linear" }' --slice-of distance --output "$images/field-linear.png"
outline --set output.step=8 --slice-of distance --output "$images/field-step.png"
mkdir -p "$images/nodes" "$images/objects" "$folder/nodes"
for object in gears logo-text rock crowd wine-glass bottle chess-king bone rope coral; do
    picture "$object" --frames 1 --size 420 --output "$images/objects/$object.png"
done
for node in $(hfvdb scenes | sed -n 's/^Nodes, each as a scene of its own: //p'); do
    picture "$node" --size 240 --output "$images/nodes/$node.png"
    hfvdb bake "$node" --resolution 80 --quiet --overwrite --output "$folder/nodes/$node.vdb"
done
picture "$folder"/nodes/*.vdb --columns 12 --size 144 --output "$images/nodes.png"
"$blender_python" scripts/render_blender.py "$folder/cubism" --output "$images/blender-cubism.png"
"$blender_python" scripts/render_blender.py "$folder/hsv" "$folder/rgb" --pictures 6 \
    --output "$images/blender-cube-to-heart.png"
ls -l "$images"
