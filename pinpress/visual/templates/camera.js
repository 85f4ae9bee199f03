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
      const way = vector(force), newtons = way.length();
      const tip = vector(place).addScaledVector(way, (towards ? -1 : 1) * lengthOf(newtons) / (newtons || 1));
      box.expandByPoint(upright(...tip.toArray()));
    }
}

function holdBends() {  // and the lines that bend, which may be a frame far larger than the linkage
  for (const { series } of bends)
    for (let k = 0; k < series.length; k += 3) box.expandByPoint(upright(series[k], series[k + 1], series[k + 2]));
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
