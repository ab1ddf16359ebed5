// What all drawings share: numbers, axes, layout.
function unpack(text, Kind = Float32Array) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Kind(bytes.buffer);
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
