// Sobol indices of the peaks at the excitation level.
function drawShares() {
  if (!packed.indices.length) return;
  ["shares-of-frequency", "shares-of-amplitude"].forEach((id, peak) => {
    const rows = packed.indices.filter((row) => row.peak === peak && row.level === state.level);
    const bars = (order, name, color) => {
      const known = (row, end) => row[order][0] === null ? 0 : Math.max(0, end);
      return {
        type: "bar",
        x: rows.map((row) => row.key.replaceAll(" ", "<br>")),
        y: rows.map((row) => row[order][0]),
        error_y: {
          type: "data",
          symmetric: false,
          array: rows.map((row) => known(row, row[order][2] - row[order][0])),
          arrayminus: rows.map((row) => known(row, row[order][0] - row[order][1])),
          color: ink,
          thickness: 1.2,
        },
        name,
        marker: { color },
        customdata: rows.map((row) => row[order].slice(1)),
        hovertemplate: `${name}: %{y:.3f}<br>95 % within %{customdata[0]:.3f} to ` +
          "%{customdata[1]:.3f}<extra></extra>",
      };
    };
    const changes = {
      height: 380,
      barmode: "group",
      title: { text: peaks[peak].words, font: { ...font, size: 14 }, x: 0.5, y: 0.98, yanchor: "top" },
      xaxis: { automargin: true, linecolor: soft, showline: true },
      yaxis: axisLayout({ title: "share of the variance", log: false }, [0, 1], { rangemode: "tozero" }),
      legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" },
      margin: { l: 60, r: 20, t: 70, b: 40 },
    };
    const traces = [bars("first_order", "first order", "#3b4a8c"), bars("total", "total", "#b4bada")];
    Plotly.react(id, traces, layout(changes), still);
  });
}
