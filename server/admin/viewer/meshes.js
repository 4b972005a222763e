// Meshes: corners with normals, as flat arrays of six numbers.

/** A box with half sizes 1, its faces seen from outside: { corners, index }. */
export function boxMesh() {
  const corners = [];
  const index = [];
  for (let axis = 0; axis < 3; ++axis) {
    for (const side of [-1, 1]) {
      const first = corners.length / 6;
      for (const [a, b] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        const v = [0, 0, 0];
        v[axis] = side;
        v[(axis + 1) % 3] = a;
        v[(axis + 2) % 3] = b;
        corners.push(...v, ...v.map((_, k) => (k === axis ? side : 0)));
      }
      index.push(...(side > 0 ? [0, 1, 2, 0, 2, 3] : [0, 2, 1, 0, 3, 2]).map((i) => first + i));
    }
  }
  return { corners: new Float32Array(corners), index: new Uint16Array(index) };
}

/**
 * A sphere of radius 1 from rings of so many corners; its equator is doubled, so that it can be drawn out to a
 * capsule. Without a bend its caps are cones.
 */
export function roundMesh(around = 8, bend = Math.PI / 4) {
  const bends = bend > 0 ? [bend] : [];
  const heights = [-Math.PI / 2, ...bends.map((h) => -h), -1e-3, 1e-3, ...bends, Math.PI / 2];
  const corners = [];
  const index = [];
  for (const h of heights) {
    for (let a = 0; a < around; ++a) {
      const angle = (2 * Math.PI * a) / around;
      const v = [Math.cos(h) * Math.sin(angle), Math.sin(h), Math.cos(h) * Math.cos(angle)];
      corners.push(...v, ...v);
    }
  }
  for (let r = 0; r + 1 < heights.length; ++r) {
    for (let a = 0; a < around; ++a) {
      const at = (up, on) => (r + up) * around + ((a + on) % around);
      if (r > 0) {
        index.push(at(0, 0), at(0, 1), at(1, 1));
      }
      if (r + 2 < heights.length) {
        index.push(at(0, 0), at(1, 1), at(1, 0));
      }
    }
  }
  return { corners: new Float32Array(corners), index: new Uint16Array(index) };
}

/** Triangles without shared corners get the normals of their planes. */
export function flatMesh(corners) {
  const out = new Float32Array(2 * corners.length);
  for (let t = 0; t + 8 < corners.length; t += 9) {
    const edge = (to, k) => corners[t + 3 * to + k] - corners[t + k];
    const normal = [0, 1, 2].map((k) => {
      const [i, j] = [(k + 1) % 3, (k + 2) % 3];
      return edge(1, i) * edge(2, j) - edge(1, j) * edge(2, i);
    });
    const length = Math.hypot(...normal) || 1;
    for (let c = 0; c < 3; ++c) {
      for (let k = 0; k < 3; ++k) {
        out[2 * t + 6 * c + k] = corners[t + 3 * c + k];
        out[2 * t + 6 * c + 3 + k] = normal[k] / length;
      }
    }
  }
  return out;
}

/** Shared corners get the mean normal of their triangles; `normals` is overwritten. */
export function smoothNormals(places, faces, normals) {
  normals.fill(0);
  for (let f = 0; f + 2 < faces.length; f += 3) {
    const [a, b, c] = [3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]];
    const ux = places[b] - places[a], uy = places[b + 1] - places[a + 1], uz = places[b + 2] - places[a + 2];
    const vx = places[c] - places[a], vy = places[c + 1] - places[a + 1], vz = places[c + 2] - places[a + 2];
    const n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const corner of [a, b, c]) {
      normals[corner] += n[0];
      normals[corner + 1] += n[1];
      normals[corner + 2] += n[2];
    }
  }
  for (let v = 0; v < normals.length; v += 3) {
    const length = Math.hypot(normals[v], normals[v + 1], normals[v + 2]) || 1;
    normals[v] /= length;
    normals[v + 1] /= length;
    normals[v + 2] /= length;
  }
}

/** A colour for a number, evenly spread around the circle of hues: parts from 0 to 1. */
export function spreadColour(number) {
  const hue = (number * 0.61803398875 + 0.58) % 1;
  const part = (offset) => Math.min(1, Math.max(0, Math.abs(6 * ((hue + offset) % 1) - 3) - 1));
  return [part(0), part(2 / 3), part(1 / 3)].map((c) => 0.28 + 0.6 * c);
}

/** The same as a colour of CSS. */
export function spreadColourText(number) {
  return `rgb(${spreadColour(number).map((c) => Math.round(255 * c)).join()})`;
}
