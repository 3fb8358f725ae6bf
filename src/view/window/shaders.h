// The shaders. A body is one instance of a quad; its place is interpolated, coloured and cut out
// here, so that the CPU hands on the columns of a snapshot as they are.
#pragma once

namespace psim::view {

// Shared by discs and areas. `look`: kind in the low 24 bits, then static, kinematic, sensor.
inline constexpr char kBodyVertexHead[] = R"(#version 330 core
layout(location = 0) in float x;
layout(location = 1) in float y;
layout(location = 2) in float x_prev;
layout(location = 3) in float y_prev;
layout(location = 4) in float angle;
layout(location = 5) in float angle_prev;
layout(location = 6) in float radius;
layout(location = 7) in float speed;  // m/s; coloured by force: N; by strip or solver: its number, -1 none
layout(location = 8) in uint asleep;
layout(location = 9) in uint look;
uniform float alpha;       // 0: the frame before, 1: the newest
uniform vec2 shift;        // metres: the snapshot's origin from the middle of the window
uniform float scale;       // pixels a metre
uniform vec2 window;       // pixels
uniform int colouring;
uniform float bright;      // m/s (speed), rad a frame (spin) or N (force) of the brightest colour
uniform vec3 palette[9];
flat out vec4 colour;
flat out vec2 turn;

vec3 ramp(float share) {
  float at = clamp(share, 0.0, 1.0) * 8.0;
  int below = min(int(at), 7);
  return mix(palette[below], palette[below + 1], at - float(below));
}
vec3 wheel(float turns) {
  vec3 h = abs(fract(turns + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0;
  return mix(vec3(0.75), clamp(h, 0.0, 1.0), 0.7);
}
vec4 body_colour(vec2 motion) {
  float opacity = (look & (1u << 26)) != 0u ? 0.3 : 1.0;
  if ((look & (1u << 24)) != 0u) return vec4(0.49, 0.53, 0.58, opacity);
  vec3 c = ramp(speed / bright);
  if (colouring == 1) {
    float moving = clamp(length(motion) / 1e-4, 0.0, 1.0);
    c = mix(vec3(0.3), wheel(atan(motion.y, motion.x) / 6.2831853), moving);
  } else if (colouring == 2) {
    c = vec3(0.98, 0.72, 0.25);
  } else if (colouring == 3) {
    c = ramp(abs(angle - angle_prev) / bright);
  } else if (colouring == 4) {
    c = wheel(fract(float(gl_InstanceID) * 0.61803398875));
  } else if (colouring == 5) {
    c = (look & (1u << 25)) != 0u ? vec3(0.9, 0.5, 0.45) : vec3(0.4, 0.65, 0.9);
  } else if (colouring >= 7) {  // odd strips, whose turn comes second, are dark; bodies lie dim under their contacts
    if (speed < 0.0) return vec4(asleep != 0u ? vec3(0.35, 0.38, 0.43) : vec3(0.3), opacity);
    float dark = colouring == 8 ? 0.6 : 0.6 * mod(speed, 2.0);
    return vec4(mix(wheel(fract(speed * 0.61803398875)), vec3(0.07, 0.09, 0.11), dark), opacity);
  }
  if (asleep != 0u && colouring != 6) c = mix(vec3(0.35, 0.38, 0.43), c, colouring == 2 ? 0.0 : 0.25);
  return vec4(c, opacity);
}
vec2 corner() { return vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0; }
vec2 place() { return (vec2(mix(x_prev, x, alpha), mix(y_prev, y, alpha)) + shift) * scale; }
void set_turn() {
  float a = mix(angle_prev, angle, alpha);
  turn = vec2(cos(a), sin(a));
}
)";

inline constexpr char kDiscVertex[] = R"(
flat out float pixels;     // radius
flat out float weight;
out vec2 at;               // pixels from the centre
void main() {
  float r = radius * scale;
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  if ((look & 0xFFFFFFu) != 0u || !(r > 0.0)) return;
  pixels = max(r, 0.75);
  weight = (r / pixels) * (r / pixels);
  at = corner() * (pixels + 1.0);
  gl_Position = vec4((place() + at) * 2.0 / window, 0.0, 1.0);
  colour = body_colour(vec2(x - x_prev, y - y_prev));
  set_turn();
}
)";

inline constexpr char kDiscFragment[] = R"(#version 330 core
flat in vec4 colour;
flat in vec2 turn;
flat in float pixels;
flat in float weight;
in vec2 at;
out vec4 result;
void main() {
  float d = length(at) - pixels;
  if (d >= 0.5) discard;
  float rim = pixels < 3.0 ? 0.0 : min(0.14 * pixels, 16.0);
  float dark = rim > 0.0 ? 0.45 * clamp(d + rim + 0.5, 0.0, 1.0) : 0.0;
  if (pixels > 7.0) {   // a spoke shows how it is turned
    vec2 p = vec2(at.x * turn.x + at.y * turn.y, at.y * turn.x - at.x * turn.y);
    float along = clamp(p.x, 0.35 * pixels, 0.78 * pixels);
    float spoke = length(p - vec2(along, 0.0)) - max(0.6, 0.045 * pixels);
    dark = max(dark, 0.55 * clamp(0.5 - spoke, 0.0, 1.0));
  }
  result = vec4(colour.rgb * (1.0 - dark), colour.a * weight * clamp(0.5 - d, 0.0, 1.0));
}
)";

// Kinds in a buffer texture, 6 texels each: (points, radius, how deep the middle is, -), (xmin,
// ymin, xmax, ymax), then two points a texel. A shape thinner than 1.5 pixels is painted wider and
// fainter.
inline constexpr char kAreaVertex[] = R"(
uniform samplerBuffer kinds;
flat out int first;
flat out int points;
flat out float rounding;   // metres
flat out float metres;     // a pixel
flat out float grow;       // pixels
flat out float weight;
flat out float rim;        // pixels
out vec2 at;               // metres, body frame
void main() {
  int kind = int(look & 0xFFFFFFu);
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  first = kind * 6;
  vec4 head = texelFetch(kinds, first);
  points = int(head.x);
  if (points == 0) return;
  rounding = head.y;
  metres = 1.0 / scale;
  vec4 box = texelFetch(kinds, first + 1);
  float inner = head.z * scale;
  grow = max(0.75 - inner, 0.0);
  weight = inner / (inner + grow);
  rim = inner < 3.0 ? 0.0 : min(0.2 * inner, 1.8);
  vec2 grown = vec2(rounding + metres * (1.0 + grow));
  at = mix(box.xy - grown, box.zw + grown, corner() * 0.5 + 0.5);
  set_turn();
  vec2 turned = vec2(at.x * turn.x - at.y * turn.y, at.x * turn.y + at.y * turn.x);
  gl_Position = vec4((place() + turned * scale) * 2.0 / window, 0.0, 1.0);
  colour = body_colour(vec2(x - x_prev, y - y_prev));
}
)";

// Distance to a convex polygon: the farthest of its edges' lines inside, the nearest edge outside.
inline constexpr char kAreaFragment[] = R"(#version 330 core
uniform samplerBuffer kinds;
flat in vec4 colour;
flat in int first;
flat in int points;
flat in float rounding;
flat in float metres;
flat in float grow;
flat in float weight;
flat in float rim;
in vec2 at;
out vec4 result;
vec2 point(int k) {
  vec4 two = texelFetch(kinds, first + 2 + (k >> 1));
  return (k & 1) == 0 ? two.xy : two.zw;
}
void main() {
  float beyond = points < 3 ? 1.0 : -1e30;
  float near2 = 1e30;
  vec2 p = point(points - 1);
  for (int k = 0; k < points; ++k) {
    vec2 q = point(k);
    vec2 u = q - p, d = at - p;
    float uu = dot(u, u);
    vec2 e = d - u * (uu > 0.0 ? clamp(dot(d, u) / uu, 0.0, 1.0) : 0.0);
    near2 = min(near2, dot(e, e));
    if (points > 2) beyond = max(beyond, (d.x * u.y - d.y * u.x) * inversesqrt(uu));
    p = q;
  }
  float d = ((beyond <= 0.0 ? beyond : sqrt(near2)) - rounding) / metres - grow;
  if (d >= 0.5) discard;
  float dark = rim > 0.0 ? 0.45 * clamp(d + rim + 0.5, 0.0, 1.0) : 0.0;
  result = vec4(colour.rgb * (1.0 - dark), colour.a * weight * clamp(0.5 - d, 0.0, 1.0));
}
)";

inline constexpr char kLineVertex[] = R"(#version 330 core
layout(location = 0) in vec4 ends;   // metres from the middle of the window
layout(location = 1) in float width; // pixels
layout(location = 2) in vec4 rgba;
uniform float scale;
uniform vec2 window;
flat out vec4 colour;
flat out vec2 half_size;   // length, width
out vec2 at;
void main() {
  vec2 a = ends.xy * scale, b = ends.zw * scale;
  vec2 u = b - a;
  float size = length(u);
  u = size > 0.0 ? u / size : vec2(1.0, 0.0);
  half_size = vec2(size, width) * 0.5;
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  at = corner * (half_size + 1.0);
  vec2 p = (a + b) * 0.5 + u * at.x + vec2(-u.y, u.x) * at.y;
  gl_Position = vec4(p * 2.0 / window, 0.0, 1.0);
  colour = rgba;
}
)";

inline constexpr char kLineFragment[] = R"(#version 330 core
flat in vec4 colour;
flat in vec2 half_size;
in vec2 at;
out vec4 result;
void main() {
  vec2 covered = clamp(half_size - abs(at) + 0.5, 0.0, 1.0);
  result = vec4(colour.rgb, colour.a * min(covered.y, 1.0) * max(covered.x, 0.0));
}
)";

}  // namespace psim::view
