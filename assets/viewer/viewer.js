// Shows the scene of a report where the browser can: the drawing that stands still stays for paper
// and for browsers that cannot.
(() => {
  'use strict';

  const figure = document.getElementById('scene');
  const data = document.getElementById('scene-glb');
  if (!figure || !data || typeof THREE === 'undefined') return;
  const canvas = figure.querySelector('canvas');
  const seen = figure.querySelector('img.seen');

  // Requested before the library does, which would complain to the console.
  const context = canvas.getContext('webgl2', { antialias: true, alpha: true });
  if (!context) return;

  const FIELD_OF_VIEW_DEG = 30;
  const FIRST_LOOK = new THREE.Vector3(0.75, 0.4, 1).normalize();
  const TURN_OF_A_KEY_RAD = Math.PI / 24;

  let renderer;
  try {
    renderer = new THREE.WebGLRenderer({ canvas, context, antialias: true, alpha: true });
  } catch {
    return;
  }
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 0.01, 100);
  // The light comes from the viewer, so that colours are read alike from every side.
  const light = new THREE.DirectionalLight(0xffffff, 1.5);
  camera.add(light);
  scene.add(camera, new THREE.AmbientLight(0xffffff, 1.9));
  const controls = new THREE.OrbitControls(camera, canvas);

  let isRequested = false;
  const draw = () => {
    isRequested = false;
    renderer.render(scene, camera);
  };
  // Nothing is drawn while nothing changes.
  const requestDraw = () => {
    if (!isRequested) requestAnimationFrame(draw);
    isRequested = true;
  };
  // For paper: a canvas is not printed by every browser.
  const remember = () => {
    draw();
    seen.src = canvas.toDataURL('image/png');
  };

  const fit = () => {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (width === 0 || height === 0) return;
    renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    requestDraw();
  };

  const show = (model) => {
    const box = new THREE.Box3();
    model.updateMatrixWorld(true);
    model.traverse((object) => {
      if (!object.isMesh) return;
      box.expandByObject(object);
      // Metal without surroundings to mirror would be black.
      if ('metalness' in object.material) object.material.metalness = 0;
    });
    if (box.isEmpty()) return;
    scene.add(model);
    const sphere = box.getBoundingSphere(new THREE.Sphere());
    const away = (1.1 * sphere.radius) / Math.sin((FIELD_OF_VIEW_DEG / 2) * (Math.PI / 180));
    camera.near = away / 1000;
    camera.far = away * 10;
    controls.target.copy(sphere.center);
    controls.minDistance = away / 50;
    controls.maxDistance = away * 3;
    camera.position.copy(sphere.center).addScaledVector(FIRST_LOOK, away);
    controls.saveState();
    controls.update();

    figure.classList.add('turns');
    canvas.hidden = false;
    seen.hidden = false;
    for (const words of figure.querySelectorAll('.turning-words, .scene-legend')) words.hidden = false;
    figure.querySelector('.still-words').hidden = true;
    fit();
    remember();
  };

  const turn = (theta, phi) => {
    const offset = camera.position.clone().sub(controls.target);
    const spherical = new THREE.Spherical().setFromVector3(offset);
    spherical.theta += theta;
    spherical.phi += phi;
    spherical.makeSafe();
    camera.position.copy(controls.target).add(offset.setFromSpherical(spherical));
    controls.update();
    remember();
  };

  controls.addEventListener('change', requestDraw);
  controls.addEventListener('end', remember);
  new ResizeObserver(fit).observe(canvas);
  canvas.addEventListener('dblclick', () => {
    controls.reset();
    remember();
  });
  canvas.addEventListener('keydown', (event) => {
    const step = TURN_OF_A_KEY_RAD;
    const turns = {
      ArrowLeft: [-step, 0],
      ArrowRight: [step, 0],
      ArrowUp: [0, -step],
      ArrowDown: [0, step],
    };
    const angles = turns[event.key];
    if (!angles) return;
    event.preventDefault();
    turn(...angles);
  });
  // A page that is scrolled past does not get caught here.
  controls.enableZoom = false;
  canvas.addEventListener('pointerdown', () => {
    controls.enableZoom = true;
    canvas.focus({ preventScroll: true });
  });
  canvas.addEventListener('blur', () => {
    controls.enableZoom = false;
  });
  // A driver that gives up leaves the drawing.
  canvas.addEventListener('webglcontextlost', () => {
    figure.classList.remove('turns');
    canvas.hidden = true;
    seen.hidden = true;
    for (const words of figure.querySelectorAll('.turning-words, .scene-legend')) words.hidden = true;
    figure.querySelector('.still-words').hidden = false;
  });

  const bytes = Uint8Array.from(atob(data.textContent.trim()), (letter) => letter.charCodeAt(0));
  // A scene that cannot be read leaves the drawing, too.
  new THREE.GLTFLoader().parse(bytes.buffer, '', (gltf) => show(gltf.scene), () => {});
})();
