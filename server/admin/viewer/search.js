// Search: entities by number, by type or by the name of the player.

const MOST_FOUND = 30;

/** Entities that fit a text: { id, name } of each. `sessions` are those of /api/v1/sessions. */
export function find(text, entities, types, sessions) {
  const wanted = text.trim().toLowerCase();
  if (wanted === '') {
    return [];
  }
  const out = [];
  const add = (id, name) => {
    if (out.length < MOST_FOUND && entities.slotOf.has(id) && !out.some((found) => found.id === id)) {
      out.push({ id, name });
    }
  };
  const nameOf = (id) => types[entities.type(entities.slotOf.get(id))].name;
  if (/^\d+$/.test(wanted) && entities.slotOf.has(Number(wanted))) {
    add(Number(wanted), `${nameOf(Number(wanted))} ${wanted}`);
  }
  for (const session of sessions) {
    if (`${session.name} ${session.account}`.toLowerCase().includes(wanted)) {
      add(session.avatar, `${session.name || session.account}, client ${session.client}`);
    }
  }
  for (const [id, slot] of entities.slotOf) {
    const { name } = types[entities.type(slot)];
    if (out.length >= MOST_FOUND) {
      break;
    }
    if (name.toLowerCase().includes(wanted) || (/^\d+$/.test(wanted) && String(id).startsWith(wanted))) {
      add(id, `${name} ${id}`);
    }
  }
  return out;
}
