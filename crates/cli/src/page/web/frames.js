// Frames: a table of mixes, and for each pixel its place in the table, as `pack.rs` writes them.

// Bytes of decoded frames that are kept.
const KEPT = 512e6;
const decoded = new Map();
let kept = 0;

function bytesOf(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let at = 0; at < raw.length; at++) bytes[at] = raw.charCodeAt(at);
  return bytes;
}

// The browser may still be reading the page.
async function element(id) {
  while (!document.getElementById(id) && document.readyState === "loading") {
    await new Promise(done => setTimeout(done, 20));
  }
  return document.getElementById(id);
}

// Decodes a block: the number of `mixes`, their `weights` by color with the sum 65280, and the `places` of `area` pixels.
// Mixes of the key frame come first, and pixels may be as they are there.
async function decodeBlock(id, colors, area, key = null) {
  const text = (await element(id)).textContent;
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const own = new DataView(bytes.buffer).getUint32(0, true);
  const base = key?.mixes ?? 0;
  const mixes = base + own;
  const weights = new Uint16Array(colors * mixes);
  for (let color = 0, at = 4; color < colors; color++) {
    if (key) weights.set(key.weights.subarray(color * base, (color + 1) * base), color * mixes);
    const start = color * mixes + base;
    for (let mix = 0; mix < own; mix++, at++) weights[start + mix] = bytes[at] << 8 | bytes[at + colors * own];
  }
  const planes = mixes < 1 << 8 ? 1 : mixes < 1 << 16 ? 2 : 3;
  const places = planes < 3 ? new Uint16Array(area) : new Uint32Array(area);
  for (let plane = 0, from = 4 + 2 * colors * own; plane < planes; plane++, from += area) {
    for (let at = 0; at < area; at++) places[at] = places[at] << 8 | bytes[from + at];
  }
  for (let at = 0; at < area; at++) places[at] = places[at] === 0 ? key.places[at] : places[at] - 1;
  return { mixes, weights, places };
}

async function decodeFrame(pictureIndex, index) {
  const { names, width, height } = facts.pictures[pictureIndex];
  const first = index - index % facts.group;
  const key = first === index ? null : await frameOf(pictureIndex, first).frame;
  return decodeBlock(`frame-${pictureIndex}-${index}`, names.length, width * height, key);
}

// Returns what is known of a frame: its promise and, once it is `ready`, itself. Frames that were not asked for lately are
// forgotten.
function frameOf(pictureIndex, index) {
  const id = `frame-${pictureIndex}-${index}`;
  let entry = decoded.get(id);
  if (entry) {
    decoded.delete(id);
  } else {
    const frame = decodeFrame(pictureIndex, index);
    entry = { frame, bytes: 0, ready: null };
    const fresh = entry;
    frame.then(ready => {
      fresh.ready = ready;
      fresh.bytes = ready.weights.byteLength + ready.places.byteLength + 8 * ready.mixes;
      kept += fresh.bytes;
    }, () => decoded.delete(id));
  }
  decoded.set(id, entry);
  for (const [old, { bytes, ready }] of decoded) {
    if (kept <= KEPT || old === id) break;
    if (!ready) continue;
    decoded.delete(old);
    kept -= bytes;
  }
  return entry;
}

// Light from 0 to 1 in 65535 steps, as the display encodes it, in 8 bits.
let encoding = null;
function encodingTable() {
  return encoding ??= Uint8Array.from({ length: 65536 }, (_, at) => steps(encode(at / 65535)));
}

// Mixes the table of a frame of these colors, as red, green, blue and 255, in `table`.
function mix({ mixes, weights }, colors, linear, table) {
  const shown = linear ? encodingTable() : null;
  const sums = [0, 1, 2].map(() => new Float32Array(mixes));
  colors.forEach((rgb, color) => {
    const row = weights.subarray(color * mixes, (color + 1) * mixes);
    sums.forEach((sum, channel) => {
      const by = (linear ? decode(rgb[channel]) : rgb[channel]) / 65280;
      if (by !== 0) for (let at = 0; at < mixes; at++) sum[at] += row[at] * by;
    });
  });
  sums.forEach((sum, channel) => {
    for (let at = 0; at < mixes; at++) {
      const v = sum[at] <= 0 ? 0 : sum[at] >= 1 ? 1 : sum[at];
      table[4 * at + channel] = shown ? shown[(v * 65535 + 0.5) | 0] : (v * 255 + 0.5) | 0;
    }
  });
  for (let at = 0; at < mixes; at++) table[4 * at + 3] = 255;
  return table;
}
