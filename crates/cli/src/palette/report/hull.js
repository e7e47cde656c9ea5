"use strict";
(() => {
  const { colors, edges, pixels, outside } = JSON.parse(document.getElementById("space").textContent);
  const canvas = document.getElementById("hull");
  const brush = canvas.getContext("2d");
  const showPixels = document.getElementById("show-pixels");
  const showNames = document.getElementById("show-names");
  // Many names would hide the hull.
  showNames.checked = colors.length <= 12;
  const START = { yaw: 0.65, pitch: 0.22, zoom: 1 };
  const view = { ...START };
  let marked = -1;

  // Color space stands on its black corner: gray goes up, and hues go around.
  const stand = ([r, g, b]) => {
    const [x, y, z] = [r / 127.5 - 1, g / 127.5 - 1, b / 127.5 - 1];
    return [(x - y) / Math.SQRT2, (x + y + z) / Math.sqrt(3), (2 * z - x - y) / Math.sqrt(6)];
  };
  const corner = (index) => [0, 1, 2].map((c) => 255 * ((index >> c) & 1));
  const cube = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((index) =>
    [1, 2, 4].filter((bit) => !(index & bit)).map((bit) => [stand(corner(index)), stand(corner(index | bit))]));
  const dots = pixels.map(([r, g, b, size]) => ({ at: stand([r, g, b]), color: `rgb(${r},${g},${b})`, size }));
  const lines = edges.map((edge) => [stand(edge.slice(0, 3)), stand(edge.slice(3))]);
  const inks = colors.map(([name, hex, rgb]) => ({ name, hex, at: stand(rgb) }));
  const rings = outside.map(stand);

  function draw() {
    const scale = Math.min(window.devicePixelRatio || 1, 3);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
      [canvas.width, canvas.height] = [Math.round(width * scale), Math.round(height * scale)];
    }
    brush.setTransform(scale, 0, 0, scale, 0, 0);
    brush.clearRect(0, 0, width, height);
    const style = getComputedStyle(canvas);
    const [ink, faint, paper] = ["--ink", "--faint", "--stripe"].map((name) => style.getPropertyValue(name).trim());
    const [cosYaw, sinYaw] = [Math.cos(view.yaw), Math.sin(view.yaw)];
    const [cosPitch, sinPitch] = [Math.cos(view.pitch), Math.sin(view.pitch)];
    const unit = Math.min(0.25 * height, 0.24 * width) * view.zoom;
    // From the front, depth is positive; a slight perspective.
    const place = ([x, y, z]) => {
      const [across, away] = [x * cosYaw + z * sinYaw, z * cosYaw - x * sinYaw];
      const [up, depth] = [y * cosPitch - away * sinPitch, away * cosPitch + y * sinPitch];
      const near = unit * 6 / (6 - depth);
      return [width / 2 + across * near, height / 2 - up * near, depth];
    };
    const line = ([from, to], color, thick, alpha) => {
      const [a, b] = [place(from), place(to)];
      brush.globalAlpha = alpha((a[2] + b[2]) / 2);
      brush.strokeStyle = color;
      brush.lineWidth = thick;
      brush.beginPath();
      brush.moveTo(a[0], a[1]);
      brush.lineTo(b[0], b[1]);
      brush.stroke();
    };
    const disc = ([x, y], radius) => {
      brush.beginPath();
      brush.arc(x, y, radius, 0, 2 * Math.PI);
    };
    cube.forEach((edge) => line(edge, faint, 1, () => 0.22));
    lines.forEach((edge) => line(edge, ink, 1.25, (depth) => (depth < 0 ? 0.35 : 0)));
    if (showPixels.checked) {
      const sorted = dots.map((dot) => [place(dot.at), dot]).sort((a, b) => a[0][2] - b[0][2]);
      brush.globalAlpha = 0.9;
      for (const [at, dot] of sorted) {
        brush.fillStyle = dot.color;
        disc(at, (1.3 + Math.min(5, 0.06 * dot.size)) * Math.min(1.6, view.zoom));
        brush.fill();
      }
    }
    rings.forEach((ring) => {
      brush.globalAlpha = 0.65;
      brush.strokeStyle = "#d04a4a";
      brush.lineWidth = 1.25;
      disc(place(ring), 3.5);
      brush.stroke();
    });
    lines.forEach((edge) => line(edge, ink, 1.5, (depth) => (depth < 0 ? 0 : 0.75)));
    brush.globalAlpha = 1;
    brush.font = "600 13px system-ui, sans-serif";
    brush.textBaseline = "middle";
    inks.map((own, index) => [place(own.at), own, index]).sort((a, b) => a[0][2] - b[0][2]).forEach(([at, own, index]) => {
      const radius = index === marked ? 15 : 10;
      disc(at, radius);
      brush.fillStyle = own.hex;
      brush.fill();
      brush.lineWidth = index === marked ? 3.5 : 2;
      brush.strokeStyle = ink;
      brush.stroke();
      if (!showNames.checked && index !== marked) return;
      const long = brush.measureText(own.name).width;
      // Names near the right edge stand on the left.
      const left = at[0] + radius + 8 + long > width - 4;
      const x = left ? at[0] - radius - 7 - long : at[0] + radius + 7;
      brush.lineWidth = 4;
      brush.lineJoin = "round";
      brush.strokeStyle = paper;
      brush.strokeText(own.name, x, at[1]);
      brush.fillStyle = ink;
      brush.fillText(own.name, x, at[1]);
    });
  }

  let waiting = false;
  function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; draw(); });
  }
  function turn(yaw, pitch) {
    view.yaw += yaw;
    view.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, view.pitch + pitch));
    redraw();
  }
  function zoom(by) {
    view.zoom = Math.max(0.5, Math.min(6, view.zoom * by));
    redraw();
  }
  function reset() {
    Object.assign(view, START);
    redraw();
  }

  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (canvas.hasPointerCapture(event.pointerId)) turn(event.movementX / 160, event.movementY / 160);
  });
  canvas.addEventListener("wheel", (event) => {
    // Without a key, the wheel scrolls the page.
    if (!event.ctrlKey && !event.metaKey) return;
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 300));
  }, { passive: false });
  const KEYS = {
    ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, -0.1), ArrowDown: () => turn(0, 0.1),
    "+": () => zoom(1.15), "=": () => zoom(1.15), "-": () => zoom(1 / 1.15), Home: reset,
  };
  canvas.addEventListener("keydown", (event) => {
    const act = KEYS[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
  });
  document.getElementById("reset").addEventListener("click", reset);
  [showPixels, showNames].forEach((box) => box.addEventListener("change", redraw));
  document.querySelectorAll("[data-color]").forEach((swatch) => {
    const mark = (index) => () => { marked = index; redraw(); };
    swatch.addEventListener("pointerenter", mark(Number(swatch.dataset.color)));
    swatch.addEventListener("pointerleave", mark(-1));
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  new ResizeObserver(redraw).observe(canvas);
})();
