// ---- the window: what a recording shows, of a press that is changed while it moves. Numbers come from the server, by a socket ----
const socket = new WebSocket(new URL("socket", location.href).href.replace(/^http/, "ws"));
let values = [...data.values], waiting = false, wanted = null, touched = null;  // waiting: for an answer; touched: the row changed last
const rows = [], charts = [];
const scale = { m: [[1, "m"], [1e-3, "mm"], [1e-6, "µm"]], N: [[1e6, "MN"], [1e3, "kN"], [1, "N"]], "N m": [[1e6, "MN m"], [1e3, "kN m"], [1, "N m"]] };

// ---- links: their poses are set here instead of by an animation, as they change with each picture ----
let linkPoses = data.poses.map(floats);
const before7 = new THREE.Quaternion(), after7 = new THREE.Quaternion();

viewer.animator.seek = () => {
  for (const [i, series] of linkPoses.entries()) {
    const { object } = viewer.scene_tree.find(["press", String(i)]);
    const last = series.length / 7 - 1, from = 7 * Math.min(moment.before, last), to = 7 * Math.min(moment.after, last);
    object.position.set(...[0, 1, 2].map(c => series[from + c] + moment.part * (series[to + c] - series[from + c])));
    before7.fromArray(series, from + 3);
    after7.fromArray(series, to + 3);
    object.quaternion.copy(before7).slerp(after7, moment.part);
  }
};

let shapesAt = 0, shapesTook = 0;  // when shapes were made last, and how long that took [ms]

function replaceShapes() {
  const began = performance.now();
  viewer.delete_path(["press"]);
  for (const command of data.scene)
    viewer.handle_command_bytearray(Uint8Array.from(atob(command), c => c.charCodeAt(0)));
  addEdges();
  shapesAt = performance.now();
  shapesTook = shapesAt - began;
}

// ---- forces, paths and names ----
function renewSeries() {  // of the same bearings
  data.places.forEach((place, i) => { places[i] = floats(place); });
  data.bearings.forEach(({ place, force }, i) => { if (arrows[i]) Object.assign(arrows[i], { place: places[place], force: floats(force) }); });
  const count = data.bearings.length;
  if (arrows[count]) arrows[count].force = floats(data.shaking);
  if (arrows[count + 1] && data.process) Object.assign(arrows[count + 1], { place: floats(data.process.place), force: floats(data.process.force) });
  labels.forEach((label, i) => {
    if (i < places.length) label.series = places[i];
    else if (data.process && label === labels.at(-1)) label.series = floats(data.process.place);
  });
  data.traces.forEach(({ path }, i) => { if (dots[i]) dots[i].series = floats(path); });
  if (data.peak > 0) element("peak").textContent = newtons(data.peak);
}

function renewAll() {  // bearings may be others
  overlay.clear();
  element("labels").replaceChildren();
  for (const list of [arrows, labels, places]) list.length = 0;
  leaders.replaceChildren();
  places.push(...data.places.map(floats));
  addForces();
  renewPaths();
  addLabels();
  element("legend").replaceChildren();
  addLegend();
}

function renewPaths() {
  for (const tube of paths.children) tube.geometry.dispose();
  paths.clear();
  dots.length = 0;
  addPaths();
}

const kinds = () => JSON.stringify([data.bearings.map(({ name, place }) => [name, place]), !!data.process, data.traces.length, data.peak > 0]);
let drawnKinds = kinds(), stale = false;  // of bearings as they are drawn; whether the links are behind the curves

function adopt(message) {
  const share = duration > 0 ? now / duration : 0;
  Object.assign(data, message);
  duration = data.time.at(-1);
  now = share * duration;
  if (message.type === "opened") showDimensions();
  showValues();
  showNotes();
  showCurves();
  if (message.scene || !hurried()) drawLinks(message); else stale = true;
  if (stale) { moment = momentAt(now); showCursor(); viewer.set_dirty(); }
}

function drawLinks({ type, scene }) {
  stale = false;
  element("slider").max = duration;
  linkPoses = data.poses.map(floats);
  if (scene) replaceShapes();
  if (type === "opened" || drawnKinds !== kinds()) renewAll(); else renewSeries();
  if (scene && type !== "opened") renewPaths();
  drawnKinds = kinds();
  seek(now);
}

// While a slider moves, the curves come first: a browser that takes long for the links, as one without a graphics card, draws them less often.
let drawnAt = 0, drawingTook = 0;  // [ms]

const hurried = () => (waiting || wanted) && drawingTook > 25 && performance.now() - drawnAt < 4 * drawingTook;

function limitDrawing() {
  const draw = viewer.render;
  viewer.render = () => {
    if (hurried()) return;
    if (stale) drawLinks({ type: "picture" });
    const began = performance.now();
    draw();
    requestAnimationFrame(() => { drawnAt = performance.now(); drawingTook = drawnAt - began; });
  };
}

// ---- curves: slide, torque and largest bearing force, with those of the press as it was opened ----
let overTime;  // of a driver that goes to and fro
const abscissa = () => overTime ? data.time : data.crank;

function showCurves() {
  if (charts.length !== data.curves.length || overTime !== !data.period) {
    overTime = !data.period;
    element("curves").replaceChildren();
    charts.length = 0;
    for (const _ of data.curves) {
      const figure = make("figure", element("curves")), caption = make("figcaption", figure);
      const chart = { title: make("b", caption), range: make("small", caption), value: make("output", caption) }, plot = make("div", figure);
      Object.assign(chart, { canvas: make("canvas", plot), cursor: make("i", plot), dot: make("i", plot, { className: "dot" }) });
      chart.canvas.setAttribute("role", "img");
      chart.canvas.addEventListener("pointerdown", event => { setPlaying(false); seekInChart(chart, event); });
      chart.canvas.addEventListener("pointermove", event => { if (event.buttons) seekInChart(chart, event); });
      charts.push(chart);
    }
  }
  data.curves.forEach((curve, i) => {
    const now = floats(curve.values), old = data.before[i] ? floats(data.before[i].values) : now;
    const both = [...now, ...old], low = Math.min(0, ...both), high = Math.max(0, ...both);
    const [per, unit] = scale[curve.unit].find(([per]) => Math.max(-low, high) >= 0.9995 * per) || scale[curve.unit].at(-1);
    Object.assign(charts[i], { now, old, low: low / per, high: (high > low ? high : low + per) / per, per, unit, at: curve.at, name: curve.name });
    charts[i].title.textContent = curve.name;
    charts[i].canvas.setAttribute("aria-label", `${curve.name} over the ${overTime ? "time" : "crank angle"}`);
    const peak = now.reduce((best, value, k) => Math.abs(value) > Math.abs(now[best]) ? k : best, 0);
    const where = `${inWords(abscissa()[peak])}${overTime ? " s" : data.driver.unit}`;
    charts[i].range.textContent = curve.unit === "m" ? `stroke ${digits((Math.max(...now) - Math.min(...now)) / per)} ${unit}` : `peak ${digits(now[peak] / per)} ${unit} at ${where}${curve.at ? `, ${curve.at[peak]}` : ""}`;
    charts[i].range.title = charts[i].range.textContent;
    paint(charts[i]);
  });
}

const digits = value => (Math.abs(value) >= 1000 ? value.toFixed(0) : Number(value.toPrecision(4)).toString()).replace("-", "\u2212");
const inWords = value => Number(value.toPrecision(4)).toString();
const EDGE = { left: 46, right: 8, top: 6, bottom: 18 };

function paint(chart) {
  const { canvas } = chart, ratio = devicePixelRatio, width = canvas.clientWidth, height = canvas.clientHeight, pen = canvas.getContext("2d", { willReadFrequently: true });  // so it is drawn by the processor, which is quicker for as little
  if (!width) return;
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  const colour = name => getComputedStyle(document.body).getPropertyValue(name), along = abscissa();
  const first = Math.min(...along), last = Math.max(...along), inner = width - EDGE.left - EDGE.right, tall = height - EDGE.top - EDGE.bottom;
  const x = value => EDGE.left + (value - first) / (last - first || 1) * inner;
  const y = value => EDGE.top + (chart.high - value) / (chart.high - chart.low || 1) * tall;
  Object.assign(chart, { x, y, inner });
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "11px system-ui, sans-serif";
  pen.lineWidth = 1;
  for (const tick of ticks(chart.low, chart.high, 4)) line(pen, colour("--hairline"), [[EDGE.left, y(tick)], [width - EDGE.right, y(tick)]]), write(pen, colour("--faint"), digits(tick), EDGE.left - 5, y(tick) + 4, "right");
  for (const tick of overTime ? ticks(first, last, 4) : quarters(first, last, inner)) line(pen, colour("--hairline"), [[x(tick), EDGE.top], [x(tick), height - EDGE.bottom]]), write(pen, colour("--faint"), overTime ? `${inWords(tick)} s` : `${tick}°`, x(tick), height - 5, tick === first ? "left" : tick === last ? "right" : "center");
  pen.setLineDash([4, 3]);
  pen.lineWidth = 1.2;
  const points = series => Array.from(series, (value, k) => [x(along[Math.min(k, along.length - 1)]), y(value / chart.per)]);
  line(pen, colour("--faint"), points(chart.old));
  pen.setLineDash([]);
  pen.lineWidth = 2;
  line(pen, colour("--accent"), points(chart.now));
}

function line(pen, colour, points) {
  pen.strokeStyle = colour;
  pen.beginPath();
  points.forEach(([x, y], k) => k ? pen.lineTo(x, y) : pen.moveTo(x, y));
  pen.stroke();
}

function write(pen, colour, text, x, y, align) {
  pen.fillStyle = colour;
  pen.textAlign = align;
  pen.fillText(text, x, y);
}

function ticks(low, high, about) {
  const raw = (high - low) / about, decade = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 2.5, 5, 10].find(step => step * decade >= raw) * decade;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(6)));
  return found;
}

function quarters(first, last, width) {  // of turns, or fewer where there is little room or are many turns
  const step = [90, 180, 360, 720, 1440].find(step => (last - first) / step * 36 < width) || 2880, found = [];
  for (let k = Math.ceil(first / step - 1e-9); k * step <= last + 1e-6; k++) found.push(k * step);
  return found;
}

function showCursor() {
  const along = number(abscissa());
  for (const chart of charts) {
    if (!chart.x) continue;
    const value = number(chart.now) / chart.per;
    chart.cursor.style.transform = `translateX(${chart.x(along).toFixed(1)}px)`;
    chart.dot.style.transform = `translate(${chart.x(along).toFixed(1)}px, ${chart.y(value).toFixed(1)}px)`;
    chart.value.textContent = `${digits(value)} ${chart.unit}`;
  }
}

function seekInChart(chart, event) {
  const share = Math.min(Math.max((event.offsetX - EDGE.left) / chart.inner, 0), 1);
  seek(overTime || data.crank.at(-1) > data.crank[0] ? share * duration : (1 - share) * duration);
}

// ---- dimensions ----
function showDimensions() {
  element("dimensions").replaceChildren();
  rows.length = 0;
  values = [...data.values];
  const groups = new Map();
  data.dimensions.forEach((each, i) => {
    if (!groups.has(each.group)) {
      const group = make("fieldset", element("dimensions"));
      make("legend", group, { textContent: each.group });
      groups.set(each.group, group);
    }
    rows.push(addRow(groups.get(each.group), each, i));
  });
  element("name").value = data.suggested;
  element("name").title = `in ${data.folder}`;
  element("speed-unit").textContent = data.speed_unit;
  element("moves").hidden = !data.drivers.length;
  element("moving").replaceChildren(...data.drivers.map(name => new Option(name, name, false, name === data.moving)));
  data.drivers.forEach((name, i) => { rows[i].box.hidden = name === data.moving; });
}

function addRow(group, each, i) {
  const box = make("div", group, { className: "row" }), name = make("span", box, { textContent: each.name });
  if (each.note) make("small", name, { textContent: ` ${each.note}` });
  const range = make("input", box, { type: "range", min: each.low, max: each.high, step: "any" });
  const field = make("input", box, { type: "number", step: each.step });
  make("i", box, { textContent: each.unit });
  const back = make("button", box, { type: "button", textContent: "↺", title: "As it was" });
  const row = { box, range, field, error: make("p", box), index: i };
  const label = `${each.group}: ${each.name}${each.unit ? `, ${each.unit}` : ""}`;
  for (const input of [range, field]) input.setAttribute("aria-label", label);
  back.setAttribute("aria-label", `${label}: as it was`);
  row.error.setAttribute("role", "alert");
  range.addEventListener("input", () => { change(row, onStep(Number(range.value), each), false); });
  range.addEventListener("change", () => { change(row, onStep(Number(range.value), each), true); });
  range.addEventListener("keydown", event => {  // a step, with Shift ten
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
    if (!way) return;
    event.preventDefault();
    event.stopPropagation();
    change(row, Number((values[i] + way * each.step * (event.shiftKey ? 10 : 1)).toPrecision(9)), true);
  });
  field.addEventListener("change", () => { if (field.value !== "") change(row, Number(field.value), true); });
  back.addEventListener("click", () => { change(row, each.value, true); });
  return row;
}

const onStep = (value, each) => Number((Math.round(value / each.step) * each.step).toPrecision(9));

function change(row, value, final) {
  touched = row;
  values[row.index] = value;
  row.field.value = Number(value.toPrecision(7));
  want(final);
}

function showValues() {  // as they are in the press that is shown, unless more is wanted
  if (!wanted && !waiting) values = [...data.values];
  const active = document.activeElement;
  for (const { box, range, field, error, index } of rows) {
    const value = values[index];
    if (range !== active || !waiting) range.value = value;
    if (field !== active) field.value = Number(value.toPrecision(7));
    box.classList.toggle("changed", data.values[index] !== data.dimensions[index].value);
    error.textContent = "";
  }
  if (element("moving") !== active) element("moving").value = data.moving;
  if (element("speed") !== active) element("speed").value = data.speed;
  element("reset").disabled = data.values.every((value, i) => value === data.dimensions[i].value);
}

function showNotes() {
  const said = [...data.notes];
  if (data.points < 180) said.push(`A linkage that takes long: ${data.points} states of a period are computed.`);
  element("notes").replaceChildren();
  for (const text of said) make("p", element("notes"), { textContent: text });
  element("notes").hidden = !said.length;
}

// ---- what is sent and what comes: one question at a time, the newest ----
function want(final) {
  wanted = { final: final || (wanted !== null && wanted.final) };
  ask();
}

function ask() {
  if (waiting || !wanted || socket.readyState !== WebSocket.OPEN) return;
  const speed = Number(element("speed").value);
  const shapes = wanted.final || (!hurried() && performance.now() - shapesAt > 5 * shapesTook + 50);  // at most a sixth of the time goes into them
  socket.send(JSON.stringify({ type: "set", values, speed: Number.isFinite(speed) ? speed : data.speed, shapes }));
  waiting = wanted.final ? "final" : "on the way";
  wanted = null;
}

function refused(text) {
  const final = waiting === "final";
  waiting = false;
  (touched ? touched.error : element("saved")).textContent = text;
  if (final && !wanted) {  // let go: back to the last good one
    values = [...data.values];
    for (const { range, field, index } of rows) range.value = field.value = Number(values[index].toPrecision(7));
    element("speed").value = data.speed;
    element("moving").value = data.moving;
  }
  ask();
}

socket.addEventListener("open", () => { socket.send(JSON.stringify({ type: "ready", version: data.version })); ask(); });
socket.addEventListener("message", event => {
  const message = JSON.parse(event.data);
  if (message.type === "picture" || message.type === "opened") {
    waiting = false;
    element("broken").hidden = true;
    if (message.type === "opened" && !(Math.abs(Math.log(message.size / data.size)) < 0.7)) { location.reload(); return; }
    ask();  // before it is drawn, so that the next one is computed meanwhile
    adopt(message);
    socket.send(JSON.stringify({ type: "ready", version: message.version }));
    ask();
  } else if (message.type === "refused") refused(message.text);
  else if (message.type === "broken") {
    element("broken").textContent = message.text;
    element("broken").hidden = false;
  } else {
    element("saved").textContent = message.type === "saved" ? `Written: ${message.text}` : message.text;
    element("save").textContent = message.type === "exists" ? "Replace it" : "Save";
    element("save").dataset.replace = message.type === "exists" ? element("name").value : "";
  }
});
socket.addEventListener("close", () => {
  element("broken").textContent = "pinpress has ended: start it again, and open its new address.";
  element("broken").hidden = false;
});

element("saving").addEventListener("submit", event => {
  event.preventDefault();
  const name = element("name").value;
  socket.send(JSON.stringify({ type: "save", name, replace: name !== "" && element("save").dataset.replace === name }));
});
element("panel").addEventListener("keydown", event => event.stopPropagation());  // blanks and arrows are for fields and sliders there
element("name").addEventListener("input", () => { element("save").textContent = "Save"; });
element("dimensions").addEventListener("submit", event => event.preventDefault());
element("speed").addEventListener("change", () => { touched = null; want(true); });
element("moving").addEventListener("change", event => {
  touched = null;
  waiting = "final";
  socket.send(JSON.stringify({ type: "move", driver: event.target.value }));
  event.target.blur();
});
element("reset").addEventListener("click", () => { values = data.dimensions.map(each => each.value); touched = null; want(true); });

start();
limitDrawing();
listeners.push(showCursor);
showDimensions();
showValues();
showNotes();
showCurves();
new ResizeObserver(() => { charts.forEach(paint); showCursor(); }).observe(element("curves"));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { charts.forEach(paint); showCursor(); });
if (data.broken) { element("broken").textContent = data.broken; element("broken").hidden = false; }
seek(now);
