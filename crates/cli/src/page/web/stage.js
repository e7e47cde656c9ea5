// The picture: painting, comparing, and frames that play.

let surface = null;
// The frame that is painted: as decoded, with its tables.
let shown = null;
// Share of the width that shows the original.
let divided = 0;
let holds = false;
let isDirty = false;

// Paints as often as the display shows it, and no more.
function repaint(isNew = true) {
  if (shown && isNew) shown.isMixed = false;
  if (isDirty) return;
  isDirty = true;
  requestAnimationFrame(() => {
    isDirty = false;
    paint();
  });
}

function paint() {
  if (!shown) return;
  const { painter, canvas } = surface;
  if (!shown.isMixed) {
    painter.table("now", mix(shown.frame, colors().map(color => color.shown), facts.linear, shown.now));
    shown.isMixed = true;
  }
  painter.paint(holds ? canvas.width : Math.round(divided * canvas.width));
}

function openSurface(isLost = false) {
  const { width, height, name } = picture();
  surface?.canvas.remove();
  surface?.painter.close();
  surface = isLost ? plainPainter(width, height) : painterOf(width, height, lost => {
    if (lost === surface.canvas) reopen();
  });
  surface.canvas.setAttribute("role", "img");
  surface.canvas.setAttribute("aria-label", `${worded(name)}, painted in ${picture().names.length} colors`);
  surface.canvas.addEventListener("click", pick);
  find("frame").prepend(surface.canvas);
  find("frame").style.setProperty("--ratio", width / height);
}

// Goes on with a plain canvas when the graphics card is lost, or cannot hold a frame.
function reopen() {
  openSurface(true);
  if (shown) take(shown.frame);
}

// Puts a decoded frame on the canvas.
function take(frame) {
  try {
    surface.painter.places(frame);
  } catch {
    openSurface(true);
    surface.painter.places(frame);
  }
  shown = { frame, now: tableOf(frame.mixes), isMixed: false };
  const before = mix(frame, originals().map(color => color.shown), facts.linear, tableOf(frame.mixes));
  surface.painter.table("before", before);
  paint();
  if (!find("wait").hidden) performance.mark("shown");
  find("wait").hidden = true;
}

// Shows the frame that the state names, once it is decoded, unless another one was asked for since.
async function open() {
  const asked = [state.picture, state.frame];
  const entry = frameOf(...asked);
  if (entry.ready) return take(entry.ready);
  try {
    const frame = await entry.frame;
    if (asked[0] === state.picture && asked[1] === state.frame) take(frame);
  } catch {
    find("wait").hidden = false;
    find("wait").textContent = "This frame cannot be opened: the file is damaged, or the browser is out of memory.";
  }
}

// Decodes the other frames while nothing else happens.
async function prepare() {
  const at = state.picture;
  for (let index = 1; index < facts.pictures[at].frames.length && at === state.picture && kept < KEPT / 2; index++) {
    await new Promise(done => (window.requestIdleCallback ?? setTimeout)(done));
    await frameOf(at, index).frame.catch(() => {});
  }
}

// Chooses the color of which a pixel has most.
function pick(event) {
  if (!shown) return;
  const { canvas } = surface;
  const box = canvas.getBoundingClientRect();
  const [x, y] = [event.offsetX / box.width * canvas.width, event.offsetY / box.height * canvas.height].map(Math.floor);
  const { places, weights, mixes } = shown.frame;
  const place = places[clamp(y, 0, canvas.height - 1) * canvas.width + clamp(x, 0, canvas.width - 1)];
  const of = picture().names.map((_, color) => weights[color * mixes + place]);
  select(of.indexOf(Math.max(...of)));
  say(described(state.selected));
}

// Comparing: a divider, and a button that shows the original while it is held.

function divide(share) {
  divided = clamp(share, 0, 1);
  const isOn = find("compare").getAttribute("aria-pressed") === "true";
  for (const id of ["split", "tag-before", "tag-after"]) find(id).hidden = !isOn;
  if (!isOn) divided = 0;
  find("split").style.left = `${100 * divided}%`;
  find("split").setAttribute("aria-valuenow", Math.round(100 * divided));
  find("split").setAttribute("aria-valuetext", `${Math.round(100 * divided)} % original`);
  repaint(false);
}

function hold(isHeld) {
  holds = isHeld;
  find("hold").classList.toggle("held", isHeld);
  repaint(false);
}

find("compare").addEventListener("click", () => {
  const isOn = find("compare").getAttribute("aria-pressed") !== "true";
  find("compare").setAttribute("aria-pressed", isOn);
  divide(0.5);
});
find("split").addEventListener("pointerdown", event => find("split").setPointerCapture(event.pointerId));
find("split").addEventListener("pointermove", event => {
  if (!find("split").hasPointerCapture(event.pointerId)) return;
  const box = find("frame").getBoundingClientRect();
  divide((event.clientX - box.left) / box.width);
});
find("split").addEventListener("keydown", event => {
  const to = {
    ArrowLeft: divided - 0.02, ArrowDown: divided - 0.02, ArrowRight: divided + 0.02, ArrowUp: divided + 0.02,
    PageDown: divided - 0.1, PageUp: divided + 0.1, Home: 0, End: 1,
  }[event.key];
  if (to === undefined) return;
  event.preventDefault();
  divide(to);
});
find("hold").addEventListener("pointerdown", event => {
  find("hold").setPointerCapture(event.pointerId);
  hold(true);
});
for (const kind of ["pointerup", "pointercancel", "blur"]) find("hold").addEventListener(kind, () => hold(false));
const isHeldKey = event => event.target === find("hold") && [" ", "Enter"].includes(event.key) ||
  event.key === "o" && !event.target.matches("input[type=text], select") && !event.ctrlKey && !event.metaKey;
addEventListener("keydown", event => { if (isHeldKey(event)) hold(true); });
addEventListener("keyup", event => { if (isHeldKey(event)) hold(false); });

// Frames.

let playing = 0;

function updateFrame() {
  const { frames } = picture();
  find("play-bar").hidden = frames.length < 2;
  Object.assign(find("scrub"), { max: frames.length - 1, value: state.frame });
  find("scrub").setAttribute("aria-valuetext", `frame ${frames[state.frame].label}, ${state.frame + 1} of ${frames.length}`);
  find("at").textContent = `${state.frame + 1} / ${frames.length}`;
}

function play(isOn) {
  cancelAnimationFrame(playing);
  playing = 0;
  find("play").setAttribute("aria-label", isOn ? "Pause" : "Play");
  find("play").classList.toggle("on", isOn);
  if (!isOn) return;
  let due = performance.now();
  const step = now => {
    playing = requestAnimationFrame(step);
    if (now < due) return;
    const next = (state.frame + 1) % picture().frames.length;
    // A frame that is not decoded yet is waited for.
    if (!frameOf(state.picture, next).ready) return;
    due = Math.max(due + 1000 / facts.fps, now - 1000 / facts.fps);
    showFrame(next);
  };
  playing = requestAnimationFrame(step);
}

find("play").addEventListener("click", () => play(!playing));
find("scrub").addEventListener("input", () => {
  play(false);
  showFrame(Number(find("scrub").value));
});

on("picture", () => {
  play(false);
  shown = null;
  openSurface();
  updateFrame();
  open().then(prepare);
});
on("frame", () => {
  updateFrame();
  open();
});
on("colors", () => repaint());
