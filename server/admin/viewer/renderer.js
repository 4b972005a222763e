// Draws the world by WebGL2: near entities as their shapes, far ones as points that look like them.

import { BOX_NUMBERS, BoxCells, CORNER_BYTES } from './boxes.js';
import { Camera } from './camera.js';
import { ROW_BYTES } from './entities.js';
import { LINE_BYTES, Lines } from './lines.js';
import { boxMesh, roundMesh, smoothNormals, spreadColour } from './meshes.js';
import { placeOf } from './platforms.js';
import * as shaders from './shaders.js';
import { isRope } from './softs.js';
import { Colours, POINT_BYTES, Visible } from './visible.js';

/** So many are drawn as shapes where the machine keeps up, where it does not, and at first where it has no graphics card. */
const MOST_SHAPES = 1000;
const FEWEST_SHAPES = 60;
const SOFTWARE_SHAPES = 150;
/** Smaller than this radius, in pixels, a round one has few corners. */
const COARSE_PIXELS = 24;
/** Times between frames, ms: above the first less is drawn, below the second more. */
const SLOW_MS = 31;
const FAST_MS = 19;
const LEAST_SCALE = 0.5;

const SUN = [0.42, 0.8, 0.43];
const THEMES = {
  light: { sky: [0.8, 0.87, 0.93], ground: [0.71, 0.76, 0.66], box: [0.86, 0.84, 0.8], terrain: [0.62, 0.71, 0.52] },
  dark: { sky: [0.07, 0.09, 0.12], ground: [0.16, 0.19, 0.19], box: [0.42, 0.43, 0.46], terrain: [0.24, 0.31, 0.24] },
};
export const COLOURINGS = ['type', 'zone', 'load'];
/** Sizes of the picture that a user can fix; without one it follows the pace of frames. */
export const SIZES = { automatic: 0, full: 1, 'three quarters': 0.75, half: 0.5 };

/** Whether the pictures are made by the processor alone. */
function isSoftware(gl) {
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

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
    this.software = isSoftware(gl);
    this.mostShapes = this.software ? SOFTWARE_SHAPES : MOST_SHAPES;
    this.scale = this.software ? LEAST_SCALE : 1;
    this.fixedScale = 0; // 0: as `scale` says
    this.frameMs = 16;
    this.shader = {
      shape: new shaders.Program(gl, shaders.SHAPE_VERTEX, shaders.LIT_FRAGMENT),
      plainPoint: new shaders.Program(gl, shaders.POINT_VERTEX, shaders.PLAIN_FRAGMENT),
      capsulePoint: new shaders.Program(gl, shaders.POINT_VERTEX, shaders.CAPSULE_FRAGMENT),
      box: new shaders.Program(gl, shaders.BOX_VERTEX, shaders.BOX_FRAGMENT),
      mesh: new shaders.Program(gl, shaders.MESH_VERTEX, shaders.SHEET_FRAGMENT),
      ground: new shaders.Program(gl, shaders.GROUND_VERTEX, shaders.GROUND_FRAGMENT),
      line: new shaders.Program(gl, shaders.LINE_VERTEX, shaders.LINE_FRAGMENT),
    };
    this.boxCorners = this.#mesh(boxMesh());
    this.roundCorners = this.#mesh(roundMesh());
    this.coarseCorners = this.#mesh(roundMesh(5, 0));
    this.pointRows = this.#buffer(null);
    this.nearRows = this.#buffer(null);
    // Boxes that always stand, doors and platforms: where one turns or moves, only its like are laid out anew.
    const boxes = () => ({ cells: new BoxCells(), corners: this.#buffer(null), index: gl.createBuffer() });
    this.walls = boxes();
    this.doors = boxes();
    this.platforms = boxes();
    this.cellsSeen = [];
    this.groundCorners = this.#buffer(null);
    this.lineCorners = this.#buffer(null);
    this.softCorners = this.#buffer(null);
    this.softFaces = { handle: gl.createBuffer() };
    this.typeMeshes = new Map();
    this.typeTable = gl.createTexture();
    this.visible = new Visible();
    this.groups = new Map(); // mesh -> { mesh, kind, slots, count, first }
    this.nearWords = new Uint32Array(10 * (MOST_SHAPES + 1));
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

  /** Fills a buffer with the first elements of an array; makes it larger only where it must be. */
  #upload(buffer, content, count = content.length) {
    const gl = this.gl;
    const bytes = count * content.BYTES_PER_ELEMENT;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer.handle);
    if (bytes > buffer.bytes || buffer.bytes === 0) {
      gl.bufferData(gl.ARRAY_BUFFER, content, gl.DYNAMIC_DRAW);
      buffer.bytes = content.byteLength;
    } else if (bytes > 0) {
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, content, 0, count);
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
    this.groups.clear();
    this.walls.cells.clear();
    this.doors.cells.clear();
    this.platforms.cells.clear();
    this.boxChunks = 0;
    this.shutDoors = null;
    this.movedTo = '';
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
    const table = new Float32Array(8 * this.types.length);
    this.types.forEach((type, i) => {
      table.set(type.size, 4 * i);
      table.set(spreadColour(i), 4 * (this.types.length + i));
      type.radius = type.shape === 'round' ? type.size[0] + type.size[1] : Math.hypot(...type.size);
    });
    this.colours = new Colours(this.types.map((_, i) => spreadColour(i)));
    gl.bindTexture(gl.TEXTURE_2D, this.typeTable);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, this.types.length, 2, 0, gl.RGBA, gl.FLOAT, table);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  hideType(type, hidden) {
    this.hiddenTypes[hidden ? 'add' : 'delete'](type);
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
      this.#layOut(this.walls, all);
    }
    for (const [type, mesh] of geometry.typeTriangles) {
      if (!this.typeMeshes.has(type)) {
        this.typeMeshes.set(type, this.#buffer(mesh));
      }
    }
  }

  #layOut(boxes, numbers) {
    const gl = this.gl;
    boxes.cells.build(numbers, this.origin, (x, y, z) => 0.7 + 0.3 * (x * SUN[0] + y * SUN[1] + z * SUN[2]));
    this.#upload(boxes.corners, boxes.cells.corners);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, boxes.index);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, boxes.cells.index, gl.STATIC_DRAW);
  }

  /** Takes doors (1: open) and platforms (ticks of travel) as rules have moved them, in the order of the scene. */
  moveByRules(doors, platforms) {
    this.scene.doors.filter((door) => door.by_rules).forEach((door, i) => (door.is_open = doors[i] === 1));
    this.scene.platforms.filter((platform) => platform.by_rules).forEach((platform, i) => (platform.along_ticks = platforms[i]));
  }

  /** The doors that are shut; those that rules move are as they begin until the server says more. */
  #placeDoors(tick) {
    const phase = (door) => (((tick + door.shift_ticks) % door.period_ticks) + door.period_ticks) % door.period_ticks;
    const openByTimes = (door) => door.open.some(([from, to]) => phase(door) >= from && phase(door) < to);
    const shut = this.scene.doors.filter((door) => !(door.is_open ?? openByTimes(door)));
    const names = shut.map((door) => door.name).join();
    if (names !== this.shutDoors) {
      this.shutDoors = names;
      const all = new Float32Array(BOX_NUMBERS * shut.length);
      shut.forEach((door, i) => all.set([...door.p, ...door.size, ...door.q], BOX_NUMBERS * i));
      this.#layOut(this.doors, all);
    }
  }

  /** Platforms where their times have them, or the rules. */
  #placePlatforms(tick) {
    const all = this.scene.platforms;
    if (all.length > 0) {
      this.layPlatforms(all.flatMap((platform) => [...placeOf(platform, tick), ...platform.size, ...platform.q]));
    }
  }

  /** Ten numbers for each platform. */
  layPlatforms(numbers) {
    const key = numbers.join();
    if (key !== this.movedTo) {
      this.movedTo = key;
      this.#layOut(this.platforms, new Float32Array(numbers));
    }
  }

  /** Gathers the rows of the near entities, those of one mesh after the other. */
  #gatherRows(entities) {
    const { visible, groups } = this;
    this.coarseFrom = (this.view.pixelsPerMetre / COARSE_PIXELS) ** 2;
    for (const group of groups.values()) {
      group.count = 0;
    }
    for (let i = 0; i < visible.nearCount; ++i) {
      const slot = visible.near[i];
      const type = entities.type(slot);
      const { shape } = this.types[type];
      if (shape === 'soft' && this.softs.has(entities.id(slot))) {
        continue;
      }
      const coarse = visible.squared[i] > this.coarseFrom * this.types[type].radius ** 2;
      const key = shape === 'round' ? (coarse ? -3 : -1) : shape === 'solid' && this.typeMeshes.has(type) ? type : -2;
      const group = groups.get(key) ?? this.#addGroup(key);
      group.slots[group.count++] = slot;
    }
    let row = 0;
    for (const group of groups.values()) {
      group.first = row;
      for (let i = 0; i < group.count; ++i, ++row) {
        const from = 10 * group.slots[i];
        for (let k = 0; k < 10; ++k) {
          this.nearWords[10 * row + k] = entities.words[from + k];
        }
      }
    }
    this.#upload(this.nearRows, this.nearWords, 10 * row);
  }

  #addGroup(key) {
    const shared = { [-1]: this.roundCorners, [-2]: this.boxCorners, [-3]: this.coarseCorners };
    const mesh = shared[key] ?? this.typeMeshes.get(key);
    const group = { mesh, kind: key === -2 ? 0 : key < 0 ? 1 : 2, slots: new Uint32Array(MOST_SHAPES), count: 0, first: 0 };
    this.groups.set(key, group);
    return group;
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
    const steps = this.fixedScale || Math.ceil(20 * this.scale) / 20; // a new size costs a frame: not for every little change
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
    gl.uniform1f(at.fogFrom, this.#fogFrom());
    return at;
  }

  #fogFrom() {
    return 0.35 / (this.camera.distance + 0.35 * Math.min(this.extent, 2000));
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
    const fogFrom = this.#fogFrom();
    this.visible.sort(entities, view, {
      types: this.types, hiddenTypes: this.hiddenTypes, colours: this.colours, colouring: this.colouring,
      chosen, sky: theme.sky, fogFrom, tick, tickSeconds: clock.tickSeconds, width, height, mostShapes: this.mostShapes,
    });
    this.#gatherRows(entities);
    gl.viewport(0, 0, width, height);
    gl.clearColor(...theme.sky, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    this.#drawShapes(view, theme, { tick, tickSeconds: clock.tickSeconds, chosen });
    this.#drawPoints(this.visible.plain, this.shader.plainPoint);
    this.#drawPoints(this.visible.lit, this.shader.capsulePoint);
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

  #drawShapes(view, theme, moment) {
    const gl = this.gl;
    const at = this.#use(this.shader.shape, view, theme);
    this.#entityUniforms(at, moment);
    this.#noAttributes();
    for (const { mesh, kind, first, count } of this.groups.values()) {
      if (count === 0) {
        continue;
      }
      gl.uniform1i(at.kind, kind);
      gl.bindBuffer(gl.ARRAY_BUFFER, mesh.handle);
      this.#attribute(0, 3, gl.FLOAT, 24, 0);
      this.#attribute(1, 3, gl.FLOAT, 24, 12);
      this.#rowAttributes(this.nearRows, first, 1);
      this.#drawMesh(mesh, count);
    }
  }

  #drawPoints(rows, program) {
    const gl = this.gl;
    if (rows.count === 0) {
      return;
    }
    program.use();
    this.#upload(this.pointRows, rows.floats, (POINT_BYTES / 4) * rows.count);
    this.#noAttributes();
    this.#attribute(0, 4, gl.FLOAT, POINT_BYTES, 0);
    this.#attribute(1, 4, gl.UNSIGNED_BYTE, POINT_BYTES, 16, { norm: true });
    gl.drawArrays(gl.POINTS, 0, rows.count);
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
      if (!soft.faces || soft.faces.length === 0 || isRope(soft) || this.hiddenTypes.has(soft.type)) {
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
    this.#placeDoors(tick);
    this.#placePlatforms(tick);
    this.#drawBoxes(this.walls, view, theme);
    this.#drawBoxes(this.doors, view, theme);
    this.#drawBoxes(this.platforms, view, theme);
    for (const surface of this.geometry.drawn) {
      this.#meshUniforms(view, theme, surface.told.p, surface.told.q, theme.terrain, 1);
      this.#noAttributes();
      gl.enableVertexAttribArray(0);
      gl.enableVertexAttribArray(1);
      surface.draw(gl, view);
    }
  }

  #drawBoxes({ cells, corners, index }, view, theme) {
    const gl = this.gl;
    cells.seen(view, this.cellsSeen);
    if (this.cellsSeen.length === 0) {
      return;
    }
    const at = this.#use(this.shader.box, view, theme);
    gl.uniform3fv(at.colour, theme.box);
    this.#noAttributes();
    gl.bindBuffer(gl.ARRAY_BUFFER, corners.handle);
    this.#attribute(0, 4, gl.FLOAT, CORNER_BYTES, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, index);
    for (const { first, count } of this.cellsSeen) {
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 4 * first);
    }
  }

  #drawLines(lines, mode, view, theme, height) {
    const gl = this.gl;
    if (lines.count === 0) {
      return;
    }
    this.#upload(this.lineCorners, lines.bytes, LINE_BYTES * lines.count);
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
