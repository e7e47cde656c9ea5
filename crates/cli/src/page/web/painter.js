// Painters: WebGL2, and a plain canvas where there is none. Both look up the place of each pixel in two tables of colors,
// `before` left of the column `split`, and `now` from there on. Places and tables go in when they change.

// Width of the textures with tables; their height follows from the number of colors.
const ROW = 1024;

const VERTEX = `#version 300 es
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }`;
const FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
uniform highp usampler2D places;
uniform highp sampler2D now;
uniform highp sampler2D before;
uniform int split;
out vec4 color;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.x, float(textureSize(places, 0).y) - gl_FragCoord.y);
  int place = int(texelFetch(places, pixel, 0).r);
  ivec2 at = ivec2(place % ${ROW}, place / ${ROW});
  color = pixel.x < split ? texelFetch(before, at, 0) : texelFetch(now, at, 0);
}`;

class GlPainter {
  // Throws if the browser, or its graphics card, has no WebGL2 or too small textures.
  constructor(canvas, width, height) {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, preserveDrawingBuffer: true });
    if (!gl || gl.getParameter(gl.MAX_TEXTURE_SIZE) < Math.max(width, height)) throw new Error("no WebGL2");
    this.gl = gl;
    this.size = [width, height];
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "no shader");
    gl.useProgram(program);
    this.split = gl.getUniformLocation(program, "split");
    ["places", "now", "before"].forEach((name, unit) => {
      gl.uniform1i(gl.getUniformLocation(program, name), unit);
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
      for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
      for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    });
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  }

  places({ places, mixes }) {
    const { gl, size: [width, height] } = this;
    if (mixes > ROW * gl.getParameter(gl.MAX_TEXTURE_SIZE)) throw new Error("too many mixes");
    gl.activeTexture(gl.TEXTURE0);
    const [inside, type] = places instanceof Uint16Array ? [gl.R16UI, gl.UNSIGNED_SHORT] : [gl.R32UI, gl.UNSIGNED_INT];
    gl.texImage2D(gl.TEXTURE_2D, 0, inside, width, height, 0, gl.RED_INTEGER, type, places);
  }

  table(which, table) {
    const { gl } = this;
    gl.activeTexture(gl.TEXTURE0 + (which === "now" ? 1 : 2));
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, ROW, table.length / 4 / ROW, 0, gl.RGBA, gl.UNSIGNED_BYTE, table);
  }

  paint(split) {
    const { gl } = this;
    gl.uniform1i(this.split, split);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  close() {
    this.gl.getExtension("WEBGL_lose_context")?.loseContext();
  }
}

class CanvasPainter {
  constructor(canvas, width, height) {
    this.context = canvas.getContext("2d", { alpha: false });
    this.image = this.context.createImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.width = width;
  }

  places({ places }) {
    this.at = places;
  }

  table(which, table) {
    this[which] = new Uint32Array(table.buffer);
  }

  paint(split) {
    const { at, now, before, pixels, width } = this;
    for (let start = 0; start < pixels.length; start += width) {
      const middle = start + split, end = start + width;
      for (let pixel = start; pixel < middle; pixel++) pixels[pixel] = before[at[pixel]];
      for (let pixel = middle; pixel < end; pixel++) pixels[pixel] = now[at[pixel]];
    }
    this.context.putImageData(this.image, 0, 0);
  }

  close() {}
}

// Room for a table, in whole rows.
const tableOf = mixes => new Uint8Array(4 * ROW * Math.ceil(mixes / ROW));

const canvasOf = (width, height) => Object.assign(document.createElement("canvas"), { width, height });

// Returns a canvas with its painter. When the graphics card is lost, `lost` gets the canvas.
function painterOf(width, height, lost) {
  try {
    const canvas = canvasOf(width, height);
    const painter = new GlPainter(canvas, width, height);
    canvas.addEventListener("webglcontextlost", () => lost(canvas));
    return { canvas, painter };
  } catch {
    return plainPainter(width, height);
  }
}

function plainPainter(width, height) {
  const canvas = canvasOf(width, height);
  return { canvas, painter: new CanvasPainter(canvas, width, height) };
}
