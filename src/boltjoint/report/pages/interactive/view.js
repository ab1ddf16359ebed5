// The joint in space: parts, shapes, contact, and the hysteresis loop of a pair that is picked.
const PARTS = ["#b9cfe4", "#e6d3b3", "#8b949e", "#b3a797"];
const STATES = ["#0072b2", "#e69f00", "#009e73", "#cc79a7"];
// largest displacement that is drawn, over the length of the structure
const ENLARGED = 0.08;
let view = null, space = null;
const look = { shape: "rest", colour: "pressure", peak: 0, enlarge: 1, lines: true, parts: new Set(),
  pair: null, phase: 1, playing: false };

function startSpace() {
  const { surface, contact } = view;
  space = {
    nodes: surface ? unpack(surface.nodes) : null,
    own: surface ? Uint32Array.from(unpack(surface.nodes), (_, i) => i) : null,
    parts: surface ? surface.parts.map((part) => ({
      words: part.words,
      faces: unpack(part.faces, Uint16Array),
      edges: unpack(part.edges, Uint16Array),
    })) : [],
    pairs: unpack(contact.places),
    corners: contact.corners ? unpack(contact.corners, Uint16Array) : null,
    cells: contact.cells ? unpack(contact.cells, Uint16Array) : null,
    owners: contact.owners ? unpack(contact.owners, Uint16Array) : null,
    nodeOfPair: contact.nodes ? unpack(contact.nodes, Uint16Array) : null,
    pressure: unpack(view.pressure),
    load: unpack(view.load),
    gap: unpack(view.gap),
    elementOfPair: new Map(Array.from(unpack(view.elements, Uint16Array), (pair, element) => [pair, element])),
    slipForce: unpack(view.slipForce),
    displacements: new Map(),
  };
  space.ends = [0, 1, 2].map((axis) =>
    extent((space.nodes || space.pairs).filter((_, i) => i % 3 === axis)));
  space.length = Math.max(...space.ends.map(([low, high]) => high - low));
  // two bars hide the contact between them: the second starts switched off
  space.parts.forEach((part, place) => place !== 1 && look.parts.add(place));
}

// the chosen shape: its displacement in mm, and by how much it is enlarged
function displacement() {
  const shape = look.shape === "rest" ? null
    : look.shape === "peak" ? view.peaks[look.peak] : view.shapes[Number(look.shape)];
  if (!shape || !shape.values || !space.nodes) return null;
  if (!space.displacements.has(shape)) {
    const numbers = unpack(shape.values, Int16Array);
    const largest = extent(numbers.map(Math.abs))[1];
    space.displacements.set(shape, { numbers, unit: 1 / largest, largest: largest * shape.unit * 1e3 });
  }
  return space.displacements.get(shape);
}

// places of points, moved by the chosen shape
function moved(places, nodeOf) {
  const chosen = displacement(), number = places.length / 3;
  const x = new Float32Array(number), y = new Float32Array(number), z = new Float32Array(number);
  const scale = chosen && nodeOf ? chosen.unit * ENLARGED * space.length * look.enlarge * look.phase : 0;
  for (let i = 0; i < number; i++) {
    x[i] = places[3 * i];
    y[i] = places[3 * i + 1];
    z[i] = places[3 * i + 2];
    if (scale) {
      const node = nodeOf[i];
      x[i] += scale * chosen.numbers[3 * node];
      y[i] += scale * chosen.numbers[3 * node + 1];
      z[i] += scale * chosen.numbers[3 * node + 2];
    }
  }
  return { x, y, z };
}

// what colours the pairs: values, words, unit
function field() {
  const number = space.pairs.length / 3;
  const ofElements = (values) => Array.from({ length: number }, (_, pair) =>
    space.elementOfPair.has(pair) ? values[space.elementOfPair.get(pair)] : null);
  const peak = view.peaks[look.peak];
  const at = peak && `at ${numberText(peak.level)} ${view.unit}`;
  if (look.colour === "gap") return { words: "gap (µm)", values: Array.from(space.gap) };
  if (look.colour === "state" && peak) {
    return { words: `contact state ${at}`, values: ofElements(unpack(peak.state, Int8Array)), isState: true };
  }
  if (look.colour === "slide" && peak) {
    return { words: `relative motion (µm) ${at}`, values: ofElements(unpack(peak.slide)) };
  }
  return { words: "contact pressure (MPa)", values: Array.from(space.pressure) };
}

// nodes a little outside of the surface, where lines on it are seen
function lifted({ x, y, z }) {
  const sums = [x, y, z].map((each) => new Float32Array(each.length));
  for (const { faces } of space.parts) {
    for (let face = 0; face < faces.length; face += 4) {
      const corner = faces.subarray(face, face + 4);
      const [a, , c] = corner, [, b, , d] = corner;
      const u = [x[c] - x[a], y[c] - y[a], z[c] - z[a]], v = [x[d] - x[b], y[d] - y[b], z[d] - z[b]];
      const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
      for (const node of corner) sums.forEach((sum, axis) => (sum[node] += n[axis]));
    }
  }
  const [nx, ny, nz] = sums, by = 5e-4 * space.length;
  const place = (from, n) => from.map((value, i) => {
    const size = Math.hypot(nx[i], ny[i], nz[i]);
    return size ? value + (by * n[i]) / size : value;
  });
  return { x: place(x, nx), y: place(y, ny), z: place(z, nz) };
}

function partTraces() {
  if (!space.nodes) return [];
  const { x, y, z } = moved(space.nodes, space.own);
  const above = look.lines ? lifted({ x, y, z }) : null;
  const traces = [];
  space.parts.forEach((part, place) => {
    if (!look.parts.has(place)) return;
    const i = [], j = [], k = [];
    for (let face = 0; face < part.faces.length; face += 4) {
      const [a, b, c, d] = part.faces.subarray(face, face + 4);
      i.push(a, a);
      j.push(b, c);
      k.push(c, d);
    }
    traces.push({ type: "mesh3d", x, y, z, i, j, k, color: PARTS[Math.min(place, PARTS.length - 2)],
      flatshading: true, hoverinfo: "skip", name: part.words,
      lighting: { ambient: 0.65, diffuse: 0.5, specular: 0.05 } });
    if (!look.lines) return;
    const line = [[], [], []];
    for (const node of part.edges) {
      line[0].push(above.x[node]);
      line[1].push(above.y[node]);
      line[2].push(above.z[node]);
      if (line[0].length % 3 === 2) line.forEach((each) => each.push(null));
    }
    traces.push({ type: "scatter3d", mode: "lines", x: line[0], y: line[1], z: line[2],
      line: { color: "#5b6772", width: 1 }, hoverinfo: "skip", name: "mesh" });
  });
  return traces;
}

function contactTraces() {
  const { words, values, isState } = field();
  const { x, y, z } = moved(space.pairs, space.nodeOfPair);
  const known = values.filter((value) => value !== null && value >= 0);
  const [low, high] = isState ? [-0.5, STATES.length - 0.5] : [0, extent(known)[1]];
  const steps = STATES.flatMap((colour, number) =>
    [[number / STATES.length, colour], [(number + 1) / STATES.length, colour]]);
  const scale = isState ? steps : "Viridis";
  const bar = { title: { text: words, side: "right" }, thickness: 14, len: 0.7 };
  if (isState) {
    Object.assign(bar, { tickvals: [0, 1, 2, 3], ticktext: view.states.map((each) => each.replace(" with ", "<br>with ")) });
  }
  const text = (pair) => `pair ${pair}<br>${values[pair] === null ? "no element"
    : isState ? view.states[values[pair]] || "unknown" : numberText(values[pair])}`;
  const traces = [];
  if (space.cells) {
    const { corners, cells, owners } = space;
    const number = corners.length / 4;
    const X = new Float32Array(number), Y = new Float32Array(number), Z = new Float32Array(number);
    for (let corner = 0; corner < number; corner++) {
      for (let n = 0; n < 4; n++) {
        const pair = corners[4 * corner + n];
        X[corner] += x[pair] / 4;
        Y[corner] += y[pair] / 4;
        Z[corner] += z[pair] / 4;
      }
    }
    const none = { i: [], j: [], k: [] }, known = { i: [], j: [], k: [] }, intensity = [];
    for (let cell = 0; cell < owners.length; cell++) {
      const value = values[owners[cell]], has = value !== null && value >= 0;
      const [a, b, c, d] = cells.subarray(4 * cell, 4 * cell + 4);
      const { i, j, k } = has ? known : none;
      i.push(a, a);
      j.push(b, c);
      k.push(c, d);
      if (has) intensity.push(value, value);
    }
    const shared = { type: "mesh3d", x: X, y: Y, z: Z, hovertemplate: `%{text}<extra>${words}</extra>`,
      text: Array.from(X, (_, corner) => text(corners[4 * corner])),
      customdata: Array.from(X, (_, corner) => corners[4 * corner]),
      lighting: { ambient: 1, diffuse: 0, specular: 0 } };
    traces.push({ ...shared, ...known, intensity, intensitymode: "cell", colorscale: scale,
      cmin: low, cmax: high || 1, colorbar: bar, name: "contact" });
    traces.push({ ...shared, ...none, color: "#dcdfe3", name: "without" });
  } else {
    const pairs = Array.from(x, (_, pair) => pair);
    traces.push({ type: "scatter3d", mode: "markers", x, y, z, name: "contact", customdata: pairs,
      text: pairs.map(text), hovertemplate: `%{text}<extra>${words}</extra>`,
      marker: { size: 5, color: values, colorscale: scale, cmin: low, cmax: high || 1, colorbar: bar } });
  }
  if (look.pair !== null) {
    traces.push({ type: "scatter3d", mode: "markers", x: [x[look.pair]], y: [y[look.pair]],
      z: [z[look.pair]], hoverinfo: "skip", name: "picked",
      marker: { size: 8, color: "#e3117a", line: { color: "#fff", width: 2 } } });
  }
  return traces;
}

function drawView() {
  // room for a deflection of any shape, and axes of one scale
  const room = (ENLARGED * 1.5 + 0.02) * space.length;
  const ranges = space.ends.map(([low, high]) => [low - room, high + room]);
  const [x, y, z] = ranges.map(([low, high]) => (4.6 * (high - low)) / (space.length + 2 * room));
  const bare = (range) => ({ visible: false, range });
  const scene = { aspectmode: "manual", aspectratio: { x, y, z },
    xaxis: bare(ranges[0]), yaxis: bare(ranges[1]), zaxis: bare(ranges[2]),
    camera: look.camera || { eye: { x: -0.9, y: -1.6, z: 1.1 }, projection: { type: "orthographic" } } };
  const changes = { height: 560, margin: { l: 0, r: 0, t: 0, b: 0 }, scene, showlegend: false, uirevision: "view" };
  const chosen = displacement();
  const isReal = chosen && (look.shape === "peak" || view.shapes[Number(look.shape)].words === "under preload");
  const factor = isReal ? (ENLARGED * space.length * look.enlarge) / chosen.largest : 0;
  at("view-scale").textContent = isReal ? `Largest displacement: ${numberText(chosen.largest)} mm` +
    `${look.shape === "peak" ? ` with ${view.peaks[look.peak].harmonics}` : ""}, drawn ${numberText(Number(factor.toPrecision(2)))} times as large.` : "";
  return Plotly.react("view-plot", [...partTraces(), ...contactTraces()], layout(changes), still);
}

// what is known of the pair that is picked, and its loop

function pick(pair) {
  const number = space.pairs.length / 3;
  if (pair !== null && (!Number.isInteger(pair) || pair < 0 || pair >= number)) return;
  look.pair = pair;
  at("pair-number").value = pair;
  drawView();
  drawLoop();
}

// a loop with its dissipation: displacement in a unit, whose product with N has another
function plotLoop(x, y, name, words, [unit, ofWork], known) {
  let work = known || 0;
  for (let i = 1; i < x.length && known === undefined; i++) work += (y[i] + y[i - 1]) / 2 * (x[i] - x[i - 1]);
  const title = `dissipation in a period: ${numberText(Number(Math.abs(work).toPrecision(3)))} ${ofWork}`;
  const traces = [{ x, y, mode: "lines", line: { color: ink, width: 2 },
    hovertemplate: `%{x:.4g} ${unit}<br>%{y:.4g} N<extra></extra>`, name }];
  const changes = {
    height: 340,
    title: { text: title, font: { ...font, size: 13 }, x: 0.02, xanchor: "left", y: 0.98, yanchor: "top" },
    xaxis: axisLayout({ title: `${words} (${unit})`, log: false }, extent(x)),
    yaxis: axisLayout({ title: "friction force (N)", log: false }, extent(y)),
    margin: { l: 70, r: 20, t: 40, b: 55 },
  };
  at("loop").hidden = false;
  return Plotly.react("loop-plot", traces, layout(changes), settings);
}

// the loop of all elements, or of the pair that is picked
function drawLoop() {
  const peak = view.peaks[look.peak];
  at("loop").hidden = true;
  if (look.pair !== null) return drawLoopOfPair(peak);
  if (!peak || !peak.friction) return null;
  at("pair-facts").textContent = `The whole joint at the peak at ${numberText(peak.level)} ${view.unit}: ` +
    `friction of all pairs in the shape of the deflection, as a force at the output point${peak.harmonics ? ` (with ${peak.harmonics})` : ""}.`;
  const [x, y] = [peak.output, peak.friction].map((text) => Array.from(unpack(text)));
  return plotLoop([...x, x[0]], [...y, y[0]], "joint", "displacement of the output point", ["mm", "mJ"], peak.work);
}

function drawLoopOfPair(peak) {
  const pair = look.pair, element = space.elementOfPair.get(pair);
  const place = Array.from(space.pairs.subarray(3 * pair, 3 * pair + 3), (each) => numberText(Number(each.toFixed(3))));
  const facts = [`Pair ${pair} at (${place.join(", ")}) mm`];
  if (space.load[pair] > 0) {
    facts.push(`normal load ${numberText(space.load[pair])} N, pressure ${numberText(space.pressure[pair])} MPa`);
  } else {
    facts.push(`open under preload, gap ${numberText(space.gap[pair])} µm`);
  }
  if (element === undefined) {
    facts.push("no friction element");
  } else if (peak) {
    const state = unpack(peak.state, Int8Array)[element];
    facts.push(`slip force ${numberText(space.slipForce[element])} N`);
    facts.push(`at the peak at ${numberText(peak.level)} ${view.unit}: ${view.states[state] || "unknown state"}, ` +
      `relative motion ± ${numberText(unpack(peak.slide)[element])} µm`);
  }
  at("pair-facts").textContent = `${facts.join("; ")}.`;
  if (element === undefined || !peak || !peak.force) return null;
  const part = (text) => unpack(text, Int8Array).subarray(element * peak.samples, (element + 1) * peak.samples);
  const closed = (values, half, middle) => {
    const found = Array.from(values, (value) => middle + (half * value) / 127);
    return [...found, found[0]];
  };
  const x = closed(part(peak.displacement), unpack(peak.slide)[element], unpack(peak.middle)[element]);
  const y = closed(part(peak.force), unpack(peak.largestForce)[element], 0);
  return plotLoop(x, y, `pair ${pair}`, "relative displacement", ["µm", "µJ"]);
}

function loopAsCsv() {
  const [{ x, y, name }] = at("loop-plot").data, unit = name === "joint" ? "mm" : "um";
  const rows = x.map((displacement, i) => [displacement, y[i]].map((each) => Number(each.toPrecision(7))).join());
  return [`displacement_${unit},friction_force_N`, ...rows].join("\n") + "\n";
}

function animate(time) {
  if (!look.playing) return;
  look.phase = Math.cos(time / 300);
  drawView().then(() => requestAnimationFrame(animate));
}

function fillView() {
  const shape = at("view-shape");
  option(shape, "at rest", "rest");
  view.shapes.forEach((each, place) => option(shape, each.words, place));
  if (space.nodes && view.peaks.some((peak) => peak.values)) option(shape, "deflection at the peak", "peak");
  const peaks = at("view-peak");
  view.peaks.forEach((peak, place) => option(peaks,
    `${numberText(peak.level)} ${view.unit} (${peak.frequency.toFixed(1)} Hz)`, place));
  peaks.parentElement.hidden = !view.peaks.length;
  const redraw = () => {
    look.shape = shape.value;
    look.colour = at("view-colour").value;
    look.peak = Number(peaks.value || 0);
    look.enlarge = Number(at("view-enlarge").value);
    drawView();
    drawLoop();
  };
  for (const id of ["view-shape", "view-colour", "view-peak", "view-enlarge"]) {
    at(id).addEventListener("input", redraw);
  }
  space.parts.forEach((part, place) => at("view-parts").append(
    tick(part.words, look.parts.has(place), (isOn) => {
      look.parts[isOn ? "add" : "delete"](place);
      drawView();
    })));
  if (space.parts.length) {
    at("view-parts").append(tick("mesh lines", look.lines, (isOn) => {
      look.lines = isOn;
      drawView();
    }));
  }
  at("view-play").addEventListener("click", () => {
    look.playing = !look.playing;
    at("view-play").textContent = look.playing ? "stop" : "move";
    look.phase = 1;
    if (look.playing) requestAnimationFrame(animate);
    else drawView();
  });
  at("view-png").addEventListener("click", () => downloadPicture("view-plot", `${view.case}_joint`));
  at("loop-csv").addEventListener("click", () =>
    download(`${view.case}_loop.csv`, loopAsCsv(), "text/csv"));
  at("loop-png").addEventListener("click", () => downloadPicture("loop-plot", `${view.case}_loop`));
  at("pair-number").addEventListener("change", (event) => pick(event.target.value ? Number(event.target.value) : null));
}

async function openView() {
  at("view-open").disabled = true;
  at("view-open").textContent = "opening …";
  view = await expandJson("view-content");
  await loadLibrary();
  startSpace();
  fillView();
  at("view").hidden = false;
  at("view-open").hidden = true;
  await drawView();
  await drawLoop();
  at("view-plot").on("plotly_click", (event) => {
    const found = event.points.find((point) => Number.isInteger(point.customdata));
    // what is drawn anew within its own event would tell it again
    if (found) setTimeout(() => pick(found.customdata), 0);
  });
  at("view-plot").on("plotly_relayout", (change) => {
    if (change["scene.camera"]) look.camera = change["scene.camera"];
  });
  at("view").dataset.ready = "yes";
}
