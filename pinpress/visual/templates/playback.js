// ---- playback ----
let now = 0, playing = false, before = null;
const DIGITS = Math.max(3, 2 - Math.floor(Math.log10(duration || 1)));  // of times, so that those of a fast press differ
const [LENGTH, PER_METRE] = data.size > 50 ? ["m", 1] : data.size > 0.02 ? ["mm", 1e3] : ["µm", 1e6];
const travel = data.height ? (Math.max(...data.height) - Math.min(...data.height)) * PER_METRE : 0;
const PLACES = travel > 0 ? Math.min(9, Math.max(1, 2 - Math.floor(Math.log10(travel)))) : 1;
const UNWRAPPED = !data.period || data.crank.every(angle => Math.abs(angle) <= data.period + 0.001);
const listeners = [];  // what else follows the time: functions of the time [s]

// of vibrations, mode follows mode in the time of the page, and the one on show is repeated
const modeAt = time => data.modes.findLastIndex(mode => mode.start <= time + 1e-9);
let modeShown = -1;
const span = () => data.modes ? data.modes[Math.max(modeAt(now), 0)] : { start: 0, end: duration };  // s

function seek(time) {
  now = Math.min(Math.max(time, 0), duration);
  moment = momentAt(now);
  viewer.animator.seek(now);
  arrows.forEach(drawArrow);
  for (const { dot, series } of dots) dot.position.copy(vector(series));
  bends.forEach(drawBend);
  const angle = number(data.crank);
  if (data.modes) showMode(); else show("time", "", now.toFixed(DIGITS) + " s");
  const within = UNWRAPPED ? angle : (angle % data.period + data.period) % data.period;
  show("crank", data.driver.name, within.toFixed(1) + data.driver.unit);
  if (data.height) show("slide", data.above, `${(number(data.height) * PER_METRE).toFixed(PLACES)} ${LENGTH}`);
  element("slider").value = now;
  element("slider").ariaValueText = ["time", "crank", "slide"].map(id => element(id).textContent).filter(Boolean).join(", ");
  fillLabels();
  for (const tell of listeners) tell(now);
  viewer.set_dirty();
}

function showMode() {
  const place = modeAt(now), mode = data.modes[place];
  show("time", mode.name, number(data.frequency).toPrecision(4) + " Hz");
  if (modeShown === place) return;
  modeShown = element("mode").value = place;
  Object.assign(element("slider"), { min: mode.start, max: mode.end });
  element("words").textContent = mode.words;
}

function addModes() {  // a choice beside the speed, and words below the links
  const choice = Object.assign(document.createElement("select"), { id: "mode", ariaLabel: say("Mode"), title: say("Natural vibration") });
  data.modes.forEach(({ name }, value) => make("option", choice, { value, textContent: name }));
  choice.addEventListener("change", () => seek(data.modes[choice.value].start + now - span().start));
  element("rate").before(choice);
  element("legend").after(Object.assign(document.createElement("p"), { id: "words" }));
}

function show(id, label, text) {
  const small = document.createElement("small");
  small.textContent = label && label + " ";
  element(id).replaceChildren(small, spoken(text).replace("-", "\u2212"));
}

function setPlaying(on) {
  playing = on && duration > 0;
  before = null;
  element("play").ariaLabel = playing ? say("Pause") : say("Play");
  element("play").querySelector("path").setAttribute("d", playing ? "M2 1h4v12H2zM8 1h4v12H8z" : "M2 0l11 7-11 7z");
}

function frame(stamp) {
  requestAnimationFrame(frame);
  if (playing) {
    const { start, end } = span();
    if (before !== null) seek(start + (now - start + (stamp - before) / 1000 * element("rate").value) % (end - start));
    before = stamp;
  }
  if (viewer.needs_render) viewer.render();
}

function seekFromAddress() {
  const match = /^#t=(\d*\.?\d+)$/.exec(location.hash);
  if (match) { setPlaying(false); seek(Number(match[1]) || 0); }
  return match !== null;
}

function startingRate() {  // real time, or so slow that a period takes half a second at least
  const turn = data.time[data.turn - 1], rates = [...element("rate").options].map(option => Number(option.value));
  return String(Math.max(rates[0], ...rates.filter(rate => rate <= 1 && turn / rate >= 0.5)));
}

// ---- controls ----
const KEYS = {
  " ": () => setPlaying(!playing),
  ArrowLeft: count => step(-count),
  ArrowRight: count => step(count),
};

function step(count) {  // to a key before or after the present one
  const key = moment.part > 0.5 ? moment.after : moment.before;
  setPlaying(false);
  const { start, end } = span(), to = data.time[Math.min(Math.max(key + count, 0), data.time.length - 1)];
  seek(Math.min(Math.max(to, start), end));
}

function toggle(id, apply) {
  element(id).addEventListener("click", () => {
    const on = element(id).ariaPressed !== "true";
    element(id).ariaPressed = String(on);
    apply(on);
    seek(now);
  });
}

function addLegend() {
  for (const { name, colour } of data.legend) {
    const row = make("li", element("legend"), { title: name });
    make("i", row).style.background = colour;
    row.append(name);
  }
}

function sayAll() {  // the words of the page's own elements
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode())
    if (texts.currentNode.parentNode.tagName !== "SCRIPT") texts.currentNode.textContent = texts.currentNode.textContent.replace(/\S.*\S/s, say);
  for (const name of ["title", "aria-label"])
    for (const each of document.body.querySelectorAll(`[${name}]`)) each.setAttribute(name, say(each.getAttribute(name)));
}

function start() {
  if (data.language) sayAll();
  element("slider").max = duration;
  document.documentElement.style.setProperty("--title", JSON.stringify(document.title));
  element("rate").value = startingRate();
  element("slider").addEventListener("input", event => { setPlaying(false); seek(Number(event.target.value)); });
  element("slider").addEventListener("change", () => history.replaceState(null, "", "#t=" + now.toFixed(DIGITS)));
  element("play").addEventListener("click", () => setPlaying(!playing));
  toggle("show-forces", on => { overlay.visible = on; });
  toggle("show-names", on => { element("labels").hidden = !on; });
  toggle("show-paths", on => { paths.visible = on; });
  toggle("front-view", on => { fromFront = on; fitted = true; resize(); });
  addEventListener("hashchange", seekFromAddress);
  addEventListener("keydown", event => {
    const act = KEYS[event.key], { tagName, id } = event.target;
    if (!act || event.ctrlKey || event.altKey || event.metaKey) return;
    if (tagName === "SELECT" || (tagName === "INPUT" && id !== "slider") || (tagName === "BUTTON" && event.key === " ")) return;  // they use it themselves
    event.preventDefault();
    act(event.shiftKey ? 10 : 1);
  });
  element("slide").hidden = data.height === null;
  element("front-view").hidden = !data.front.length;
  addLegend();
  if (data.magnified) make("li", element("legend"), { textContent: `${say("displacements on the springs drawn")} ${data.magnified}×` });
  if (data.modes) addModes();
  addLights();
  addEdges();
  addForces();
  addPaths();
  addBends();
  addLabels();
  viewer.scene.add(paths, overlay);
  holdArrows();
  holdBends();
  const render = viewer.render.bind(viewer);
  viewer.render = () => { render(); placeLabels(); };
  resize();
  viewer.controls.addEventListener("start", () => { fitted = false; });
  new ResizeObserver(() => resize()).observe(element("view"));
  if (!seekFromAddress()) { seek(0); setPlaying(!matchMedia("(prefers-reduced-motion: reduce)").matches); }
  requestAnimationFrame(frame);
}
