// The designs of the page, and what the reader has chosen to see of them.
const packed = JSON.parse(document.getElementById("data").textContent);

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

function withUnit(axis, text) {
  return axis.unit ? `${text} ${axis.unit}` : text;
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
