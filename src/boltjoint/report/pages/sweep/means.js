// Means of a peak over two keys: a heat map, and slices of it.
const MOST_VALUES = 24, MOST_CLASSES = 6, MOST_DOTS = 800;

// cells of a key: one for each of few values, or ranges of equal width; their edges and middles
function cells(axis, wanted) {
  const all = axis.ofLevel(state.level);
  const values = [...new Set(all)].filter(Number.isFinite).sort((a, b) => a - b);
  const shown = values.map((value) => toAxis(axis, value));
  const last = shown.length - 1;
  let edges, centres;
  const single = values.length <= (wanted.values || MOST_VALUES);
  if (single) {
    const between = shown.slice(1).map((value, i) => (value + shown[i]) / 2);
    const side = last > 0 ? [shown[1] - shown[0], shown[last] - shown[last - 1]] : [1, 1];
    edges = [shown[0] - side[0] / 2, ...between, shown[last] + side[1] / 2];
  } else if (wanted.equal) {
    // as many designs in each
    const sorted = Array.from(all, (value) => toAxis(axis, value)).sort((a, b) => a - b);
    const at = (share) => sorted[Math.round(share * (sorted.length - 1))];
    edges = Array.from({ length: wanted.cells + 1 }, (_, i) => at(i / wanted.cells));
    centres = edges.slice(1).map((_, i) => at((i + 0.5) / wanted.cells));
  } else {
    const step = (shown[last] - shown[0]) / wanted.cells;
    edges = Array.from({ length: wanted.cells + 1 }, (_, i) => shown[0] + i * step);
  }
  const number = edges.length - 1;
  const find = (value) => {
    const x = toAxis(axis, value);
    let low = 0, high = number - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (x < edges[middle + 1]) high = middle; else low = middle + 1;
    }
    return low;
  };
  centres = centres || edges.slice(1).map((edge, i) => (edge + edges[i]) / 2);
  const middles = single ? values : centres.map((centre) => fromAxis(axis, centre));
  const bounds = edges.map((edge) => fromAxis(axis, edge));
  const labels = middles.map((middle, i) => single ? numberText(middle)
    : `${numberText(bounds[i])} to ${numberText(bounds[i + 1])}`);
  const words = labels.map((label) => withUnit(axis, label));
  return { axis, number, bounds, middles, labels, words, find };
}

// sums and numbers of designs in the cells of two keys
function means(places, first, second) {
  const x = first.axis.ofLevel(state.level), y = second.axis.ofLevel(state.level);
  const z = state.peak.ofLevel(state.level);
  const sum = new Float64Array(first.number * second.number);
  const found = new Int32Array(sum.length);
  for (const place of places) {
    const cell = second.find(y[place]) * first.number + first.find(x[place]);
    sum[cell] += z[place];
    found[cell] += 1;
  }
  return Array.from({ length: second.number }, (_, row) =>
    Array.from({ length: first.number }, (_, column) => {
      const cell = row * first.number + column;
      return { mean: found[cell] ? sum[cell] / found[cell] : null, designs: found[cell] };
    }));
}

function drawHeatMap(places) {
  if (!document.getElementById("heat-map")) return null;
  const wanted = Math.max(4, Math.min(20, Math.round(Math.sqrt(count / 12))));
  const first = cells(state.first, { cells: wanted });
  const second = cells(state.second, { cells: wanted });
  const rows = means(places, first, second);
  const known = rows.flat().map((cell) => cell.mean).filter((mean) => mean !== null);
  const colour = coloured(state.peak, known);
  const text = rows.map((row, j) => row.map((cell, i) => cell.mean === null ? "" :
    `${state.first.words} ${first.words[i]}<br>${state.second.words} ${second.words[j]}<br>` +
    `mean ${state.peak.words} ${withUnit(state.peak, numberText(cell.mean))}<br>` +
    `${cell.designs} design${cell.designs === 1 ? "" : "s"}`));
  const trace = {
    type: "heatmap",
    x: first.bounds,
    y: second.bounds,
    z: rows.map((row) => row.map(({ mean }) => mean === null ? null : toAxis(state.peak, mean))),
    text,
    hovertemplate: "%{text}<extra></extra>",
    hoverongaps: false,
    colorscale: scale,
    zmin: colour.low,
    zmax: colour.high > colour.low ? colour.high : colour.low + 1,
    colorbar: { ...colour.bar, title: { text: `mean ${state.peak.title}`, side: "right" } },
    xgap: 1,
    ygap: 1,
  };
  const changes = {
    height: 440,
    xaxis: axisLayout(state.first, ends(state.first), { showgrid: false }),
    yaxis: axisLayout(state.second, ends(state.second), { showgrid: false }),
  };
  return Plotly.react("heat-map", [trace], layout(changes), settings);
}

function drawSlices(places) {
  const wanted = Math.max(4, Math.min(12, Math.round(Math.sqrt(count / 20))));
  const first = cells(state.first, { cells: wanted, equal: true });
  const classes = { cells: 4, values: MOST_CLASSES, equal: true };
  const second = cells(state.second, classes);
  const rows = means(places, first, second);
  const x = state.first.ofLevel(state.level), y = state.second.ofLevel(state.level);
  const z = state.peak.ofLevel(state.level);
  const dots = places.slice(0, MOST_DOTS);
  const one = state.first === state.second;
  const colourOf = (row) =>
    packed.colours[Math.round(row * (COLOURS - 1) / Math.max(1, second.number - 1))];
  const traces = [];
  for (let row = 0; row < second.number; row++) {
    const mine = dots.filter((place) => second.find(y[place]) === row);
    traces.push({
      x: mine.map((place) => x[place]),
      y: mine.map((place) => z[place]),
      customdata: mine,
      mode: "markers",
      marker: { color: colourOf(row), size: 5, opacity: 0.3 },
      hovertemplate: "%{x:.4g}, %{y:.4g}<extra></extra>",
      showlegend: false,
    });
  }
  for (let row = 0; row < second.number; row++) {
    traces.push({
      x: first.middles,
      y: rows[row].map((cell) => cell.mean),
      mode: "lines+markers",
      line: { color: colourOf(row), width: 2.2 },
      marker: { color: colourOf(row), size: 7, line: { color: "#fff", width: 1 } },
      name: second.labels[row],
      showlegend: !one,
      hovertemplate: "mean %{y:.4g} at %{x:.4g}<extra></extra>",
    });
  }
  if (state.design !== null && hasPeak(state.design)) {
    traces.push({
      x: [x[state.design]],
      y: [z[state.design]],
      mode: "markers",
      marker: { size: 12, color: "rgba(0,0,0,0)", line: { color: "#c0392b", width: 2.5 } },
      name: `design ${designs[state.design]}`,
      showlegend: false,
      hoverinfo: "skip",
    });
  }
  const changes = {
    height: 440,
    xaxis: axisLayout(state.first, ends(state.first)),
    yaxis: axisLayout(state.peak, ends(state.peak)),
    legend: { title: { text: state.second.title, font }, orientation: "h", x: 0, y: 1.02, yanchor: "bottom" },
    margin: { l: 70, r: 20, t: 95, b: 55 },
  };
  return Plotly.react("slices", traces, layout(changes), settings);
}
