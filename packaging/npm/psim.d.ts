/** A 2D physics engine for very many bodies. Lengths are metres, times seconds, angles radians. */

/** What this browser or Node can run. */
export interface Abilities {
  simd: boolean;
  exceptions: boolean;
  /** Shared memory: a page needs the headers COOP and COEP. */
  threads: boolean;
}
export function abilities(): Abilities;

export interface LoadOptions {
  /** 1 to 16, in pages alone; the worlds of the module share them. 1 by default. */
  threads?: number;
  /** Instead of what was found, for tests. */
  abilities?: Abilities;
}
/** Loads the best module that can run here. `notes` says what was missing for a better one. */
export function load(options?: LoadOptions): Promise<Psim>;

export interface WorldOptions {
  /** 'auto' or what the module has, 'simd128' or 'scalar'; both give the same bits. Another one is an error. */
  isa?: string;
}

export interface BuiltinScene {
  name: string;
  description: string;
  /** How many by default. */
  bodies: number;
  /** Whether the number can be chosen. */
  sized: boolean;
}

export interface Psim {
  readonly module: string;
  readonly version: string;
  readonly threads: number;
  /** The instruction sets of the module, the best last. */
  readonly isas: string[];
  /** One line each: why this is not the fastest module. */
  readonly notes: string[];
  readonly scenes: BuiltinScene[];
  builtin(name: string, options?: { bodies?: number; seed?: number }): Scene;
  /** A scene from the text, or the object, of a scene file. Errors name line and column. */
  scene(json: string | object, file?: string): Scene;
  /** The world of a scene that is used once. */
  world(json: string | object, options?: WorldOptions): World;
  /** A world that goes on from what World.save gave, here or on another machine, with the same bits. */
  restore(bytes: Uint8Array, options?: WorldOptions): World;
}

export interface Shape {
  kind: 'disc' | 'area' | 'line' | 'loop' | 'parts';
  /** Around the points; a disc's is that of the state's column. */
  radius: number;
  /** kg, of a body of it; 0 if the body cannot move. */
  mass: number;
  /** x and y of each point, in the frame of the body. */
  points: Float64Array;
  /** Of several shapes that move as one: each of them; an area of one point is a disc. */
  parts?: Shape[];
}

export interface Scene {
  readonly json: string;
  readonly bodies: number;
  /** 1 to 64, for worlds that are made from now on. */
  substeps: number;
  /** What bodies look like: body `id` is all[of[id]]. */
  shapes(): { of: Uint32Array; all: Shape[] };
  /** What its fluids are made of: fluid 0 first. */
  readonly fluids: Fluid[];
  world(options?: WorldOptions): World;
  /** Adds the scene's bodies, not its groups and joints, to a world. */
  addTo(world: World): Id[];
  free(): void;
}

/** Of a body or joint. One that was removed is refused by every call. */
export interface Id {
  index: number;
  generation: number;
}

export interface StepReport {
  /** Wall time of the step, milliseconds. */
  ms: number;
  contacts: number;
  awake: number;
  asleep: number;
  pairs: number;
  escaped: number;
  /** Bodies frozen because of broken numbers. */
  quarantined: number;
}

/** Columns of all bodies in the order of their ids. */
export interface State {
  count: number;
  id: Uint32Array;
  x: Float64Array;
  y: Float64Array;
  angle: Float64Array;
  vx: Float64Array;
  vy: Float64Array;
  omega: Float64Array;
  radius: Float64Array;
  /** 0 dynamic, 1 static, 2 kinematic. */
  type: Uint8Array;
}

/** What a renderer draws: floats, counted from `origin`. */
export interface Snapshot {
  count: number;
  id: Uint32Array;
  x: Float32Array;
  y: Float32Array;
  xPrev: Float32Array;
  yPrev: Float32Array;
  angle: Float32Array;
  anglePrev: Float32Array;
  radius: Float32Array;
  speed: Float32Array;
  asleep: Uint8Array;
  origin: [number, number];
}

/** What a fluid of a scene is made of. */
export interface Fluid {
  /** Metres between the particles of a full region. A particle is drawn as a disc of half of it. */
  spacing: number;
  /** kg/m^2. */
  density: number;
  /** m^2/s. */
  viscosity: number;
  /** N/m. */
  surfaceTension: number;
}

/** Columns of the particles of all fluids in the order of their ids. */
export interface FluidParticles {
  count: number;
  id: Uint32Array;
  /** The number of the particle's fluid, which is its place in Scene.fluids. */
  fluid: Uint32Array;
  x: Float64Array;
  y: Float64Array;
  vx: Float64Array;
  vy: Float64Array;
  /** kg/m^2, where the particle is, as of the last step. */
  density: Float64Array;
  /** N/m, likewise; 0 before the first step. */
  pressure: Float64Array;
}

export interface JointOptions {
  anchorA?: [number, number];
  anchorB?: [number, number];
  length?: number;
  stiffness?: number;
  damping?: number;
  axis?: [number, number];
  reference?: number;
  lower?: number;
  upper?: number;
  motorSpeed?: number;
  motorLimit?: number;
  collide?: boolean;
  /** target: a point of the world. */
  target?: [number, number];
  /** Where the spring of a pin or slide rests. */
  rest?: number;
  linearVelocity?: [number, number];
  angularVelocity?: number;
  forceLimit?: number;
  torqueLimit?: number;
  groundA?: [number, number];
  groundB?: [number, number];
  ratio?: number;
  /** gear: two joints. */
  jointA?: Id;
  jointB?: Id;
  /** Hz: instead of stiffness and damping. */
  frequency?: number;
  dampingRatio?: number;
  /** Past them, N and N m, the joint is gone. */
  breakForce?: number;
  breakTorque?: number;
}

export interface World {
  /** Advances by the scene's dt, or by another one. */
  step(dt?: number): StepReport;
  readonly frame: number;
  readonly bodyCount: number;
  readonly dynamicCount: number;
  readonly jointCount: number;
  readonly memoryBytes: number;
  readonly threads: number;
  readonly isa: string;
  readonly settings: {
    bounds: [number, number, number, number];
    boundary: 'walls' | 'periodic' | 'open';
    gravity: [number, number];
    dt: number;
    substeps: number;
  };
  setGravity(x: number, y: number): void;
  setSleeping(on: boolean): void;
  /** '0x' and 16 digits: the same on every machine, instruction set and number of threads. */
  hash(): string;
  diagnostics(): {
    kinetic: number;
    potential: number;
    momentum: [number, number];
    angularMomentum: number;
    maxPenetration: number;
  };

  /** Typed arrays on the module's memory, not copies: valid until the next call of any function of this module. */
  state(): State;
  setSnapshots(on: boolean): void;
  /** The newest snapshot, valid as `state`; nothing before the first step with snapshots on. */
  snapshot(): Snapshot | undefined;
  /** The particles of all fluids, valid as `state`. The module copies them: O(particles). */
  fluidParticles(): FluidParticles;

  /** Bodies in the words of scene files: {shape: {disc: {radius: 1}}, position: [0, 5]}. */
  add(body: object, materials?: object): Id;
  add(bodies: object[], materials?: object): Id[];
  idOf(index: number): Id | undefined;
  body(id: Id): {
    x: number; y: number; angle: number; vx: number; vy: number; omega: number; radius: number;
    type: 'dynamic' | 'static' | 'kinematic';
  };
  remove(id: Id): void;
  setTransform(id: Id, x: number, y: number, angle?: number): void;
  setVelocity(id: Id, vx: number, vy: number, omega?: number): void;
  /** N s at a point of the world. */
  applyImpulse(id: Id, px: number, py: number, x: number, y: number): void;
  wake(id: Id): void;

  /** The world as a body of a joint: anchors at it are points of the world. */
  static readonly worldBody: Id;
  /** A target has no a, a gear neither. */
  addJoint(type: 'distance' | 'spring' | 'rope' | 'revolute' | 'prismatic' | 'weld' | 'wheel' | 'motor' | 'target' |
                 'gear' | 'pulley' | 'filter', a: Id | undefined, b: Id | undefined, options?: JointOptions): Id;
  /** target: moves the point that pulls. */
  setTarget(id: Id, x: number, y: number): void;
  removeJoint(id: Id): void;
  setMotor(id: Id, speed: number, limit: number): void;

  rayCast(x0: number, y0: number, x1: number, y1: number):
    { body: Id; point: [number, number]; normal: [number, number]; fraction: number } | undefined;
  closest(x: number, y: number, reach: number, options?: { dynamic?: boolean }):
    { body: Id; point: [number, number]; distance: number } | undefined;
  /** Bodies of which some part lies in the rectangle, by id. */
  inRegion(xmin: number, ymin: number, xmax: number, ymax: number): Id[];
  /** What touched at the end of the last step; -1 stands for a wall. */
  contacts(): { a: number; b: number; point: [number, number]; impulse: number; separation: number }[];

  /** Holds the dynamic body nearest to a point within reach. `mass`, kg, or a function of its index; a disc's by default. */
  grab(x: number, y: number, reach: number, mass?: number | ((index: number) => number)): Grab | undefined;

  /** All that the world must remember to go on with the same bits; a copy. */
  save(): Uint8Array;
  /** Gives the memory back. No other function may be called afterwards. */
  free(): void;
}

export interface Grab {
  readonly body: Id;
  moveTo(x: number, y: number): void;
  /** Before every step. */
  lead(dt?: number): void;
  release(): void;
}
