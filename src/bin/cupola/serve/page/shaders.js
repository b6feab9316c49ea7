// Shaders of the dome in three dimensions, and vectors.
'use strict';

const VERTEX = `#version 300 es
uniform mat4 camera;
in vec3 point; in vec2 uv; in float value;
out vec3 at; out vec2 place; out float shown;
void main() { at = point; place = uv; shown = value; gl_Position = camera * vec4(point, 1.0); }`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D frame; uniform vec4 rect; uniform float texel;
const int mode = MODE; uniform vec3 eye, viewer; uniform vec2 range; uniform float tilt, seen;
in vec3 at; in vec2 place; in float shown;
out vec4 color;
vec3 ramp(float t) {
  t = clamp(t, 0.0, 1.0);
  return clamp(vec3(1.5 - abs(4.0 * t - 3.0), 1.5 - abs(4.0 * t - 2.0), 1.5 - abs(4.0 * t - 1.0)), 0.0, 1.0);
}
float grid(float angle, float every) {
  float lines = angle / every, near = abs(lines - round(lines));
  return 1.0 - clamp(near / max(fwidth(lines), 1e-6) - 0.4, 0.0, 1.0);
}
void main() {
  // Shows only the side that the viewer sees.
  vec3 normal = cross(dFdx(at), dFdy(at));
  if (dot(normal, viewer - at) * dot(normal, eye - at) < 0.0) discard;
  if (mode == 0) {
    vec2 inside = clamp(rect.xy + place * rect.zw, rect.xy + 0.5 * texel, rect.xy + rect.zw - 0.5 * texel);
    color = vec4(texture(frame, inside).rgb, 1.0);
  } else if (mode == 1) {
    vec3 dome = vec3(at.x, at.y * cos(tilt) - at.z * sin(tilt), at.y * sin(tilt) + at.z * cos(tilt));
    float polar = degrees(acos(clamp(normalize(dome).y, -1.0, 1.0))), around = degrees(atan(dome.x, -dome.z));
    float line = max(grid(polar, 10.0), polar < 4.0 ? 0.0 : grid(around, 10.0));
    color = vec4((vec3(0.05, 0.06, 0.08) + line * vec3(0.25, 0.5, 0.8)) * shown, 1.0);
  } else if (mode == 2) {
    float angle = degrees(acos(clamp(dot(normalize(at - viewer), normalize(at - eye)), -1.0, 1.0)));
    color = vec4(ramp((angle - range.x) / (range.y - range.x)) * 0.8, 1.0);
  } else if (mode == 3) {
    vec3 colors[5] = vec3[5](vec3(0.0), vec3(0.22), vec3(0.06, 0.4, 0.1), vec3(0.08, 0.14, 0.6), vec3(0.6, 0.08, 0.08));
    color = vec4(colors[int(clamp(shown + 0.5, 0.0, 4.0))], 1.0);
  } else {
    color = vec4(ramp((shown - range.x) / (range.y - range.x)) * 0.8, 1.0);
  }
  color.rgb *= seen;
}`;

const FLAT = `#version 300 es
uniform mat4 camera; in vec3 point; void main() { gl_Position = camera * vec4(point, 1.0); }`;
const PLAIN = `#version 300 es
precision mediump float; uniform vec4 paint; out vec4 color; void main() { color = paint; }`;
const WHOLE = `#version 300 es
out vec2 at; void main() { vec2 p = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0; at = p * 0.5 + 0.5; gl_Position = vec4(p, 0.0, 1.0); }`;
const SHOW = `#version 300 es
precision highp float; uniform sampler2D light; in vec2 at; out vec4 color;
void main() { color = vec4(pow(texture(light, at).rgb, vec3(1.0 / 2.2)), 1.0); }`;

const add = (a, b) => a.map((v, i) => v + b[i]);
const sub = (a, b) => a.map((v, i) => v - b[i]);
const scale = (a, f) => a.map(v => v * f);
const dot = (a, b) => a.reduce((sum, v, i) => sum + v * b[i], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = a => scale(a, 1 / (Math.hypot(...a) || 1));
