// Draws the world by WebGL2: near entities as their shapes, far ones as points that look like them.

import { Camera } from './camera.js';
import { ROW_BYTES } from './entities.js';
import { LINE_BYTES, Lines } from './lines.js';
import { boxMesh, roundMesh, smoothNormals, spreadColour } from './meshes.js';
import * as shaders from './shaders.js';

/** So many are drawn as shapes where the machine keeps up, and where it does not. */
const MOST_SHAPES = 1000;
const FEWEST_SHAPES = 100;
/** Smaller than this radius, in pixels, an entity is a point. */
const LEAST_SHAPE_PIXELS = 5;
/** Times between frames, ms: above the first less is drawn, below the second more. */
const SLOW_MS = 28;
const FAST_MS = 19;
const LEAST_SCALE = 0.5;

const SUN = [0.42, 0.8, 0.43];
const THEMES = {
  light: { sky: [0.8, 0.87, 0.93], ground: [0.71, 0.76, 0.66], box: [0.86, 0.84, 0.8], terrain: [0.62, 0.71, 0.52] },
  dark: { sky: [0.07, 0.09, 0.12], ground: [0.16, 0.19, 0.19], box: [0.42, 0.43, 0.46], terrain: [0.24, 0.31, 0.24] },
};
export const COLOURINGS = ['type', 'zone', 'load'];

export class Renderer {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = canvas.getContext('webgl2', { antialias: false, alpha: false, powerPreference: 'high-performance' });
    if (!gl) {
      throw new Error('this browser has no WebGL2');
    }
    this.gl = gl;
    this.camera = new Camera();
    this.origin = [0, 0, 0];
    this.types = [];
    this.hiddenTypes = new Set();
    this.colouring = 'type';
    this.shown = { statics: true, zones: true };
    this.lines = new Lines(); // of this frame, by the owner of the page
    this.points = new Lines(); // particles
    this.softs = new Map(); // entity -> { places, faces }
    this.mostShapes = MOST_SHAPES;
    this.scale = 1;
    this.frameMs = 16;
    this.shader = {
      shape: new shaders.Program(gl, shaders.SHAPE_VERTEX, shaders.LIT_FRAGMENT),
      point: new shaders.Program(gl, shaders.POINT_VERTEX, shaders.POINT_FRAGMENT),
      box: new shaders.Program(gl, shaders.BOX_VERTEX, shaders.LIT_FRAGMENT),
      mesh: new shaders.Program(gl, shaders.MESH_VERTEX, shaders.SHEET_FRAGMENT),
      ground: new shaders.Program(gl, shaders.GROUND_VERTEX, shaders.GROUND_FRAGMENT),
      line: new shaders.Program(gl, shaders.LINE_VERTEX, shaders.LINE_FRAGMENT),
    };
    this.boxCorners = this.#mesh(boxMesh());
    this.roundCorners = this.#mesh(roundMesh());
    this.entityRows = this.#buffer(null);
    this.nearMarks = this.#buffer(null);
    this.nearRows = this.#buffer(null);
    this.boxRows = this.#buffer(null);
    this.groundCorners = this.#buffer(null);
    this.lineCorners = this.#buffer(null);
    this.softCorners = this.#buffer(null);
    this.softFaces = { handle: gl.createBuffer() };
    this.typeMeshes = new Map();
    this.typeTable = gl.createTexture();
    this.near = { slots: new Uint32Array(0), away: new Float32Array(0), marks: new Uint8Array(0) };
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
  }

  #buffer(content) {
    const buffer = { handle: this.gl.createBuffer(), bytes: 0, count: content ? content.length / 6 : 0 };
    if (content) {
      this.#upload(buffer, content);
    }
    return buffer;
  }

  #mesh({ corners, index }) {
    const gl = this.gl;
    const buffer = this.#buffer(corners);
    buffer.index = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer.index);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, index, gl.STATIC_DRAW);
    buffer.count = index.length;
    return buffer;
  }

  /** Draws a mesh as often as there are instances; its attributes are set. */
  #drawMesh(mesh, instances) {
    const gl = this.gl;
    if (mesh.index) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, mesh.index);
      gl.drawElementsInstanced(gl.TRIANGLES, mesh.count, gl.UNSIGNED_SHORT, 0, instances);
    } else {
      gl.drawArraysInstanced(gl.TRIANGLES, 0, mesh.count, instances);
    }
  }

  /** Fills a buffer; makes it larger only where it must be. */
  #upload(buffer, content) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer.handle);
    if (content.byteLength > buffer.bytes || buffer.bytes === 0) {
      gl.bufferData(gl.ARRAY_BUFFER, content, gl.DYNAMIC_DRAW);
      buffer.bytes = content.byteLength;
    } else if (content.byteLength > 0) {
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, content);
    }
  }

  #attribute(place, size, type, stride, offset, { each = 0, norm = false, whole = false } = {}) {
    const gl = this.gl;
    gl.enableVertexAttribArray(place);
    if (whole) {
      gl.vertexAttribIPointer(place, size, type, stride, offset);
    } else {
      gl.vertexAttribPointer(place, size, type, norm, stride, offset);
    }
    gl.vertexAttribDivisor(place, each);
  }

  #noAttributes() {
    for (let place = 0; place <= 10; ++place) {
      this.gl.disableVertexAttribArray(place);
      this.gl.vertexAttribDivisor(place, 0);
    }
  }

  /** The columns of a row of entities.js, from a row on. */
  #rowAttributes(buffer, first, each) {
    const gl = this.gl;
    const at = ROW_BYTES * first;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer.handle);
    this.#attribute(2, 3, gl.FLOAT, ROW_BYTES, at, { each });
    this.#attribute(3, 1, gl.UNSIGNED_INT, ROW_BYTES, at + 12, { each, whole: true });
    this.#attribute(4, 4, gl.SHORT, ROW_BYTES, at + 16, { each, norm: true });
    this.#attribute(5, 3, gl.HALF_FLOAT, ROW_BYTES, at + 24, { each });
    this.#attribute(6, 1, gl.UNSIGNED_SHORT, ROW_BYTES, at + 30, { each, whole: true });
    this.#attribute(7, 1, gl.UNSIGNED_INT, ROW_BYTES, at + 32, { each, whole: true });
    this.#attribute(8, 2, gl.UNSIGNED_BYTE, ROW_BYTES, at + 36, { each, whole: true });
    this.#attribute(9, 1, gl.UNSIGNED_SHORT, ROW_BYTES, at + 38, { each, whole: true });
  }

  /** Types, zones and ground; geometry comes in pieces. */
  setScene(scene, geometry) {
    this.scene = scene;
    this.geometry = geometry;
    this.types = scene.types;
    this.softs.clear();
    this.typeMeshes.clear();
    this.boxCount = 0;
    this.boxChunks = 0;
    const zones = scene.zones;
    const edge = (f, key) => f(...zones.map((zone) => zone[key]));
    const bounds = [edge(Math.min, 'min_x'), edge(Math.min, 'min_z'), edge(Math.max, 'max_x'), edge(Math.max, 'max_z')];
    this.origin = [(bounds[0] + bounds[2]) / 2, scene.ground_height_m, (bounds[1] + bounds[3]) / 2];
    this.extent = Math.max(bounds[2] - bounds[0], bounds[3] - bounds[1]);
    this.camera.frame(...bounds, scene.ground_height_m);
    const [x0, z0, x1, z1] = [bounds[0] - this.extent, bounds[1] - this.extent, bounds[2] + this.extent, bounds[3] + this.extent];
    const y = scene.ground_height_m;
    this.#upload(this.groundCorners, new Float32Array([x0, y, z0, x0, y, z1, x1, y, z1, x0, y, z0, x1, y, z1, x1, y, z0]));
    this.#setTypes();
  }

  #setTypes() {
    const gl = this.gl;
    const kinds = { box: 0, round: 1, solid: 2, soft: 3 };
    const table = new Float32Array(8 * this.types.length);
    this.types.forEach((type, i) => {
      const kind = this.hiddenTypes.has(i) ? -1 : kinds[type.shape];
      table.set([...type.size, kind], 4 * i);
      table.set(spreadColour(i), 4 * (this.types.length + i));
      type.radius = type.shape === 'round' ? type.size[0] + type.size[1] : Math.hypot(...type.size);
    });
    gl.bindTexture(gl.TEXTURE_2D, this.typeTable);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, this.types.length, 2, 0, gl.RGBA, gl.FLOAT, table);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  hideType(type, hidden) {
    this.hiddenTypes[hidden ? 'add' : 'delete'](type);
    this.#setTypes();
  }

  /** Puts pieces of geometry that have come where they can be drawn. */
  #takeGeometry() {
    const { geometry } = this;
    for (const surface of geometry.ready.splice(0)) {
      surface.upload(this.gl);
      geometry.drawn.push(surface);
    }
    if (geometry.boxes.length !== this.boxChunks) {
      this.boxChunks = geometry.boxes.length;
      const all = new Float32Array(geometry.boxes.reduce((sum, chunk) => sum + chunk.length, 0));
      let at = 0;
      for (const chunk of geometry.boxes) {
        all.set(chunk, at);
        at += chunk.length;
      }
      this.staticBoxes = all;
      this.staticDoors = null;
    }
    for (const [type, mesh] of geometry.typeTriangles) {
      if (!this.typeMeshes.has(type)) {
        this.typeMeshes.set(type, this.#buffer(mesh));
      }
    }
  }

  /** The boxes that stand, doors that are shut among them. */
  #placeBoxes(tick) {
    const phase = (door) => (((tick + door.shift_ticks) % door.period_ticks) + door.period_ticks) % door.period_ticks;
    const shut = this.scene.doors.filter((door) => !door.open.some(([from, to]) => phase(door) >= from && phase(door) < to));
    const names = shut.map((door) => door.name).join();
    if (names === this.staticDoors) {
      return;
    }
    this.staticDoors = names;
    const boxes = this.staticBoxes ?? new Float32Array(0);
    const all = new Float32Array(boxes.length + 10 * shut.length);
    all.set(boxes);
    shut.forEach((door, i) => all.set([...door.p, ...door.size, ...door.q], boxes.length + 10 * i));
    this.#upload(this.boxRows, all);
    this.boxCount = all.length / 10;
  }

  /** Chooses the entities that are drawn as shapes, nearest first, and gathers their rows by mesh. */
  #chooseNear(entities, view, tick, tickSeconds, height) {
    const { near, types } = this;
    if (near.slots.length < entities.capacity) {
      near.slots = new Uint32Array(entities.capacity);
      near.away = new Float32Array(entities.capacity);
      near.marks = new Uint8Array(entities.capacity);
      near.words = new Uint32Array(10 * (MOST_SHAPES + 1));
    }
    const limit = Camera.pixelsPerMetre(height) / LEAST_SHAPE_PIXELS;
    const reaches = types.map((type) => (type.radius * limit) ** 2);
    const { floats, shorts } = entities;
    const [ex, ey, ez] = view.eye;
    const place = [0, 0, 0];
    let count = 0;
    near.marks.fill(0, 0, entities.end);
    for (let slot = 0; slot < entities.end; ++slot) {
      // Where it was told last is near enough for most: they are far away.
      const at = 10 * slot;
      const [dx, dy, dz] = [floats[at] - ex, floats[at + 1] - ey, floats[at + 2] - ez];
      const squared = dx * dx + dy * dy + dz * dz;
      const type = shorts[2 * at + 15];
      if (squared > reaches[type] || entities.isFree(slot)) {
        continue;
      }
      if (view.sees(entities.place(slot, tick, tickSeconds, place), types[type].radius)) {
        near.slots[count++] = slot;
        near.away[slot] = squared;
      }
    }
    let chosen = near.slots.subarray(0, count);
    if (count > this.mostShapes) {
      chosen = chosen.slice().sort((a, b) => near.away[a] - near.away[b]).subarray(0, this.mostShapes);
    }
    return this.#gatherRows(entities, chosen);
  }

  /** Rows of the chosen slots, those of one mesh after the other: { mesh, kind, first, count }. */
  #gatherRows(entities, chosen) {
    const groups = new Map();
    for (const slot of chosen) {
      const type = entities.type(slot);
      this.near.marks[slot] = 1;
      if (this.hiddenTypes.has(type)) {
        continue;
      }
      const shape = this.types[type].shape;
      if (shape === 'soft' && this.softs.has(entities.id(slot))) {
        continue;
      }
      const key = shape === 'round' ? -1 : shape === 'solid' && this.typeMeshes.has(type) ? type : -2;
      const group = groups.get(key);
      if (group) {
        group.push(slot);
      } else {
        groups.set(key, [slot]);
      }
    }
    const out = [];
    let at = 0;
    for (const [key, slots] of groups) {
      const mesh = key === -1 ? this.roundCorners : key === -2 ? this.boxCorners : this.typeMeshes.get(key);
      out.push({ mesh, kind: key === -1 ? 1 : key === -2 ? 0 : 2, first: at, count: slots.length });
      for (const slot of slots) {
        for (let k = 0; k < 10; ++k) {
          this.near.words[10 * at + k] = entities.words[10 * slot + k];
        }
        ++at;
      }
    }
    this.#upload(this.nearRows, this.near.words.subarray(0, 10 * at));
    return out;
  }

  /** Less where frames come late, more where they come early; the time since the frame before, ms. */
  adapt(elapsed) {
    this.frameMs += 0.08 * (Math.min(elapsed, 200) - this.frameMs);
    if (this.frameMs > SLOW_MS) {
      const late = Math.min(8, this.frameMs / SLOW_MS); // the later, the faster it gives in
      this.mostShapes = Math.max(FEWEST_SHAPES, Math.round(this.mostShapes * (1 - 0.03 * late)));
      this.scale = Math.max(LEAST_SCALE, this.scale - 0.01 * late);
    } else if (this.frameMs < FAST_MS) {
      this.mostShapes = Math.min(MOST_SHAPES, this.mostShapes + 10);
      this.scale = Math.min(1, this.scale + 0.002);
    }
  }

  #fit() {
    const steps = Math.ceil(20 * this.scale) / 20; // a new size costs a frame: not for every little change
    const ratio = Math.min(window.devicePixelRatio, 1.5) * steps;
    const width = Math.max(1, Math.round(ratio * this.canvas.clientWidth));
    const height = Math.max(1, Math.round(ratio * this.canvas.clientHeight));
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    return [width, height];
  }

  #use(program, view, theme) {
    const gl = this.gl;
    program.use();
    const at = program.at;
    gl.uniformMatrix4fv(at.camera, false, view.matrix);
    gl.uniform3fv(at.origin, this.origin);
    gl.uniform3fv(at.sun, SUN);
    gl.uniform3fv(at.sky, theme.sky);
    gl.uniform1f(at.fogFrom, 0.35 / (this.camera.distance + 0.35 * Math.min(this.extent, 2000)));
    return at;
  }

  /** Draws one frame of a tick (broken); `chosen` is the number of an entity. */
  draw(entities, clock, chosen) {
    const gl = this.gl;
    const [width, height] = this.#fit();
    const theme = THEMES[window.matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light'];
    const view = this.camera.view(width / height, this.origin);
    this.view = view;
    view.pixelsPerMetre = Camera.pixelsPerMetre(height);
    const tick = clock.shown;
    const groups = this.#chooseNear(entities, view, tick, clock.tickSeconds, height);
    gl.viewport(0, 0, width, height);
    gl.clearColor(...theme.sky, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const moment = { tick, tickSeconds: clock.tickSeconds, chosen, height };
    this.#drawShapes(groups, view, theme, moment);
    this.#drawPoints(entities, view, theme, moment);
    this.#drawSofts(view, theme);
    if (this.shown.statics) {
      this.#takeGeometry();
      this.#drawStatics(view, theme, Math.floor(tick));
    }
    const at = this.#use(this.shader.ground, view, theme);
    gl.uniform3fv(at.colour, theme.ground);
    gl.uniform1f(at.square, this.extent > 600 ? 50 : 10);
    this.#noAttributes();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.groundCorners.handle);
    this.#attribute(0, 3, gl.FLOAT, 12, 0);
    gl.drawArrays(gl.TRIANGLES, 0, 6);
    this.#drawLines(this.points, gl.POINTS, view, theme, height);
    this.#drawLines(this.lines, gl.LINES, view, theme, height);
  }

  #entityUniforms(at, moment) {
    const gl = this.gl;
    const whole = Math.floor(moment.tick);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.typeTable);
    gl.uniform1i(at.types, 0);
    gl.uniform1i(at.tickNow, whole);
    gl.uniform1f(at.tickPart, moment.tick - whole);
    gl.uniform1f(at.tickSeconds, moment.tickSeconds);
    gl.uniform1ui(at.chosen, moment.chosen);
    gl.uniform1i(at.colouring, COLOURINGS.indexOf(this.colouring));
  }

  #drawShapes(groups, view, theme, moment) {
    const gl = this.gl;
    const at = this.#use(this.shader.shape, view, theme);
    this.#entityUniforms(at, moment);
    this.#noAttributes();
    for (const { mesh, kind, first, count } of groups) {
      gl.uniform1i(at.kind, kind);
      gl.bindBuffer(gl.ARRAY_BUFFER, mesh.handle);
      this.#attribute(0, 3, gl.FLOAT, 24, 0);
      this.#attribute(1, 3, gl.FLOAT, 24, 12);
      this.#rowAttributes(this.nearRows, first, 1);
      this.#drawMesh(mesh, count);
    }
  }

  #drawPoints(entities, view, theme, moment) {
    const gl = this.gl;
    if (entities.end === 0) {
      return;
    }
    if (entities.changed) {
      this.#upload(this.entityRows, entities.bytes.subarray(0, ROW_BYTES * entities.end));
      entities.changed = false;
    }
    this.#upload(this.nearMarks, this.near.marks.subarray(0, entities.end));
    const at = this.#use(this.shader.point, view, theme);
    this.#entityUniforms(at, moment);
    gl.uniform1f(at.scale, Camera.pixelsPerMetre(moment.height));
    gl.uniform2f(at.tilt, Math.sin(view.pitch), Math.cos(view.pitch));
    this.#noAttributes();
    this.#rowAttributes(this.entityRows, 0, 0);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.nearMarks.handle);
    this.#attribute(10, 1, gl.UNSIGNED_BYTE, 1, 0, { whole: true });
    gl.drawArrays(gl.POINTS, 0, entities.end);
  }

  #meshUniforms(view, theme, move, turn, colour, steepness) {
    const gl = this.gl;
    const at = this.#use(this.shader.mesh, view, theme);
    gl.uniform3fv(at.move, move);
    gl.uniform4fv(at.turn, turn);
    gl.uniform3fv(at.colour, colour);
    gl.uniform1f(at.steepness, steepness);
  }

  #drawSofts(view, theme) {
    const gl = this.gl;
    gl.disable(gl.CULL_FACE);
    let number = 0;
    for (const soft of this.softs.values()) {
      ++number;
      if (!soft.faces || soft.faces.length === 0 || this.hiddenTypes.has(soft.type)) {
        continue;
      }
      if (!soft.normals || soft.normals.length !== soft.places.length) {
        soft.normals = new Float32Array(soft.places.length);
      }
      smoothNormals(soft.places, soft.faces, soft.normals);
      this.#meshUniforms(view, theme, [0, 0, 0], [0, 0, 0, 1], spreadColour((soft.type ?? 0) + 0.13 * number), 0);
      this.#noAttributes();
      gl.bindBuffer(gl.ARRAY_BUFFER, this.softCorners.handle);
      gl.bufferData(gl.ARRAY_BUFFER, 8 * soft.places.length, gl.DYNAMIC_DRAW);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, soft.places);
      gl.bufferSubData(gl.ARRAY_BUFFER, 4 * soft.places.length, soft.normals);
      this.#attribute(0, 3, gl.FLOAT, 12, 0);
      this.#attribute(1, 3, gl.FLOAT, 12, 4 * soft.places.length);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.softFaces.handle);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, soft.faces, gl.DYNAMIC_DRAW);
      gl.drawElements(gl.TRIANGLES, soft.faces.length, gl.UNSIGNED_INT, 0);
    }
    gl.enable(gl.CULL_FACE);
  }

  #drawStatics(view, theme, tick) {
    const gl = this.gl;
    this.#placeBoxes(tick);
    if (this.boxCount > 0) {
      const at = this.#use(this.shader.box, view, theme);
      gl.uniform3fv(at.colour, theme.box);
      this.#noAttributes();
      gl.bindBuffer(gl.ARRAY_BUFFER, this.boxCorners.handle);
      this.#attribute(0, 3, gl.FLOAT, 24, 0);
      this.#attribute(1, 3, gl.FLOAT, 24, 12);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.boxRows.handle);
      this.#attribute(2, 3, gl.FLOAT, 40, 0, { each: 1 });
      this.#attribute(3, 3, gl.FLOAT, 40, 12, { each: 1 });
      this.#attribute(4, 4, gl.FLOAT, 40, 24, { each: 1 });
      this.#drawMesh(this.boxCorners, this.boxCount);
    }
    for (const surface of this.geometry.drawn) {
      this.#meshUniforms(view, theme, surface.told.p, surface.told.q, theme.terrain, 1);
      this.#noAttributes();
      gl.enableVertexAttribArray(0);
      gl.enableVertexAttribArray(1);
      surface.draw(gl, view);
    }
  }

  #drawLines(lines, mode, view, theme, height) {
    const gl = this.gl;
    if (lines.count === 0) {
      return;
    }
    this.#upload(this.lineCorners, lines.bytes.subarray(0, LINE_BYTES * lines.count));
    const at = this.#use(this.shader.line, view, theme);
    gl.uniform1f(at.pointSize, 0.16 * Camera.pixelsPerMetre(height));
    this.#noAttributes();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lineCorners.handle);
    this.#attribute(0, 3, gl.FLOAT, LINE_BYTES, 0);
    this.#attribute(1, 4, gl.UNSIGNED_BYTE, LINE_BYTES, 12, { norm: true });
    gl.drawArrays(mode, 0, lines.count);
  }

  /** Where a place is on the canvas, in CSS pixels, and its depth; null behind the camera. */
  project(place) {
    const aspect = this.canvas.clientWidth / this.canvas.clientHeight;
    const matrix = this.camera.matrix(aspect, this.origin);
    return this.#projected(matrix, place);
  }

  #projected(matrix, place) {
    const [x, y, z] = [place[0] - this.origin[0], place[1] - this.origin[1], place[2] - this.origin[2]];
    const at = (r) => matrix[r] * x + matrix[4 + r] * y + matrix[8 + r] * z + matrix[12 + r];
    const w = at(3);
    return w <= 0 ? null : {
      x: (0.5 + (0.5 * at(0)) / w) * this.canvas.clientWidth,
      y: (0.5 - (0.5 * at(1)) / w) * this.canvas.clientHeight,
      w,
    };
  }

  /** The slot of the entity under a point of the canvas, or the nearest within some pixels; -1: none. */
  pick(entities, clock, x, y) {
    const matrix = this.camera.matrix(this.canvas.clientWidth / this.canvas.clientHeight, this.origin);
    const metres = Camera.pixelsPerMetre(this.canvas.clientHeight);
    const place = [0, 0, 0];
    let best = -1;
    let least = Infinity;
    for (let slot = 0; slot < entities.end; ++slot) {
      if (entities.isFree(slot) || this.hiddenTypes.has(entities.type(slot))) {
        continue;
      }
      const at = this.#projected(matrix, entities.place(slot, clock.shown, clock.tickSeconds, place));
      if (!at) {
        continue;
      }
      const reach = Math.max(8, (this.types[entities.type(slot)].radius * metres) / at.w);
      const away = Math.hypot(at.x - x, at.y - y) / reach;
      if (away <= 1 && away + at.w * 1e-4 < least) {
        least = away + at.w * 1e-4;
        best = slot;
      }
    }
    return best;
  }
}
