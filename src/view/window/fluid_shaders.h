// The shaders of fluids: a surface is one rectangle whose pixels look up the grid; particles are discs.
#pragma once

namespace psim::view {

// Shared by both fragment shaders. `share`: of the brightest; below 0 the fluid has its own colour.
inline constexpr char kFluidColour[] = R"(#version 330 core
uniform vec3 palette[9];
uniform vec3 own;
out vec4 result;
vec3 fluid_colour(float share) {
  if (share < 0.0) return own;
  float at = clamp(share, 0.0, 1.0) * 8.0;
  int below = min(int(at), 7);
  return mix(palette[below], palette[below + 1], at - float(below));
}
)";

inline constexpr char kSurfaceVertex[] = R"(#version 330 core
uniform vec2 low, high;    // metres from the middle of the window
uniform vec2 first, last;  // nodes of the grid at these places
uniform float scale;       // pixels a metre
uniform vec2 window;       // pixels
out vec2 at;               // nodes
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  at = mix(first, last, corner);
  gl_Position = vec4(mix(low, high, corner) * scale * 2.0 / window, 0.0, 1.0);
}
)";

// As pictures of psim: how far a pixel's middle is from the edge comes from the steepness there.
inline constexpr char kSurfaceFragment[] = R"(
uniform sampler2D fullness, value;
uniform vec2 nodes;
uniform float edge;
uniform bool by_value;
in vec2 at;
void main() {
  vec2 place = (at + 0.5) / nodes;
  float beyond = texture(fullness, place).r - edge;
  float steep = length(vec2(dFdx(beyond), dFdy(beyond)));
  float share = clamp(0.5 + beyond / max(steep, 1e-6), 0.0, 1.0);
  if (share <= 0.0) discard;
  float pale = by_value ? 0.0 : 0.35 * clamp(1.0 - beyond / 0.35, 0.0, 1.0);
  result = vec4(mix(fluid_colour(by_value ? max(texture(value, place).r, 0.0) : -1.0), vec3(1.0), pale), share);
}
)";

inline constexpr char kParticleVertex[] = R"(#version 330 core
layout(location = 0) in vec3 particle;  // metres from the middle of the window; share of the brightest
uniform float radius;                   // metres
uniform float scale;
uniform vec2 window;
flat out float share;
flat out float pixels;     // radius
flat out float weight;
out vec2 at;               // pixels from the centre
void main() {
  float r = radius * scale;
  pixels = max(r, 0.75);
  weight = (r / pixels) * (r / pixels);
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  at = corner * (pixels + 1.0);
  gl_Position = vec4((particle.xy * scale + at) * 2.0 / window, 0.0, 1.0);
  share = particle.z;
}
)";

inline constexpr char kParticleFragment[] = R"(
flat in float share;
flat in float pixels;
flat in float weight;
in vec2 at;
void main() {
  float d = length(at) - pixels;
  if (d >= 0.5) discard;
  result = vec4(fluid_colour(share), weight * clamp(0.5 - d, 0.0, 1.0));
}
)";

}  // namespace psim::view
