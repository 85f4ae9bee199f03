"use strict";
const { Viewer, THREE } = MeshCat;
const element = id => document.getElementById(id);
const data = JSON.parse(element("data").textContent);
const duration = data.time[data.time.length - 1];  // s
const floats = text => new Float32Array(Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer);
const upright = (x, y, z) => new THREE.Vector3(x, z, -y);  // three.js has y up: the press's (x, y, z) stands there

// ---- scene ----
const viewer = new Viewer(element("view"), false);
viewer.set_3d_pane_size = resize;
for (const command of data.scene)
  viewer.handle_command_bytearray(Uint8Array.from(atob(command), c => c.charCodeAt(0)));
for (const path of ["Lights", "Grid", "Axes", "Background"]) viewer.set_property([path], "visible", false);
viewer.scene.background = null;  // the page's own background shows through
viewer.animator.play();  // once, as seeking does nothing before
viewer.animator.pause();

const { min: low, max: high } = boundsOverTheMotion();
const centre = low.clone().add(high).multiplyScalar(0.5);
const size = high.distanceTo(low);

function boundsOverTheMotion() {
  const bounds = new THREE.Box3(), stride = Math.ceil(data.time.length / 60);
  for (let k = 0; k < data.time.length; k += stride) {
    viewer.animator.seek(data.time[k]);
    viewer.scene.updateMatrixWorld(true);
    bounds.expandByObject(viewer.scene_tree.find(["press"]).object);
  }
  return bounds;
}

function addLights() {
  const stage = new THREE.Group();
  stage.rotation.x = Math.PI / 2;  // undoes the scene's own rotation: y is up in here
  const sun = new THREE.DirectionalLight(0xffffff, 0.5);
  sun.position.copy(centre).add(new THREE.Vector3(-0.35, 1.1, 1.0).multiplyScalar(size));
  sun.target.position.copy(centre);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  sun.shadow.radius = 3;
  sun.shadow.normalBias = 0.004 * size;
  Object.assign(sun.shadow.camera, { left: -0.7 * size, right: 0.7 * size, top: 0.7 * size, bottom: -0.7 * size, near: 0.1 * size, far: 3 * size });
  const side = new THREE.DirectionalLight(0xffffff, 0.22);
  side.position.set(1, 0.3, 0.5);
  stage.add(sun, sun.target, side, ...ground(), new THREE.HemisphereLight(0xffffff, 0xc4ccd4, 0.62));
  viewer.scene.add(stage);
}

function ground() {  // what the shadow falls on, and a grid of 1, 2 or 5 times a power of ten metres that fades away from the press
  const width = 4 * size, raw = size / 8, decade = 10 ** Math.floor(Math.log10(raw));
  const spacing = decade * [1, 2, 5, 10].find(step => step * decade >= raw);
  const canvas = document.createElement("canvas"), pen = canvas.getContext("2d"), pixels = 1024;
  canvas.width = canvas.height = pixels;
  pen.strokeStyle = "#5b6873";
  pen.lineWidth = 1.4;
  for (let i = -Math.ceil(width / 2 / spacing); i * spacing <= width / 2; i++) {
    const at = (0.5 + i * spacing / width) * pixels;
    pen.moveTo(at, 0); pen.lineTo(at, pixels);
    pen.moveTo(0, at); pen.lineTo(pixels, at);
  }
  pen.stroke();
  const fade = pen.createRadialGradient(pixels / 2, pixels / 2, 0.1 * pixels, pixels / 2, pixels / 2, 0.5 * pixels);
  fade.addColorStop(0, "#000");
  fade.addColorStop(1, "#0000");
  pen.globalCompositeOperation = "destination-in";
  pen.fillStyle = fade;
  pen.fillRect(0, 0, pixels, pixels);
  const texture = new THREE.CanvasTexture(canvas);
  texture.anisotropy = 8;
  const lines = new THREE.MeshBasicMaterial({ map: texture, transparent: true, opacity: 0.3, depthWrite: false });
  const shade = new THREE.ShadowMaterial({ opacity: 0.10 });
  return [[lines, width, 0.002], [shade, 3 * width, 0.001]].map(([material, side, below]) => {
    const floor = new THREE.Mesh(new THREE.PlaneGeometry(side, side), material);
    floor.rotation.x = -Math.PI / 2;
    floor.position.set(centre.x, low.y - below * size, centre.z);
    floor.receiveShadow = true;
    return floor;
  });
}

function addEdges() {  // thin outlines make overlapping parts of one colour readable
  const meshes = [];
  viewer.scene_tree.find(["press"]).object.traverse(o => { if (o.isMesh) meshes.push(o); });
  for (const mesh of meshes) {
    mesh.material.polygonOffset = true;
    mesh.material.polygonOffsetFactor = mesh.material.polygonOffsetUnits = 1;
    const line = new THREE.LineBasicMaterial({ color: 0x14191e, transparent: true, opacity: 0.45 * mesh.material.opacity });
    const large = mesh.geometry.clone().scale(1 / size, 1 / size, 1 / size);  // three.js tells corners apart by four decimals
    mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(large, 30).scale(size, size, size), line));
  }
}

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
  const length = LONGEST * arrow.newtons / data.peak, { group, parts: [shaftRim, headRim, shaft, head] } = arrow;
  group.visible = length > 1e-4 * size;
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
  const colours = [0, 0.25, 0.5, 0.75, 1].map(share => `rgb(${mapped(share)})`);
  element("scale").querySelector("i").style.background = `linear-gradient(90deg, ${colours})`;
  element("peak").textContent = newtons(data.peak);
}

const foot = () => [centre.x, -centre.z, low.y];  // of the press, in its own axes

function newtons(force) {
  const [unit, per] = data.peak >= 1e6 ? ["MN", 1e6] : data.peak >= 1e3 ? ["kN", 1e3] : ["N", 1];
  const largest = data.peak / per;
  if (largest < 0.1) return `${force.toPrecision(3)} N`;
  return `${(force / per).toFixed(largest >= 100 ? 0 : largest >= 10 ? 1 : 2)} ${unit}`;
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

// ---- names: one label a place, beside a dot on it ----
const labels = [];

function addLabels() {
  const named = data.bearings.map(({ name, place }, i) => ({ name, place, arrow: arrows[i] }));
  places.forEach((series, place) => addLabel(series, named.filter(bearing => bearing.place === place)));
  if (arrows.length) addLabel(foot(), [{ name: "shaking force", arrow: arrows[named.length] }]);
}

function addLabel(series, named) {
  const dot = document.createElement("i"), chip = document.createElement("div");
  const rows = named.map(({ name, arrow }) => {
    const row = document.createElement("p"), bold = document.createElement("b"), value = document.createElement("span");
    bold.textContent = bold.title = name;
    row.append(bold, value);
    chip.append(row);
    return { value, arrow };
  });
  element("labels").append(dot, chip);
  labels.push({ series, dot, chip, rows, width: 0, height: 0 });
}

function fillLabels() {
  const shown = element("show-forces").ariaPressed === "true";
  for (const label of labels)
    for (const { value, arrow } of label.rows) value.textContent = arrow && shown ? newtons(arrow.newtons) : "";
  for (const label of labels) [label.width, label.height] = [label.chip.offsetWidth, label.chip.offsetHeight];
}

function placeLabels() {  // where their places are on the screen; a label that would lie on another one moves below it
  const width = element("view").clientWidth, height = element("view").clientHeight, taken = [];
  for (const label of labels) {
    const at = upright(...vector(label.series).toArray()).project(viewer.camera);
    const x = (at.x + 1) / 2 * width, y = (1 - at.y) / 2 * height;
    label.dot.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    label.at = { left: Math.min(x + 8, width - label.width - 4), top: Math.max(y - label.height - 6, 4) };
  }
  for (const label of [...labels].sort((a, b) => a.at.top - b.at.top)) {
    const { at } = label;
    for (const other of taken)
      if (at.left < other.right && at.left + label.width > other.left && at.top < other.bottom && at.top + label.height > other.top) at.top = other.bottom + 3;
    taken.push({ left: at.left, right: at.left + label.width, top: at.top, bottom: at.top + label.height });
    taken.sort((a, b) => a.top - b.top);
    label.chip.style.transform = `translate(${at.left.toFixed(1)}px, ${at.top.toFixed(1)}px)`;
  }
}

// ---- camera: as near as the box of the whole motion and all arrows allows, until the user moves it ----
let fitted = true, fromFront = false;
const box = new THREE.Box3(low.clone(), high.clone());
const { slanted, straight } = eyeDirections();

function eyeDirections() {
  if (!data.front.length) return { slanted: new THREE.Vector3(0.55, 0.42, 1).normalize(), straight: new THREE.Vector3(0, 0, 1) };
  const front = upright(...data.front), lying = Math.abs(front.y) > 0.9;
  const up = lying ? new THREE.Vector3(0, 0, -1) : new THREE.Vector3(0, 1, 0), right = up.clone().cross(front).normalize();
  const slanted = front.clone().addScaledVector(right, 0.34).addScaledVector(up, lying ? -0.5 : 0.2).normalize();
  return { slanted, straight: lying ? front.clone().addScaledVector(up, -0.01).normalize() : front };
}

function holdArrows() {  // the camera holds them too
  const stride = Math.ceil(data.time.length / 60);
  for (const { place, force, towards } of arrows)
    for (let k = 0; k < data.time.length; k += stride) {
      moment = { before: k, after: k, part: 0 };
      const tip = vector(place).addScaledVector(vector(force), (towards ? -LONGEST : LONGEST) / data.peak);
      box.expandByPoint(upright(...tip.toArray()));
    }
}

function resize() {
  const width = element("view").clientWidth, height = Math.max(1, element("view").clientHeight), camera = viewer.camera;
  camera.aspect = width / height;
  if (fitted) fit(camera);
  camera.updateProjectionMatrix();
  viewer.renderer.setSize(width, height);
  viewer.set_dirty();
}

function fit(camera) {
  const eye = fromFront ? straight : slanted, middle = box.getCenter(new THREE.Vector3());
  const right = new THREE.Vector3(0, 1, 0).cross(eye).normalize(), up = eye.clone().cross(right);
  camera.fov = 22;
  const slopeY = Math.tan(camera.fov * Math.PI / 360) / 1.08, slopeX = slopeY * camera.aspect;
  let distance = 0;
  for (let i = 0; i < 8; i++) {
    const corner = new THREE.Vector3(...["x", "y", "z"].map((axis, bit) => (i >> bit & 1 ? box.max : box.min)[axis])).sub(middle);
    const depth = corner.dot(eye);
    distance = Math.max(distance, depth + Math.abs(corner.dot(right)) / slopeX, depth + Math.abs(corner.dot(up)) / slopeY);
  }
  camera.near = 0.05 * distance;
  camera.far = 20 * distance;
  viewer.controls.target.copy(middle);
  camera.position.copy(eye).multiplyScalar(distance).add(middle);
  viewer.controls.update();
}

// ---- playback ----
let now = 0, playing = false, before = null;
const DIGITS = Math.max(3, 2 - Math.floor(Math.log10(duration || 1)));  // of times, so that those of a fast press differ
const [LENGTH, PER_METRE] = data.size > 50 ? ["m", 1] : data.size > 0.02 ? ["mm", 1e3] : ["µm", 1e6];
const listeners = [];  // what else follows the time: functions of the time [s]

function seek(time) {
  now = Math.min(Math.max(time, 0), duration);
  moment = momentAt(now);
  viewer.animator.seek(now);
  arrows.forEach(drawArrow);
  for (const { dot, series } of dots) dot.position.copy(vector(series));
  const angle = number(data.crank);
  show("time", "", now.toFixed(DIGITS) + " s");
  show("crank", "crank", (Math.abs(angle) <= 360 ? angle : (angle % 360 + 360) % 360).toFixed(1) + "°");
  if (data.slide) show("slide", "slide", `${(number(data.slide) * PER_METRE).toFixed(1).replace("-", "\u2212")} ${LENGTH}`);
  element("slider").value = now;
  fillLabels();
  for (const tell of listeners) tell(now);
  viewer.set_dirty();
}

function show(id, label, text) {
  const small = document.createElement("small");
  small.textContent = label;
  element(id).replaceChildren(small, text);
}

function setPlaying(on) {
  playing = on && duration > 0;
  before = null;
  element("play").querySelector("path").setAttribute("d", playing ? "M2 1h4v12H2zM8 1h4v12H8z" : "M2 0l11 7-11 7z");
}

function frame(stamp) {
  requestAnimationFrame(frame);
  if (playing) {
    if (before !== null) seek((now + (stamp - before) / 1000 * element("rate").value) % duration);
    before = stamp;
  }
  if (viewer.needs_render) viewer.render();
}

function seekFromAddress() {
  const match = /^#t=([\d.]+)$/.exec(location.hash);
  if (match) { setPlaying(false); seek(Number(match[1]) || 0); }
  return match !== null;
}

// ---- controls ----
function toggle(id, apply) {
  element(id).addEventListener("click", () => {
    const on = element(id).ariaPressed !== "true";
    element(id).ariaPressed = String(on);
    apply(on);
    seek(now);
  });
}

function start() {
  element("slider").max = duration;
  element("slider").addEventListener("input", event => { setPlaying(false); seek(Number(event.target.value)); });
  element("slider").addEventListener("change", () => history.replaceState(null, "", "#t=" + now.toFixed(DIGITS)));
  element("play").addEventListener("click", () => setPlaying(!playing));
  element("toolbar").addEventListener("pointerdown", event => event.stopPropagation());  // the camera's controls would take it
  toggle("show-forces", on => { overlay.visible = on; });
  toggle("show-names", on => { element("labels").hidden = !on; });
  toggle("show-paths", on => { paths.visible = on; });
  toggle("front-view", on => { fromFront = on; fitted = true; resize(); });
  addEventListener("hashchange", seekFromAddress);
  addEventListener("keydown", event => {
    if (event.key !== " " || ["BUTTON", "SELECT"].includes(event.target.tagName)) return;  // these two use the space bar themselves
    event.preventDefault();
    setPlaying(!playing);
  });
  element("slide").hidden = data.slide === null;
  element("front-view").hidden = !data.front.length;
  for (const { name, colour } of data.legend) {
    const row = document.createElement("li"), swatch = document.createElement("i");
    swatch.style.background = colour;
    row.append(swatch, name);
    element("legend").append(row);
  }
  addLights();
  addEdges();
  addForces();
  addPaths();
  addLabels();
  viewer.scene.add(paths, overlay);
  holdArrows();
  const render = viewer.render.bind(viewer);
  viewer.render = () => { render(); placeLabels(); };
  resize();
  viewer.controls.addEventListener("start", () => { fitted = false; });
  new ResizeObserver(() => resize()).observe(element("view"));
  if (!seekFromAddress()) { seek(0); setPlaying(!matchMedia("(prefers-reduced-motion: reduce)").matches); }
  requestAnimationFrame(frame);
}
