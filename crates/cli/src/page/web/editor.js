// The editor of the chosen color: lightness, chroma and hue (OKLCh), a field of the first two, and its hex number.

// Largest chroma that the editor offers; sRGB has no more.
const MOST_CHROMA = 0.33;
const sliders = ["l", "c", "h"].map(find);

// What is asked for: it keeps the hue of grays, and chroma that the display lacks at some lightness.
let wanted = [0, 0, 0];

// Shortest time between two drawings of the editor while a color changes, in milliseconds: the picture comes first.
const PAUSE = 80;
let following = 0;

function followSoon() {
  following ||= setTimeout(() => {
    following = 0;
    follow();
  }, PAUSE);
}

// Takes over the chosen color, unless it is what the editor itself made of what is asked for.
function follow() {
  const { shown } = colors()[state.selected];
  if (hexOf(fitted(wanted).rgb) !== hexOf(shown)) {
    const [l, c, h] = lchOf(shown);
    wanted = [l, c, c < 0.002 ? wanted[2] : h];
  }
  updateEditor();
}

function updateEditor() {
  const { shown } = colors()[state.selected];
  find("editing").textContent = worded(selectedName());
  find("editor").setAttribute("aria-label", `Color ${worded(selectedName())}`);
  find("editor").style.setProperty("--color", hexOf(shown));
  if (document.activeElement !== find("hex")) find("hex").value = hexOf(shown);
  find("hex").removeAttribute("aria-invalid");
  find("revert").disabled = !state.edits.has(selectedName());
  const texts = [`${Math.round(100 * wanted[0])} %`, wanted[1].toFixed(3), `${Math.round(wanted[2]) % 360}°`];
  sliders.forEach((slider, at) => {
    slider.value = wanted[at];
    slider.setAttribute("aria-valuetext", texts[at]);
    slider.nextElementSibling.textContent = texts[at];
    slider.style.setProperty("--track", track(at, Number(slider.max)));
  });
  const there = fitted(wanted).lch[1];
  const lacks = wanted[1] > there + 0.004;
  find("gamut").textContent = lacks ?
    `At this lightness and hue, sRGB has no chroma above ${there.toFixed(3)}: that is painted.` : "";
  updateField();
}

// The colors along a slider; empty where the display has none.
function track(at, max) {
  const stops = Array.from({ length: 25 }, (_, index) => {
    const lch = wanted.with(at, index / 24 * max);
    if (at === 1) return isShown(rgbOf(lch)) ? hexOf(rgbOf(lch)) : "transparent";
    return hexOf(fitted(lch).rgb);
  });
  return `linear-gradient(to right, ${stops.join()})`;
}

const canvas = find("field").querySelector("canvas");
let fieldHue = null;

function updateField() {
  const mark = find("field").querySelector("span");
  mark.style.left = `${100 * clamp(fitted(wanted).lch[1] / MOST_CHROMA, 0, 1)}%`;
  mark.style.top = `${100 * (1 - wanted[0])}%`;
  if (fieldHue === wanted[2]) return;
  fieldHue = wanted[2];
  const context = canvas.getContext("2d");
  const image = context.createImageData(canvas.width, canvas.height);
  const perPixel = MOST_CHROMA / canvas.width;
  for (let y = 0; y < canvas.height; y++) {
    const l = 1 - (y + 0.5) / canvas.height;
    const edge = fitted([l, MOST_CHROMA, fieldHue]).lch[1] / perPixel;
    for (let x = 0; x < edge; x++) {
      const rgb = rgbOf([l, Math.min(x + 0.5, edge) * perPixel, fieldHue]);
      image.data.set([...rgb.map(steps), 255 * Math.min(edge - x, 1)], 4 * (y * canvas.width + x));
    }
  }
  context.putImageData(image, 0, 0);
}

function ask(lch) {
  wanted = lch;
  setColor(state.selected, fitted(wanted).rgb);
  updateField();
  say(described(state.selected));
}

sliders.forEach((slider, at) => slider.addEventListener("input", () => ask(wanted.with(at, Number(slider.value)))));

find("hex").addEventListener("input", () => {
  const rgb = parseHex(find("hex").value);
  find("hex").setAttribute("aria-invalid", !rgb);
  if (rgb && find("hex").value.replace("#", "").trim().length === 6) setColor(state.selected, rgb);
});
find("hex").addEventListener("change", () => {
  const rgb = parseHex(find("hex").value);
  if (rgb) setColor(state.selected, rgb);
  find("hex").value = hexOf(colors()[state.selected].shown);
  find("hex").removeAttribute("aria-invalid");
  say(rgb ? described(state.selected) : "That is no color. Write six digits, such as #f2c14e.");
});
find("revert").addEventListener("click", () => {
  revert(state.selected);
  say(described(state.selected));
});

// Dragging in the field sets lightness and chroma, as the sliders do.
function fromField(event) {
  const box = find("field").getBoundingClientRect();
  const [x, y] = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  ask([1 - clamp(y, 0, 1), clamp(x, 0, 1) * MOST_CHROMA, wanted[2]]);
}
find("field").addEventListener("pointerdown", event => {
  find("field").setPointerCapture(event.pointerId);
  beginDrag(() => find("field").releasePointerCapture(event.pointerId));
  fromField(event);
});
find("field").addEventListener("lostpointercapture", () => { dragged = null; });
find("field").addEventListener("pointermove", event => {
  if (find("field").hasPointerCapture(event.pointerId)) fromField(event);
});

for (const what of ["picture", "selected"]) on(what, follow);
on("colors", followSoon);
