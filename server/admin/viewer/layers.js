// The server tells these beside entities (server/admin/spectator/spectator_layers.h).

const HEAD_BYTES = 16;

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
    }
  }

  #takeSofts(buffer, count, entities) {
    const seen = new Set();
    let at = HEAD_BYTES;
    for (let i = 0; i < count; ++i) {
      const [entity, vertices, faces] = new Uint32Array(buffer, at, 3);
      const soft = this.renderer.softs.get(entity) ?? {};
      soft.places = new Float32Array(buffer, at + 12, 3 * vertices);
      at += 12 + 12 * vertices;
      if (faces > 0) {
        soft.faces = new Uint32Array(buffer, at, 3 * faces).slice();
        at += 12 * faces;
      }
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

  /** Joints and ghosts as lines. */
  draw(lines) {
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
