// The programs of the graphics card. All positions are relative to `origin`, where floats are fine.

const VERSION = '#version 300 es\n';

/** A row of entities.js; `types` holds for each type half sizes, then its colour. */
const ENTITY = `
layout(location = 2) in vec3 place;
layout(location = 3) in uint tick;
layout(location = 4) in vec4 turn;
layout(location = 5) in vec3 velocity;
layout(location = 6) in uint type;
layout(location = 7) in uint id;
layout(location = 8) in uvec2 marks; // flags, zone
layout(location = 9) in uint heat;
uniform mat4 camera;
uniform vec3 origin;
uniform int tickNow;
uniform float tickPart;
uniform float tickSeconds;
uniform uint chosen;
uniform int colouring; // 0 by type, 1 by zone, 2 by load
uniform sampler2D types;
vec3 now() {
  float elapsed = tickSeconds * (float(tickNow - int(tick)) + tickPart);
  return place - origin + velocity * elapsed;
}
vec3 hue(float h) { return clamp(abs(6.0 * fract(h + vec3(0.0, 0.6667, 0.3333)) - 3.0) - 1.0, 0.0, 1.0); }
vec3 colour() {
  if (id == chosen) return vec3(1.0, 0.95, 0.35);
  vec3 c = texelFetch(types, ivec2(int(type), 1), 0).rgb;
  if (colouring == 1) c = 0.25 + 0.65 * hue(float(marks.y) * 0.618);
  if (colouring == 2) {
    float load = clamp(float(heat) / 2560.0, 0.0, 1.0);
    return mix(vec3(0.25, 0.45, 0.75), load < 0.5 ? vec3(0.95, 0.8, 0.3) : vec3(0.9, 0.2, 0.15), min(1.0, 2.0 * load));
  }
  return (marks.x & 1u) != 0u ? mix(c, vec3(0.55), 0.55) * 0.85 : c;
}
`;

/** By the quaternion `turn` of the program that holds it. */
const TURN = `vec3 turned(vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }
`;

/** Fragments fade into the sky with the distance that their vertices tell as `far`. */
const FOG = `
in float far;
uniform vec3 sky;
uniform float fogFrom;
out vec4 pixel;
void fogged(vec3 c) { pixel = vec4(mix(c, sky, clamp(far * fogFrom - 0.5, 0.0, 0.8)), 1.0); }
`;

export const SHAPE_VERTEX = `${VERSION}
layout(location = 0) in vec3 corner;
layout(location = 1) in vec3 normal;
${ENTITY}
uniform int kind; // 0 box, 1 round, 2 as it is
uniform vec3 sun;
out vec3 shade;
out float far;
${TURN}void main() {
  vec3 size = texelFetch(types, ivec2(int(type), 0), 0).xyz;
  vec3 local = kind == 2 ? corner : kind == 0 ? corner * size
    : corner * size.x + vec3(0.0, sign(corner.y) * size.y, 0.0);
  float light = 0.62 + 0.38 * dot(turned(normal), sun);
  shade = colour() * light;
  gl_Position = camera * vec4(now() + turned(local), 1.0);
  far = gl_Position.w;
}`;

/** Points that visible.js has placed and coloured: the graphics card has nothing left to work out. */
export const POINT_VERTEX = `${VERSION}
layout(location = 0) in vec4 place; // of the picture, and pixels
layout(location = 1) in vec4 colour; // and how slim
flat out vec4 shade;
void main() {
  gl_Position = vec4(place.xyz, 1.0);
  gl_PointSize = place.w;
  shade = colour;
}`;
export const PLAIN_FRAGMENT = `${VERSION}
precision mediump float;
flat in vec4 shade;
out vec4 pixel;
void main() { pixel = shade; }`;
/** An upright capsule. */
export const CAPSULE_FRAGMENT = `${VERSION}
precision mediump float;
flat in vec4 shade;
out vec4 pixel;
void main() {
  vec2 p = 2.0 * gl_PointCoord - 1.0;
  float rim = 1.0 - shade.a;
  vec2 d = vec2(p.x, p.y - clamp(p.y, -rim, rim)) / shade.a;
  float r = dot(d, d);
  if (r > 1.0) discard;
  pixel = vec4(shade.rgb * (0.62 + 0.38 * (0.45 * sqrt(1.0 - r) - 0.55 * d.y + 0.25 * d.x)), 1.0);
}`;

export const LIT_FRAGMENT = `${VERSION}
precision mediump float;
in vec3 shade;
${FOG}
void main() { fogged(shade); }`;

/** Boxes that never move, as boxes.js lays them out; the fog of their corners is near enough. */
export const BOX_VERTEX = `${VERSION}
layout(location = 0) in vec4 place; // from the origin, and light
uniform mat4 camera;
uniform vec3 colour;
uniform vec3 sky;
uniform float fogFrom;
out vec3 shade;
void main() {
  gl_Position = camera * vec4(place.xyz, 1.0);
  shade = mix(colour * place.w, sky, clamp(gl_Position.w * fogFrom - 0.5, 0.0, 0.8));
}`;
export const BOX_FRAGMENT = `${VERSION}
precision mediump float;
in vec3 shade;
out vec4 pixel;
void main() { pixel = vec4(shade, 1.0); }`;

/** Triangles as they are: terrain, meshes, soft bodies. */
export const MESH_VERTEX = `${VERSION}
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal;
uniform mat4 camera;
uniform vec3 origin;
uniform vec3 move;
uniform vec4 turn;
uniform vec3 sun;
uniform vec3 colour;
uniform float steepness; // how much darker slopes are
out vec3 shade;
out float far;
${TURN}void main() {
  vec3 n = turned(normal);
  float light = 0.7 + 0.3 * dot(n, sun);
  shade = mix(colour, vec3(0.62, 0.58, 0.53), steepness * clamp(3.0 * (1.0 - abs(n.y)), 0.0, 1.0)) * light;
  gl_Position = camera * vec4(move - origin + turned(place), 1.0);
  far = gl_Position.w;
}`;

/** Seen from both sides: each lights its own. */
export const SHEET_FRAGMENT = `${VERSION}
precision mediump float;
in vec3 shade;
${FOG}
void main() { fogged(gl_FrontFacing ? shade : shade * 0.75); }`;

/** The plane below everything, with squares that give a sense of scale. */
export const GROUND_VERTEX = `${VERSION}
layout(location = 0) in vec3 place;
uniform mat4 camera;
uniform vec3 origin;
out vec2 at;
out float far;
void main() {
  at = place.xz;
  gl_Position = camera * vec4(place - origin, 1.0);
  far = gl_Position.w;
}`;
export const GROUND_FRAGMENT = `${VERSION}
precision highp float;
in vec2 at;
uniform vec3 colour;
uniform float square; // m
${FOG}
void main() {
  vec2 s = floor(at / square);
  float odd = mod(s.x + s.y, 2.0) * 0.045 * clamp(1.6 - far * fogFrom, 0.0, 1.0);
  fogged(colour * (1.0 - odd));
}`;

/** Lines and small points with a colour for each corner. */
export const LINE_VERTEX = `${VERSION}
layout(location = 0) in vec3 place;
layout(location = 1) in vec4 colour;
uniform mat4 camera;
uniform vec3 origin;
uniform float pointSize;
out vec4 shade;
void main() {
  gl_Position = camera * vec4(place - origin, 1.0);
  gl_PointSize = clamp(pointSize / gl_Position.w, 1.5, 8.0);
  shade = colour;
}`;
export const LINE_FRAGMENT = `${VERSION}
precision mediump float;
in vec4 shade;
out vec4 pixel;
void main() { pixel = shade; }`;

export class Program {
  constructor(gl, vertex, fragment) {
    this.gl = gl;
    this.program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
    }
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) {
      const logs = gl.getAttachedShaders(this.program).map((shader) => gl.getShaderInfoLog(shader));
      throw new Error(`a shader does not compile: ${logs.join(' ')}${gl.getProgramInfoLog(this.program)}`);
    }
    this.at = {};
    const count = gl.getProgramParameter(this.program, gl.ACTIVE_UNIFORMS);
    for (let i = 0; i < count; ++i) {
      const { name } = gl.getActiveUniform(this.program, i);
      this.at[name] = gl.getUniformLocation(this.program, name);
    }
  }

  use() {
    this.gl.useProgram(this.program);
  }
}
