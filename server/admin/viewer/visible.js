// Sorts the entities of one frame: near ones are drawn as their shapes, far ones as points that are placed here.

import { AT_REST } from './entities.js';

/** Smaller than these radii, in pixels, an entity is a point. A round one looks like its point for longer. */
const LEAST_SHAPE_PIXELS = { round: 10, box: 5, solid: 5, soft: 5 };
/** Smaller than this, in pixels, a point is a plain square: nobody sees more. */
const PLAIN_PIXELS = 4;
const LEAST_PIXELS = 2.5;
const MOST_PIXELS = 48;
const HIDDEN = -1;
const CHOSEN = [1, 0.95, 0.35];
export const POINT_BYTES = 20;

/** Points as the graphics card takes them: x, y, z of the picture, pixels; colour and how slim. */
class PointRows {
  constructor() {
    this.#allocate(1024);
  }

  #allocate(rows) {
    this.floats = new Float32Array((POINT_BYTES / 4) * rows);
    this.bytes = new Uint8Array(this.floats.buffer);
    this.count = 0;
  }

  /** Makes room for so many rows; what it held is gone. */
  reserve(rows) {
    if (POINT_BYTES * rows > this.bytes.length) {
      this.#allocate(2 ** Math.ceil(Math.log2(rows)));
    }
    this.count = 0;
  }
}

export function hue(h) {
  const part = (offset) => Math.min(1, Math.max(0, Math.abs(6 * ((h + offset) % 1) - 3) - 1));
  return [part(0), part(0.6667), part(0.3333)];
}

/** Base colours as the shaders mix them (shaders.js, ENTITY): three parts for each type, awake and at rest, and zone. */
export class Colours {
  constructor(typeColours) {
    this.types = new Float32Array(6 * typeColours.length);
    typeColours.forEach((c, i) => {
      this.types.set(c, 6 * i);
      this.types.set(c.map((v) => (0.45 * v + 0.55 * 0.55) * 0.85), 6 * i + 3);
    });
    this.zones = new Float32Array(6 * 256);
    for (let zone = 0; zone < 256; ++zone) {
      const c = hue((zone * 0.618) % 1).map((v) => 0.25 + 0.65 * v);
      this.zones.set(c, 6 * zone);
      this.zones.set(c.map((v) => (0.45 * v + 0.55 * 0.55) * 0.85), 6 * zone + 3);
    }
    const steps = [[0.25, 0.45, 0.75], [0.95, 0.8, 0.3], [0.9, 0.2, 0.15]];
    this.loads = new Float32Array(3 * 256);
    for (let i = 0; i < 256; ++i) {
      const load = i / 255;
      const far = load < 0.5 ? steps[1] : steps[2];
      this.loads.set(steps[0].map((v, k) => v + (far[k] - v) * Math.min(1, 2 * load)), 3 * i);
    }
  }
}

export class Visible {
  constructor() {
    this.near = new Uint32Array(1024); // slots of shapes, the first `nearCount`
    this.nearCount = 0;
    this.squared = new Float32Array(1024); // their distances, squared
    this.sorted = new Float32Array(1024);
    this.plain = new PointRows();
    this.lit = new PointRows();
    this.taken = new Uint32Array(0); // by cell of the picture: the frame whose plain point it holds
    this.across = 0;
    this.frame = 0;
    this.limits = new Float32Array(0); // by type: squared distance within which it is a shape
  }

  #reserve(entities, { types, hiddenTypes, width, height }, pixelsPerMetre) {
    this.across = Math.ceil(width / LEAST_PIXELS) + 1;
    const cells = this.across * (Math.ceil(height / LEAST_PIXELS) + 1);
    if (this.taken.length < cells) {
      this.taken = new Uint32Array(cells);
    }
    ++this.frame;
    if (this.near.length < entities.end) {
      this.near = new Uint32Array(entities.capacity);
      this.squared = new Float32Array(entities.capacity);
      this.sorted = new Float32Array(entities.capacity);
    }
    this.plain.reserve(entities.end);
    this.lit.reserve(entities.end);
    if (this.limits.length !== types.length) {
      this.limits = new Float32Array(types.length);
      this.radii = new Float32Array(types.length);
    }
    for (let i = 0; i < types.length; ++i) {
      this.limits[i] = hiddenTypes.has(i) ? HIDDEN : ((types[i].radius * pixelsPerMetre) / LEAST_SHAPE_PIXELS[types[i].shape]) ** 2;
      this.radii[i] = types[i].radius;
    }
    this.nearCount = 0;
  }

  /**
   * `view`: of camera.js; `look`: { types, hiddenTypes, colours, colouring, chosen, sky, fogFrom, tick,
   * tickSeconds, width, height, mostShapes }. Entities beside the picture are left out.
   */
  sort(entities, view, look) {
    this.#reserve(entities, look, view.pixelsPerMetre);
    this.#place(entities, view, look);
    if (this.nearCount > look.mostShapes) {
      this.#keepNearest(entities, view, look);
    }
  }

  #place(entities, view, look) {
    const { words, bytes, shorts, floats } = entities;
    const { tick, tickSeconds } = look;
    const [ex, ey, ez] = view.eye;
    const planes = view.planes;
    for (let slot = 0; slot < entities.end; ++slot) {
      const at = 10 * slot;
      if ((bytes[40 * slot + 36] & 128) !== 0) {
        continue;
      }
      const type = shorts[2 * at + 15];
      if (this.limits[type] === HIDDEN) {
        continue;
      }
      const elapsed = tickSeconds * (tick - words[at + 3]);
      const x = floats[at] + entities.velocity(slot, 0) * elapsed - view.origin[0];
      const y = floats[at + 1] + entities.velocity(slot, 1) * elapsed - view.origin[1];
      const z = floats[at + 2] + entities.velocity(slot, 2) * elapsed - view.origin[2];
      const radius = this.radii[type];
      let seen = true;
      for (let p = 0; p < 5 && seen; ++p) {
        const plane = planes[p];
        seen = plane[0] * x + plane[1] * y + plane[2] * z + plane[3] >= -radius;
      }
      if (!seen) {
        continue;
      }
      const dx = x + view.origin[0] - ex;
      const dy = y + view.origin[1] - ey;
      const dz = z + view.origin[2] - ez;
      const squared = dx * dx + dy * dy + dz * dz;
      if (squared < this.limits[type]) {
        this.near[this.nearCount] = slot;
        this.squared[this.nearCount++] = squared;
      } else {
        this.#addPoint(entities, slot, type, x, y, z, view, look);
      }
    }
  }

  /** Of too many shapes the nearest stay, and the others become points. */
  #keepNearest(entities, view, look) {
    const count = this.nearCount;
    this.sorted.set(this.squared.subarray(0, count));
    const limit = this.sorted.subarray(0, count).sort()[look.mostShapes];
    const place = [0, 0, 0];
    this.nearCount = 0;
    for (let i = 0; i < count; ++i) {
      const slot = this.near[i];
      if (this.squared[i] < limit) {
        this.squared[this.nearCount] = this.squared[i];
        this.near[this.nearCount++] = slot;
      } else {
        entities.place(slot, look.tick, look.tickSeconds, place);
        this.#addPoint(entities, slot, entities.type(slot), place[0] - view.origin[0],
          place[1] - view.origin[1], place[2] - view.origin[2], view, look);
      }
    }
  }

  /** The place is relative to the view's origin. */
  #addPoint(entities, slot, type, x, y, z, view, look) {
    const m = view.matrix;
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    if (w <= 0) {
      return;
    }
    const { shape, size } = look.types[type];
    const wide = Math.max(size[0], size[2]);
    const high = shape === 'round' ? size[1] * view.upright + size[0] : size[1] * view.upright + wide * view.level;
    const most = Math.max(wide, high);
    const pixels = Math.min(MOST_PIXELS, Math.max(LEAST_PIXELS, (2 * view.pixelsPerMetre * most) / w));
    const px = (m[0] * x + m[4] * y + m[8] * z + m[12]) / w;
    const py = (m[1] * x + m[5] * y + m[9] * z + m[13]) / w;
    const plain = pixels < PLAIN_PIXELS;
    if (plain && this.#isTaken(px, py, look) && entities.id(slot) !== look.chosen) {
      return;
    }
    const rows = plain ? this.plain : this.lit;
    const at = 5 * rows.count++;
    const out = rows.floats;
    out[at] = px;
    out[at + 1] = py;
    out[at + 2] = (m[2] * x + m[6] * y + m[10] * z + m[14]) / w;
    out[at + 3] = pixels;
    this.#paint(rows.bytes, 4 * at + 16, entities, slot, type, w, plain ? 0.9 : 1, look);
    rows.bytes[4 * at + 19] = Math.min(255, Math.max(64, (255 * wide) / most));
  }

  /** Whether another plain point lies there already, one upon the other; from now on one does. */
  #isTaken(px, py, { width, height }) {
    const column = Math.min(this.across - 1, Math.max(0, ((0.5 + 0.5 * px) * width) / LEAST_PIXELS)) | 0;
    const row = Math.max(0, ((0.5 + 0.5 * py) * height) / LEAST_PIXELS) | 0;
    const cell = row * this.across + column;
    if (this.taken[cell] === this.frame) {
      return true;
    }
    this.taken[cell] = this.frame;
    return false;
  }

  #paint(bytes, to, entities, slot, type, w, light, look) {
    const { colours, sky } = look;
    let from = colours.types;
    let first = 6 * type;
    if (entities.id(slot) === look.chosen) {
      from = CHOSEN;
      first = 0;
    } else if (look.colouring === 'load') {
      from = colours.loads;
      first = 3 * Math.min(255, Math.floor(entities.heat[slot] * 25.6));
    } else {
      if (look.colouring === 'zone') {
        from = colours.zones;
        first = 6 * entities.zone(slot);
      }
      first += entities.flags(slot) & AT_REST ? 3 : 0;
    }
    const fog = Math.min(0.8, Math.max(0, w * look.fogFrom - 0.5));
    for (let k = 0; k < 3; ++k) {
      bytes[to + k] = 255 * (light * from[first + k] * (1 - fog) + sky[k] * fog);
    }
  }
}
