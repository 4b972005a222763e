// Static geometry from the pieces of the scene: boxes, heights and meshes (server/app/admin/spectator_scene.h).

import { flatMesh, smoothNormals } from './meshes.js';

/** More samples of a height grid than this are thinned out, and more triangles are not told apart. */
const MOST_SAMPLES = 700000;
const MOST_FLAT_TRIANGLES = 150000;
const TILE = 32; // cells on a side
/** A cell that is drawn takes about so many pixels at least. */
const CELL_PIXELS = 6;

function turned([x, y, z, w], v) {
  const t = [y * v[2] - z * v[1] + w * v[0], z * v[0] - x * v[2] + w * v[1], x * v[1] - y * v[0] + w * v[2]];
  return [v[0] + 2 * (y * t[2] - z * t[1]), v[1] + 2 * (z * t[0] - x * t[2]), v[2] + 2 * (x * t[1] - y * t[0])];
}

/** One height grid, in tiles that are drawn the coarser the farther they are. */
class HeightSurface {
  constructor(told) {
    this.told = told;
    this.step = 1;
    while (Math.ceil(told.columns / this.step) * Math.ceil(told.rows / this.step) > MOST_SAMPLES) {
      ++this.step;
    }
    this.columns = Math.floor((told.columns - 1) / this.step) + 1;
    this.rows = Math.floor((told.rows - 1) / this.step) + 1;
    this.heights = new Float32Array(this.columns * this.rows);
    this.missing = told.rows;
    this.patterns = new Map();
  }

  /** Takes rows of heights; true once all are there. */
  take(first, count, heights) {
    for (let r = 0; r < count; ++r) {
      const row = first + r;
      if (row % this.step === 0 && row / this.step < this.rows) {
        for (let c = 0; c < this.columns; ++c) {
          this.heights[(row / this.step) * this.columns + c] = heights[r * this.told.columns + c * this.step];
        }
      }
    }
    this.missing -= count;
    return this.missing <= 0;
  }

  get spacing() {
    return [this.told.spacing_x_m * this.step, this.told.spacing_z_m * this.step];
  }

  /** Height at a place of the world; null beside the surface. */
  heightAt(x, z) {
    if (this.missing > 0) {
      return null;
    }
    const [qx, qy, qz, qw] = this.told.q;
    const local = turned([-qx, -qy, -qz, qw], [x - this.told.p[0], 0, z - this.told.p[2]]);
    const i = local[0] / this.spacing[0] + (this.told.columns - 1) / (2 * this.step);
    const k = local[2] / this.spacing[1] + (this.told.rows - 1) / (2 * this.step);
    if (i < 0 || k < 0 || i > this.columns - 1 || k > this.rows - 1) {
      return null;
    }
    const [i0, k0] = [Math.min(Math.floor(i), this.columns - 2), Math.min(Math.floor(k), this.rows - 2)];
    const h = (di, dk) => this.heights[(k0 + dk) * this.columns + i0 + di];
    const [u, v] = [i - i0, k - k0];
    return this.told.p[1] + (h(0, 0) * (1 - u) + h(1, 0) * u) * (1 - v) + (h(0, 1) * (1 - u) + h(1, 1) * u) * v;
  }

  upload(gl) {
    const [sx, sz] = this.spacing;
    const { columns, rows, heights } = this;
    const left = -((this.told.columns - 1) * this.told.spacing_x_m) / 2;
    const top = -((this.told.rows - 1) * this.told.spacing_z_m) / 2;
    const corners = new Float32Array(6 * columns * rows);
    for (let k = 0, at = 0; k < rows; ++k) {
      for (let i = 0; i < columns; ++i, at += 6) {
        const h = (a, b) => heights[Math.min(rows - 1, Math.max(0, b)) * columns + Math.min(columns - 1, Math.max(0, a))];
        const dx = (h(i + 1, k) - h(i - 1, k)) / (2 * sx);
        const dz = (h(i, k + 1) - h(i, k - 1)) / (2 * sz);
        const length = Math.hypot(dx, 1, dz);
        corners.set([left + i * sx, h(i, k), top + k * sz, -dx / length, 1 / length, -dz / length], at);
      }
    }
    this.buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    this.tiles = [];
    for (let k = 0; k + 1 < rows; k += TILE) {
      for (let i = 0; i + 1 < columns; i += TILE) {
        this.tiles.push(this.#tile(i, k, Math.min(TILE, columns - 1 - i), Math.min(TILE, rows - 1 - k), left, top));
      }
    }
  }

  #tile(i, k, wide, deep, left, top) {
    const [sx, sz] = this.spacing;
    let [low, high] = [Infinity, -Infinity];
    for (let b = k; b <= k + deep; ++b) {
      for (let a = i; a <= i + wide; ++a) {
        const h = this.heights[b * this.columns + a];
        low = Math.min(low, h);
        high = Math.max(high, h);
      }
    }
    const middle = turned(this.told.q, [left + (i + wide / 2) * sx, (low + high) / 2, top + (k + deep / 2) * sz]);
    return {
      first: k * this.columns + i,
      wide,
      deep,
      middle: middle.map((v, axis) => v + this.told.p[axis]),
      radius: Math.hypot(wide * sx, high - low, deep * sz) / 2,
    };
  }

  /** Triangles of a tile with so many cells, every `stride`-th sample; they hang over its rim a little. */
  pattern(gl, wide, deep, stride) {
    const key = `${wide},${deep},${stride}`;
    let pattern = this.patterns.get(key);
    if (!pattern) {
      const steps = (count) => {
        const out = [];
        for (let at = 0; at < count; at += stride) {
          out.push(at);
        }
        return [...out, count];
      };
      const [across, along] = [steps(wide), steps(deep)];
      const index = [];
      for (let k = 0; k + 1 < along.length; ++k) {
        for (let i = 0; i + 1 < across.length; ++i) {
          const at = (a, b) => along[k + b] * this.columns + across[i + a];
          index.push(at(0, 0), at(0, 1), at(1, 1), at(0, 0), at(1, 1), at(1, 0));
        }
      }
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(index), gl.STATIC_DRAW);
      pattern = { buffer, count: index.length };
      this.patterns.set(key, pattern);
    }
    return pattern;
  }

  /** The program is in use; `view` tells what is seen. */
  draw(gl, view) {
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    for (const tile of this.tiles) {
      const away = view.distance(tile.middle);
      if (!view.sees(tile.middle, tile.radius)) {
        continue;
      }
      const pixels = (view.pixelsPerMetre * Math.max(...this.spacing)) / Math.max(1, away - tile.radius);
      let stride = 1;
      while (stride < TILE && stride * pixels < CELL_PIXELS) {
        stride *= 2;
      }
      const { buffer, count } = this.pattern(gl, tile.wide, tile.deep, stride);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
      gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 24, 24 * tile.first);
      gl.vertexAttribPointer(1, 3, gl.FLOAT, false, 24, 24 * tile.first + 12);
      gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    }
  }
}

/** One triangle mesh. */
class MeshSurface {
  constructor(told) {
    this.told = told;
    this.vertices = new Float32Array(3 * told.vertices);
    this.corners = new Uint32Array(3 * told.triangles);
    this.missing = told.vertices + told.triangles;
  }

  take(first, count, values) {
    (values instanceof Float32Array ? this.vertices : this.corners).set(values, 3 * first);
    this.missing -= count;
    return this.missing <= 0;
  }

  heightAt() {
    return null;
  }

  upload(gl) {
    let mesh;
    if (this.told.triangles <= MOST_FLAT_TRIANGLES) {
      const soup = new Float32Array(3 * this.corners.length);
      this.corners.forEach((corner, i) => soup.set(this.vertices.subarray(3 * corner, 3 * corner + 3), 3 * i));
      mesh = flatMesh(soup);
    } else {
      const normals = new Float32Array(this.vertices.length);
      smoothNormals(this.vertices, this.corners, normals);
      mesh = new Float32Array(6 * this.corners.length);
      this.corners.forEach((corner, i) => {
        mesh.set(this.vertices.subarray(3 * corner, 3 * corner + 3), 6 * i);
        mesh.set(normals.subarray(3 * corner, 3 * corner + 3), 6 * i + 3);
      });
    }
    this.count = mesh.length / 6;
    this.buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, mesh, gl.STATIC_DRAW);
    this.vertices = this.corners = null;
  }

  draw(gl) {
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 24, 0);
    gl.vertexAttribPointer(1, 3, gl.FLOAT, false, 24, 12);
    gl.drawArrays(gl.TRIANGLES, 0, this.count);
  }
}

/** Gathers the pieces, and says what of the scene is whole. */
export class Geometry {
  constructor(scene) {
    this.boxes = []; // Float32Arrays of ten numbers for each box
    this.typeTriangles = new Map(); // type -> mesh
    this.surfaces = scene.surfaces.map((told) => (told.columns ? new HeightSurface(told) : new MeshSurface(told)));
    this.ready = []; // surfaces that are whole and not uploaded yet
    this.drawn = []; // surfaces that are uploaded
  }

  /** Takes one piece as it came. */
  take(buffer) {
    const [kind, owner, first, count] = new Uint32Array(buffer, 0, 4);
    const floats = () => new Float32Array(buffer, 16);
    if (kind === 1) {
      this.boxes.push(floats());
    } else if (kind === 2) {
      this.typeTriangles.set(owner, flatMesh(floats()));
    } else {
      const surface = this.surfaces[owner];
      const values = kind === 5 ? new Uint32Array(buffer, 16) : floats();
      if (surface.take(first, count, values)) {
        this.ready.push(surface);
      }
    }
  }

  /** Height of the topmost height grid at a place, or `otherwise`. */
  heightAt(x, z, otherwise) {
    let best = otherwise;
    for (const surface of this.surfaces) {
      const height = surface.heightAt(x, z);
      best = height === null ? best : Math.max(best, height);
    }
    return best;
  }
}
