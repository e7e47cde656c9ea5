// Colors: [red, green, blue] as encoded for an sRGB display, 0 to 1; and OKLCh, [lightness, chroma, hue in degrees].

const decode = v => v < 0 ? -decode(-v) : v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
const encode = v => v < 0 ? -encode(-v) : v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055;
const clamp = (v, low, high) => Math.min(Math.max(v, low), high);

function oklab(rgb) {
  const [r, g, b] = rgb.map(decode);
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [
    0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
    1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s,
  ];
}

function lchOf(rgb) {
  const [l, a, b] = oklab(rgb);
  const c = Math.hypot(a, b);
  return [l, c, c < 1e-4 ? 0 : (Math.atan2(b, a) * 180 / Math.PI + 360) % 360];
}

function rgbOf([lightness, c, h]) {
  const [a, b] = [c * Math.cos(h * Math.PI / 180), c * Math.sin(h * Math.PI / 180)];
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.2914855480 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s,
  ].map(encode);
}

const isShown = rgb => rgb.every(v => v > -0.0001 && v < 1.0001);

// The nearest color that the display shows: of the same lightness and hue, with as much chroma as there is.
function fitted([l, c, h]) {
  let [low, high] = [0, c];
  if (!isShown(rgbOf([l, c, h]))) {
    for (let turn = 0; turn < 20; turn++) {
      const middle = (low + high) / 2;
      if (isShown(rgbOf([l, middle, h]))) low = middle; else high = middle;
    }
    c = low;
  }
  return { lch: [l, c, h], rgb: rgbOf([l, c, h]).map(v => clamp(v, 0, 1)) };
}

const steps = v => Math.floor(clamp(v, 0, 1) * 255 + 0.5);
const hexOf = rgb => "#" + rgb.map(v => steps(v).toString(16).padStart(2, "0")).join("");

// Reads #rgb or #rrggbb, with or without the sign; null if it is neither.
function parseHex(text) {
  const digits = text.trim().replace(/^#/, "");
  if (!/^([0-9a-f]{3}|[0-9a-f]{6})$/i.test(digits)) return null;
  const size = digits.length / 3;
  return [0, 1, 2].map(at => parseInt(digits.slice(at * size, (at + 1) * size).repeat(3 - size), 16) / 255);
}
