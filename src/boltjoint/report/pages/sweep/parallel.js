// Parallel coordinates of keys and peaks: limits that are set on them choose designs everywhere.

// how an axis counts: the logarithm where it is logarithmic
function toAxis(axis, value) {
  return axis.log ? Math.log10(value) : value;
}

function fromAxis(axis, value) {
  return axis.log ? 10 ** value : value;
}

function dimension(axis, places) {
  const all = axis.ofLevel(state.level);
  const values = places.map((place) => all[place]);
  const [low, high] = extent(values);
  const room = high > low ? 0 : Math.abs(high) * 0.01 || 1;
  const found = {
    name: String(axis.number),
    label: axis.title.replace(" ", "<br>"),
    values: values.map((value) => toAxis(axis, value)),
    range: [toAxis(axis, low) - room, toAxis(axis, high) + room],
  };
  if (axis.log) {
    const ticks = decadeTicks(low, high);
    found.tickvals = ticks.map((tick) => toAxis(axis, tick));
    found.ticktext = ticks.map(numberText);
  } else {
    found.tickformat = high >= 1e6 ? ".3~e" : "~r";
  }
  const ranges = state.limits.get(axis.number);
  if (ranges) {
    found.constraintrange = ranges.map((range) => range.map((value) => toAxis(axis, value)));
  }
  return found;
}

function drawParallel() {
  const places = withPeak().filter((place) => place < packed.lines);
  const values = state.colour.ofLevel(state.level);
  const colour = coloured(state.colour, places.map((place) => values[place]));
  const trace = {
    type: "parcoords",
    dimensions: state.order.map((number) => dimension(axes[number], places)),
    line: {
      color: colour.shown,
      colorscale: scale,
      cmin: colour.low,
      cmax: colour.high,
      showscale: true,
      colorbar: colour.bar,
    },
    unselected: { line: { color: "#b8c2cc", opacity: 0.06 } },
    labelfont: { ...font, size: 13 },
    tickfont: { ...font, size: 12 },
    rangefont: { ...font, size: 1, color: "rgba(0,0,0,0)" },
  };
  const changes = { height: 450, margin: { l: 90, r: 60, t: 80, b: 30 } };
  return Plotly.react("parallel", [trace], layout(changes), still);
}

// take over what was set by dragging
function readLimits() {
  const dimensions = document.getElementById("parallel").data[0].dimensions;
  state.order = dimensions.map((each) => Number(each.name));
  state.limits.clear();
  for (const { name, constraintrange } of dimensions) {
    if (!constraintrange || !constraintrange.length) continue;
    const axis = axes[Number(name)];
    const ranges = Array.isArray(constraintrange[0]) ? constraintrange : [constraintrange];
    const set = ranges.map((range) => range.map((value) => fromAxis(axis, value)));
    state.limits.set(axis.number, set);
  }
}
