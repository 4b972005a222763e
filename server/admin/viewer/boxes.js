// Boxes that never move, and doors: their corners as they stand, in cells that are drawn nearest first.
// Instances would be less memory, but a graphics card made of software takes longer for each than for its corners.

import { boxMesh } from './meshes.js';

/** So many boxes at most are one cell: what is drawn or left out as a whole. */
const CELL_BOXES = 32;
const CORNER_WORDS = 4;
export const BOX_NUMBERS = 10; // place, half sizes, turn
export const CORNER_BYTES = 4 * CORNER_WORDS;

/** Splits boxes at their longest side's middle until each part is small: lists of box numbers. */
function cellsOf(boxes, numbers, out) {
  if (numbers.length <= CELL_BOXES) {
    out.push(numbers);
    return out;
  }
  const range = [0, 2].map((axis) => {
    let [low, high] = [Infinity, -Infinity];
    for (const n of numbers) {
      low = Math.min(low, boxes[BOX_NUMBERS * n + axis]);
      high = Math.max(high, boxes[BOX_NUMBERS * n + axis]);
    }
    return high - low;
  });
  const axis = range[0] >= range[1] ? 0 : 2;
  const sorted = numbers.sort((a, b) => boxes[BOX_NUMBERS * a + axis] - boxes[BOX_NUMBERS * b + axis]);
  const half = sorted.length >> 1;
  cellsOf(boxes, sorted.slice(0, half), out);
  cellsOf(boxes, sorted.slice(half), out);
  return out;
}

export class BoxCells {
  constructor() {
    this.clear();
    const mesh = boxMesh();
    this.mesh = mesh;
    this.cornersPerBox = mesh.corners.length / 6;
  }

  clear() {
    this.cells = []; // { first and count of the index, middle, radius, away }
    this.corners = new Float32Array(0); // x, y, z from the origin, light
    this.index = new Uint32Array(0);
  }

  /** `boxes`: ten numbers each, of the world; `light(x, y, z)` of a normal. */
  build(boxes, origin, light) {
    const count = boxes.length / BOX_NUMBERS;
    const parts = count > 0 ? cellsOf(boxes, Array.from({ length: count }, (_, i) => i), []) : [];
    this.corners = new Float32Array(CORNER_WORDS * this.cornersPerBox * count);
    this.index = new Uint32Array(this.mesh.index.length * count);
    let row = 0;
    this.cells = parts.map((numbers) => {
      const first = row * this.mesh.index.length;
      const low = [Infinity, Infinity, Infinity];
      const high = [-Infinity, -Infinity, -Infinity];
      for (const n of numbers) {
        this.#add(row++, boxes.subarray(BOX_NUMBERS * n, BOX_NUMBERS * (n + 1)), origin, light, low, high);
      }
      const middle = low.map((v, k) => (v + high[k]) / 2 + origin[k]);
      const radius = Math.hypot(...low.map((v, k) => (high[k] - v) / 2));
      return { first, count: numbers.length * this.mesh.index.length, middle, radius, away: 0 };
    });
  }

  #add(row, [px, py, pz, sx, sy, sz, qx, qy, qz, qw], origin, light, low, high) {
    const turned = (x, y, z) => {
      const tx = qy * z - qz * y + qw * x;
      const ty = qz * x - qx * z + qw * y;
      const tz = qx * y - qy * x + qw * z;
      return [x + 2 * (qy * tz - qz * ty), y + 2 * (qz * tx - qx * tz), z + 2 * (qx * ty - qy * tx)];
    };
    const place = [px - origin[0], py - origin[1], pz - origin[2]];
    const { corners, index } = this.mesh;
    const firstCorner = row * this.cornersPerBox;
    for (let c = 0; c < this.cornersPerBox; ++c) {
      const at = turned(corners[6 * c] * sx, corners[6 * c + 1] * sy, corners[6 * c + 2] * sz);
      const to = CORNER_WORDS * (firstCorner + c);
      for (let k = 0; k < 3; ++k) {
        const v = place[k] + at[k];
        this.corners[to + k] = v;
        low[k] = Math.min(low[k], v);
        high[k] = Math.max(high[k], v);
      }
      this.corners[to + 3] = light(...turned(corners[6 * c + 3], corners[6 * c + 4], corners[6 * c + 5]));
    }
    for (let i = 0; i < index.length; ++i) {
      this.index[row * index.length + i] = firstCorner + index[i];
    }
  }

  /** Fills `out` with the cells within the picture, nearest first: what they hide costs less then. */
  seen(view, out) {
    out.length = 0;
    for (const cell of this.cells) {
      if (view.sees(cell.middle, cell.radius)) {
        cell.away = view.distance(cell.middle);
        out.push(cell);
      }
    }
    out.sort((a, b) => a.away - b.away);
  }
}
