// ---- charts: Plotly draws the curves; cursor, legend with present values and table are the page's own ----
const { report } = data;
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];  // Okabe and Ito: the colour-blind tell them apart
const FONT = { family: getComputedStyle(document.body).fontFamily, size: 11.5, color: "#46535f" };
const CONFIG = {  // nothing that would send a chart anywhere
  responsive: true, displaylogo: false, modeBarButtons: [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
};
const LAYOUT = {  // a finger on a chart scrolls the page
  font: FONT, separators: data.language?.comma ? ",\u202f" : ".\u202f", showlegend: false, paper_bgcolor: "#fff", plot_bgcolor: "#fff", dragmode: matchMedia("(hover: none)").matches ? false : "zoom",
};
const AXIS = { gridcolor: "#e9edf0", zerolinecolor: "#b9c3cc", linecolor: "#b9c3cc", ticks: "outside", ticklen: 4, tickcolor: "#b9c3cc", automargin: true, exponentformat: "none", separatethousands: true };
const over = report.over.unit === "s" ? data.time : data.crank;
const overBefore = report.before && floats(report.before);
const heights = report.heights && floats(report.heights);
const asText = text => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");  // Plotly takes some tags
const MODE = over.length > 1 ? "lines" : "markers";
const brief = (text, most = 40) => text.length > most ? text.slice(0, most - 1) + "…" : text;

function xAxis({ across, follows, reach, bare }, x) {
  const title = across || `${report.over.quantity} [${report.over.unit}]`, axis = { ...AXIS, title: { text: bare ? "" : asText(title), standoff: 6 } }, way = x.at(-1) - x[0];
  if (way && (follows === "frames" || (follows === "position" && way < 0))) axis.range = [x[0], x.at(-1)];  // backwards too time runs to the right
  if (title.endsWith("[deg]") && Math.abs(way) >= 180) axis.dtick = 90 * Math.ceil(Math.abs(way) / 360 - 0.01);
  if (reach) axis.range = reach;
  return axis;
}

function logarithmicAxis(axis, lines) {  // within two decades the powers of ten alone would be too few ticks
  const values = lines.flatMap(line => [...line]).filter(value => value > 0), least = Math.min(...values), largest = Math.max(...values);
  const ticks = [];
  for (let decade = Math.floor(Math.log10(least)); decade <= Math.log10(largest); decade++)
    for (const step of [1, 2, 5]) ticks.push(Number(`${step}e${decade}`));
  const decades = Math.log10(largest / least), wide = { dtick: Math.ceil(decades / 7), exponentformat: "power" };
  Object.assign(axis, { type: "log" }, decades > 2 ? wide : { tickvals: ticks, ticktext: ticks.map(String) });
}

// What the cursors of a chart follow: present places along it, and the moment at one of them.
const PLACES_ALONG = {
  frames: { now: () => number(over), moments: () => over },
  time: { now: () => now, moments: () => data.time },
  height: { now: () => number(heights), moments: () => heights },
  position: { now: () => within(number(data.crank)), moments: () => data.crank.map(within) },
};

function within(position) {  // the period from 0 on, or from 0 down where it is negative; on its border 0
  const size = Math.abs(report.period), way = Math.sign(report.period);
  return size ? way * ((way * position % size + size) % size) : position;
}

function card(parent, title, unit) {
  const box = make("section", parent, { className: "chart", role: "group", ariaLabel: unit ? `${title} in ${unit}` : title }), heading = make("h3", box, { textContent: title + " " });
  if (unit) make("small", heading, { textContent: `[${unit}]` });
  return box;
}

function rounded(value, largest) {  // to four digits of the largest value
  const digits = Math.max(0, 3 - Math.floor(Math.log10(largest || 1))), text = digits > 9 ? value.toPrecision(4) : value.toFixed(digits);
  return spoken(Number(text) ? text.replace("-", "\u2212") : text.replace("-", ""));
}

const largestOf = values => values.reduce((largest, value) => Math.max(largest, Math.abs(value)), 0);

function legend(parent, plot, curves) {  // a button a curve, which hides it, with its present value
  const list = make("ul", parent, { className: "legend" });
  return curves.map(({ name, colour, traces, dash, pale }) => {
    if (pale) return document.createElement("output");  // helps for the eye have no names beside the chart
    const button = make("button", make("li", list), { type: "button", title: name, ariaPressed: "true" }), swatch = make("i", button);
    swatch.style.background = colour;
    if (dash) swatch.style.maskImage = "repeating-linear-gradient(90deg, #000 0 4px, #0000 4px 6px)";
    make("b", button, { textContent: name });
    button.addEventListener("click", () => {
      button.ariaPressed = String(button.ariaPressed !== "true");
      Plotly.restyle(plot, { visible: button.ariaPressed === "true" }, traces);
    });
    return make("output", button);
  });
}

const dashOf = i => ["", "9px,3px,2px,3px", "2px,3px"][Math.floor(i / COLOURS.length) % 3];  // tells those apart that share a colour

function look(curve, colour, i) {  // of a curve that lies on another, and of that one
  if (curve.look === "dotted") return { color: colour, width: 2.6, dash: "1.5px,5px", simplify: false };
  if (curve.look === "pale") return { color: "#b9c3cc", width: 1, simplify: false };
  return { color: colour, width: { wide: 3.4, strong: 5, limit: 1.4 }[curve.look] || 1.8, dash: curve.look === "limit" ? "6px,3px" : dashOf(i) || "solid", simplify: false };
}

function lineChart(parent, chart) {
  const box = card(parent, chart.title, chart.unit), traces = [], place = PLACES_ALONG[chart.follows];
  const unpacked = chart.curves.map(curve => ({ ...curve, x: curve.x ? floats(curve.x) : over, y: floats(curve.y), atFrames: curve.at_frames && floats(curve.at_frames) }));
  const largest = Math.max(...unpacked.map(({ y }) => largestOf(y)));
  const curves = unpacked.map((curve, i) => {
    const pale = curve.look === "pale", place = unpacked.slice(0, i).filter(({ look }) => look !== "pale").length;
    const colour = pale ? "#b9c3cc" : COLOURS[place % COLOURS.length], mine = [traces.length], name = asText(brief(curve.name));
    const line = { mode: curve.points ? "markers" : chart.logarithmic === "xy" || curve.look === "marked" ? "lines+markers" : MODE, hovertemplate: `%{y:.5g} ${chart.unit}` };
    if (chart.stacked) Object.assign(line, { stackgroup: "all", fillcolor: colour + "aa" });
    traces.push({ ...line, x: curve.x, y: curve.y, name, line: look(curve, colour, place), marker: { color: colour, size: 6 } });
    if (curve.band) {  // its lower end, and its upper one with the room between
      const end = { ...line, mode: "lines", x: curve.x, hoverinfo: "skip", hovertemplate: null, line: { width: 0 }, name };
      mine.push(traces.length, traces.length + 1);
      traces.push({ ...end, y: floats(curve.band[0]) }, { ...end, y: floats(curve.band[1]), fill: "tonexty", fillcolor: colour + "33" });
    }
    if (curve.before) {
      mine.push(traces.length);
      traces.push({ ...line, x: overBefore, y: floats(curve.before), name: name + `, ${say("before")}`, opacity: 0.65, line: { color: colour, width: 1.4, dash: "dash", simplify: false } });
    }
    return { name: curve.name, colour, traces: mine, dash: curve.look === "dotted" || curve.look === "limit" || dashOf(place), pale };
  });
  const yaxis = { ...AXIS, rangemode: chart.follows === "height" || chart.stacked ? "tozero" : "normal" };
  if (chart.square) Object.assign(yaxis, { scaleanchor: "x", scaleratio: 1 });
  if (chart.logarithmic) logarithmicAxis(yaxis, unpacked.map(({ y }) => y));
  const xaxis = xAxis(chart, unpacked[0].x);
  if (chart.logarithmic === "xy") logarithmicAxis(xaxis, unpacked.map(({ x }) => x));
  const layout = { ...LAYOUT, margin: { l: 58, r: 12, t: 8, b: chart.bare ? 20 : 38 }, hovermode: chart.follows === "height" || chart.square ? "closest" : "x unified", xaxis, yaxis, ...marksOf(chart) };
  const plot = document.createElement("div"), values = legend(box, plot, curves);
  plot.className = "plot";
  if (chart.square) plot.style.height = "24rem";
  if (chart.strip) plot.style.height = chart.bare ? "116px" : "134px";  // the last one has the names of the places
  box.append(plot);
  if (chart.note) make("p", box, { className: "remark", textContent: chart.note });
  plotted(plot, traces, layout);
  if (place) seekOnClick(plot, ({ x, y, curveNumber }) => nearestMoment(place, unpacked.find(({ atFrames }, i) => atFrames && curves[i].traces.includes(curveNumber)), x, y));
  const follow = () => {
    const { xaxis, yaxis } = plot._fullLayout, at = place && place.now(), away = x => !(x >= 0 && x <= xaxis._length);
    unpacked.forEach((curve, i) => {
      const value = curve.atFrames ? pairAt(curve.atFrames)[1] : !place ? null : curve.x === over ? number(curve.y) : valueAt(curve.x, curve.y, at);
      values[i].textContent = value === null ? "" : rounded(value, largest);
    });
    for (const { dot, atFrames } of dots) {
      const [x, y] = pairAt(atFrames), [left, top] = [xaxis.l2p(x), yaxis.l2p(y)];
      dot.hidden = away(left) || !(top >= 0 && top <= yaxis._length);
      Object.assign(dot.style, { left: `${xaxis._offset + left}px`, top: `${yaxis._offset + top}px` });
    }
    if (!place) return;
    const x = xaxis.l2p(at);
    cursor.hidden = away(x);
    Object.assign(cursor.style, { left: `${xaxis._offset + x}px`, top: `${yaxis._offset}px`, height: `${yaxis._length}px` });
  };
  const cursor = place && make("div", plot, { className: "cursor" });
  const dots = unpacked.filter(({ atFrames }) => atFrames).map(({ atFrames }) => ({ atFrames, dot: make("div", plot, { className: "tip" }) }));
  if (!place && !dots.length) {
    values.forEach(value => value.remove());
    return () => { Plotly.purge(plot); box.remove(); };
  }
  plot.on("plotly_relayout", follow);
  plot.on("plotly_afterplot", follow);
  listeners.push(follow);
  return () => { listeners.splice(listeners.indexOf(follow), 1); Plotly.purge(plot); box.remove(); };
}

function marksOf({ marks }) {  // straight lines across a chart, or the room between two, with their names
  const shapes = [], annotations = [];
  for (const { name, axis, at } of marks) {
    const [low, high] = [at[0], at.at(-1)], whole = { [axis === "x" ? "yref" : "xref"]: "paper" }, two = at.length > 1;
    const ends = axis === "x" ? { x0: low, x1: high, y0: 0, y1: 1 } : { y0: low, y1: high, x0: 0, x1: 1 };
    shapes.push({ type: two ? "rect" : "line", layer: "below", ...whole, ...ends, fillcolor: "#eef1f4", line: { color: "#9aa5b0", width: two ? 0 : 1, dash: axis === "x" ? "dot" : "dash" } });
    if (!name) continue;
    const place = axis === "x" ? { x: high, y: 1, xanchor: "right", yanchor: "top" } : { x: 1, y: high, xanchor: "right", yanchor: "bottom" };
    annotations.push({ text: asText(brief(name)), showarrow: false, font: { size: 10, color: "#6a7580" }, ...whole, ...place });
  }
  return { shapes, annotations };
}

function mapChart(parent, { title, unit, across, up, x, y, values, written, note, points }) {
  const box = card(parent, title, unit), plot = make("div", box, { className: "plot" }), named = places => places.map(place => typeof place === "string" ? asText(brief(place)) : place);
  const heat = { type: "heatmap", x: named(x), y: named(y), z: values, colorscale: written ? "Blues" : "Viridis", reversescale: written, colorbar: { thickness: 12 }, hovertemplate: `%{x}, %{y}: %{z:.4g} ${unit}<extra></extra>` };
  if (written) Object.assign(heat, { texttemplate: "%{z:.2f}" });
  const axis = title => ({ ...AXIS, title: { text: asText(title), standoff: 6 } });
  if (note) make("p", box, { className: "remark", textContent: note });
  const over = points.map(({ name, x, y }, k) => ({ type: "scatter", mode: "markers", name: asText(brief(name)), x, y, marker: { size: 4, color: COLOURS[(1 + 2 * k) % COLOURS.length] } }));
  const named_points = over.length ? { showlegend: true, legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom" } } : {};
  plotted(plot, [heat, ...over], { ...LAYOUT, ...named_points, margin: { l: 58, r: 12, t: over.length ? 30 : 8, b: 38 }, xaxis: axis(across), yaxis: axis(up) });
}

const pairAt = pairs => [0, 1].map(i => pairs[2 * moment.before + i] + moment.part * (pairs[2 * moment.after + i] - pairs[2 * moment.before + i]));

function valueAt(x, y, at) {  // of a curve over rising or falling places, between which it is straight; null beyond its ends
  at = Math.fround(at);  // as the places are
  const way = Math.sign(x.at(-1) - x[0]), k = x.findIndex(place => way * (place - at) >= 0);
  if (k < 0 || (k === 0 && x[0] !== at)) return null;
  return k === 0 ? y[0] : y[k - 1] + (at - x[k - 1]) / (x[k] - x[k - 1] || 1) * (y[k] - y[k - 1]);
}

function nearestMoment({ moments }, curve, x, y) {  // the moment at a place along a chart; of a curve that is no function of it the nearest on it
  const along = moments(), wide = largestOf(along) || 1, high = curve ? largestOf(curve.y) || 1 : 1;
  const far = k => Math.hypot((along[k] - x) / wide, curve ? (curve.atFrames[2 * k + 1] - y) / high : 0);
  let best = 0;
  for (let k = 0; k < along.length; k++) if (far(k) < far(best)) best = k;
  return data.time[best];
}

function plotted(plot, traces, layout) {
  Plotly.newPlot(plot, traces, layout, CONFIG);
  for (const image of plot.querySelectorAll("svg.main-svg")) image.ariaHidden = "true";  // a reader of the screen has heading, values and tables
}

function seekOnClick(plot, time) {  // but not on a double click, which takes the zoom back
  let waiting = 0;
  plot.on("plotly_click", ({ points, event }) => {
    clearTimeout(waiting);
    if (!(event.detail > 1)) waiting = setTimeout(() => { setPlaying(false); seek(time(points[0])); }, 300);
  });
  plot.on("plotly_doubleclick", () => clearTimeout(waiting));
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
  const texts = values => Array.from(values, value => `${report.over.quantity} ${spoken(value.toFixed(report.over.unit === "s" ? 4 : 1))} ${report.over.unit}`);
  const traces = [{ ...hover, x: column(points, 0), y: column(points, 1), text: texts(over), line: { color: COLOURS[0], width: 1.8, simplify: false } }];
  if (before) traces.unshift({ ...hover, x: column(others, 0), y: column(others, 1), text: texts(overBefore), line: { color: "#8a949e", width: 1.4, dash: "dash", simplify: false } });
  const layout = { ...LAYOUT, margin: { l: 46, r: 10, t: 8, b: 40 }, hovermode: "closest", shapes: circles, xaxis: { ...axis, title: { text: axes[0], standoff: 4 }, constrain: "domain" }, yaxis: { ...axis, title: { text: axes[1], standoff: 2 }, scaleanchor: "x", constrain: "domain" } };
  plotted(plot, traces, layout);
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

function bearingDetail(parent, { bearings }) {  // one at a time, as a press has up to a dozen; on paper all
  const heading = make("h2", parent, { textContent: say("Force in") + " ", className: "choice" }), choice = make("select", heading, { id: "bearing", ariaLabel: say("Bearing or guide") });
  bearings.forEach((bearing, i) => make("option", choice, { value: i, textContent: bearing.name }));
  const place = make("div", parent);
  let stop = [];
  const draw = some => {
    stop.forEach(end => end());
    stop = some.flatMap(bearing => forceDetail(place, bearing));
    seek(now);
  };
  const chosen = () => draw([bearings[choice.value]]);
  choice.addEventListener("change", chosen);
  forPaper.push(() => { draw(bearings); return chosen; });
  chosen();
}

function forceDetail(place, { link, axes, unit, frame, own, before, components, open }) {
  const box = make("div", place, { className: "bearing" }), note = make("p", box, { className: "note", hidden: !open });
  note.textContent = `${say("Rigid mechanics leaves open")}: ${open}. ${say("It is shared with the least sum of squared bearing forces, or as the stiffnesses say.")}`;
  const chart = lineChart(box, components), pair = make("div", box, { className: "pair" });
  const frames = polarChart(pair, say("Polar diagram, world axes"), axes, unit, frame, before?.frame);
  const links = polarChart(pair, `${say("Polar diagram, axes of")} ${brief(link)}`, axes, unit, own, before?.own);
  return [chart, frames, links, () => box.remove()];
}

function barChart(parent, { title, unit, places, bars, before, across, note, stacked, band }) {
  const box = card(parent, title, unit), traces = [], words = typeof places[0] === "string";
  const x = words ? places.map(place => asText(brief(place, 24))) : places, where = words ? "%{x}" : say("order") + " %{x}";
  const curves = Object.keys(bars).map((name, i) => {
    const bar = { type: "bar", x, hovertemplate: `${where}: %{y:.4g} ${unit}` }, mine = [traces.length];
    const labels = words ? { text: bars[name].map(value => rounded(value, largestOf(bars[name]))), textposition: "auto", cliponaxis: false } : {};
    traces.push({ ...bar, ...labels, y: bars[name], name: asText(brief(name)), marker: { color: COLOURS[i % COLOURS.length] } });
    if (before?.[name]) {
      mine.push(traces.length);
      traces.push({ ...bar, y: before[name], name: asText(brief(name)) + `, ${say("before")}`, marker: { color: COLOURS[i % COLOURS.length], opacity: 0.35 } });
    }
    return { name, colour: COLOURS[i % COLOURS.length], traces: mine };
  });
  const xaxis = { ...AXIS, title: { text: asText(across), standoff: 6 }, ...(words ? {} : { dtick: 1 }) };
  if (band) {
    const sums = places.map((_, k) => Object.values(bars).reduce((sum, values) => sum + values[k], 0));
    const ends = { type: "data", symmetric: false, array: band.map(([, high], k) => high - sums[k]), arrayminus: band.map(([low], k) => sums[k] - low) };
    traces.push({ type: "scatter", mode: "markers", x, y: sums, error_y: ends, name: say("sum"), marker: { color: "#000", size: 6 }, hovertemplate: `${say("sum")}: %{y:.4g} ${unit}` });
  }
  const layout = { ...LAYOUT, barmode: stacked ? "relative" : "group", margin: { l: 58, r: 12, t: 12, b: 38 }, bargap: words ? 0.5 : 0.25, xaxis, yaxis: { ...AXIS, rangemode: "tozero" } };
  const plot = document.createElement("div");
  if (curves.length > 1) legend(box, plot, curves).forEach(value => value.remove());
  plot.className = "plot";
  box.append(plot);
  if (note) make("p", box, { className: "remark", textContent: note });
  plotted(plot, traces, layout);
}

function smallCurve(cell, values, name) {  // the shape of a curve, with the cursor; a click shows it large
  const [width, height] = [132, 24], along = over.map(x => width * (x - over[0]) / (over.at(-1) - over[0] || 1)), most = largestOf(values) || 1;
  const image = document.createElementNS(SVG, "svg"), line = document.createElementNS(SVG, "polyline"), cursor = document.createElementNS(SVG, "line");
  for (const [key, value] of Object.entries({ width, height, viewBox: `0 0 ${width} ${height}`, "aria-hidden": "true" })) image.setAttribute(key, value);
  line.setAttribute("points", Array.from(values, (value, k) => `${along[k].toFixed(1)},${(height - 1 - (height - 3) * value / most).toFixed(1)}`).join(" "));
  for (const y of ["y1", "y2"]) cursor.setAttribute(y, y === "y1" ? 0 : height);
  image.append(line, cursor);
  cell.append(image);
  listeners.push(() => { const x = width * (number(over) - over[0]) / (over.at(-1) - over[0] || 1); cursor.setAttribute("x1", x); cursor.setAttribute("x2", x); });
  cell.addEventListener("click", () => {
    const choice = element("bearing"), option = [...choice.options].find(({ textContent }) => textContent === name);
    if (!option) return;
    choice.value = option.value;
    choice.dispatchEvent(new Event("change"));
    choice.scrollIntoView({ block: "start" });
  });
}

function table(parent, { title, heads, rows, words, note, curves }) {
  const box = make("section", parent, { className: "chart table" });
  if (title) make("h3", box, { textContent: title });
  const grid = make("table", box), head = make("tr", make("thead", grid)), body = make("tbody", grid);
  const cell = (tag, row, text, i) => make(tag, row, { textContent: brief(text.replace(/^-/, "\u2212"), 80), title: text, className: i < words ? "words" : "" });
  heads.forEach((text, i) => cell("th", head, text, i));
  if (curves) head.children[0].after(make("th", head, { className: "small", textContent: `${say("over the")} ${report.over.quantity}` }));
  rows.forEach((cells, k) => {
    const row = make("tr", body);
    cells.forEach((text, i) => cell("td", row, text, i));
    if (!curves) return;
    const small = make("td", row, { className: "small" });
    row.children[0].after(small);
    if (curves[k]) smallCurve(small, floats(curves[k]), cells[0]);
  });
  if (note) make("p", box, { className: "remark", textContent: note });
}

function figures(parent, { figures }) {  // in rows of nearly equal numbers, each of which is filled
  const box = make("div", parent, { className: "figures" });
  const boxes = figures.map(({ name, value, at }) => {
    const one = make("div", box), signed = text => text.replace(/(^| )-(?=\d)/g, "$1\u2212");
    make("small", one, { textContent: name });
    make("strong", one, { textContent: signed(value) });
    make("small", one, { textContent: signed(at) });
    return one;
  });
  const arrange = () => {
    const most = Math.max(1, Math.floor(box.clientWidth / 150)), rows = Math.ceil(boxes.length / most);
    for (let row = 0, i = 0; row < rows; row++)
      for (let end = Math.ceil((row + 1) * boxes.length / rows), count = end - i; i < end; i++) boxes[i].style.flex = `1 1 calc(${100 / count}% - 10px)`;
  };
  new ResizeObserver(arrange).observe(box);
  arrange();
}

function verdict(parent, { figures }) {  // what is looked for first: value, share of its limit, where; beside another press its value and the change
  const box = make("section", parent, { className: "chart table verdict", ariaLabel: say("Summary") }), body = make("tbody", make("table", box));
  const compared = report.dashed, signed = text => text.replace(/(^| )-(?=\d)/g, "$1\u2212");
  if (compared) {
    box.classList.add("compared");
    const heads = make("tr", make("thead", box.firstChild));
    for (const text of ["", compared, say("here"), say("change"), "", ""]) make("th", heads, { textContent: brief(text, 24) });
  }
  for (const { name, value, at, use, before, change } of figures) {
    const row = make("tr", body), bar = use === undefined ? "" : `${Math.round(100 * use)} %`;
    make("th", row, { textContent: name, scope: "row", className: "words" });
    if (compared) make("td", row, { textContent: signed(before ?? "") });
    make("td", row).append(Object.assign(document.createElement("strong"), { textContent: signed(value) }));
    if (compared) make("td", row, { textContent: signed(change ?? "") });
    const cell = make("td", row, { className: "use" });
    if (bar) make("meter", cell, { min: 0, max: 1, high: 0.9, optimum: 0, value: Math.min(1, use), title: bar });
    if (bar) make("small", cell, { textContent: use > 1 ? `${bar} !` : bar });
    make("td", row, { textContent: signed(at), className: "words" });
  }
}

function facts(parent, { title, rows }) {
  const box = make("section", parent, { className: "chart inputs" });
  if (title) make("h3", box, { textContent: title });
  const list = make("dl", box);
  for (const [name, words] of rows) {
    make("dt", list, { textContent: name });
    make("dd", list, { textContent: words });
  }
}

function titleBlock(article, { logo, company, rows, notes }) {  // beside the press; on paper above it, with the title
  const box = make("section", article, { id: "head", className: "chart", ariaLabel: say("Title block") });
  if (logo) make("img", box, { src: logo, alt: company || say("Logo") });
  if (company) make("strong", box, { textContent: company });
  const list = make("dl", box), title = document.querySelector("h1"), before = title.nextSibling;
  for (const [name, words] of rows) {
    const one = make("div", list);
    make("dt", one, { textContent: name });
    make("dd", one, { textContent: words });
  }
  if (notes) make("p", box, { textContent: notes });
  article.prepend(box);
  const onSheets = [document.title, company, ...rows.map(([name, words]) => `${name} ${words}`)].filter(Boolean).join(" · ");
  document.documentElement.style.setProperty("--title", JSON.stringify(onSheets));
  forPaper.push(() => {
    document.body.prepend(box);
    list.before(title);
    return () => { article.prepend(box); before.before(title); };
  });
}

const BLOCKS = { lines: lineChart, map: mapChart, bars: barChart, bearings: bearingDetail, table, figures };

function drawReport() {
  const article = element("charts");
  if (report.header) titleBlock(article, report.header);
  element("subtitle").textContent = report.subtitle;
  if (report.figures.length) verdict(article, report);
  const low = report.sections.flatMap(({ blocks }) => blocks.filter(({ strip }) => strip)), strips = make("div", article, { className: "strips" });
  low.forEach((chart, i) => lineChart(strips, { ...chart, bare: i < low.length - 1 }));
  for (const { title, note, blocks: all } of report.sections) {
    const blocks = all.filter(({ strip }) => !strip);
    if (!blocks.length) continue;
    make("h2", article, { textContent: title });
    if (note) make("p", article, { className: "remark", textContent: note });
    for (const block of blocks) BLOCKS[block.kind](article, block);
  }
  make("h2", article, { textContent: say("Inputs") });
  for (const given of report.inputs) facts(article, given);
  seek(now);
}
