// What the reader changes, and the drawings that follow.
const element = (id) => document.getElementById(id);

function drawSelection() {
  const places = selected();
  drawResponses(places);
  if (keys.length) {
    drawHeatMap(places);
    drawSlices(places);
  }
  const all = withPeak().length;
  const responses = family ? places.filter((place) => place < family.designs).length : 0;
  const drawn = family ? `, ${responses} response${responses === 1 ? "" : "s"} drawn` : "";
  const which = state.limits.size ? "within the limits" : "with a peak";
  element("count").textContent =
    `${places.length} of ${state.limits.size ? all : count} designs ${which}${drawn}`;
  element("clear").disabled = state.limits.size === 0;
  fillLimits();
  tellDesign();
}

function drawAll() {
  if (element("level-value")) element("level-value").textContent = packed.levels[state.level];
  const done = drawParallel();
  drawSelection();
  drawShares();
  return done;
}

// limits as numbers

function fillLimits() {
  for (const input of element("limits").querySelectorAll("input")) {
    const ranges = state.limits.get(Number(input.dataset.axis));
    const ends = ranges ? ranges.flat() : [];
    const value = input.dataset.end === "low" ? Math.min(...ends) : Math.max(...ends);
    input.value = Number.isFinite(value) ? Number(value.toPrecision(5)) : "";
  }
}

function makeLimits() {
  for (const axis of axes) {
    const row = element("limits").insertRow();
    row.insertCell().textContent = axis.title;
    for (const end of ["low", "high"]) {
      const input = document.createElement("input");
      Object.assign(input, { type: "number", step: "any" });
      Object.assign(input.dataset, { axis: axis.number, end });
      input.setAttribute("aria-label", `${end === "low" ? "lowest" : "highest"} ${axis.title}`);
      input.addEventListener("change", () => typeLimit(axis, row));
      row.insertCell().append(input);
    }
  }
}

function typeLimit(axis, row) {
  const [low, high] = [...row.querySelectorAll("input")].map((input) => input.value);
  const all = extent(Array.from({ length: levels }, (_, each) => extent(axis.ofLevel(each))).flat());
  if (low === "" && high === "") {
    state.limits.delete(axis.number);
  } else {
    const range = [low === "" ? all[0] : Number(low), high === "" ? all[1] : Number(high)];
    state.limits.set(axis.number, [range.sort((a, b) => a - b)]);
  }
  drawParallel();
  drawSelection();
}

// a single design

function tellDesign() {
  if (state.design === null) return;
  const place = state.design;
  const values = axes.map((axis) =>
    `${axis.words} ${withUnit(axis, numberText(axis.ofLevel(state.level)[place]))}`);
  const bold = document.createElement("b");
  bold.textContent = `Design ${designs[place]}: `;
  element("design").replaceChildren(bold, hasPeak(place) ? values.join(", ") : "no peak");
}

function chooseDesign(event) {
  const place = event.points[0].customdata;
  if (!Number.isInteger(place)) return;
  state.design = place;
  drawSelection();
}

// choices

function fillChoice(id, from, name, redraw) {
  const select = element(id);
  if (!select) return;
  from.forEach((axis) => select.add(new Option(axis.title, axis.number)));
  if (state[name]) select.value = state[name].number;
  select.addEventListener("change", () => {
    state[name] = axes[Number(select.value)];
    redraw();
  });
}

function drawMeans() {
  const places = selected();
  drawHeatMap(places);
  drawSlices(places);
}

fillChoice("colour", axes, "colour", drawAll);
fillChoice("peak", peaks, "peak", drawMeans);
fillChoice("first", keys, "first", drawMeans);
fillChoice("second", keys, "second", drawMeans);
makeLimits();
if (element("level")) {
  element("level").addEventListener("input", (event) => {
    state.level = Number(event.target.value);
    drawAll();
  });
}
element("clear").addEventListener("click", () => {
  state.limits.clear();
  drawParallel();
  drawSelection();
});
for (const id of ["bands", "lines"]) {
  if (element(id)) element(id).addEventListener("change", drawSelection);
}

drawAll().then(() => {
  element("parallel").on("plotly_restyle", () => {
    readLimits();
    drawSelection();
  });
  for (const id of ["responses", "slices"]) {
    if (element(id) && element(id).on) element(id).on("plotly_click", chooseDesign);
  }
  document.body.dataset.ready = "yes";
});
