// The entities as the server's messages tell them (server/admin/spectator/spectator_hub.h): rows of bytes that
// the graphics card reads as they are.

export const ROW_BYTES = 40;
const ROW_WORDS = ROW_BYTES / 4;
const HEAD_WORDS = 4;

export const AT_REST = 1;
export const AVATAR = 2;
export const OFF_SCREEN = 4;
/** Set here alone: the slot holds no entity. */
const FREE = 128;

const halfFloats = (() => {
  const out = new Float32Array(65536);
  for (let i = 0; i < 65536; ++i) {
    const exponent = (i >> 10) & 31;
    const fraction = i & 1023;
    const size = exponent === 0 ? fraction * 2 ** -24
      : exponent === 31 ? (fraction ? NaN : Infinity)
        : (1 + fraction / 1024) * 2 ** (exponent - 15);
    out[i] = i & 32768 ? -size : size;
  }
  return out;
})();

export class Entities {
  constructor() {
    this.#allocate(1024);
    this.clear();
  }

  #allocate(slots) {
    this.capacity = slots;
    const old = this.words;
    this.words = new Uint32Array(ROW_WORDS * slots);
    if (old) {
      this.words.set(old);
    }
    this.floats = new Float32Array(this.words.buffer);
    this.shorts = new Uint16Array(this.words.buffer);
    this.parts = new Int16Array(this.words.buffer);
    this.bytes = new Uint8Array(this.words.buffer);
    const heat = this.heat;
    this.heat = new Float32Array(slots); // times told of late
    if (heat) {
      this.heat.set(heat);
    }
  }

  clear() {
    this.slotOf = new Map(); // entity -> slot
    this.end = 0; // one more than the largest slot in use
    this.tick = 0;
    this.told = 0; // rows so far
    this.heat.fill(0);
    for (let slot = 0; slot < this.capacity; ++slot) {
      this.bytes[ROW_BYTES * slot + 36] = FREE;
    }
  }

  get size() {
    return this.slotOf.size;
  }

  /** Takes one message of kind 1 or 2; throws on anything malformed. */
  take(buffer) {
    const message = new Uint32Array(buffer, 0, buffer.byteLength >> 2);
    const [kind, tick, removed, rows] = message;
    if (buffer.byteLength !== 4 * (HEAD_WORDS + removed + (1 + ROW_WORDS) * rows)) {
      throw new Error('a message of the server is malformed');
    }
    if (kind === 1) {
      this.clear();
    }
    this.tick = tick;
    let at = HEAD_WORDS;
    for (let i = 0; i < removed; ++i, ++at) {
      this.#remove(message[at]);
    }
    for (let i = 0; i < rows; ++i, at += 1 + ROW_WORDS) {
      this.#put(message, at);
    }
    this.told += rows;
  }

  #remove(slot) {
    this.slotOf.delete(this.id(slot));
    this.bytes[ROW_BYTES * slot + 36] = FREE;
    this.heat[slot] = 0;
  }

  #put(message, at) {
    const slot = message[at];
    if (slot >= this.capacity) {
      const before = this.capacity;
      this.#allocate(2 ** Math.ceil(Math.log2(slot + 1)));
      for (let free = before; free < this.capacity; ++free) {
        this.bytes[ROW_BYTES * free + 36] = FREE;
      }
    }
    const to = ROW_WORDS * slot;
    const id = message[at + 9];
    if (this.words[to + 8] !== id || this.isFree(slot)) {
      this.slotOf.set(id, slot);
    }
    for (let k = 0; k < ROW_WORDS; ++k) {
      this.words[to + k] = message[at + 1 + k];
    }
    this.heat[slot] += 1;
    this.end = Math.max(this.end, slot + 1);
  }

  /** Lets the heat of all fade by a factor, and writes it where the shaders read it. */
  fade(factor) {
    for (let slot = 0; slot < this.end; ++slot) {
      this.heat[slot] *= factor;
      this.shorts[20 * slot + 19] = Math.min(65535, 256 * this.heat[slot]);
    }
  }

  isFree(slot) {
    return (this.bytes[ROW_BYTES * slot + 36] & FREE) !== 0;
  }

  id(slot) {
    return this.words[ROW_WORDS * slot + 8];
  }

  type(slot) {
    return this.shorts[20 * slot + 15];
  }

  flags(slot) {
    return this.bytes[ROW_BYTES * slot + 36];
  }

  zone(slot) {
    return this.bytes[ROW_BYTES * slot + 37];
  }

  /** Speed along an axis, m/s. */
  velocity(slot, axis) {
    return halfFloats[this.shorts[20 * slot + 12 + axis]];
  }

  orientation(slot) {
    return [0, 1, 2, 3].map((k) => this.parts[20 * slot + 8 + k] / 32767);
  }

  /** World coordinates at a (broken) tick, m, into `out`. */
  place(slot, tick, tickSeconds, out = [0, 0, 0]) {
    const from = ROW_WORDS * slot;
    const elapsed = tickSeconds * (tick - this.words[from + 3]);
    for (let axis = 0; axis < 3; ++axis) {
      out[axis] = this.floats[from + axis] + this.velocity(slot, axis) * elapsed;
    }
    return out;
  }
}
