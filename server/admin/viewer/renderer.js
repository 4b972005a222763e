// Draws the world by WebGL2: near entities as their shapes, far ones as points.

import { Camera } from './camera.js';

/** So many are drawn as shapes where the machine keeps up, and where it does not. */
const MOST_SHAPES = 1000;
const FEWEST_SHAPES = 50;
/** Times between frames, ms: above the first fewer shapes are drawn, below the second more. */
const SLOW_MS = 40;
const FAST_MS = 20;
const INSTANCE_FLOATS = 11; // position 3, orientation 4, half sizes 3, colour as RGBA8

const SHAPE_VERTEX = `#version 300 es
uniform mat4 camera;
layout(location = 0) in vec3 corner;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 position;
layout(location = 3) in vec4 turn;
layout(location = 4) in vec3 size;
layout(location = 5) in vec4 colour;
uniform bool round;
out vec3 shade;
vec3 turned(vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }
void main() {
  vec3 local = round ? corner * size.x + vec3(0.0, sign(corner.y) * size.y, 0.0) : corner * size;
  float light = 0.55 + 0.45 * max(0.0, dot(turned(normal), normalize(vec3(0.4, 0.8, 0.3))));
  shade = colour.rgb * light;
  gl_Position = camera * vec4(position + turned(local), 1.0);
}`;
const SHAPE_FRAGMENT = `#version 300 es
precision mediump float;
in vec3 shade;
out vec4 pixel;
void main() { pixel = vec4(shade, 1.0); }`;
const POINT_VERTEX = `#version 300 es
uniform mat4 camera;
uniform float scale;
layout(location = 2) in vec3 position;
layout(location = 4) in vec3 size;
layout(location = 5) in vec4 colour;
out vec3 shade;
void main() {
  shade = colour.rgb;
  gl_Position = camera * vec4(position, 1.0);
  gl_PointSize = clamp(scale * max(size.x, size.z) / gl_Position.w, 2.0, 24.0);
}`;
const LINE_VERTEX = `#version 300 es
uniform mat4 camera;
layout(location = 0) in vec3 position;
void main() { gl_Position = camera * vec4(position, 1.0); }`;
const LINE_FRAGMENT = `#version 300 es
precision mediump float;
uniform vec4 colour;
out vec4 pixel;
void main() { pixel = colour; }`;

function compile(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
    throw new Error('a shader does not compile: ' + gl.getProgramInfoLog(program));
  }
  return program;
}

/** Corners and normals of a box with half sizes 1, as triangles seen from outside. */
function boxMesh() {
  const out = [];
  for (let axis = 0; axis < 3; ++axis) {
    for (const side of [-1, 1]) {
      const corner = (a, b) => {
        const v = [0, 0, 0];
        v[axis] = side;
        v[(axis + 1) % 3] = a;
        v[(axis + 2) % 3] = b;
        return v;
      };
      const normal = [0, 0, 0];
      normal[axis] = side;
      const quad = [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]];
      for (const [a, b] of side > 0 ? quad : quad.map(([x, y]) => [y, x])) {
        out.push(...corner(a, b), ...normal);
      }
    }
  }
  return new Float32Array(out);
}

/** A sphere of radius 1 from rings; its equator is doubled, so that it can be drawn out to a capsule. */
function roundMesh() {
  const out = [];
  const around = 10;
  const heights = [-Math.PI / 2, -Math.PI / 4, -1e-3, 1e-3, Math.PI / 4, Math.PI / 2];
  const at = (h, a) => {
    const angle = (2 * Math.PI * a) / around;
    return [Math.cos(h) * Math.sin(angle), Math.sin(h), Math.cos(h) * Math.cos(angle)];
  };
  for (let r = 0; r + 1 < heights.length; ++r) {
    for (let a = 0; a < around; ++a) {
      const [p, q, s, t] = [at(heights[r], a), at(heights[r], a + 1), at(heights[r + 1], a + 1), at(heights[r + 1], a)];
      for (const v of [p, q, s, p, s, t]) {
        out.push(...v, ...v);
      }
    }
  }
  return new Float32Array(out);
}

/** A colour for a type's number, evenly spread around the circle of hues. */
export function typeColour(type, dim) {
  const hue = (type * 0.61803398875 + 0.08) % 1;
  const part = (offset) => {
    const h = (hue + offset) % 1;
    return Math.min(1, Math.max(0, Math.abs(6 * h - 3) - 1));
  };
  const [light, pale] = dim ? [0.62, 0.75] : [1, 0.3];
  return [part(0), part(2 / 3), part(1 / 3)].map((c) => Math.round(255 * light * (pale + (1 - pale) * c)));
}

export class Renderer {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext('webgl2', { antialias: false, alpha: false });
    if (!gl) {
      throw new Error('this browser has no WebGL2');
    }
    this.gl = gl;
    this.camera = new Camera();
    this.origin = [0, 0, 0];
    this.shapes = compile(gl, SHAPE_VERTEX, SHAPE_FRAGMENT);
    this.points = compile(gl, POINT_VERTEX, SHAPE_FRAGMENT);
    this.lines = compile(gl, LINE_VERTEX, LINE_FRAGMENT);
    this.box = this.#mesh(boxMesh());
    this.round = this.#mesh(roundMesh());
    this.staticBoxes = this.#instances(this.box);
    this.boxes = this.#instances(this.box);
    this.rounds = this.#instances(this.round);
    this.far = this.#instances(null);
    this.borders = { vao: gl.createVertexArray(), buffer: gl.createBuffer(), count: 0 };
    this.types = [];
    this.mostShapes = MOST_SHAPES;
    this.frameMs = (SLOW_MS + FAST_MS) / 2;
  }

  /** Learns from the time between two frames that were drawn one after the other, ms. */
  adapt(ms) {
    this.frameMs += 0.2 * (ms - this.frameMs);
    if (this.frameMs > SLOW_MS || this.frameMs < FAST_MS) {
      const factor = this.frameMs > SLOW_MS ? 0.7 : 1.1;
      this.mostShapes = Math.round(Math.min(MOST_SHAPES, Math.max(FEWEST_SHAPES, factor * this.mostShapes)));
      this.frameMs = (SLOW_MS + FAST_MS) / 2;
    }
  }

  #mesh(data) {
    const gl = this.gl;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return { buffer, count: data.length / 6 };
  }

  #instances(mesh) {
    const gl = this.gl;
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    if (mesh) {
      gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffer);
      for (const [place, offset] of [[0, 0], [1, 12]]) {
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 24, offset);
      }
    }
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    const stride = 4 * INSTANCE_FLOATS;
    for (const [place, size, type, offset] of [
      [2, 3, gl.FLOAT, 0], [3, 4, gl.FLOAT, 12], [4, 3, gl.FLOAT, 28], [5, 4, gl.UNSIGNED_BYTE, 40],
    ]) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, type, type === gl.UNSIGNED_BYTE, stride, offset);
      gl.vertexAttribDivisor(place, mesh ? 1 : 0);
    }
    gl.bindVertexArray(null);
    return { vao, buffer, mesh, count: 0 };
  }

  #fill(instances, rows) {
    const floats = new Float32Array(rows.length * INSTANCE_FLOATS);
    const bytes = new Uint8Array(floats.buffer);
    rows.forEach((row, i) => {
      const at = i * INSTANCE_FLOATS;
      for (let k = 0; k < 3; ++k) {
        floats[at + k] = row.p[k] - this.origin[k];
        floats[at + 7 + k] = row.size[k];
      }
      floats.set(row.q, at + 3);
      bytes.set([...row.colour, 255], 4 * at + 40);
    });
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, instances.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, floats, gl.DYNAMIC_DRAW);
    instances.count = rows.length;
  }

  /** Types, zones and what never moves. */
  setScene(scene) {
    this.types = scene.types;
    const zones = scene.zones;
    const edge = (f, key) => f(...zones.map((zone) => zone[key]));
    const bounds = [edge(Math.min, 'min_x'), edge(Math.min, 'min_z'), edge(Math.max, 'max_x'), edge(Math.max, 'max_z')];
    this.origin = [(bounds[0] + bounds[2]) / 2, 0, (bounds[1] + bounds[3]) / 2];
    this.camera.frame(...bounds);
    const boxes = scene.boxes.map((box) => ({ ...box, colour: [150, 150, 145] }));
    for (const zone of zones) {
      // The ground, as a flat box.
      boxes.push({
        p: [(zone.min_x + zone.max_x) / 2, scene.ground_height_m - 0.5, (zone.min_z + zone.max_z) / 2],
        size: [(zone.max_x - zone.min_x) / 2, 0.5, (zone.max_z - zone.min_z) / 2],
        q: [0, 0, 0, 1],
        colour: [196, 202, 190],
      });
    }
    this.#fill(this.staticBoxes, boxes);
    const line = [];
    for (const zone of zones) {
      const y = scene.ground_height_m + 0.03;
      const [a, b, c, d] = [[zone.min_x, zone.min_z], [zone.max_x, zone.min_z], [zone.max_x, zone.max_z], [zone.min_x, zone.max_z]];
      for (const [from, to] of [[a, b], [b, c], [c, d], [d, a]]) {
        line.push(from[0] - this.origin[0], y, from[1] - this.origin[2], to[0] - this.origin[0], y, to[1] - this.origin[2]);
      }
    }
    const gl = this.gl;
    gl.bindVertexArray(this.borders.vao);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.borders.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(line), gl.STATIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 12, 0);
    gl.bindVertexArray(null);
    this.borders.count = line.length / 3;
  }

  #matrix() {
    return this.camera.matrix(this.canvas.width / this.canvas.height, this.origin);
  }

  /** Sorts the entities into shapes and points; `chosen` is the number of the one that was clicked. */
  place(entities, chosen) {
    const eye = this.camera.eye();
    const rows = [...entities.rows.values()];
    for (const row of rows) {
      const type = this.types[row.type];
      row.size = type.size;
      row.colour = row.id === chosen ? [255, 255, 255] : typeColour(row.type, (row.flags & 1) !== 0);
      row.far = (row.p[0] - eye[0]) ** 2 + (row.p[1] - eye[1]) ** 2 + (row.p[2] - eye[2]) ** 2;
    }
    if (rows.length > this.mostShapes) {
      rows.sort((a, b) => a.far - b.far);
    }
    const near = [];
    const far = [];
    rows.forEach((row, i) => {
      // What would be smaller than three pixels is seen better as a point.
      const large = Math.max(...row.size) * this.canvas.height > 3 * Math.sqrt(row.far);
      (large && i < this.mostShapes ? near : far).push(row);
    });
    this.#fill(this.boxes, near.filter((row) => !this.types[row.type].round));
    this.#fill(this.rounds, near.filter((row) => this.types[row.type].round));
    this.#fill(this.far, far);
  }

  draw() {
    const gl = this.gl;
    const scale = Math.min(window.devicePixelRatio, 1.5);
    const width = Math.max(1, Math.round(scale * this.canvas.clientWidth));
    const height = Math.max(1, Math.round(scale * this.canvas.clientHeight));
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    const dark = window.matchMedia('(prefers-color-scheme: dark)').matches;
    gl.viewport(0, 0, width, height);
    gl.clearColor(...(dark ? [0.063, 0.086, 0.11] : [0.875, 0.898, 0.918]), 1);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const matrix = this.#matrix();
    gl.useProgram(this.shapes);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.shapes, 'camera'), false, matrix);
    for (const instances of [this.staticBoxes, this.boxes, this.rounds]) {
      gl.uniform1i(gl.getUniformLocation(this.shapes, 'round'), instances.mesh === this.round ? 1 : 0);
      gl.bindVertexArray(instances.vao);
      gl.drawArraysInstanced(gl.TRIANGLES, 0, instances.mesh.count, instances.count);
    }
    gl.useProgram(this.points);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.points, 'camera'), false, matrix);
    gl.uniform1f(gl.getUniformLocation(this.points, 'scale'), 2 * height);
    gl.bindVertexArray(this.far.vao);
    gl.drawArrays(gl.POINTS, 0, this.far.count);
    gl.useProgram(this.lines);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.lines, 'camera'), false, matrix);
    gl.uniform4fv(gl.getUniformLocation(this.lines, 'colour'), dark ? [0.35, 0.6, 0.8, 1] : [0.1, 0.35, 0.6, 1]);
    gl.bindVertexArray(this.borders.vao);
    gl.drawArrays(gl.LINES, 0, this.borders.count);
    gl.bindVertexArray(null);
  }

  /** Where an entity is on the canvas, in CSS pixels, and its depth; null behind the camera. */
  project(row, matrix = this.#matrix()) {
    const p = row.p.map((v, i) => v - this.origin[i]);
    const at = (r) => matrix[r] * p[0] + matrix[4 + r] * p[1] + matrix[8 + r] * p[2] + matrix[12 + r];
    const w = at(3);
    return w <= 0 ? null : {
      x: (0.5 + (0.5 * at(0)) / w) * this.canvas.clientWidth,
      y: (0.5 - (0.5 * at(1)) / w) * this.canvas.clientHeight,
      w,
    };
  }

  /** The entity under a place on the canvas, or the next one within some pixels. */
  pick(entities, x, y) {
    const matrix = this.#matrix();
    let best = null;
    for (const row of entities.rows.values()) {
      const at = this.project(row, matrix);
      if (!at) {
        continue;
      }
      const size = Math.max(...this.types[row.type].size);
      const reach = Math.max(8, (size * this.canvas.clientHeight) / at.w);
      const away = Math.hypot(at.x - x, at.y - y);
      if (away <= reach && (!best || away / reach + at.w * 1e-4 < best.score)) {
        best = { row, score: away / reach + at.w * 1e-4 };
      }
    }
    return best ? best.row : null;
  }
}
