// Draws a world with WebGL2: fluids (fluids.mjs), and on top of them bodies, with one instanced call for all discs and one
// for each other shape.
import { Fluids } from './fluids.mjs';
import { programOf } from './program.mjs';

const vertexText = `#version 300 es
layout(location = 0) in vec2 corner;
layout(location = 1) in vec4 body;    // x, y, angle, radius: metres from the origin of the snapshot
layout(location = 2) in vec4 paint;
uniform vec2 centre, scale;           // of the picture, metres; picture units a metre
uniform float byRadius;               // 1: corners are in radii
out vec2 inside;
out vec4 colour;
out float metres;
void main() {
  float c = cos(body.z), s = sin(body.z);
  vec2 p = corner * mix(1.0, body.w, byRadius);
  gl_Position = vec4((body.xy + vec2(c * p.x - s * p.y, s * p.x + c * p.y) - centre) * scale, 0, 1);
  inside = corner;
  colour = paint;
  metres = body.w;
}`;
const fragmentText = `#version 300 es
precision highp float;
in vec2 inside;
in vec4 colour;
in float metres;
uniform float byRadius;
uniform float pixelsAMetre;
out vec4 result;
void main() {
  result = colour;
  if (byRadius > 0.5) {
    float d = length(inside), edge = 1.0 / max(metres * pixelsAMetre, 1.0);
    if (d > 1.0) discard;
    bool spoke = abs(inside.y) < edge && inside.x > 0.0;
    bool rim = d > 1.0 - 1.5 * edge;
    if (metres * pixelsAMetre > 4.0 && (spoke || rim)) result.rgb *= 0.55;
  }
}`;

const instanceNumbers = 8;
const arcStep = 0.3; // radians

/** A convex outline with a radius around it as a polygon. */
function rounded(points, radius) {
  const n = points.length / 2;
  const out = [];
  for (let k = 0; k < n; ++k) {
    const at = (j) => [points[2 * ((j + n) % n)], points[2 * ((j + n) % n) + 1]];
    const [a, b, c] = [at(k - 1), at(k), at(k + 1)];
    if (radius === 0) {
      out.push(...b);
      continue;
    }
    const before = Math.atan2(-(b[0] - a[0]), b[1] - a[1]); // outward normals of the two edges
    let turn = Math.atan2(-(c[0] - b[0]), c[1] - b[1]) - before;
    while (turn < 0) turn += 2 * Math.PI;
    const steps = Math.max(1, Math.ceil(turn / arcStep));
    for (let s = 0; s <= steps; ++s) {
      const angle = before + (turn * s) / steps;
      out.push(b[0] + radius * Math.cos(angle), b[1] + radius * Math.sin(angle));
    }
  }
  return out;
}

// A part of a body that is a disc: its place is no centre of a snapshot.
function circle([x, y], radius) {
  const steps = Math.ceil((2 * Math.PI) / arcStep);
  return Array.from({ length: steps }, (_, k) => [
    x + radius * Math.cos((2 * Math.PI * k) / steps), y + radius * Math.sin((2 * Math.PI * k) / steps)]).flat();
}

function mesh(gl, shape) {
  if (shape.kind === 'disc') return { mode: gl.TRIANGLE_STRIP, corners: [-1, -1, 1, -1, -1, 1, 1, 1], byRadius: 1 };
  if (shape.kind === 'area' && shape.points.length === 2) return { mode: gl.TRIANGLE_FAN, corners: circle(shape.points, shape.radius), byRadius: 0 };
  if (shape.kind === 'area') return { mode: gl.TRIANGLE_FAN, corners: rounded(shape.points, shape.radius), byRadius: 0 };
  return { mode: shape.kind === 'loop' ? gl.LINE_LOOP : gl.LINE_STRIP, corners: [...shape.points], byRadius: 0 };
}

export class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = (this.gl = canvas.getContext('webgl2', { antialias: true, preserveDrawingBuffer: true }));
    if (!gl) throw new Error('this browser has no WebGL2');
    const { program, uniforms } = programOf(gl, vertexText, fragmentText, ['centre', 'scale', 'byRadius', 'pixelsAMetre']);
    this.program = program, this.uniforms = uniforms;
    this.fluids = new Fluids(gl);
    this.instances = gl.createBuffer();
    this.meshes = [];
    this.shapes = []; // the numbers of the meshes of each
    this.data = new Float32Array(0);
  }

  setShapes(shapes) {
    const gl = this.gl;
    for (const m of this.meshes) gl.deleteBuffer(m.buffer);
    this.meshes = [];
    this.shapes = [];
    for (const shape of shapes) this.addShape(shape);
  }

  addShape(shape) {
    return this.shapes.push((shape.parts ?? [shape]).map((part) => this.addMesh(part))) - 1;
  }

  addMesh(shape) {
    const gl = this.gl;
    const m = { ...mesh(gl, shape), buffer: gl.createBuffer(), count: 0 };
    gl.bindBuffer(gl.ARRAY_BUFFER, m.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(m.corners), gl.STATIC_DRAW);
    this.meshes.push(m);
    return this.meshes.length - 1;
  }

  /** rows: the snapshot; meshOf(id): a number of addShape, which may have several meshes; paint(row, into, at) writes red, green, blue, opacity. The particles that `fluids` took are drawn, too. */
  draw(rows, meshOf, paint, camera) {
    const gl = this.gl;
    const { width, height } = this.resize();
    for (const m of this.meshes) m.count = 0;
    for (let k = 0; k < rows.count; ++k) for (const m of this.shapes[meshOf(rows.id[k])]) ++this.meshes[m].count;
    let first = 0;
    for (const m of this.meshes) (m.first = first), (m.next = first), (first += m.count);
    const numbers = first * instanceNumbers;
    if (this.data.length < numbers) this.data = new Float32Array(2 * numbers);
    const d = this.data;
    for (let k = 0; k < rows.count; ++k) {
      for (const m of this.shapes[meshOf(rows.id[k])]) {
        const at = this.meshes[m].next++ * instanceNumbers;
        d[at] = rows.x[k], d[at + 1] = rows.y[k], d[at + 2] = rows.angle[k], d[at + 3] = rows.radius[k];
        paint(k, d, at + 4);
      }
    }
    gl.viewport(0, 0, width, height);
    gl.clearColor(0.067, 0.082, 0.102, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    const pixels = camera.pixelsAMetre(width, height);
    this.fluids.draw(pixels, width, height);
    gl.useProgram(this.program);
    gl.uniform2f(this.uniforms.centre, camera.x - rows.origin[0], camera.y - rows.origin[1]);
    gl.uniform2f(this.uniforms.scale, (2 * pixels) / width, (2 * pixels) / height);
    gl.uniform1f(this.uniforms.pixelsAMetre, pixels);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.instances);
    gl.bufferData(gl.ARRAY_BUFFER, this.data.subarray(0, numbers), gl.STREAM_DRAW);
    for (const m of this.meshes) if (m.count) this.drawMesh(m);
  }

  drawMesh(m) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, m.buffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.instances);
    for (const [place, offset] of [[1, 0], [2, 16]]) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 4, gl.FLOAT, false, 4 * instanceNumbers, 4 * instanceNumbers * m.first + offset);
      gl.vertexAttribDivisor(place, 1);
    }
    gl.uniform1f(this.uniforms.byRadius, m.byRadius);
    gl.drawArraysInstanced(m.mode, 0, m.corners.length / 2, m.count);
  }

  resize() {
    const { canvas } = this;
    const ratio = Math.min(globalThis.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) (canvas.width = width), (canvas.height = height);
    return { width, height };
  }
}

/** What of the world the picture shows. */
export class Camera {
  x = 0;
  y = 0;
  span = [1, 1]; // metres that fit at least

  pixelsAMetre(width, height) { return Math.min(width / this.span[0], height / this.span[1]); }

  fit(xmin, ymin, xmax, ymax) {
    this.x = (xmin + xmax) / 2, this.y = (ymin + ymax) / 2;
    this.span = [1.06 * (xmax - xmin || 1), 1.06 * (ymax - ymin || 1)];
  }

  zoom(factor, [x, y]) {
    this.span = this.span.map((s) => s / factor);
    this.x = x + (this.x - x) / factor, this.y = y + (this.y - y) / factor;
  }

  /** A place on the canvas, CSS pixels, in metres. */
  toWorld(canvas, px, py) {
    const pixels = this.pixelsAMetre(canvas.clientWidth, canvas.clientHeight);
    return [this.x + (px - canvas.clientWidth / 2) / pixels, this.y - (py - canvas.clientHeight / 2) / pixels];
  }
}
