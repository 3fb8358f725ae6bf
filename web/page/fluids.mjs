// Draws fluids with WebGL2: a disc of half a spacing for each particle, one call for each fluid. The discs are points, because
// drivers without a graphics card draw instances one by one: 20,000 would take most of a second.
import { programOf } from './program.mjs';

// The colours of fluids in psim's own pictures and in its viewer (src/psim/surface/fluid_field.cpp).
const colours = [0x2f7fd0, 0xd08a2e, 0x3fa06b, 0xb0558c, 0x8678d8, 0xb9b04a];

/** Red, green and blue of a fluid, 0 to 1. */
export function colourOf(fluid) {
  const rgb = colours[fluid % colours.length];
  return [16, 8, 0].map((shift) => ((rgb >> shift) & 255) / 255);
}

// A disc smaller than a pixel is drawn larger and paler, so that thin spray stays visible and does not flicker.
const vertexText = `#version 300 es
layout(location = 0) in vec2 place;   // metres from the middle of the picture
uniform vec2 scale;                   // picture units a metre
uniform float pixelsAMetre, radius;   // metres
flat out float pixels, weight;
void main() {
  float r = radius * pixelsAMetre;
  pixels = max(r, 0.75);
  weight = (r / pixels) * (r / pixels);
  gl_PointSize = 2.0 * pixels + 1.0;
  gl_Position = vec4(place * scale, 0, 1);
}`;
const fragmentText = `#version 300 es
precision highp float;
flat in float pixels, weight;
uniform vec3 colour;
out vec4 result;
void main() {
  float inside = (pixels + 0.5) * (1.0 - length(2.0 * gl_PointCoord - 1.0));
  if (inside <= 0.0) discard;
  result = vec4(colour, weight * min(inside, 1.0));
}`;

export class Fluids {
  spacings = [];                 // metres, of each fluid
  places = new Float32Array(0);  // x and y of the particles, fluid after fluid
  ends = [];                     // in `places`, particles: where each fluid ends

  constructor(gl) {
    this.gl = gl;
    const { program, uniforms } = programOf(gl, vertexText, fragmentText, ['scale', 'pixelsAMetre', 'radius', 'colour']);
    this.program = program, this.uniforms = uniforms;
    this.buffer = gl.createBuffer();
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    gl.bindVertexArray(null);
  }

  /** Copies the particles of a world, which are views that the next call of the module may end. */
  take({ count, fluid, x, y }, camera) {
    if (this.places.length < 2 * count) this.places = new Float32Array(3 * count);
    const next = this.spacings.map(() => 0);
    for (let k = 0; k < count; ++k) ++next[fluid[k]];
    let first = 0;
    next.forEach((size, f) => ((next[f] = first), (first += size)));
    for (let k = 0; k < count; ++k) {
      const at = 2 * next[fluid[k]]++;
      this.places[at] = x[k] - camera.x, this.places[at + 1] = y[k] - camera.y;
    }
    this.ends = next;
  }

  /** Draws what was taken for the camera of this picture. pixels: of a metre. */
  draw(pixels, width, height) {
    const { gl, uniforms, ends } = this;
    if (!ends.at(-1)) return;
    gl.useProgram(this.program);
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, this.places.subarray(0, 2 * ends.at(-1)), gl.STREAM_DRAW);
    gl.uniform2f(uniforms.scale, (2 * pixels) / width, (2 * pixels) / height);
    gl.uniform1f(uniforms.pixelsAMetre, pixels);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ZERO, gl.ONE);
    ends.forEach((end, f) => {
      const begin = f === 0 ? 0 : ends[f - 1];
      gl.uniform1f(uniforms.radius, this.spacings[f] / 2);
      gl.uniform3f(uniforms.colour, ...colourOf(f));
      if (end > begin) gl.drawArrays(gl.POINTS, begin, end - begin);
    });
    gl.disable(gl.BLEND);
    gl.bindVertexArray(null);
  }
}
