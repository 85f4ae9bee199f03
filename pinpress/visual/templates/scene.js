"use strict";
// What every page begins with: the scene of Meshcat's viewer, its lights and its ground.
const { Viewer, THREE } = MeshCat;
const element = id => document.getElementById(id);
const data = JSON.parse(element("data").textContent);
const say = words => data.language?.words[words] ?? words;  // in the language of the page
const spoken = text => data.language?.comma ? text.replace(/(\d)\.(\d)/g, "$1,$2") : text;  // numbers
let duration = data.time[data.time.length - 1];  // s
function floats(text) {
  const packed = atob(text), bytes = new Uint8Array(packed.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = packed.charCodeAt(i);
  return new Float32Array(bytes.buffer);
}
function make(tag, parent, properties = {}) {
  const made = document.createElement(tag);
  Object.assign(made, properties);
  parent.append(made);
  return made;
}

const upright = (x, y, z) => new THREE.Vector3(x, z, -y);  // three.js has y up: the press's (x, y, z) stands there

// ---- scene ----
const solid = ["webgl2", "webgl"].some(kind => document.createElement("canvas").getContext(kind));
const viewer = solid ? new Viewer(element("view"), false) : flatViewer();

function flatViewer() {  // without WebGL, as on remote desktops: a drawing stands in place of the moving press, and all else of the page works
  const nothing = () => {}, message = make("p", element("view"), { className: "message", textContent: say("This browser cannot draw the moving press: WebGL is switched off or missing. Allow hardware acceleration, or open the page in another browser.") });
  message.setAttribute("role", "status");
  document.body.classList.add("flat");
  if (data.drawing) make("img", element("view"), { id: "drawing", src: data.drawing, alt: say("Drawing of the press") });
  return {
    scene: new THREE.Scene(), camera: new THREE.PerspectiveCamera(), scene_tree: { find: () => ({ object: new THREE.Group() }) },
    animator: { seek: nothing, play: nothing, pause: nothing }, controls: { target: new THREE.Vector3(), update: nothing, addEventListener: nothing },
    renderer: { setSize: nothing, setPixelRatio: nothing, domElement: { toDataURL: () => data.drawing || "data:," } },
    handle_command_bytearray: nothing, set_property: nothing, set_dirty: nothing, delete_path: nothing, render: nothing, needs_render: false,
  };
}

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
  return bounds.isEmpty() ? new THREE.Box3(new THREE.Vector3(), new THREE.Vector3(1, 1, 1)) : bounds;
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
