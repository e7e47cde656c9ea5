#!/usr/bin/env bash
# Renders what README.md and graphs/README.md show: stills at half size, animated previews, scenes in their second
# palettes, trees of the graphs, a page, the editor.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
trochoid=${CARGO_TARGET_DIR:-target}/release/trochoid

still() { "$trochoid" preview "graphs/$1.json" --output beauty --frames "$2" --shrink "${3:-2}" --overwrite -o "samples/$1.png"; }
moving() { "$trochoid" preview "graphs/$1.json" --frames "$2" --shrink 4 --quality 78 --overwrite -o "samples/$1.webp"; }
recolored() {
  "$trochoid" preview "graphs/$1.json" --palette "graphs/palettes/$1_$2.json" --frames "$3" --shrink "${4:-3}" \
    --quality 88 --overwrite -o "samples/palettes/$1_$2.webp"
}
tree() { "$trochoid" graph "graphs/$1.json" --overwrite -o "graphs/trees/$1.svg"; }

still stormy_sea 36
still stormy_sea_bare 36
still open_sea 1
still great_wave 33
still toon_sea 48
still cartoon_bay 48
still toon_teapot 4
still from_passes 1
still glow 25 1

moving stormy_sea 1-96x2
moving great_wave 1-48
moving toon_sea 1-96x2
moving cartoon_bay 1-96x3
moving toon_teapot 1-48

recolored stormy_sea night 29
recolored great_wave autumn 33
recolored cartoon_bay sunset 48
recolored toon_sea night 48
recolored toon_teapot copper 4
recolored from_passes moonlight 1
recolored open_sea morning 1
recolored glow ember 25 1
recolored hooks dawn 25 1
recolored two_seas dusk 1 1
recolored cartoon_water winter 48 1
recolored noise_and_shapes night 1 1
recolored spray summer 41 1
recolored wave_group aurora 49 1
recolored toon_lines evening 25 1
recolored toon_bursts blossom 48 1
recolored buoys fog 25 1
recolored toon_teapot_plain delft 1 1
recolored painted_normals gold 1 1
recolored bake_sea lagoon 25 1

for scene in stormy_sea stormy_sea_bare great_wave toon_sea cartoon_bay toon_teapot from_passes open_sea; do
  tree "$scene"
done

# A page of a recipe, as a browser shows it.
"$trochoid" decompose samples/great_wave.png --palette graphs/great_wave.json --overwrite -o out/great_wave.exr
"$trochoid" page out/great_wave.exr --palette graphs/palettes/great_wave_autumn.json --title 'The great wave' \
  --overwrite -o out/great_wave.html
TROCHOID=$trochoid .ci/page picture out/great_wave.html samples/page_great_wave.png

# The editor is drawn without a window, but not without a graphics driver.
cargo run --release -p trochoid-editor --features snapshots --example screenshots -- samples
