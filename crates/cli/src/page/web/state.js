// What the page shows. Changes go through these functions, which tell the listeners.

const facts = JSON.parse(document.getElementById("data").textContent);
const find = id => document.getElementById(id);

const state = {
  picture: 0,
  frame: 0,
  // Index of the color that the editor shows.
  selected: 0,
  // Changed colors by name, as displayed. They hold in all pictures that have the name.
  edits: new Map(),
  // Name of the palette from which the edits started.
  palette: null,
};

const listeners = { picture: [], frame: [], colors: [], selected: [] };
const on = (what, listener) => listeners[what].push(listener);
const tell = what => listeners[what].forEach(listener => listener());

const picture = () => facts.pictures[state.picture];

// Colors of the picture as it was made, at the frame that is shown.
const originals = (frame = state.frame) => picture().frames[frame].colors ?? picture().colors;
// Colors as they are painted: { shown, exact }, as the page's facts have them.
const colors = () => originals().map((color, index) => state.edits.get(picture().names[index]) ?? color);

const selectedName = () => picture().names[state.selected];

function setColor(index, rgb) {
  state.edits.set(picture().names[index], { shown: rgb.map(v => steps(v) / 255) });
  tell("colors");
}

function revert(index) {
  state.edits.delete(picture().names[index]);
  tell("colors");
}

// While the pointer drags the chosen color: what it was before, and what ends the drag.
let dragged = null;

function beginDrag(end) {
  const name = selectedName();
  dragged = { name, before: state.edits.get(name), end };
}

// Escape puts a dragged color back.
addEventListener("keydown", event => {
  if (event.key !== "Escape" || !dragged) return;
  const { name, before, end } = dragged;
  dragged = null;
  if (before) state.edits.set(name, before);
  else state.edits.delete(name);
  end();
  tell("colors");
});

// Starts from a palette, or from the original without one.
function choosePalette(palette) {
  state.edits = new Map((palette?.colors ?? []).map(({ name, color }) => [name, color]));
  state.palette = palette;
  tell("colors");
}

function select(index) {
  state.selected = index;
  tell("selected");
}

function showFrame(index) {
  const before = originals();
  state.frame = index;
  tell("frame");
  // Keyed colors are others in each frame.
  if (originals() !== before) tell("colors");
}

function showPicture(index) {
  const name = selectedName();
  Object.assign(state, { picture: index, frame: 0 });
  state.selected = Math.max(picture().names.indexOf(name), 0);
  tell("picture");
}

// Says something to those who do not see the page; only the last of many things at once.
let saying = 0;
function say(text) {
  clearTimeout(saying);
  saying = setTimeout(() => { find("said").textContent = text; }, 400);
}

const percent = share => share < 0.0005 ? "< 0.1 %" : `${(100 * share).toFixed(share < 0.0995 ? 1 : 0)} %`;
// Names in files are written with underscores.
const worded = name => name.replaceAll("_", " ");

function described(index) {
  const { shown } = colors()[index];
  const [l, c, h] = lchOf(shown);
  return `${worded(picture().names[index])}, ${hexOf(shown)}, lightness ${Math.round(100 * l)} percent, ` +
    `chroma ${c.toFixed(2)}, hue ${Math.round(h)} degrees`;
}
