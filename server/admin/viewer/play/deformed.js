// Soft bodies as a player's client hears of them: the page has their undeformed surfaces and deforms them for each picture.

/** By type; of others nothing. `told`: the types of play.json, by name. */
export function surfacesOf(types, told) {
  return types.map(({ name }) => {
    const surface = told.get(name)?.surface;
    return surface && { places: Float32Array.from(surface.places), faces: Uint32Array.from(surface.faces) };
  });
}

/** Turns places by a quaternion and moves them, without garbage: it runs for each vertex of a picture. */
function pose(places, [x, y, z, w], [mx, my, mz]) {
  for (let at = 0; at < places.length; at += 3) {
    const a = places[at];
    const b = places[at + 1];
    const c = places[at + 2];
    const tx = y * c - z * b + w * a;
    const ty = z * a - x * c + w * b;
    const tz = x * b - y * a + w * c;
    places[at] = mx + a + 2 * (y * tz - z * ty);
    places[at + 1] = my + b + 2 * (z * tx - x * tz);
    places[at + 2] = mz + c + 2 * (x * ty - y * tx);
  }
}

/** Brings `softs` (entity -> { places, faces, type }) up to the entities that are displayed. */
export function deformSofts(softs, surfaces, entities, client) {
  const seen = new Set();
  for (const [entity, slot] of entities.slotOf) {
    const type = entities.type(slot);
    const surface = surfaces[type];
    if (!surface) {
      continue;
    }
    const soft = softs.get(entity) ?? { places: new Float32Array(surface.places.length), faces: surface.faces, type };
    soft.places.set(surface.places);
    if (!client.deform(entity, soft.places)) {
      continue;
    }
    const move = entities.place(slot, entities.tick, 0);
    const orientation = entities.orientation(slot);
    pose(soft.places, orientation, move);
    softs.set(entity, soft);
    seen.add(entity);
  }
  for (const entity of softs.keys()) {
    if (!seen.has(entity)) {
      softs.delete(entity);
    }
  }
}
