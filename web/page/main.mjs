// The page: a gallery of scenes, sliders, hands, and what a step cost. ?scene=NAME&bodies=N&threads=N choose at
// the start. NAME may be the address of a scene file.
import { load } from '../npm/psim.mjs';
import { Camera, Picture } from './draw.mjs';
import { Graph } from './graph.mjs';
import { Hands } from './hands.mjs';

const find = (id) => document.getElementById(id);
const query = new URLSearchParams(location.search);
const mostBodies = 100000; // of the slider
const hashEvery = 30; // frames
const sceneFiles = ['boats', 'dam_break', 'tap']; // what the gallery takes from the folder `scenes`

const show = {
  psim: undefined, world: undefined, scene: undefined, shapes: undefined, camera: new Camera(),
  paused: false, tool: 'grab', meshOf: [], addedMass: new Map(),
  massOf(id) { return this.addedMass.get(id) ?? this.shapes.all[this.shapes.of[id]]?.mass ?? 1; },
};
let picture, graph, hands, names;
let left = 0, last = 0; // seconds of the world that are still to be stepped; time of the last picture

function say(text) { find('message').textContent = text; }

function tellErrors(action) {
  try {
    action();
  } catch (error) {
    say(error.message);
  }
}

// ---- scenes ----
function chosen() { return names.find((scene) => scene.name === find('scene').value); }

function bodiesWanted() {
  const scene = chosen();
  if (!scene.sized) return scene.bodies;
  return Math.max(1, Math.round(Math.exp(find('bodies').value * Math.log(mostBodies))));
}

/** The scene that was chosen, with so many bodies where their number is free. */
function made(bodies) {
  const { name, text, sized } = chosen();
  return text ? show.psim.scene(text, name) : show.psim.builtin(name, { bodies: sized ? bodies : 0 });
}

/** What stands in a scene file as an entry of the gallery. */
async function fetched(address) {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${address} cannot be read`);
  const text = await answer.text();
  const { name = address, description = '' } = JSON.parse(text);
  return { name, description, text, bodies: 1, sized: false };
}

/** Adds a scene file to the gallery and returns the name that is to be shown first. */
async function firstOf(name) {
  if (/[/.]/.test(name ?? '')) {
    const scene = await fetched(name);
    names = [scene, ...names.filter((other) => other.name !== scene.name)];
    return scene.name;
  }
  if (name === null || names.some((scene) => scene.name === name)) return name ?? 'washer';
  throw new Error(`there is no scene ${name} here, or it has more than ${mostBodies} bodies`);
}

function start() {
  hands.forget();
  show.world?.free();
  show.scene?.free();
  show.world = show.scene = undefined;
  show.scene = made(bodiesWanted());
  show.scene.substeps = Number(find('substeps').value);
  show.world = show.scene.world();
  show.world.setSnapshots(true);
  show.world.setGravity(show.world.settings.gravity[0], Number(find('gravity').value));
  show.shapes = show.scene.shapes();
  picture.fluids.spacings = show.scene.fluids.map((fluid) => fluid.spacing);
  show.addedMass.clear();
  picture.setShapes(show.shapes.all.length ? show.shapes.all : [{ kind: 'disc' }]);
  show.meshOf = Array.from(show.shapes.of);
  find('words').textContent = chosen().description;
  graph.times = [];
  frame();
  lookAtAll();
}

/** A scene was chosen: the sliders take its own settings. */
function choose() {
  const scene = made(Math.min(chosen().bodies, 1000));
  const world = scene.world();
  const { gravity, substeps } = world.settings;
  world.free();
  scene.free();
  find('gravity').value = gravity[1];
  find('substeps').value = substeps;
  find('bodies').disabled = !chosen().sized;
  const wanted = Number(query.get('bodies')) || Math.min(chosen().bodies, 20000);
  find('bodies').value = Math.log(wanted) / Math.log(mostBodies);
  query.delete('bodies');
  start();
  tellSliders();
}

function lookAtAll() {
  const { bounds, boundary } = show.world.settings;
  // A fluid goes wherever the walls let it.
  if (picture.fluids.spacings.length && boundary !== 'open') return show.camera.fit(...bounds);
  const { id, x, y, radius, origin, count } = show.world.snapshot();
  const reaches = show.shapes.all.map((shape) => {
    if (shape.kind === 'line') return 0; // a ground that is much longer than what stands on it
    const far = Array.from(shape.points.subarray(0, shape.points.length / 2), (_, k) => Math.hypot(shape.points[2 * k], shape.points[2 * k + 1]));
    return shape.radius + Math.max(0, ...far);
  });
  const box = [Infinity, Infinity, -Infinity, -Infinity];
  for (let k = 0; k < count; ++k) {
    const reach = Math.max(radius[k], reaches[show.meshOf[id[k]]]);
    box[0] = Math.min(box[0], x[k] - reach), box[1] = Math.min(box[1], y[k] - reach);
    box[2] = Math.max(box[2], x[k] + reach), box[3] = Math.max(box[3], y[k] + reach);
  }
  const within = box.map((v, k) => (k < 2 ? Math.max(v + origin[k], bounds[k]) : Math.min(v + origin[k - 2], bounds[k])));
  show.camera.fit(...(count ? within : bounds));
}

show.add = (body) => {
  const id = show.world.add(body);
  const { all } = alike(body);
  show.meshOf[id.index] = picture.addShape(all[0]);
  show.addedMass.set(id.index, all[0].mass);
};

function alike(body) {
  const { bounds } = show.world.settings;
  const scene = show.psim.scene({ psim: 1, world: { bounds }, bodies: [body] });
  const shapes = scene.shapes();
  scene.free();
  return shapes;
}

// ---- frames ----
function frame() {
  const { dt } = show.world.settings;
  hands.lead(dt);
  const { ms } = show.world.step();
  graph.add(ms);
  if (show.world.frame % hashEvery === 1) find('hash').textContent = `frame ${show.world.frame}  ${show.world.hash()}`;
}

function paint(rows) {
  const most = Math.hypot(...show.world.settings.gravity) || 5;
  return (k, into, at) => {
    const asleep = rows.asleep[k] ? 0.55 : 1;
    const warm = Math.min(rows.speed[k] / (2 * most), 1);
    const tint = ((rows.id[k] * 2654435761) >>> 24) / 255;
    into[at] = asleep * (0.32 + 0.6 * warm + 0.1 * tint);
    into[at + 1] = asleep * (0.56 - 0.1 * warm + 0.1 * tint);
    into[at + 2] = asleep * (0.8 - 0.5 * warm);
    into[at + 3] = 1;
  };
}

const noParticles = { count: 0, fluid: [], x: [], y: [] };

function draw() {
  const particles = picture.fluids.spacings.length ? show.world.fluidParticles() : noParticles;
  picture.fluids.take(particles, show.camera);
  const rows = show.world.snapshot();
  if (rows) picture.draw(rows, (id) => show.meshOf[id] ?? 0, paint(rows), show.camera);
  graph.draw();
  const { world, psim } = show;
  const threads = world.threads > 1 ? `, ${world.threads} threads` : '';
  const fluid = particles.count ? `  ${particles.count.toLocaleString('en')} particles` : '';
  find('status').textContent =
    `${world.bodyCount.toLocaleString('en')} bodies${fluid}  ${graph.median.toFixed(2)} ms a step  ${world.isa}${threads}  psim ${psim.version}`;
}

function tick(now) {
  requestAnimationFrame(tick);
  tellErrors(() => {
    if (!show.world) return;
    const { dt } = show.world.settings;
    if (!show.paused) left += Math.min((now - last) / 1000, 0.05) * Number(find('speed').value);
    last = now;
    for (let k = 0; k < 3 && left >= dt; ++k, left -= dt) frame();
    left = Math.min(left, dt);
    draw();
  });
}

// ---- sliders ----
function tellSliders() {
  const bodies = chosen().sized || !show.scene ? bodiesWanted() : show.scene.bodies;
  const values = { bodies: bodies.toLocaleString('en') };
  for (const id of ['bodies', 'gravity', 'substeps', 'speed']) {
    find(id).parentElement.querySelector('output').textContent = values[id] ?? find(id).value;
  }
}

function listen() {
  find('scene').addEventListener('change', () => tellErrors(choose));
  find('restart').addEventListener('click', () => tellErrors(start));
  find('pause').addEventListener('click', () => {
    show.paused = !show.paused;
    find('pause').textContent = show.paused ? 'go on' : 'pause';
  });
  find('message').addEventListener('click', () => say(''));
  find('fold').addEventListener('click', () => find('panel').classList.toggle('folded'));
  for (const id of ['bodies', 'substeps']) find(id).addEventListener('change', () => tellErrors(start));
  find('gravity').addEventListener('input', () => show.world.setGravity(show.world.settings.gravity[0], Number(find('gravity').value)));
  for (const id of ['bodies', 'gravity', 'substeps', 'speed']) find(id).addEventListener('input', tellSliders);
  for (const tool of document.querySelectorAll('[name=tool]')) {
    tool.addEventListener('change', () => (show.tool = tool.value));
  }
}

async function main() {
  picture = new Picture(find('view'));
  graph = new Graph(find('graph'));
  hands = new Hands(find('view'), show);
  const threads = Number(query.get('threads')) || Math.min(navigator.hardwareConcurrency || 1, 4);
  show.psim = await load({ threads });
  say(show.psim.notes.join('\n'));
  names = show.psim.scenes.filter((scene) => scene.bodies <= mostBodies);
  const files = await Promise.allSettled(sceneFiles.map((name) => fetched(`scenes/${name}.json`)));
  for (const { value, reason } of files) {
    if (value) names.push(value);
    else say(reason.message);
  }
  const first = await firstOf(query.get('scene')).catch((error) => (say(error.message), 'washer'));
  find('scene').append(...names.map(({ name, description }) => {
    const option = new Option(name, name);
    option.title = description;
    return option;
  }));
  find('scene').value = first;
  if (innerWidth <= 560) find('panel').classList.add('folded');
  listen();
  choose();
  requestAnimationFrame(tick);
}

window.psimPage = show; // for tests and the curious
main().catch((error) => say(error.message));
