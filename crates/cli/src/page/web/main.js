// Puts the page together.

if (!window.DecompressionStream || !Array.prototype.with) {
  find("wait").textContent = "This page needs a browser of 2023 or later.";
  return;
}

function updateFacts() {
  const { width, height, frames, names, name } = picture();
  const parts = [`${names.length} colors`, `${width} × ${height}`];
  if (facts.pictures.length > 1) parts.unshift(worded(name));
  if (frames.length > 1) parts.push(`${frames.length} frames`);
  find("facts").textContent = parts.join("  ·  ");
  find("swatches").classList.toggle("many", names.length > 16);
  find("promise").textContent =
    `Every pixel is a mix of these ${names.length} colors, so nothing can appear that does not lie between them.`;
}

// The palettes to start from; what was changed since is told apart.
function updatePalettes() {
  const isStart = picture().names.every(name => {
    const color = state.palette?.colors.find(color => color.name === name)?.color;
    return (state.edits.get(name) ?? null) === (color ?? null);
  });
  const choose = find("palettes");
  choose.options[0].textContent = facts.palettes.length ? "Original" : "Original colors";
  choose.value = state.palette ? facts.palettes.indexOf(state.palette) : -1;
  const option = choose.selectedOptions[0];
  for (const other of choose.options) other.textContent = other.textContent.replace(/ \*$/, "");
  if (!isStart && option) option.textContent += " *";
  find("reset").disabled = isStart;
  find("tag-after").textContent = isStart && state.palette ? worded(state.palette.name) : "Yours";
}

function offer(select, names, chosen) {
  select.replaceChildren(...names.map(([value, text]) => new Option(text, value)));
  select.addEventListener("change", () => chosen(Number(select.value)));
}

offer(find("palettes"), [[-1, "Original"], ...facts.palettes.map(({ name }, index) => [index, worded(name)])], index => {
  choosePalette(facts.palettes[index] ?? null);
  say(index < 0 ? "The original colors" : `Palette ${worded(facts.palettes[index].name)}`);
});
offer(find("pictures"), facts.pictures.map(({ name }, index) => [index, worded(name)]), showPicture);
find("pictures-label").hidden = facts.pictures.length < 2;
find("reset").addEventListener("click", () => {
  choosePalette(state.palette);
  say("All changes are undone");
});

on("picture", updateFacts);
for (const what of ["picture", "colors"]) on(what, updatePalettes);
tell("picture");
