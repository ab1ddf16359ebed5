// Responses of the designs within the limits, over the bands of all designs.
const family = packed.responses && {
  designs: packed.responses.designs,
  frequency: unpack(packed.responses.frequency),
  amplitude: unpack(packed.responses.amplitude),
  bands: unpack(packed.responses.bands),
};
const COLOURS = packed.colours.length;

function curve(place) {
  const points = family.frequency.length;
  const start = (state.level * family.designs + place) * points;
  return family.amplitude.subarray(start, start + points);
}

function quantile(number) {
  const points = family.frequency.length, lines = 5;
  const start = (state.level * lines + number) * points;
  return family.bands.subarray(start, start + points);
}

function bandTraces() {
  const visible = document.getElementById("bands").checked;
  const skipped = { x: family.frequency, mode: "lines", hoverinfo: "skip", visible };
  const edge = { ...skipped, line: { width: 1, color: soft }, showlegend: false };
  const traces = [];
  for (const [low, high, opacity, name] of [
    [0, 4, 0.16, "nine tenths of all designs"],
    [1, 3, 0.3, "half of all designs"],
  ]) {
    const fill = { fill: "tonexty", fillcolor: `rgba(90, 104, 118, ${opacity})` };
    traces.push({ ...edge, y: quantile(low) });
    traces.push({ ...edge, ...fill, y: quantile(high), name, showlegend: true });
  }
  const median = { color: ink, width: 2, dash: "dash" };
  traces.push({ ...skipped, y: quantile(2), name: "median of all designs", line: median });
  return traces;
}

// designs of one colour are one line with gaps, so that hundreds are drawn quickly
function curveTraces(places) {
  const values = state.colour.ofLevel(state.level);
  const all = withPeak();
  const { low, high } = coloured(state.colour, all.map((place) => values[place]));
  const groups = Array.from({ length: COLOURS }, () => []);
  for (const place of places) {
    const value = toAxis(state.colour, values[place]);
    const share = high > low ? (value - low) / (high - low) : 0;
    groups[Math.min(COLOURS - 1, Math.floor(share * COLOURS))].push(place);
  }
  return groups.map((group, number) => {
    const x = [], y = [], customdata = [];
    for (const place of group) {
      x.push(...family.frequency, null);
      y.push(...curve(place), null);
      customdata.push(...Array(family.frequency.length + 1).fill(place));
    }
    return {
      x, y, customdata,
      mode: "lines",
      line: { color: packed.colours[number], width: 1 },
      opacity: places.length > 100 ? 0.55 : 0.85,
      showlegend: false,
      visible: document.getElementById("lines").checked,
      hovertemplate: "%{x:.4g} Hz, %{y:.4g} mm<extra></extra>",
    };
  });
}

function drawResponses(places) {
  if (!family) return null;
  const drawn = places.filter((place) => place < family.designs);
  const traces = [...curveTraces(drawn), ...bandTraces()];
  if (state.design !== null && state.design < family.designs) {
    traces.push({
      x: family.frequency,
      y: curve(state.design),
      mode: "lines",
      line: { color: "#c0392b", width: 2.5 },
      name: `design ${designs[state.design]}`,
      hoverinfo: "skip",
    });
  }
  const amplitude = { title: "response amplitude (mm)", log: true };
  const frequency = { title: "frequency (Hz)", log: false };
  const range = extent(family.frequency);
  const size = family.designs * family.frequency.length;
  const ofLevel = family.amplitude.subarray(state.level * size, (state.level + 1) * size);
  const changes = {
    height: 460,
    xaxis: axisLayout(frequency, range, { range }),
    yaxis: axisLayout(amplitude, extent(ofLevel)),
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" },
    margin: { l: 70, r: 20, t: 50, b: 55 },
    uirevision: "responses",
  };
  document.getElementById("responses").dataset.drawn = drawn.length;
  return Plotly.react("responses", traces, layout(changes), settings);
}
