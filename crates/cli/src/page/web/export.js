// What can be saved: the palette, the picture, and a 3D LUT where the picture is a function of its colors.

const fileName = ending => `${facts.title.replace(/[^\p{L}\p{N}]+/gu, "_").replace(/^_|_$/g, "") || "palette"}.${ending}`;

function save(blob, ending) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: fileName(ending) });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  say(`Saved ${link.download}`);
}

function paletteJson() {
  const named = colors().map((color, index) => [picture().names[index], color.exact ?? hexOf(color.shown)]);
  const palette = { trochoid_palette: 1, working_space: facts.space, palette: Object.fromEntries(named) };
  return JSON.stringify(palette, null, 2) + "\n";
}

// GIMP, Krita and Inkscape hold colors of 8 bits.
function paletteGpl() {
  const line = ({ shown }, index) =>
    shown.map(v => String(steps(v)).padStart(3)).join(" ") + "\t" + picture().names[index].replace(/\s/g, " ");
  const head = ["GIMP Palette", `Name: ${facts.title.replace(/\s/g, " ")}`, `Columns: ${colors().length}`, `# Trochoid ${facts.version}`];
  return [...head, ...colors().map(line)].join("\n") + "\n";
}

// A table from old colors to new ones, both as displayed; red changes fastest.
async function cube() {
  const side = 33;
  const lattice = await decodeBlock(`cube-${state.picture}`, picture().names.length, side ** 3);
  const now = colors().map(color => color.shown);
  const nodes = Array.from(lattice.places, place => [0, 1, 2].map(channel => {
    const sum = now.reduce((sum, rgb, color) => sum + lattice.weights[color * lattice.mixes + place] * rgb[channel], 0);
    return clamp(sum / 65280, 0, 1).toFixed(6);
  }).join(" "));
  return [`TITLE "${facts.title.replace(/["\s]/g, " ")}"`, `LUT_3D_SIZE ${side}`, ...nodes].join("\n") + "\n";
}

const text = content => new Blob([content], { type: "text/plain" });
const savers = {
  json: () => save(new Blob([paletteJson()], { type: "application/json" }), "json"),
  gpl: () => save(text(paletteGpl()), "gpl"),
  cube: async () => save(text(await cube()), "cube"),
  // The whole picture in the new colors, without the divider.
  png: () => {
    surface.painter.paint(0);
    surface.canvas.toBlob(blob => save(blob, "png"));
    repaint(false);
  },
};
for (const button of document.querySelectorAll("[data-save]")) {
  button.addEventListener("click", () => savers[button.dataset.save]());
}
on("picture", () => { find("save-cube").hidden = !picture().hasCube; });
