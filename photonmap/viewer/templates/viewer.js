"use strict";
const head = JSON.parse(document.getElementById("head").textContent);
const byId = (id) => document.getElementById(id);
const { width: W, height: H } = head;
const TWO = head.files.length === 2;
const LUMINANCE = [0.2126, 0.7152, 0.0722];
const INFINITE = 255;
const OTHERS = ["number", "direction", "id"]; // kinds without bands

// The values of all half floats.
const HALF = new Float32Array(65536);
for (let bits = 0; bits < 65536; bits++) {
  const exponent = (bits >> 10) & 31, fraction = bits & 1023;
  const size = exponent ? 2 ** (exponent - 15) * (1 + fraction / 1024) : 2 ** -24 * fraction;
  HALF[bits] = bits >> 15 ? -size : size;
}
// 8-bit sRGB of linear values in steps of 1/4095.
const ENCODED = new Uint8ClampedArray(4096);
for (let i = 0; i < 4096; i++) {
  const v = i / 4095;
  ENCODED[i] = Math.round(255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055));
}
const encode = (v) => ENCODED[v >= 1 ? 4095 : v > 0 ? (v * 4095 + 0.5) | 0 : 0];

const buffers = head.buffers.map((about) => ({ ...about, on: true, files: [null, null] }));
const named = new Map(buffers.map((buffer) => [buffer.name, buffer]));
const view = { zoom: 1, x: W / 2, y: H / 2 };
let pinned = null, hovered = null;

// ---- reading

async function inflate(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Undo packing: low bytes of differences along lines, then high ones, band after band.
function unpack(bytes, channels, size) {
  const count = W * H;
  const out = size === 2 ? new Uint16Array(count * channels) : new Uint8Array(count * channels);
  for (let band = 0; band < channels; band++) {
    const low = band * count * size, high = low + count, to = band * count;
    for (let row = 0, i = 0; row < H; row++)
      for (let x = 0, sum = 0; x < W; x++, i++) {
        sum += bytes[low + i] + (size === 2 ? bytes[high + i] << 8 : 0);
        out[to + i] = sum;
      }
  }
  return out;
}

async function readAll() {
  const scripts = [...document.querySelectorAll('script[type="text/plain"]')];
  for (const array of head.arrays) {
    const buffer = named.get(array.buffer);
    const data = { factor: 2 ** -array.scale, values: null, errors: null, first: array.errors };
    for (const [key, wanted, size] of [
      ["values", array.values, 2],
      ["errors", array.errors !== undefined, 1],
    ]) {
      if (!wanted) continue;
      const script = scripts.shift();
      data[key] = unpack(await inflate(script.textContent), buffer.channels, size);
      script.remove();
    }
    buffer.files[array.file] = data;
    draw();
  }
}

// ---- values

// Return a function of a pixel's index and a channel; null where the file has no such buffer.
function reader(buffer, file) {
  const data = buffer.files[file];
  if (!data) return null;
  if (buffer.kind === "id") return (at) => data.values[at];
  if (data.values) {
    const { values, factor } = data;
    return (at, channel) => HALF[values[channel * W * H + at]] * factor;
  }
  const parts = head.parts.map((name) => named.get(name) && reader(named.get(name), file));
  if (parts.some((part) => !part)) return null;
  return (at, channel) => parts[0](at, channel) + parts[1](at, channel) + parts[2](at, channel);
}

function errorOf(buffer, file, at, channel) {
  const data = buffer.files[file];
  if (!data || !data.errors) return null;
  const code = data.errors[channel * W * H + at];
  if (code === 0) return 0;
  if (code === INFINITE) return Infinity;
  const steps = code + data.first, octave = Math.floor(steps / 4);
  return 2 ** octave * (1 + (steps - 4 * octave + 0.5) / 4);
}

function pixel(name, x, y, file = 0) {
  const buffer = named.get(name), read = reader(buffer, file), at = y * W + x;
  const channels = [...Array(buffer.channels).keys()];
  if (!read) return null;
  return {
    values: channels.map((channel) => read(at, channel)),
    errors: channels.map((channel) => errorOf(buffer, file, at, channel)),
  };
}

// ---- colours

const exposure = () => head.exposure * 2 ** Number(byId("exposure").value);

// Return three rows of weights of bands, with the exposure in them.
function weights(buffer) {
  const choice = byId("colour").value, n = head.bands.length;
  const isLight = buffer.kind === "radiance";
  const factor = isLight ? exposure() : 1;
  const row = (band) => Array.from({ length: n }, (_, i) => (i === band ? factor : 0));
  if (choice === "pick") return ["red", "green", "blue"].map((id) => row(Number(byId(id).value)));
  if (choice.startsWith("band")) return Array(3).fill(row(Number(choice.slice(4))));
  const way = head.projections[Number(choice)];
  return (isLight ? way.matrix : way.reflectance).map((line) => line.map((w) => w * factor));
}

function scatter(id) { // a colour of a number of an object
  const hue = (id * 0.618034) % 1, f = (k) => 0.5 + 0.45 * Math.cos(2 * Math.PI * (hue + k / 3));
  return id ? [f(0), f(1), f(2)] : [0, 0, 0];
}

// Return a function that writes the colour of a pixel's index into [r, g, b], 0 to 255.
function painter(buffer, mode) {
  const one = reader(buffer, mode === "b" ? 1 : 0), other = reader(buffer, 1);
  if (mode === "a" || mode === "b" ? !one : !one || !other) return null;
  const n = buffer.channels, difference = mode !== "a" && mode !== "b";
  if (buffer.kind === "id") {
    return difference
      ? (at, out) => out.fill(one(at) === other(at) ? 0 : 255)
      : (at, out) => scatter(one(at)).forEach((v, k) => (out[k] = 255 * v));
  }
  const read = difference ? (at, k) => one(at, k) - other(at, k) : one;
  const signed = (v, out) => {
    out[0] = encode(v); out[1] = encode(0.35 * Math.abs(v)); out[2] = encode(-v);
  };
  if (mode === "sigma")
    return (at, out) => {
      let sum = 0, squares = 0, count = 0;
      for (let k = 0; k < n; k++) {
        const a = errorOf(buffer, 0, at, k), b = errorOf(buffer, 1, at, k);
        const d = read(at, k), s = Math.hypot(a, b);
        if (!(s > 0 && s < Infinity)) continue;
        sum += d; squares += (d / s) ** 2; count++;
      }
      signed(count ? (Math.sign(sum) * Math.sqrt(squares / count)) / 5 : 0, out);
    };
  if (buffer.kind === "direction" && !difference)
    return (at, out) => { for (let k = 0; k < 3; k++) out[k] = 127.5 + 127.5 * read(at, k); };
  if (n !== head.bands.length || buffer.kind === "direction" || buffer.kind === "number") {
    const scale = 1 / (largest(buffer) || 1);
    if (difference) return (at, out) => signed(read(at, 0) * scale, out);
    return (at, out) => out.fill(255 * Math.min(1, Math.max(0, read(at, 0) * scale)));
  }
  const rows = weights(buffer);
  if (difference) {
    const line = rows[0].map((_, i) => LUMINANCE.reduce((sum, w, k) => sum + w * rows[k][i], 0));
    return (at, out) => {
      let v = 0;
      for (let k = 0; k < n; k++) v += line[k] * read(at, k);
      signed(v, out);
    };
  }
  const [red, green, blue] = rows;
  return (at, out) => {
    let r = 0, g = 0, b = 0;
    for (let k = 0; k < n; k++) {
      const v = read(at, k);
      r += red[k] * v; g += green[k] * v; b += blue[k] * v;
    }
    out[0] = encode(r); out[1] = encode(g); out[2] = encode(b);
  };
}

function largest(buffer) {
  if (buffer.largest === undefined) {
    const read = reader(buffer, 0);
    buffer.largest = 0;
    for (let at = 0; at < W * H; at++) buffer.largest = Math.max(buffer.largest, read(at, 0));
  }
  return buffer.largest;
}

// ---- drawing

const scaleOf = (canvas) => (canvas.width / W) * view.zoom;

function paint(buffer) {
  const canvas = buffer.canvas, ratio = window.devicePixelRatio || 1;
  canvas.width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  canvas.height = Math.max(1, Math.round((canvas.width * H) / W));
  const context = canvas.getContext("2d"), scale = scaleOf(canvas);
  const colour = painter(buffer, byId("show").value);
  context.fillStyle = "#777";
  context.fillRect(0, 0, canvas.width, canvas.height);
  if (colour) {
    const image = context.createImageData(canvas.width, canvas.height), pixels = image.data;
    const rgb = [0, 0, 0];
    const columns = Array.from({ length: canvas.width }, (_, i) =>
      Math.floor(view.x + (i + 0.5 - canvas.width / 2) / scale));
    for (let j = 0; j < canvas.height; j++) {
      const y = Math.floor(view.y + (j + 0.5 - canvas.height / 2) / scale);
      for (let i = 0; i < canvas.width; i++) {
        const x = columns[i], to = 4 * (j * canvas.width + i);
        if (x >= 0 && x < W && y >= 0 && y < H) colour(y * W + x, rgb);
        else rgb.fill(119);
        pixels[to] = rgb[0]; pixels[to + 1] = rgb[1]; pixels[to + 2] = rgb[2]; pixels[to + 3] = 255;
      }
    }
    context.putImageData(image, 0, 0);
  }
  const mark = pinned || hovered;
  if (mark) {
    const side = Math.max(scale, 7 * ratio);
    const x = (mark.x + 0.5 - view.x) * scale + canvas.width / 2 - side / 2;
    const y = (mark.y + 0.5 - view.y) * scale + canvas.height / 2 - side / 2;
    context.strokeStyle = "#fff"; context.lineWidth = 3 * ratio; context.strokeRect(x, y, side, side);
    context.strokeStyle = "#000"; context.lineWidth = ratio; context.strokeRect(x, y, side, side);
  }
}

let waiting = false;
function draw() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => {
    waiting = false;
    for (const buffer of buffers) {
      buffer.figure.hidden = !buffer.on;
      if (buffer.on) paint(buffer);
    }
  });
}

// ---- the pixel

const short = (v) => (v === null ? "" : !isFinite(v) ? "∞" : v === 0 ? "0" :
  Math.abs(v) >= 1e4 || Math.abs(v) < 1e-3 ? v.toExponential(2) : v.toPrecision(4));

function tell() {
  const at = pinned || hovered;
  if (!at) return;
  byId("where").textContent = `Pixel ${at.x}, ${at.y}` + (pinned ? " (held)" : "");
  const notes = [];
  for (const [id, list, word] of [["object_id", "objects", ""], ["material_id", "materials", "of "]]) {
    const found = named.has(id) && pixel(id, at.x, at.y), names = head.files[0][list];
    if (found) notes.push(found.values[0] ? word + (names?.[found.values[0] - 1] ?? `number ${found.values[0]}`) : "background");
  }
  const others = buffers.filter((buffer) => buffer.on && buffer.kind !== "id" && OTHERS.includes(buffer.kind));
  const said = others.map((buffer) => {
    const found = pixel(buffer.name, at.x, at.y);
    return found && `${buffer.name} ${found.values.map(short).join(" ")} ${buffer.unit}`.trim();
  });
  byId("what").textContent = [[...new Set(notes)].join(" "), ...said].filter(Boolean).join(", ");
  byId("charts").innerHTML = chart("radiance", at) + chart("reflectance", at) + chart("ratio", at);
  const heads = head.bands.map((band) => `<th>${escape(band)}</th>`).join("");
  const rows = buffers.filter((buffer) => buffer.on && !OTHERS.includes(buffer.kind)).flatMap((buffer) =>
    head.files.map((file, number) => {
      const found = pixel(buffer.name, at.x, at.y, number);
      const cells = found && found.values.map((v, k) =>
        `<td>${short(v)}${found.errors[k] === null ? "" : ` ± ${short(found.errors[k])}`}</td>`);
      const title = TWO ? `${buffer.name} ${"AB"[number]}` : buffer.name;
      return found ? `<tr><th>${escape(title)}</th>${cells.join("")}</tr>` : "";
    }));
  byId("numbers").innerHTML = `<tr><th></th>${heads}</tr>${rows.join("")}`;
}

const escape = (text) => String(text).replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);

// Return the spectra of a pixel in all buffers of a kind, as SVG.
function chart(kind, at) {
  const lines = buffers.filter((buffer) => buffer.on && buffer.kind === kind).flatMap((buffer) =>
    head.files.map((_, file) => ({ buffer, file, found: pixel(buffer.name, at.x, at.y, file) })));
  const shown = lines.filter((line) => line.found);
  if (!shown.length) return "";
  const nm = head.wavelengths || head.bands.map((_, i) => i);
  const all = shown.flatMap(({ found }) => found.values.flatMap((v, k) => {
    const e = isFinite(found.errors[k]) ? found.errors[k] || 0 : 0;
    return [v - e, v + e];
  }));
  const low = Math.min(0, ...all), high = Math.max(...all, low + 1e-9);
  const [left, top, right, bottom] = [58, 22, 352, 150];
  const span = nm.at(-1) - nm[0] || 1;
  const px = (v) => left + 6 + ((v - nm[0]) / span) * (right - left - 12);
  const py = (v) => bottom - ((v - low) / (high - low)) * (bottom - top);
  const parts = shown.map(({ buffer, file, found }) => {
    const dash = file ? ' stroke-dasharray="4 3"' : "";
    const points = found.values.map((v, k) => `${px(nm[k]).toFixed(1)},${py(v).toFixed(1)}`);
    const bars = found.values.map((v, k) => {
      const e = found.errors[k];
      if (!e || !isFinite(e)) return "";
      const x = px(nm[k]).toFixed(1), [a, b] = [py(v - e).toFixed(1), py(v + e).toFixed(1)];
      return `<path d="M${x} ${a}V${b}m-3 0h6M${x} ${a}m-3 0h6" class="bar"/>`;
    });
    const dots = points.length < 40 ? points.map((p) => {
      const [x, y] = p.split(",");
      return `<circle cx="${x}" cy="${y}" r="2" fill="${buffer.color}" stroke="none"/>`;
    }) : [];
    return `<g stroke="${buffer.color}" fill="none"${dash} data-buffer="${escape(buffer.name)}">
      <polyline points="${points.join(" ")}"/>${bars.join("")}${dots.join("")}</g>`;
  });
  const unit = shown[0].buffer.unit;
  const ticks = [low, (low + high) / 2, high].map((v) =>
    `<text x="${left - 4}" y="${py(v) + 4}" text-anchor="end">${short(v)}</text>
     <path d="M${left} ${py(v)}H${right}" stroke="#ddd"/>`);
  const under = head.wavelengths ? [nm[0], nm.at(-1)].map((v, k) =>
    `<text x="${px(v)}" y="${bottom + 14}" text-anchor="${k ? "end" : "start"}">${Math.round(v)} nm</text>`)
    : nm.map((v, k) => `<text x="${px(v)}" y="${bottom + 14}" text-anchor="middle">${escape(head.bands[k])}</text>`);
  return `<svg viewBox="0 0 360 170" class="${kind}"><text x="${left}" y="12">${kind}${unit ? ", " + unit : ""}</text>
    ${ticks.join("")}${under.join("")}${parts.join("")}</svg>`;
}

// ---- what is done with mouse and keys

function place(canvas, event) {
  const box = canvas.getBoundingClientRect(), ratio = canvas.width / box.width;
  const scale = scaleOf(canvas);
  return {
    x: view.x + ((event.clientX - box.x) * ratio - canvas.width / 2) / scale,
    y: view.y + ((event.clientY - box.y) * ratio - canvas.height / 2) / scale,
  };
}

function pixelAt(canvas, event) {
  const { x, y } = place(canvas, event), at = { x: Math.floor(x), y: Math.floor(y) };
  return at.x >= 0 && at.x < W && at.y >= 0 && at.y < H ? at : null;
}

function zoomTo(zoom, fixed = { x: view.x, y: view.y }) {
  const next = Math.min(Math.max(zoom, 0.5), 256), ratio = view.zoom / next;
  view.x = fixed.x + (view.x - fixed.x) * ratio;
  view.y = fixed.y + (view.y - fixed.y) * ratio;
  view.zoom = next;
  draw();
}

function whole() {
  Object.assign(view, { zoom: 1, x: W / 2, y: H / 2 });
  draw();
}

function actual() {
  zoomTo(W / buffers.find((buffer) => buffer.on).canvas.width);
}

function listen(canvas) {
  let from = null, moved = false;
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    zoomTo(view.zoom * 2 ** (-event.deltaY / 300), place(canvas, event));
  }, { passive: false });
  canvas.addEventListener("pointerdown", (event) => {
    from = { x: event.clientX, y: event.clientY };
    moved = false;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (from) {
      const dx = event.clientX - from.x, dy = event.clientY - from.y;
      if (!moved && Math.hypot(dx, dy) < 4) return;
      moved = true;
      const step = canvas.width / canvas.clientWidth / scaleOf(canvas);
      view.x -= dx * step;
      view.y -= dy * step;
      from = { x: event.clientX, y: event.clientY };
      draw();
    } else if (!pinned) {
      hovered = pixelAt(canvas, event);
      tell();
      draw();
    }
  });
  canvas.addEventListener("pointerup", (event) => {
    if (from && !moved) hold(pixelAt(canvas, event));
    from = null;
  });
  canvas.addEventListener("pointerleave", () => {
    if (!pinned) { hovered = null; draw(); }
  });
}

function hold(at) {
  pinned = at;
  if (at) hovered = at;
  tell();
  draw();
}

const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
document.addEventListener("keydown", (event) => {
  if (event.target.matches("select, input")) return;
  const step = STEPS[event.key];
  if (step && pinned) {
    event.preventDefault();
    hold({ x: Math.min(Math.max(pinned.x + step[0], 0), W - 1), y: Math.min(Math.max(pinned.y + step[1], 0), H - 1) });
  } else if (event.key === "Escape") hold(null);
  else if (event.key === "0") whole();
  else if (event.key === "1") actual();
});

// ---- the page

function option(select, value, text) {
  select.append(new Option(text, value));
}

function build() {
  const title = head.files.map((file, i) => (TWO ? `${"AB"[i]}: ` : "") + file.title).join(", ");
  document.querySelector("h1").textContent = title;
  const about = document.createElement("small"), first = head.files[0];
  about.textContent = `${W} × ${H}, ${head.bands.length} bands` +
    (first.passes ? `, ${first.passes} passes` : "") + (first.error ? `, error ${short(first.error)}` : "");
  document.querySelector("h1").append(about);
  const modes = [["a", "A"], ["b", "B"], ["difference", "A − B (orange, blue)"], ["sigma", "(A − B) / error, to ±5"]];
  for (const [value, text] of TWO ? modes : modes.slice(0, 1)) option(byId("show"), value, text);
  byId("show-label").hidden = !TWO;
  head.projections.forEach((way, i) => option(byId("colour"), i, way.name));
  option(byId("colour"), "pick", "three bands as R, G, B");
  const n = head.bands.length;
  head.bands.forEach((band, i) => {
    option(byId("colour"), `band${i}`, band);
    for (const id of ["red", "green", "blue"]) option(byId(id), i, band);
  });
  [["red", n - 1], ["green", n >> 1], ["blue", 0]].forEach(([id, band]) => (byId(id).value = band));
  for (const buffer of buffers) {
    const figure = document.createElement("figure"), caption = document.createElement("figcaption");
    const canvas = document.createElement("canvas"), unit = document.createElement("span");
    caption.textContent = buffer.name;
    caption.title = buffer.meaning;
    unit.textContent = buffer.unit;
    canvas.style.aspectRatio = `${W} / ${H}`;
    canvas.setAttribute("aria-label", buffer.name);
    caption.append(unit);
    figure.append(caption, canvas);
    byId("panels").append(figure);
    Object.assign(buffer, { figure, canvas });
    listen(canvas);
    const label = document.createElement("label"), box = document.createElement("input");
    box.type = "checkbox";
    box.checked = true;
    box.addEventListener("change", () => { buffer.on = box.checked; tell(); draw(); });
    label.append(box, ` ${buffer.name}`);
    if (!OTHERS.includes(buffer.kind)) {
      const swatch = document.createElement("i");
      swatch.style.background = buffer.color;
      label.append(swatch);
    }
    byId("chosen").append(label);
  }
  for (const id of ["show", "colour", "red", "green", "blue", "exposure"])
    byId(id).addEventListener("input", () => {
      byId("picks").hidden = byId("colour").value !== "pick";
      byId("stops").textContent = Number(byId("exposure").value);
      draw();
    });
  byId("whole").addEventListener("click", whole);
  byId("actual").addEventListener("click", actual);
  window.addEventListener("resize", draw);
}

build();
readAll().then(
  () => { byId("status").textContent = ""; document.body.dataset.ready = performance.now(); },
  (error) => {
    byId("status").textContent = `this page cannot be read: ${error}`;
    byId("status").className = "failed";
  },
);
