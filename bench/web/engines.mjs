// Each engine: `await make(scene)` gives { step(), height(k), free() } and takes the settings that its makers advise for
// 60 Hz; the number of passes stands in its name. All run on one thread.
import { dt, friction, gravity } from './scenes.mjs';

async function psim(scene) {
  const { load } = await import('../../build/web/npm/psim.mjs');
  const lib = await load();
  const [left, right] = scene.floor;
  const world = lib.world({
    psim: 1,
    world: { bounds: [left, 0, right, scene.height], boundary: 'walls', gravity: [0, gravity], material: 'm' },
    step: { substeps: 4, sleeping: false },
    materials: { m: { friction } },
    bodies: scene.bodies.map(({ x, y }) => ({
      position: [x, y], material: 'm', shape: scene.disc ? { disc: { radius: 0.5 } } : { box: { size: [1, 1] } },
    })),
  });
  return { step: () => world.step(), height: (k) => world.body({ index: k, generation: 0 }).y, free: () => world.free() };
}

async function box2d(scene) {
  const { default: start } = await import('box2d3-wasm');
  const b = await start();
  const worldDef = b.b2DefaultWorldDef();
  worldDef.gravity.Set(0, gravity);
  worldDef.enableSleep = false;
  worldDef.workerCount = 0;
  const world = b.b2CreateWorld(worldDef);
  const shapeDef = b.b2DefaultShapeDef();
  shapeDef.material.friction = friction;
  shapeDef.enableContactEvents = false;
  const [left, right] = scene.floor;
  const ground = b.b2CreateBody(world, b.b2DefaultBodyDef());
  for (const [x0, y0, x1, y1] of [[left, 0, right, 0], [left, 0, left, scene.height], [right, 0, right, scene.height]]) {
    const segment = new b.b2Segment();
    segment.point1.Set(x0, y0);
    segment.point2.Set(x1, y1);
    b.b2CreateSegmentShape(ground, shapeDef, segment);
  }
  const box = b.b2MakeBox(0.5, 0.5);
  const circle = new b.b2Circle();
  circle.radius = 0.5;
  const ids = scene.bodies.map(({ x, y }) => {
    const def = b.b2DefaultBodyDef();
    def.type = b.b2BodyType.b2_dynamicBody;
    def.position.Set(x, y);
    const id = b.b2CreateBody(world, def);
    def.delete();
    if (scene.disc) b.b2CreateCircleShape(id, shapeDef, circle);
    else b.b2CreatePolygonShape(id, shapeDef, box);
    return id;
  });
  return {
    step: () => b.b2World_Step(world, dt, 4),
    height: (k) => b.b2Body_GetPosition(ids[k]).y,
    free: () => b.b2DestroyWorld(world),
  };
}

async function rapier(scene) {
  const { default: r } = await import('@dimforge/rapier2d-simd-compat');
  await r.init();
  const world = new r.World({ x: 0, y: gravity });
  world.timestep = dt;
  const [left, right] = scene.floor;
  for (const [x0, y0, x1, y1] of [[left, 0, right, 0], [left, 0, left, scene.height], [right, 0, right, scene.height]]) {
    world.createCollider(r.ColliderDesc.segment({ x: x0, y: y0 }, { x: x1, y: y1 }).setFriction(friction));
  }
  const bodies = scene.bodies.map(({ x, y }) => {
    const body = world.createRigidBody(r.RigidBodyDesc.dynamic().setTranslation(x, y).setCanSleep(false));
    const shape = scene.disc ? r.ColliderDesc.ball(0.5) : r.ColliderDesc.cuboid(0.5, 0.5);
    world.createCollider(shape.setFriction(friction), body);
    return body;
  });
  return { step: () => world.step(), height: (k) => bodies[k].translation().y, free: () => world.free() };
}

async function planck(scene) {
  const p = await import('planck');
  const world = new p.World({ gravity: { x: 0, y: gravity }, allowSleep: false });
  const ground = world.createBody();
  const [left, right] = scene.floor;
  for (const [x0, y0, x1, y1] of [[left, 0, right, 0], [left, 0, left, scene.height], [right, 0, right, scene.height]]) {
    ground.createFixture({ shape: new p.Edge({ x: x0, y: y0 }, { x: x1, y: y1 }), friction });
  }
  const shape = scene.disc ? new p.Circle(0.5) : new p.Box(0.5, 0.5);
  const bodies = scene.bodies.map(({ x, y }) => {
    const body = world.createBody({ type: 'dynamic', position: { x, y } });
    body.createFixture({ shape, density: 1, friction });
    return body;
  });
  return { step: () => world.step(dt, 8, 3), height: (k) => bodies[k].getPosition().y, free: () => {} };
}

async function matter(scene) {
  const { default: m } = await import('matter-js');
  const unit = 40; // Matter's lengths are pixels
  const engine = m.Engine.create({ enableSleeping: false });
  engine.gravity.y = 1;
  engine.gravity.scale = (-gravity * unit) / 1e6;
  const [left, right] = scene.floor.map((x) => x * unit);
  const h = scene.height * unit, t = 4 * unit, middle = (left + right) / 2;
  const fixed = { isStatic: true, friction };
  const walls = [
    m.Bodies.rectangle(middle, t / 2, right - left + 2 * t, t, fixed),
    m.Bodies.rectangle(left - t / 2, -h / 2, t, h, fixed),
    m.Bodies.rectangle(right + t / 2, -h / 2, t, h, fixed),
  ];
  const bodies = scene.bodies.map(({ x, y }) => scene.disc
    ? m.Bodies.circle(x * unit, -y * unit, unit / 2, { friction })
    : m.Bodies.rectangle(x * unit, -y * unit, unit, unit, { friction }));
  m.Composite.add(engine.world, [...walls, ...bodies]);
  return { step: () => m.Engine.update(engine, 1000 * dt), height: (k) => -bodies[k].position.y / unit, free: () => {} };
}

export const engines = [
  { name: 'psim, 4 substeps', make: psim },
  { name: 'Box2D 3 (box2d3-wasm), 4 substeps', make: box2d },
  { name: 'Rapier (rapier2d-simd-compat), 4 iterations', make: rapier },
  { name: 'planck, 8 + 3 iterations', make: planck },
  { name: 'Matter (matter-js), 6 + 4 iterations', make: matter },
];
