// ---- charts: Plotly draws the curves; cursor, legend with present values and table are the page's own ----
const { report } = data;
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];  // Okabe and Ito: the colour-blind tell them apart
const FONT = { family: getComputedStyle(document.body).fontFamily, size: 11.5, color: "#46535f" };
const CONFIG = {  // nothing that would send a chart anywhere
  responsive: true, displaylogo: false, modeBarButtons: [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
};
const AXIS = { gridcolor: "#e9edf0", zerolinecolor: "#b9c3cc", linecolor: "#b9c3cc", ticks: "outside", ticklen: 4, tickcolor: "#b9c3cc", automargin: true };
const over = report.over.unit === "s" ? data.time : data.crank;
const overBefore = report.before && floats(report.before);
const asText = text => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");  // Plotly takes some tags
const MODE = over.length > 1 ? "lines" : "markers";
const brief = (text, most = 40) => text.length > most ? text.slice(0, most - 1) + "…" : text;

function xAxis() {  // backwards too time runs to the right
  const axis = { ...AXIS, title: { text: `${report.over.quantity} [${report.over.unit}]`, standoff: 6 } };
  if (over.length > 1) axis.range = [over[0], over.at(-1)];
  if (report.over.unit === "deg" && Math.abs(over.at(-1) - over[0]) >= 180) axis.dtick = 45;
  return axis;
}

function make(tag, parent, properties = {}) {
  const made = document.createElement(tag);
  Object.assign(made, properties);
  parent.append(made);
  return made;
}

function card(parent, title, unit) {
  const box = make("section", parent, { className: "chart" }), heading = make("h3", box, { textContent: title + " " });
  if (unit) make("small", heading, { textContent: `[${unit}]` });
  return box;
}

function rounded(value, largest) {  // to four digits of the largest value
  const digits = Math.max(0, 3 - Math.floor(Math.log10(largest || 1)));
  return (digits > 9 ? value.toPrecision(4) : value.toFixed(digits)).replace("-", "\u2212");
}

const largestOf = values => values.reduce((largest, value) => Math.max(largest, Math.abs(value)), 0);

function legend(parent, plot, curves) {  // a button a curve, which hides it, with its present value
  const list = make("ul", parent, { className: "legend" });
  return curves.map(({ name, colour, traces }) => {
    const button = make("button", make("li", list), { type: "button", title: name, ariaPressed: "true" });
    make("i", button).style.background = colour;
    make("b", button, { textContent: name });
    button.addEventListener("click", () => {
      button.ariaPressed = String(button.ariaPressed !== "true");
      Plotly.restyle(plot, { visible: button.ariaPressed === "true" }, traces);
    });
    return make("output", button);
  });
}

function lineChart(parent, chart) {
  const box = card(parent, chart.title, chart.unit), series = chart.curves.map(curve => floats(curve.values)), traces = [];
  const largest = Math.max(...series.map(largestOf));
  const curves = chart.curves.map((curve, i) => {
    const colour = COLOURS[i % COLOURS.length], mine = [traces.length], name = asText(brief(curve.name));
    const line = { mode: MODE, hovertemplate: `%{y:.5g} ${chart.unit}` };
    traces.push({ ...line, x: over, y: series[i], name, line: { color: colour, width: 1.8, simplify: false } });
    if (curve.before) {
      mine.push(traces.length);
      traces.push({ ...line, x: overBefore, y: floats(curve.before), name: name + ", before", opacity: 0.65, line: { color: colour, width: 1.4, dash: "dash", simplify: false } });
    }
    return { name: curve.name, colour, traces: mine };
  });
  const layout = { margin: { l: 58, r: 12, t: 8, b: 38 }, font: FONT, hovermode: "x unified", showlegend: false, xaxis: xAxis(), yaxis: { ...AXIS }, paper_bgcolor: "#fff", plot_bgcolor: "#fff" };
  const plot = document.createElement("div"), values = legend(box, plot, curves);
  plot.className = "plot";
  box.append(plot);
  Plotly.newPlot(plot, traces, layout, CONFIG);
  seekOnClick(plot, ({ x }) => timeAt(x));
  const cursor = make("div", plot, { className: "cursor" });
  const follow = () => {
    series.forEach((numbers, i) => { values[i].textContent = rounded(number(numbers), largest); });
    const { xaxis, yaxis } = plot._fullLayout, x = xaxis.l2p(number(over));
    cursor.hidden = x < 0 || x > xaxis._length;
    Object.assign(cursor.style, { left: `${xaxis._offset + x}px`, top: `${yaxis._offset}px`, height: `${yaxis._length}px` });
  };
  plot.on("plotly_relayout", follow);
  plot.on("plotly_afterplot", follow);
  listeners.push(follow);
  return () => { listeners.splice(listeners.indexOf(follow), 1); Plotly.purge(plot); box.remove(); };
}

function seekOnClick(plot, time) {  // but not on a double click, which takes the zoom back
  let waiting = 0;
  plot.on("plotly_click", ({ points, event }) => {
    clearTimeout(waiting);
    if (!(event.detail > 1)) waiting = setTimeout(() => { setPlaying(false); seek(time(points[0])); }, 300);
  });
  plot.on("plotly_doubleclick", () => clearTimeout(waiting));
}

function timeAt(x) {
  const k = over.reduce((best, value, i) => Math.abs(value - x) < Math.abs(over[best] - x) ? i : best, 0);
  return data.time[k];
}

function polarChart(parent, title, axes, unit, path, before) {  // the tip of the force vector, circles of constant force
  const box = card(parent, title, unit), plot = make("div", box, { className: "plot square" });
  const points = floats(path), others = before ? floats(before) : new Float32Array();
  const column = (values, i) => values.filter((_, k) => k % 2 === i);
  let largest = 1e-12;
  for (let k = 0; k < points.length; k += 2) largest = Math.max(largest, Math.hypot(points[k], points[k + 1]));
  for (let k = 0; k < others.length; k += 2) largest = Math.max(largest, Math.hypot(others[k], others[k + 1]));
  const decade = 10 ** Math.floor(Math.log10(largest / 3)), step = decade * [1, 2, 5, 10].find(s => s * decade >= largest / 4);
  const circles = Array.from({ length: Math.ceil(largest / step) }, (_, i) => (i + 1) * step).map(r => ({ type: "circle", layer: "below", x0: -r, x1: r, y0: -r, y1: r, line: { color: "#dfe5ea", width: 1 } }));
  const limit = 1.08 * Math.ceil(largest / step) * step, axis = { ...AXIS, showgrid: false, range: [-limit, limit], dtick: 2 * step, tickangle: 0, zeroline: true };
  const hover = { mode: MODE, hovertemplate: `%{text}<br>${axes[0]} %{x:.4g}, ${axes[1]} %{y:.4g} ${unit}<extra></extra>` };
  const texts = values => Array.from(values, value => `${report.over.quantity} ${value.toFixed(report.over.unit === "s" ? 4 : 1)} ${report.over.unit}`);
  const traces = [{ ...hover, x: column(points, 0), y: column(points, 1), text: texts(over), line: { color: COLOURS[0], width: 1.8, simplify: false } }];
  if (before) traces.unshift({ ...hover, x: column(others, 0), y: column(others, 1), text: texts(overBefore), line: { color: "#8a949e", width: 1.4, dash: "dash", simplify: false } });
  const layout = { margin: { l: 46, r: 10, t: 8, b: 40 }, font: FONT, hovermode: "closest", showlegend: false, shapes: circles, xaxis: { ...axis, title: { text: axes[0], standoff: 4 }, constrain: "domain" }, yaxis: { ...axis, title: { text: axes[1], standoff: 2 }, scaleanchor: "x", constrain: "domain" }, paper_bgcolor: "#fff", plot_bgcolor: "#fff" };
  Plotly.newPlot(plot, traces, layout, CONFIG);
  seekOnClick(plot, ({ x, y }) => nearest(x, y));
  const nearest = (x, y) => {
    let best = 0;
    for (let k = 0; k < over.length; k++)
      if (Math.hypot(points[2 * k] - x, points[2 * k + 1] - y) < Math.hypot(points[2 * best] - x, points[2 * best + 1] - y)) best = k;
    return data.time[best];
  };
  const ray = make("div", plot, { className: "ray" }), tip = make("div", plot, { className: "tip" });
  const follow = () => {
    const { xaxis, yaxis } = plot._fullLayout, at = i => points[2 * moment.before + i] + moment.part * (points[2 * moment.after + i] - points[2 * moment.before + i]);
    const place = (x, y) => [xaxis._offset + xaxis.l2p(x), yaxis._offset + yaxis.l2p(y)], [x0, y0] = place(0, 0), [x, y] = place(at(0), at(1));
    Object.assign(tip.style, { left: `${x}px`, top: `${y}px` });
    Object.assign(ray.style, { left: `${x0}px`, top: `${y0}px`, width: `${Math.hypot(x - x0, y - y0)}px`, transform: `rotate(${Math.atan2(y - y0, x - x0)}rad)` });
    const away = (x, y) => x < xaxis._offset || x > xaxis._offset + xaxis._length || y < yaxis._offset || y > yaxis._offset + yaxis._length;
    tip.hidden = away(x, y);
    ray.hidden = away(x, y) || away(x0, y0);
  };
  plot.on("plotly_relayout", follow);
  plot.on("plotly_afterplot", follow);
  listeners.push(follow);
  return () => { listeners.splice(listeners.indexOf(follow), 1); Plotly.purge(plot); box.remove(); };
}

function forceStrokeChart(parent) {  // over the height, down and up; the cursor is a dot on the curve
  const { unit, axis, reach, height, force, keys, permissible } = report.process, title = "Force over " + axis;
  const box = card(parent, title, unit), plot = document.createElement("div"), heights = floats(keys.height), forces = floats(keys.force);
  const line = { mode: MODE, hovertemplate: `%{y:.5g} ${unit} at %{x:.4g} mm` };
  const traces = [{ ...line, x: floats(height), y: floats(force), name: "process force", line: { color: COLOURS[0], width: 1.8, simplify: false } }];
  const curves = [{ name: "process force", colour: COLOURS[0], traces: [0] }];
  if (permissible) {
    traces.push({ ...line, x: floats(permissible.height), y: floats(permissible.force), name: "permissible force", line: { color: COLOURS[1], width: 1.8, simplify: false } });
    curves.push({ name: "permissible force", colour: COLOURS[1], traces: [1] });
  }
  const layout = { margin: { l: 58, r: 12, t: 8, b: 38 }, font: FONT, hovermode: "closest", showlegend: false, xaxis: { ...AXIS, range: [0, reach], title: { text: `${axis} [mm]`, standoff: 6 } }, yaxis: { ...AXIS, rangemode: "tozero" }, paper_bgcolor: "#fff", plot_bgcolor: "#fff" };
  const [value, limit] = legend(box, plot, curves);
  if (limit) limit.remove();
  plot.className = "plot";
  box.append(plot);
  Plotly.newPlot(plot, traces, layout, CONFIG);
  const largest = largestOf(forces);
  seekOnClick(plot, ({ x, y }) => {
    const far = k => Math.hypot((heights[k] - x) / reach, (forces[k] - y) / (largest || 1));
    return data.time[heights.reduce((best, _, k) => far(k) < far(best) ? k : best, 0)];
  });
  const dot = make("div", plot, { className: "tip" });
  const follow = () => {
    const { xaxis, yaxis } = plot._fullLayout, x = xaxis.l2p(number(heights)), y = yaxis.l2p(number(forces));
    value.textContent = rounded(number(forces), largest);
    dot.hidden = x < 0 || x > xaxis._length || y < 0 || y > yaxis._length;
    Object.assign(dot.style, { left: `${xaxis._offset + x}px`, top: `${yaxis._offset + y}px` });
  };
  plot.on("plotly_relayout", follow);
  plot.on("plotly_afterplot", follow);
  listeners.push(follow);
}

function inputs(parent) {
  for (const { title, rows } of report.inputs) {
    make("h2", parent, { textContent: title });
    const box = make("section", parent, { className: "chart inputs" });
    const list = make("dl", box);
    for (const [name, words] of rows) {
      make("dt", list, { textContent: name });
      make("dd", list, { textContent: words });
    }
  }
}

function bearingDetail(parent) {  // one at a time: a press has up to a dozen
  const heading = make("h2", parent, { textContent: "Force in " }), choice = make("select", heading, { id: "bearing", ariaLabel: "Bearing or guide" });
  report.bearings.forEach((bearing, i) => make("option", choice, { value: i, textContent: bearing.name }));
  const place = make("div", parent);
  let stop = [];
  const draw = () => {
    stop.forEach(end => end());
    const { name, link, axes, unit, frame, own, before, components, open } = report.bearings[choice.value];
    const note = make("p", place, { className: "note", hidden: !open });
    note.textContent = `Rigid mechanics leaves open: ${open}. It is shared with the least sum of squared bearing forces, or as the stiffnesses say.`;
    const chart = lineChart(place, components), pair = make("div", place, { className: "pair" });
    const frames = polarChart(pair, "Polar diagram, world axes", axes, unit, frame, before?.frame);
    const links = polarChart(pair, `Polar diagram, axes of ${brief(link)}`, axes, unit, own, before?.own);
    stop = [chart, frames, links, () => pair.remove(), () => note.remove()];
    seek(now);
  };
  choice.addEventListener("change", draw);
  draw();
}

function harmonicsChart(parent) {
  const { unit, orders, amplitude, before } = report.harmonics, axes = Object.keys(amplitude);
  const box = card(parent, "Harmonics of the shaking force", unit), traces = [];
  const curves = axes.map((axis, i) => {
    const bar = { type: "bar", x: orders, hovertemplate: `order %{x}: %{y:.4g} ${unit}` }, mine = [traces.length];
    traces.push({ ...bar, y: amplitude[axis], name: axis, marker: { color: COLOURS[i] } });
    if (before?.[axis]) {
      mine.push(traces.length);
      traces.push({ ...bar, y: before[axis], name: axis + ", before", marker: { color: COLOURS[i], opacity: 0.35 } });
    }
    return { name: axis, colour: COLOURS[i], traces: mine };
  });
  const layout = { margin: { l: 58, r: 12, t: 8, b: 38 }, font: FONT, showlegend: false, bargap: 0.25, xaxis: { ...AXIS, dtick: 1, title: { text: "order of the crank's speed", standoff: 6 } }, yaxis: { ...AXIS, rangemode: "tozero" }, paper_bgcolor: "#fff", plot_bgcolor: "#fff" };
  const plot = document.createElement("div");
  legend(box, plot, curves).forEach(value => value.remove());
  plot.className = "plot";
  box.append(plot);
  Plotly.newPlot(plot, traces, layout, CONFIG);
}

function table(parent) {
  make("h2", parent, { textContent: "Extremes" });
  const box = make("section", parent, { className: "chart table" }), grid = make("table", box);
  const head = make("tr", make("thead", grid)), body = make("tbody", grid);
  for (const title of report.table.head) make("th", head, { textContent: title });
  for (const cells of report.table.rows) {
    const row = make("tr", body);
    for (const cell of cells) make("td", row, { textContent: brief(cell.replace(/^-/, "\u2212"), 80), title: cell });
  }
}

function drawReport() {
  const article = element("charts");
  element("subtitle").textContent = report.subtitle + "; all inputs stand at the end";
  for (const { name, value, at } of report.cards) {
    const box = make("div", element("cards"));
    make("small", box, { textContent: name });
    make("strong", box, { textContent: value });
    make("small", box, { textContent: at });
  }
  for (const { title, charts } of report.sections) {
    make("h2", article, { textContent: title });
    for (const chart of charts) lineChart(article, chart);
    if (title === "Process" && report.process) forceStrokeChart(article);
    if (title === "Bearings and guides" && report.bearings.length) bearingDetail(article);
    if (title === "Foundation" && report.harmonics) harmonicsChart(article);
  }
  table(article);
  inputs(article);
  seek(now);
}
