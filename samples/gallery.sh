#!/usr/bin/env bash
# Renders what README.md and graphs/README.md show: stills at half size, animated previews, trees of the graphs, the editor.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release
trochoid=${CARGO_TARGET_DIR:-target}/release/trochoid

still() { "$trochoid" preview "graphs/$1.json" --output beauty --frames "$2" --shrink "${3:-2}" --overwrite -o "samples/$1.png"; }
moving() { "$trochoid" preview "graphs/$1.json" --frames "$2" --shrink 4 --quality 78 --overwrite -o "samples/$1.webp"; }
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

for scene in stormy_sea stormy_sea_bare great_wave toon_sea cartoon_bay toon_teapot from_passes open_sea; do
  tree "$scene"
done

# The editor is drawn without a window, but not without a graphics driver.
cargo run --release -p trochoid-editor --features snapshots --example screenshots -- samples
