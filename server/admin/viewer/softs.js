// Soft bodies whose faces are segments: ropes, which are drawn as lines.

const COLOUR = [200, 170, 120, 255];
const place = [0, 0, 0]; // makes no garbage: it is filled for each corner of a picture

function corner(lines, places, node) {
  for (let axis = 0; axis < 3; ++axis) {
    place[axis] = places[3 * node + axis];
  }
  lines.corner(place, COLOUR);
}

export function isRope({ faces }) {
  return faces?.length > 0 && faces[1] === faces[2];
}

export function drawRopes(softs, lines) {
  for (const soft of softs.values()) {
    if (isRope(soft)) {
      const { faces, places } = soft;
      for (let f = 0; f < faces.length; f += 3) {
        corner(lines, places, faces[f]);
        corner(lines, places, faces[f + 1]);
      }
    }
  }
}
