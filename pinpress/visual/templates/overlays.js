// What is drawn over the links: forces, paths, names. Positions in the press's own axes [m], forces in N.
// ---- series over the keys ----
let moment = { before: 0, after: 0, part: 0 };  // the keys around the present time, and how far it is from one to the other

function momentAt(time) {
  let before = 0, after = data.time.length - 1;
  while (after - before > 1) {
    const middle = (before + after) >> 1;
    if (data.time[middle] <= time) before = middle; else after = middle;
  }
  return { before, after, part: after > before ? (time - data.time[before]) / (data.time[after] - data.time[before]) : 0 };
}

const number = series => series[moment.before] + moment.part * (series[moment.after] - series[moment.before]);

function vector(series) {  // (k, 3), or (1, 3) where it does not change
  if (series.length === 3) return new THREE.Vector3(...series);
  const at = i => new THREE.Vector3().fromArray(series, 3 * i);
  return at(moment.before).lerp(at(moment.after), moment.part);
}

// ---- forces: arrows whose length and colour grow with the load, drawn over everything, outlined in white ----
const overlay = new THREE.Group(), arrows = [], LONGEST = 0.2 * size;
const MAP = [[0x00, 0x9f, 0xc7], [0x6f, 0x5b, 0xd6], [0xe6, 0x00, 0x7e]];  // no load, half and the largest: colours that no link has
const places = data.places.map(floats);

function mapped(share) {
  const i = Math.min(Math.floor(2 * share), 1), part = 2 * share - i;
  return MAP[i].map((low, c) => Math.round(low + part * (MAP[i + 1][c] - low)));
}

function layer(geometry, colour, side, order) {
  const material = new THREE.MeshBasicMaterial({ color: colour, side, depthTest: false, depthWrite: false, transparent: true });
  const mesh = new THREE.Mesh(geometry, material);
  mesh.renderOrder = order;
  mesh.frustumCulled = false;
  return mesh;
}

// By the root of the force, so that small ones are seen beside a blow; none below 2 % of the peak.
const lengthOf = force => force < 0.02 * data.peak ? 0 : LONGEST * Math.sqrt(force / data.peak);

function addArrow(place, force, towards) {
  const group = new THREE.Group(), shaft = new THREE.CylinderGeometry(1, 1, 1, 20), head = new THREE.ConeGeometry(1, 1, 28);
  shaft.translate(0, 0.5, 0);
  head.translate(0, 0.5, 0);
  const parts = [layer(shaft, 0xffffff, THREE.BackSide, 20), layer(head, 0xffffff, THREE.BackSide, 20), layer(shaft, 0, THREE.FrontSide, 21), layer(head, 0, THREE.FrontSide, 21)];
  group.add(...parts);
  overlay.add(group);
  arrows.push({ place, force, towards, group, parts, newtons: 0 });
}

function drawArrow(arrow) {
  const force = vector(arrow.force);
  arrow.newtons = force.length();
  const length = lengthOf(arrow.newtons), { group, parts: [shaftRim, headRim, shaft, head] } = arrow;
  group.visible = length > 0;
  if (!group.visible) return;
  const width = Math.min(1, 0.3 + length / (0.1 * size)) * 0.0045 * size, tip = Math.min(7 * width, 0.5 * length), rim = 0.0014 * size;
  const direction = force.divideScalar(arrow.newtons);
  group.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), direction);
  group.position.copy(vector(arrow.place));
  if (arrow.towards) group.position.addScaledVector(direction, -length);
  shaft.scale.set(width, length - tip, width);
  shaftRim.scale.set(width + rim, length - tip + rim, width + rim);
  shaftRim.position.y = -rim;
  head.scale.set(2.4 * width, tip, 2.4 * width);
  headRim.scale.set(2.4 * width + 2 * rim, tip + 4 * rim, 2.4 * width + 2 * rim);
  head.position.y = length - tip;
  headRim.position.y = length - tip - rim;
  const [r, g, b] = mapped(arrow.newtons / data.peak);
  for (const part of [shaft, head]) part.material.color.setRGB(r / 255, g / 255, b / 255);
}

function addForces() {
  if (!(data.peak > 0)) { element("show-forces").hidden = element("scale").hidden = true; return; }
  for (const { place, force } of data.bearings) addArrow(places[place], floats(force), false);
  addArrow(foot(), floats(data.shaking), true);
  if (data.process) addArrow(floats(data.process.place), floats(data.process.force), true);
  const colours = [0, 0.25, 0.5, 0.75, 1].map(share => `rgb(${mapped(share)})`);
  element("scale").querySelector("i").style.background = `linear-gradient(90deg, ${colours})`;
  element("peak").textContent = newtons(data.peak);
}

const foot = () => [centre.x, -centre.z, low.y];  // of the press, in its own axes

const UNITS = [[1e6, "MN"], [1e3, "kN"], [1, "N"], [1e-3, "mN"]];

function newtons(force) {  // three digits, in the unit of this force; rounding beside the largest of all forces is no force
  if (force < 1e-7 * data.peak) return "0 N";
  const [per, unit] = UNITS.find(([per]) => force >= 0.9995 * per) || UNITS[3];
  const digits = (force / per).toPrecision(3);
  return `${spoken(digits.includes("e+") ? String(Number(digits)) : digits)} ${unit}`;
}

// ---- paths ----
const paths = new THREE.Group(), dots = [];

function addPaths() {
  for (const { link, path, keys } of data.traces) {
    const colour = new THREE.Color((data.legend.find(row => row.name === link) || { colour: "#1d2730" }).colour).multiplyScalar(0.7);
    const series = floats(path), points = [];
    for (let k = 0; k < keys; k++) points.push(new THREE.Vector3().fromArray(series, 3 * k));
    const along = curve(points);
    if (along) paths.add(tube(along, 0.0045 * size, 0xffffff, 10), tube(along, 0.003 * size, colour, 11));
    if (along && along.isLineCurve3) paths.add(...ends(along, colour));
    const dot = layer(new THREE.SphereGeometry(0.006 * size, 20, 14), colour, THREE.FrontSide, 12);
    paths.add(dot);
    dots.push({ dot, series });
  }
  element("show-paths").hidden = !data.traces.length;
}

// ---- links that bend: the line of their nodes ----
const bends = [];

function addBends() {
  for (const { link, nodes } of data.bends || []) {
    const colour = new THREE.Color((data.legend.find(row => row.name === link) || { colour: "#1d2730" }).colour).multiplyScalar(0.6);
    const series = floats(nodes), count = series.length / 3 / data.time.length, parts = [];
    for (let i = 0; i < count - 1; i++) parts.push(layer(new THREE.CylinderGeometry(1, 1, 1, 12), colour, THREE.FrontSide, 13));
    overlay.add(...parts);
    bends.push({ series, count, parts });
  }
}

function drawBend({ series, count, parts }) {
  const at = (key, i) => new THREE.Vector3().fromArray(series, 3 * (key * count + i));
  const node = i => at(moment.before, i).lerp(at(moment.after, i), moment.part);
  parts.forEach((part, i) => {
    const from = node(i), along = node(i + 1).sub(from), length = along.length();
    part.position.copy(from).addScaledVector(along, 0.5);
    part.scale.set(0.005 * size, length, 0.005 * size);
    part.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.divideScalar(length || 1));
  });
}

function curve(points) {  // through the points; null where they rest
  const box = new THREE.Box3().setFromPoints(points), far = box.min.distanceTo(box.max);
  if (far < 1e-6 * size) return null;
  const from = farthest(points, points[0]), to = farthest(points, from), along = to.clone().sub(from).normalize();
  if (points.every(p => p.clone().sub(from).cross(along).length() < 1e-4 * far)) return new THREE.LineCurve3(from, to);
  return new THREE.CatmullRomCurve3(points.filter((p, i) => !i || p.distanceTo(points[i - 1]) > 1e-9 * size));
}

const tube = (along, radius, colour, order) =>
  layer(new THREE.TubeGeometry(along, along.isLineCurve3 ? 1 : along.points.length, radius, 8), colour, THREE.FrontSide, order);

function ends(line, colour) {  // bars across both ends of a straight path
  const along = line.v2.clone().sub(line.v1), across = new THREE.Vector3(...data.front.length ? data.front : [0, -1, 0]).cross(along).setLength(0.012 * size);
  return [line.v1, line.v2].map(at => tube(new THREE.LineCurve3(at.clone().sub(across), at.clone().add(across)), 0.003 * size, colour, 11));
}

const farthest = (points, from) => points.reduce((best, p) => p.distanceTo(from) > best.distanceTo(from) ? p : best);

// ---- names: one label a place, beside a dot on it; where others are in its way it steps aside, with a line to its dot ----
const labels = [], SVG = "http://www.w3.org/2000/svg", leaders = document.createElementNS(SVG, "svg");
const MANY = 24;  // labels, of which there may be no place for all
const GAP = 3, NEAR = 24;  // between labels, and from a dot to its label without a line [pixels]

function addLabels() {
  for (const side of ["width", "height"]) leaders.setAttribute(side, "100%");
  element("labels").append(leaders);
  const named = data.bearings.map(({ name, place }, i) => ({ name, place, arrow: arrows[i] }));
  places.forEach((series, place) => addLabel(series, named.filter(bearing => bearing.place === place)));
  if (arrows.length) addLabel(foot(), [{ name: say("force on the floor"), arrow: arrows[named.length] }]);
  if (data.process) addLabel(floats(data.process.place), [{ name: say("process force"), arrow: arrows[named.length + 1], idle: true }]);
  if (labels.length > MANY) labels.sort((one, two) => two.peak - one.peak);  // these get a place first
}

function addLabel(series, named) {
  const dot = make("i", element("labels")), chip = make("div", element("labels")), leader = document.createElementNS(SVG, "line");
  const rows = named.map(({ name, arrow, idle }) => {
    const row = make("p", chip);
    make("b", row, { textContent: name, title: name });
    return { row, value: make("span", row), arrow, idle };
  });
  leader.setAttribute("stroke", "currentColor");
  leaders.append(leader);
  const peak = Math.max(0, ...named.map(({ arrow }) => arrow ? largest(arrow.force) : 0));
  labels.push({ series, dot, chip, leader, rows, peak, width: 0, height: 0, spot: 0 });
}

function largest(force) {  // length of the vectors (k, 3)
  let most = 0;
  for (let i = 0; i < force.length; i += 3) most = Math.max(most, Math.hypot(force[i], force[i + 1], force[i + 2]));
  return most;
}

function fillLabels() {
  const shown = element("show-forces").ariaPressed === "true";
  for (const label of labels)
    for (const { row, value, arrow, idle } of label.rows) {
      row.hidden = idle && arrow.newtons < 1e-6 * data.peak;  // a load that does not act has no name
      value.textContent = arrow && shown ? newtons(arrow.newtons) : "";
    }
  for (const label of labels) [label.width, label.height] = [label.chip.offsetWidth, label.chip.offsetHeight];
}

// Where a label may stand: at the four corners of its dot, then on rings of growing distance [pixels]
const SPOTS = [[8, -6], [8, 6], [-8, -6], [-8, 6]];
for (let far = 28; far < 400; far *= 1.35)
  for (let k = 0; k < 12; k++) SPOTS.push([far * Math.cos(k * Math.PI / 6), -far * Math.sin(k * Math.PI / 6)]);

function placeLabels() {  // where their places are on the screen
  const width = element("view").clientWidth, height = element("view").clientHeight;
  for (const label of labels) {
    const at = upright(...vector(label.series).toArray()).project(viewer.camera);
    label.x = (at.x + 1) / 2 * width;
    label.y = (1 - at.y) / 2 * height;
    label.dot.style.transform = `translate(${label.x.toFixed(1)}px, ${label.y.toFixed(1)}px)`;
  }
  const dots = labels.map(({ x, y }) => ({ left: x - 3, right: x + 3, top: y - 3, bottom: y + 3 }));
  const taken = [element("toolbar"), element("scale"), document.querySelector("header")].map(areaInView);
  for (const label of labels) {
    const { area, spot } = freeArea(label, taken, dots, width, height);
    const covered = sum(taken.map(other => shared(area, other))) / (label.width * label.height);
    const crowded = covered > (label.crowded ? 0 : 0.1);  // it comes back only where it covers nothing, so that it does not flicker
    Object.assign(label, { spot, crowded });
    label.chip.style.visibility = label.leader.style.visibility = crowded ? "hidden" : "";
    if (crowded) continue;
    taken.push(area);
    label.chip.style.transform = `translate(${area.left.toFixed(1)}px, ${area.top.toFixed(1)}px)`;
    drawLeader(label, area);
  }
}

function areaInView(part) {
  const area = part.getBoundingClientRect(), view = element("view").getBoundingClientRect();
  return { left: area.left - view.left, right: area.right - view.left, top: area.top - view.top, bottom: area.bottom - view.top };
}

// The nearest area that nothing else takes; the last one is kept as long as none is clearly nearer, so that labels do not jump
function freeArea(label, taken, dots, width, height) {
  let best = null;
  for (const [spot, [dx, dy]] of SPOTS.entries()) {
    const far = Math.hypot(dx, dy) + (spot === label.spot ? 0 : 30);
    if (best && far >= best.cost) continue;
    const left = Math.min(Math.max(label.x + (dx < -1 ? dx - label.width : dx > 1 ? dx : -label.width / 2), 4), width - label.width - 4);
    const top = Math.min(Math.max(label.y + (dy < -1 ? dy - label.height : dy > 1 ? dy : -label.height / 2), 4), height - label.height - 4);
    const area = { left, top, right: left + label.width, bottom: top + label.height };
    const cost = far + 20 * sum(taken.map(other => shared(area, other))) + sum(dots.map(dot => shared(area, dot)));
    if (!best || cost < best.cost) best = { cost, area, spot };
  }
  return best;
}

const sum = numbers => numbers.reduce((total, number) => total + number, 0);

function shared(one, other) {  // area that two rectangles have in common, with the gap between them [pixels squared]
  const width = Math.min(one.right, other.right) - Math.max(one.left, other.left) + GAP;
  const height = Math.min(one.bottom, other.bottom) - Math.max(one.top, other.top) + GAP;
  return width > 0 && height > 0 ? width * height : 0;
}

function drawLeader({ x, y, leader }, area) {  // to the nearest point of the label's edge
  const toX = Math.min(Math.max(x, area.left), area.right), toY = Math.min(Math.max(y, area.top), area.bottom);
  leader.style.display = Math.hypot(toX - x, toY - y) > NEAR ? "" : "none";
  for (const [name, value] of Object.entries({ x1: x, y1: y, x2: toX, y2: toY })) leader.setAttribute(name, value.toFixed(1));
}
