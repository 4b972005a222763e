// The camera: an orbit about a point, and the same point seen from above.

/** Column-major 4 x 4 product a b. */
export function multiply(a, b) {
  const out = new Float32Array(16);
  for (let c = 0; c < 4; ++c) {
    for (let r = 0; r < 4; ++r) {
      let sum = 0;
      for (let k = 0; k < 4; ++k) {
        sum += a[4 * k + r] * b[4 * c + k];
      }
      out[4 * c + r] = sum;
    }
  }
  return out;
}

const ANGLE = 0.9; // rad, from the lowest line of the picture to the highest

function perspective(aspect, near, far) {
  const f = 1 / Math.tan(ANGLE / 2);
  return new Float32Array([
    f / aspect, 0, 0, 0, 0, f, 0, 0,
    0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0,
  ]);
}

/** One frame's sight: the matrix for places relative to `origin`, and tests by it. */
class View {
  constructor(camera, aspect, origin) {
    this.eye = camera.eye();
    this.origin = origin;
    const pitch = camera.above ? 1.5707 : camera.pitch;
    this.level = Math.sin(pitch); // of what lies flat, so much is seen
    this.upright = Math.cos(pitch);
    this.matrix = camera.matrix(aspect, origin);
    const m = this.matrix;
    // Gribb and Hartmann: the planes of the picture's sides are sums of the matrix' rows.
    this.planes = [[1, 0], [-1, 0], [1, 1], [-1, 1], [1, 2]].map(([sign, row]) => {
      const plane = [0, 1, 2, 3].map((c) => m[4 * c + 3] + sign * m[4 * c + row]);
      const length = Math.hypot(plane[0], plane[1], plane[2]);
      return plane.map((v) => v / length);
    });
  }

  distance(p) {
    return Math.hypot(p[0] - this.eye[0], p[1] - this.eye[1], p[2] - this.eye[2]);
  }

  /** Whether a ball may be within the picture. */
  sees(p, radius) {
    const [x, y, z] = [p[0] - this.origin[0], p[1] - this.origin[1], p[2] - this.origin[2]];
    for (const plane of this.planes) {
      if (plane[0] * x + plane[1] * y + plane[2] * z + plane[3] < -radius) {
        return false;
      }
    }
    return true;
  }
}

export class Camera {
  constructor() {
    this.target = [0, 0, 0];
    this.distance = 60; // m
    this.yaw = 0.6; // rad
    this.pitch = 0.6; // rad above the horizon
    this.above = false;
  }

  /** Looks at a rectangle of the ground. */
  frame(minX, minZ, maxX, maxZ, height) {
    this.target = [(minX + maxX) / 2, height, (minZ + maxZ) / 2];
    this.distance = 0.72 * Math.max(maxX - minX, maxZ - minZ, 10);
  }

  turn(dx, dy) {
    this.yaw -= 0.006 * dx;
    this.pitch = Math.min(1.5, Math.max(0.03, this.pitch + 0.006 * dy));
  }

  /** Moves the target along the ground, by pixels. */
  shift(dx, dy) {
    const scale = 0.0016 * this.distance;
    const yaw = this.above ? 0 : this.yaw;
    const s = Math.sin(yaw);
    const c = Math.cos(yaw);
    this.target[0] -= scale * (dx * c + dy * s);
    this.target[2] -= scale * (-dx * s + dy * c);
  }

  zoom(factor) {
    this.distance = Math.min(20000, Math.max(1.5, this.distance * factor));
  }

  eye() {
    const yaw = this.above ? 0 : this.yaw;
    const pitch = this.above ? 1.5707 : this.pitch;
    return [
      this.target[0] + this.distance * Math.cos(pitch) * Math.sin(yaw),
      this.target[1] + this.distance * Math.sin(pitch),
      this.target[2] + this.distance * Math.cos(pitch) * Math.cos(yaw),
    ];
  }

  view(aspect, origin) {
    return new View(this, aspect, origin);
  }

  /** View and projection in one; positions are relative to `origin`, where floats are fine. */
  matrix(aspect, origin) {
    const yaw = this.above ? 0 : this.yaw;
    const pitch = this.above ? 1.5707 : this.pitch;
    const eye = this.eye().map((v, i) => v - origin[i]);
    const sy = Math.sin(yaw), cy = Math.cos(yaw), sp = Math.sin(pitch), cp = Math.cos(pitch);
    const right = [cy, 0, -sy];
    const up = [-sp * sy, cp, -sp * cy];
    const back = [cp * sy, sp, cp * cy];
    const dot = (a) => a[0] * eye[0] + a[1] * eye[1] + a[2] * eye[2];
    const view = new Float32Array([
      right[0], up[0], back[0], 0, right[1], up[1], back[1], 0,
      right[2], up[2], back[2], 0, -dot(right), -dot(up), -dot(back), 1,
    ]);
    const near = Math.max(0.05, 0.02 * this.distance);
    return multiply(perspective(aspect, near, 12 * this.distance + 3000), view);
  }

  /** Pixels that a metre takes at a distance of a metre, for a picture of so many pixels' height. */
  static pixelsPerMetre(height) {
    return height / (2 * Math.tan(ANGLE / 2));
  }
}
