// Responses and backbones of a case: levels and models are switched on and off.
const DASHES = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"];
let curves = null;
const shown = { resonance: 0, levels: new Set(), models: new Set(), over: "level" };

const at = (id) => document.getElementById(id);
const ofResonance = () => curves.resonances[shown.resonance];
const drawnModels = () => ofResonance().models.filter((model, place) => shown.models.has(place));
const withBasis = (model) => `${model.words} (${model.basis})`;
const perLevel = () => (curves.unit === "N" ? "mm/N" : "mm/(m/s²)");
const levelText = (place) => `${numberText(curves.levels[place])} ${curves.unit}`;

function unitOfAmplitude() {
  return shown.over === "level" ? perLevel() : "mm";
}

function scaled(values, level) {
  return shown.over === "level" ? values : Float32Array.from(values, (value) => value * level);
}

function startModels() {
  const models = ofResonance().models;
  const reference = models.findIndex((model) => model.reference);
  shown.models = new Set([Math.max(0, reference)]);
}

// harmonics of a curve, and how far its peak is off
function errorText(curve) {
  if (!curve.peak || !curve.converged) return `${curve.harmonics}, error not tested`;
  const error = 100 * Math.abs(curve.peak[1] / curve.converged[1] - 1);
  return `${curve.harmonics}, at the peak ${numberText(Number(error.toPrecision(2)))} % off`;
}

function barText(bar) {
  return bar === null ? "error not tested" : `± ${numberText(Number(bar.toPrecision(2)))} %`;
}

function responseTraces() {
  const traces = [];
  drawnModels().forEach((model, number) => {
    const dash = DASHES[number % DASHES.length];
    for (const place of shown.levels) {
      const curve = model.curves[place];
      if (!curve) continue;
      const level = curves.levels[place], color = curves.colours[place];
      const x = unpack(curve.x), y = scaled(unpack(curve.y), level);
      const name = `${levelText(place)}, ${withBasis(model)}`;
      const text = `<b>${levelText(place)}</b>, ${withBasis(model)}<br>`;
      const unit = unitOfAmplitude();
      const hover = `${text}%{x:.2f} Hz<br>%{y:.4g} ${unit} (${errorText(curve)})<extra></extra>`;
      traces.push({ x, y, name, mode: "lines", line: { color, width: 1.8, dash },
        hovertemplate: hover, meta: { kind: "curve", level, model: withBasis(model) } });
      for (const [first, last] of curve.unstable) {
        traces.push({ x: x.subarray(first, last + 1), y: y.subarray(first, last + 1), mode: "lines",
          line: { color: "#fff", width: 3, dash: "dot" }, hoverinfo: "skip", name: `${name}, unstable` });
      }
      if (curve.peak) {
        traces.push({ x: [curve.peak[0]], y: scaled([curve.peak[1]], level), mode: "markers",
          marker: { color, size: 7 }, hovertemplate: hover, name: `${name}, peak` });
      }
      if (curve.converged) {
        const [frequency, amplitude, ofFrequency, ofAmplitude] = curve.converged;
        const bar = (value, percent) => ({ type: "data", array: [value * (percent || 0) / 100],
          color, thickness: 1.2, width: 4, visible: percent !== null });
        const [height] = scaled([amplitude], level);
        traces.push({ x: [frequency], y: [height], mode: "markers", name: `${name}, all harmonics`,
          marker: { symbol: "diamond", color: "#fff", size: 9, line: { color, width: 2 } },
          error_x: bar(frequency, ofFrequency), error_y: bar(height, ofAmplitude),
          hovertemplate: `${text}peak with all harmonics<br>%{x:.2f} Hz (${barText(ofFrequency)})<br>` +
            `%{y:.4g} ${unit} (${barText(ofAmplitude)})<extra></extra>` });
      }
      if (curve.brokenOff && x.length) {
        traces.push({ x: [x[x.length - 1]], y: [y[y.length - 1]], mode: "markers",
          marker: { symbol: "x", color, size: 10, line: { color: "#000", width: 1 } },
          hovertemplate: `${text}${curve.brokenOff}<extra></extra>`, name: `${name}, breaks off` });
      }
    }
  });
  return traces;
}

// where a limit of the model is reached
function limitShapes() {
  const shapes = [];
  for (const place of shown.levels) {
    const curve = drawnModels().map((model) => model.curves[place]).find((each) => each && each.limit);
    if (!curve) continue;
    const limit = shown.over === "level" ? curve.limit / curves.levels[place] : curve.limit;
    const largest = Math.max(...drawnModels().map((model) =>
      model.curves[place] ? extent(scaled(unpack(model.curves[place].y), curves.levels[place]))[1] : 0));
    if (largest > limit) {
      shapes.push({ type: "line", xref: "paper", x0: 0, x1: 1, y0: limit, y1: limit,
        line: { color: curves.colours[place], width: 1, dash: "dash" } });
    }
  }
  return shapes;
}

// frequencies at which some response is a fifth of its peak or more
function frequencies(traces) {
  let low = Infinity, high = -Infinity, first = Infinity, last = -Infinity;
  for (const { x, y, meta } of traces) {
    if (!meta) continue;
    const [, most] = extent(y), [start, end] = extent(x);
    first = Math.min(first, start);
    last = Math.max(last, end);
    x.forEach((value, place) => {
      if (y[place] > most / 5) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
    });
  }
  const margin = 0.15 * (high - low) || 1;
  return low < Infinity ? [Math.max(low - margin, first), Math.min(high + margin, last)] : undefined;
}

function drawResponses() {
  const traces = responseTraces();
  const values = traces.filter((each) => each.meta).map((each) => extent(each.y)).flat();
  const title = shown.over === "level"
    ? `response / ${curves.unit === "N" ? "force" : "acceleration"} (${perLevel()})` : "response (mm)";
  const limits = limitShapes();
  const range = frequencies(traces);
  const changes = {
    height: 480,
    showlegend: false,
    shapes: limits,
    xaxis: axisLayout({ title: "frequency (Hz)", log: false }, [1, 1000], range ? { range } : {}),
    yaxis: axisLayout({ title, log: true }, extent(values)),
    uirevision: `${shown.resonance} ${shown.over}`,
  };
  at("limit-note").hidden = !limits.length;
  at("models-count").textContent =
    `${shown.models.size} of ${ofResonance().models.length} drawn`;
  return Plotly.react("response-plot", traces, layout(changes), settings);
}

// those of the models that are drawn, or else the first
function drawnBackbones() {
  const models = drawnModels().filter((model) => model.backbone);
  return models.length ? models : ofResonance().models.filter((model) => model.backbone).slice(0, 1);
}

function drawBackbones() {
  const drawn = drawnBackbones();
  at("backbones").hidden = !drawn.length;
  if (!drawn.length) return null;
  const traces = [], shapes = [];
  drawn.forEach((model, number) => {
    const { amplitude, peaks, limit } = model.backbone;
    const x = unpack(amplitude), dash = DASHES[number % DASHES.length];
    const text = `<b>${withBasis(model)}</b><br>${model.backbone.harmonics}, error not tested<br>`;
    for (const [quantity, axis, unit] of [["frequency", "y", "Hz"], ["damping", "y2", "%"]]) {
      const hovertemplate = `${text}%{x:.4g} mm<br>%{y:.5g} ${unit}<extra></extra>`;
      traces.push({ x, y: unpack(model.backbone[quantity]), yaxis: axis, mode: "lines",
        name: `${withBasis(model)}, ${quantity}`, line: { color: ink, width: 1.8, dash }, hovertemplate,
        meta: { quantity } });
      const chosen = peaks.filter((peak) => shown.levels.has(curves.levels.indexOf(peak.level)));
      traces.push({ x: chosen.map((peak) => peak.amplitude), y: chosen.map((peak) => peak[quantity]),
        yaxis: axis, mode: "markers", name: `${withBasis(model)}, peaks`,
        marker: { size: 8, color: chosen.map((peak) => curves.colours[curves.levels.indexOf(peak.level)]) },
        text: chosen.map((peak) => `${numberText(peak.level)} ${curves.unit}`),
        hovertemplate: `${text}peak at %{text}<br>%{x:.4g} mm<br>%{y:.5g} ${unit}<extra></extra>` });
    }
    if (limit) {
      shapes.push({ type: "line", x0: limit, x1: limit, yref: "paper", y0: 0, y1: 1,
        line: { color: soft, width: 1, dash: "dash" } });
    }
  });
  const x = extent(traces.filter((each) => each.meta).map((each) => extent(each.x)).flat());
  const y = (quantity) => extent(
    traces.filter((each) => each.meta && each.meta.quantity === quantity).map((each) => extent(each.y)).flat());
  const limit = Math.min(...shapes.map((each) => each.x0));
  const end = Math.min(x[1], 2 * limit);
  const changes = {
    height: 520,
    showlegend: false,
    shapes,
    xaxis: axisLayout({ title: "amplitude at the output point (mm)", log: true }, x,
      { anchor: "y2", range: [Math.log10(x[0]), Math.log10(end)] }),
    yaxis: axisLayout({ title: "natural frequency (Hz)", log: false }, y("frequency"), { domain: [0.54, 1] }),
    yaxis2: axisLayout({ title: "damping ratio (%)", log: true }, y("damping"), { domain: [0, 0.46] }),
    uirevision: shown.resonance,
  };
  return Plotly.react("backbone-plot", traces, layout(changes), settings);
}

function drawCurves() {
  return Promise.all([drawResponses(), drawBackbones()]);
}

function fillModels() {
  const box = at("models");
  box.replaceChildren();
  let basis = null;
  ofResonance().models.forEach((model, place) => {
    if (model.basis !== basis) {
      basis = model.basis;
      box.append(Object.assign(document.createElement("b"), { textContent: basis }));
    }
    box.append(tick(model.words, shown.models.has(place), (isOn) => {
      shown.models[isOn ? "add" : "delete"](place);
      drawCurves();
    }));
  });
}

// all curves that are drawn, a row for each point
function curvesAsCsv() {
  const rows = [`basis,model,harmonics,level_${curves.unit},frequency_Hz,response_${unitOfAmplitude()}`];
  for (const model of drawnModels()) {
    for (const place of shown.levels) {
      const curve = model.curves[place];
      if (!curve) continue;
      const x = unpack(curve.x), y = scaled(unpack(curve.y), curves.levels[place]);
      x.forEach((frequency, point) =>
        rows.push([model.basis, `"${model.words}"`, curve.harmonics, curves.levels[place],
          Number(frequency.toPrecision(7)), Number(y[point].toPrecision(7))].join()));
    }
  }
  return rows.join("\n") + "\n";
}

function backbonesAsCsv() {
  const rows = ["basis,model,harmonics,amplitude_mm,frequency_Hz,damping_percent"];
  for (const model of drawnBackbones()) {
    const columns = ["amplitude", "frequency", "damping"].map((name) => unpack(model.backbone[name]));
    columns[0].forEach((_, state) => rows.push([model.basis, `"${model.words}"`, model.backbone.harmonics,
      ...columns.map((column) => Number(column[state].toPrecision(7)))].join()));
  }
  return rows.join("\n") + "\n";
}

async function startResponses() {
  curves = await expandJson("curves");
  await loadLibrary();
  curves.levels.forEach((level, place) => {
    shown.levels.add(place);
    at("levels").append(tick(levelText(place), true, (isOn) => {
      shown.levels[isOn ? "add" : "delete"](place);
      drawCurves();
    }, curves.colours[place]));
  });
  const select = at("resonance");
  curves.resonances.forEach((each, place) => option(select, each.resonance, place));
  select.parentElement.hidden = curves.resonances.length < 2;
  select.addEventListener("change", () => {
    shown.resonance = Number(select.value);
    startModels();
    fillModels();
    drawCurves();
  });
  at("over").addEventListener("change", (event) => {
    shown.over = event.target.value;
    drawCurves();
  });
  at("curves-csv").addEventListener("click", () =>
    download(`${curves.case}_responses.csv`, curvesAsCsv(), "text/csv"));
  at("curves-png").addEventListener("click", () =>
    downloadPicture("response-plot", `${curves.case}_responses`));
  at("backbones-csv").addEventListener("click", () =>
    download(`${curves.case}_backbones.csv`, backbonesAsCsv(), "text/csv"));
  at("backbones-png").addEventListener("click", () =>
    downloadPicture("backbone-plot", `${curves.case}_backbones`));
  startModels();
  fillModels();
  at("explore").hidden = false;
  document.body.classList.add("drawn");
  await drawCurves();
  document.body.dataset.ready = "yes";
}
