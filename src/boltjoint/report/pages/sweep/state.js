// The designs of the page, and what the reader has chosen to see of them.
const packed = JSON.parse(document.getElementById("data").textContent);

function unpack(text, Kind = Float32Array) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Kind(bytes.buffer);
}

const designs = unpack(packed.designs, Int32Array);
const count = designs.length;
const levels = Math.max(1, packed.levels.length);

// keys, then peaks: each has values by level, those of a key the same at all levels
const axes = [...packed.keys, ...packed.peaks].map((each, number) => {
  const whole = unpack(each.values);
  const ofLevel = (level) =>
    whole.length === count ? whole : whole.subarray(level * count, (level + 1) * count);
  const isPeak = number >= packed.keys.length;
  const title = each.unit ? `${each.words} (${each.unit})` : each.words;
  return { number, isPeak, title, words: each.words, unit: each.unit, log: each.log, ofLevel };
});
const keys = axes.filter((axis) => !axis.isPeak);
const peaks = axes.filter((axis) => axis.isPeak);

const state = {
  level: levels - 1,
  colour: peaks[1],
  peak: peaks[1],
  first: keys[0],
  second: keys[1] || keys[0],
  limits: new Map(), // by the number of an axis, ranges [lowest, highest]
  order: axes.map((axis) => axis.number),
  design: null, // its place on the page
};

function hasPeak(place) {
  return peaks.every((peak) => Number.isFinite(peak.ofLevel(state.level)[place]));
}

function isWithin(place) {
  for (const [number, ranges] of state.limits) {
    const value = axes[number].ofLevel(state.level)[place];
    if (!ranges.some(([low, high]) => low <= value && value <= high)) return false;
  }
  return true;
}

// places of the designs that have a peak at the level, and of those within all limits
function withPeak() {
  return [...Array(count).keys()].filter(hasPeak);
}

function selected() {
  return withPeak().filter(isWithin);
}

// lowest and highest of the finite values; of none, ends that a logarithmic axis may have too
function extent(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return low <= high ? [low, high] : [1, 2];
}

function numberText(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-3) {
    const [base, power] = value.toExponential(2).split("e");
    const raised = String(Number(power)).replace(/[-\d]/g, (sign) =>
      sign === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[sign]);
    return `${String(Number(base))} × 10${raised}`.replace("-", "−");
  }
  return String(Number(value.toPrecision(4))).replace("-", "−");
}

function withUnit(axis, text) {
  return axis.unit ? `${text} ${axis.unit}` : text;
}

// on a logarithmic axis, the places of its labels: the more, the fewer decades it has
function decadeTicks(low, high) {
  if (!(low > 0)) return [];
  const ticks = [];
  const ratio = high / low;
  const steps = ratio > 2e3 ? [1] : ratio > 30 ? [1, 2, 5] : [1, 1.5, 2, 3, 5, 7];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power++) {
    for (const step of steps) {
      const tick = step * 10 ** power;
      if (tick >= low * 0.999 && tick <= high * 1.001) ticks.push(Number(tick.toPrecision(3)));
    }
  }
  return ticks;
}

// colours

const scale = packed.colours.map((colour, i) => [i / (packed.colours.length - 1), colour]);

// values as the colour scale counts them, and the labels of its bar
function coloured(axis, values) {
  const shown = axis.log ? Array.from(values, Math.log10) : Array.from(values);
  const [low, high] = extent(shown.filter(Number.isFinite));
  const bar = { title: { text: axis.title, side: "right" }, thickness: 14, outlinewidth: 0 };
  if (axis.log) {
    const ticks = decadeTicks(10 ** low, 10 ** high);
    bar.tickvals = ticks.map(Math.log10);
    bar.ticktext = ticks.map(numberText);
  }
  return { shown, low, high, bar };
}

// lowest and highest value of an axis at the level
function ends(axis) {
  return extent(axis.ofLevel(state.level));
}

// layout that all drawings share

const style = getComputedStyle(document.documentElement);
const ink = style.getPropertyValue("--ink").trim();
const soft = style.getPropertyValue("--soft").trim();
const line = style.getPropertyValue("--line").trim();
const font = { family: getComputedStyle(document.body).fontFamily, size: 13, color: ink };
const still = { responsive: true, displayModeBar: false };
// no button that sends the drawing elsewhere
const settings = {
  responsive: true,
  displaylogo: false,
  plotlyServerURL: "",
  modeBarButtons: [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
};

function layout(changes) {
  return {
    font,
    paper_bgcolor: "#fff",
    plot_bgcolor: "#fff",
    margin: { l: 70, r: 20, t: 30, b: 55 },
    hovermode: "closest",
    ...changes,
  };
}

function axisLayout(axis, [low, high], changes) {
  const ticks = axis.log ? decadeTicks(low, high) : [];
  return {
    title: { text: axis.title },
    type: axis.log ? "log" : "linear",
    gridcolor: line,
    zeroline: false,
    ticks: "outside",
    tickcolor: line,
    linecolor: soft,
    showline: true,
    automargin: true,
    exponentformat: Math.max(Math.abs(low), Math.abs(high)) < 1e6 ? "none" : "power",
    ...(axis.log ? { tickvals: ticks, ticktext: ticks.map(numberText) } : {}),
    ...changes,
  };
}
