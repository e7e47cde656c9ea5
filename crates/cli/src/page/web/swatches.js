// The palette: swatches that are chosen, and dragged to change them.

// Pixels that a pointer moves before it drags.
const SLACK = 4;
// What a pixel of dragging changes: lightness, chroma, hue in degrees.
const BY = [1 / 300, 1 / 1200, 0.6];

function buildSwatches() {
  const box = find("swatches");
  box.replaceChildren(...picture().names.map((name, index) => {
    const swatch = document.createElement("button");
    Object.assign(swatch, { type: "button", className: "swatch" });
    swatch.setAttribute("role", "radio");
    const chip = Object.assign(document.createElement("span"), { className: "chip" });
    chip.append(Object.assign(document.createElement("span"), { className: "was" }));
    const label = Object.assign(document.createElement("span"), { className: "name", textContent: worded(name) });
    const share = Object.assign(document.createElement("span"), { className: "share" });
    share.style.setProperty("--share", `${100 * picture().shares[index]}%`);
    swatch.append(chip, share, label);
    swatch.title = `${worded(name)}: ${percent(picture().shares[index])} of the picture`;
    swatch.addEventListener("click", () => select(index));
    swatch.addEventListener("keydown", event => moveFocus(event, index));
    draggable(swatch, index);
    return swatch;
  }));
  updateSwatches();
}

function updateSwatches() {
  const [now, was] = [colors(), originals()];
  [...find("swatches").children].forEach((swatch, index) => {
    const { shown } = now[index];
    const hex = hexOf(shown);
    // What does not change is not drawn again.
    const look = [hex, hexOf(was[index].shown), index === state.selected].join();
    if (swatch.dataset.look === look) return;
    swatch.dataset.look = look;
    const isChanged = hex !== hexOf(was[index].shown);
    const chosen = index === state.selected;
    swatch.style.setProperty("--color", hex);
    swatch.style.setProperty("--was", hexOf(was[index].shown));
    swatch.classList.toggle("changed", isChanged);
    swatch.classList.toggle("beyond", !isShown(shown));
    swatch.setAttribute("aria-checked", chosen);
    swatch.setAttribute("aria-label", `${worded(picture().names[index])}, ${hex}${isChanged ? ", changed" : ""}, ` +
      `${percent(picture().shares[index])} of the picture`);
    swatch.tabIndex = chosen ? 0 : -1;
  });
}

// Arrow keys choose the next color, Home and End the first and the last.
function moveFocus(event, index) {
  const count = picture().names.length;
  const to = {
    ArrowRight: index + 1, ArrowDown: index + 1, ArrowLeft: index - 1, ArrowUp: index - 1, Home: 0, End: count - 1,
  }[event.key];
  if (to === undefined) return;
  event.preventDefault();
  select((to + count) % count);
  find("swatches").children[state.selected].focus();
}

function draggable(swatch, index) {
  let start = null;
  swatch.addEventListener("pointerdown", event => {
    if (event.button !== 0) return;
    select(index);
    start = { x: event.clientX, y: event.clientY, lch: lchOf(colors()[index].shown), drags: false };
    swatch.setPointerCapture(event.pointerId);
    beginDrag(() => swatch.releasePointerCapture(event.pointerId));
  });
  swatch.addEventListener("pointermove", event => {
    if (!start) return;
    const [dx, dy] = [event.clientX - start.x, event.clientY - start.y];
    start.drags ||= Math.hypot(dx, dy) > SLACK;
    if (!start.drags) return;
    swatch.classList.add("dragged");
    const [l, c, h] = start.lch;
    const lightness = clamp(l - dy * BY[0], 0, 1);
    // A gray has no hue to turn: it gets some color first.
    const least = Math.min(Math.abs(dx) * BY[1], 0.06);
    setColor(index, fitted(event.shiftKey ?
      [lightness, Math.max(c + dx * BY[1], 0), h] : [lightness, Math.max(c, least), h + dx * BY[2]]).rgb);
  });
  const end = () => {
    if (start?.drags) say(described(index));
    start = dragged = null;
    swatch.classList.remove("dragged");
  };
  for (const kind of ["pointerup", "pointercancel", "lostpointercapture"]) swatch.addEventListener(kind, end);
}

// What may be wrong with the colors, in words. Mixes lie between the colors, so nothing else can be.
function warnings() {
  const names = picture().names.map(worded);
  const [now, was] = [colors(), originals()];
  const [labNow, labWas] = [now, was].map(of => of.map(color => oklab(color.shown)));
  const found = [];
  now.forEach(({ shown }, index) => {
    if (!isShown(shown)) {
      found.push(`${names[index]} lies outside of what an sRGB display shows: what is seen is cut off at its limits.`);
    }
    for (let other = 0; other < index; other++) {
      const isNear = of => Math.hypot(...of[index].map((v, at) => v - of[other][at])) < 0.02;
      if (isNear(labNow) && !isNear(labWas)) {
        found.push(`${names[other]} and ${names[index]} look alike now: what told them apart in the picture is lost.`);
      }
    }
  });
  return found;
}

function updateWarnings() {
  const found = warnings();
  const list = find("warnings");
  const old = [...list.children].map(item => item.textContent);
  const rest = found.length - 3;
  const texts = rest > 1 ? [...found.slice(0, 3), `And ${rest} more.`] : found;
  if (texts.join() === old.join()) return;
  list.replaceChildren(...texts.map(text => Object.assign(document.createElement("li"), { textContent: text })));
}

on("picture", buildSwatches);
for (const what of ["colors", "selected"]) on(what, updateSwatches);
for (const what of ["colors", "picture"]) on(what, updateWarnings);
