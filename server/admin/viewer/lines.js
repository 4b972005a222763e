// Lines: corners with colours, gathered anew for each frame and drawn at once.

export const LINE_BYTES = 16;

export class Lines {
  constructor() {
    this.clear();
    this.floats = new Float32Array(4096);
    this.bytes = new Uint8Array(this.floats.buffer);
  }

  clear() {
    this.count = 0; // corners
  }

  /** One corner; colour parts from 0 to 255. */
  corner(p, colour) {
    if (4 * (this.count + 1) > this.floats.length) {
      const grown = new Float32Array(2 * this.floats.length);
      grown.set(this.floats);
      this.floats = grown;
      this.bytes = new Uint8Array(grown.buffer);
    }
    this.floats[4 * this.count] = p[0];
    this.floats[4 * this.count + 1] = p[1];
    this.floats[4 * this.count + 2] = p[2];
    this.bytes.set(colour, LINE_BYTES * this.count + 12);
    ++this.count;
  }

  line(a, b, colour) {
    this.corner(a, colour);
    this.corner(b, colour);
  }

  /** A circle about a place, level; with an arc of less than a turn its ends join the middle. */
  circle(p, radius, colour, from = 0, arc = 2 * Math.PI) {
    const steps = Math.max(8, Math.ceil((48 * arc) / (2 * Math.PI)));
    const at = (i) => {
      const angle = from + (arc * i) / steps;
      return [p[0] + radius * Math.sin(angle), p[1], p[2] + radius * Math.cos(angle)];
    };
    for (let i = 0; i < steps; ++i) {
      this.line(at(i), at(i + 1), colour);
    }
    if (arc < 2 * Math.PI) {
      this.line(p, at(0), colour);
      this.line(p, at(steps), colour);
    }
  }

  cross(p, arm, colour) {
    for (let axis = 0; axis < 3; ++axis) {
      const to = (sign) => p.map((v, k) => (k === axis ? v + sign * arm : v));
      this.line(to(-1), to(1), colour);
    }
  }
}
