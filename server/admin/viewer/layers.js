// The server tells these beside entities (server/admin/spectator/spectator_layers.h).

import { drawRopes } from './softs.js';

const HEAD_BYTES = 16;
const HUNG_BYTES = 36; // four nodes, four weights, an offset along the normal of the first three

/** Unit normal of a triangle of nodes; `out` has room for it. Makes no garbage: it runs for each vertex of a picture. */
function normalOf(nodes, a, b, c, out) {
  const along = (to, axis) => nodes[3 * to + (axis % 3)] - nodes[3 * a + (axis % 3)];
  for (let k = 0; k < 3; ++k) {
    out[k] = along(b, k + 1) * along(c, k + 2) - along(b, k + 2) * along(c, k + 1);
  }
  const length = Math.hypot(out[0], out[1], out[2]) || 1;
  for (let k = 0; k < 3; ++k) {
    out[k] /= length;
  }
}

/** Where drawn vertices are that hang on nodes. */
function placesOf(hung, nodes) {
  const ids = new Uint32Array(hung);
  const numbers = new Float32Array(hung);
  const places = new Float32Array(3 * (hung.byteLength / HUNG_BYTES));
  const normal = [0, 0, 0];
  for (let at = 0, out = 0; out < places.length; at += HUNG_BYTES / 4, out += 3) {
    for (let k = 0; k < 4; ++k) {
      for (let axis = 0; axis < 3; ++axis) {
        places[out + axis] += numbers[at + 4 + k] * nodes[3 * ids[at + k] + axis];
      }
    }
    const offset = numbers[at + 8];
    if (offset !== 0) {
      normalOf(nodes, ids[at], ids[at + 1], ids[at + 2], normal);
      for (let axis = 0; axis < 3; ++axis) {
        places[out + axis] += offset * normal[axis];
      }
    }
  }
  return places;
}

export class Layers {
  constructor(renderer) {
    this.renderer = renderer;
    this.clear();
  }

  clear() {
    this.joints = new Float32Array(0);
    this.ghosts = new Float32Array(0);
    this.particles = 0;
    this.renderer.softs.clear();
    this.renderer.points.clear();
  }

  take(kind, buffer, entities) {
    const count = new Uint32Array(buffer, 8, 1)[0];
    if (kind === 3) {
      this.joints = new Float32Array(buffer, HEAD_BYTES, 9 * count);
    } else if (kind === 4) {
      this.#takeSofts(buffer, count, entities);
    } else if (kind === 5) {
      this.#takeParticles(new Float32Array(buffer, HEAD_BYTES, 3 * count));
    } else if (kind === 6) {
      this.ghosts = new Float32Array(buffer, HEAD_BYTES, 4 * count);
    } else if (kind === 7) {
      this.renderer.moveByRules(new Uint32Array(buffer, HEAD_BYTES, count), new Int32Array(buffer, HEAD_BYTES + 4 * count));
    }
  }

  #takeSofts(buffer, count, entities) {
    const seen = new Set();
    let at = HEAD_BYTES;
    for (let i = 0; i < count; ++i) {
      const [entity, nodes, faces, hung] = new Uint32Array(buffer, at, 4);
      const soft = this.renderer.softs.get(entity) ?? {};
      soft.nodes = new Float32Array(buffer, at + 16, 3 * nodes);
      at += 16 + 12 * nodes;
      if (faces > 0) {
        soft.faces = new Uint32Array(buffer, at, 3 * faces).slice();
        at += 12 * faces;
        soft.hung = buffer.slice(at, at + HUNG_BYTES * hung);
        at += HUNG_BYTES * hung;
      }
      soft.places = soft.hung?.byteLength > 0 ? placesOf(soft.hung, soft.nodes) : soft.nodes;
      const slot = entities.slotOf.get(entity);
      soft.type = slot === undefined ? soft.type : entities.type(slot);
      this.renderer.softs.set(entity, soft);
      seen.add(entity);
    }
    for (const entity of this.renderer.softs.keys()) {
      if (!seen.has(entity)) {
        this.renderer.softs.delete(entity);
      }
    }
  }

  #takeParticles(places) {
    const { points } = this.renderer;
    points.clear();
    for (let i = 0; i < places.length; i += 3) {
      points.corner(places.subarray(i, i + 3), [150, 170, 205, 255]);
    }
    this.particles = places.length / 3;
  }

  /** Joints, ropes and ghosts as lines. */
  draw(lines) {
    drawRopes(this.renderer.softs, lines);
    const j = this.joints;
    for (let i = 0; i < j.length; i += 9) {
      lines.line(j.subarray(i, i + 3), j.subarray(i + 3, i + 6), [255, 150, 40, 255]);
      lines.line(j.subarray(i + 3, i + 6), j.subarray(i + 6, i + 9), [255, 200, 90, 255]);
    }
    for (let i = 0; i < this.ghosts.length; i += 4) {
      lines.cross([this.ghosts[i], this.ghosts[i + 1], this.ghosts[i + 2]], 0.6, [190, 90, 220, 255]);
    }
  }
}
