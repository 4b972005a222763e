// The panel about the chosen entity.

const element = (id) => document.getElementById(id);

function row(table, name, value) {
  const line = table.insertRow();
  const head = document.createElement('th');
  head.scope = 'row';
  head.textContent = name;
  line.append(head);
  line.insertCell().textContent = value;
}

const metres = (v) => (v >= 1e5 ? 'everywhere' : `${v.toFixed(v < 10 ? 2 : 0)} m`);

/** Bytes a second as people read them. */
export function bytes(value) {
  return value >= 1e6 ? `${(value / 1e6).toFixed(2)} MB` : value >= 1e3 ? `${(value / 1e3).toFixed(1)} kB` : `${value.toFixed(0)} B`;
}

export class Panel {
  constructor() {
    this.element = element('details');
    this.before = null; // what was shown before: { id, tick, bytes }
    this.flow = null; // { id, shared }
    this.tickSeconds = 1 / 30;
  }

  hide() {
    this.element.hidden = true;
  }

  wait(id) {
    this.element.hidden = false;
    element('chosen').textContent = `entity ${id}`;
    element('facts').replaceChildren();
    element('explain').textContent = '';
    element('explained').hidden = true;
  }

  gone(id) {
    element('chosen').textContent = `entity ${id} is gone`;
  }

  show(d) {
    this.element.hidden = false;
    element('chosen').textContent = `${d.type} ${d.id}`;
    const table = document.createElement('tbody');
    row(table, 'zone', d.zone);
    row(table, 'state', this.#state(d));
    row(table, 'place', `${d.position.map((v) => v.toFixed(2)).join(', ')} m`);
    row(table, 'speed', `${d.speed_mps.toFixed(2)} m/s`);
    row(table, 'aura', metres(d.aura_m));
    if (d.client) {
      row(table, 'client', String(d.client));
      row(table, 'nimbus', metres(d.nimbus_m));
    }
    for (const field of d.fields ?? []) {
      row(table, field.name, field.value);
    }
    row(table, 'heard by', d.heard_by.length === 1 ? '1 client' : `${d.heard_by.length} clients`);
    row(table, 'spent on it', `${bytes(d.spent.bytes)} in ${d.spent.records} records of ${d.spent.publications} publications${this.#rate(d)}`);
    if (d.view) {
      this.#view(table, d.view);
    }
    if (d.agent) {
      row(table, 'brain', d.agent.brain);
    }
    if (this.flow?.id === d.id) {
      row(table, 'flow field', this.flow.shared ? 'leads to its goal' : 'none: its path was planned alone');
    }
    element('facts').replaceChildren(...table.rows);
    element('explained').hidden = !d.agent;
    const text = d.agent ? d.agent.text : '';
    if (element('explain').textContent !== text) {
      element('explain').textContent = text;
    }
  }

  /**
   * Whether the entity's flow field is shared with others that have its goal, from the next `show` on; null: nobody asked.
   * Said in words, since nothing is drawn where it is not.
   */
  noteFlow(id, shared) {
    this.flow = shared === null ? null : { id, shared };
  }

  /** Bytes a second since it was chosen. */
  #rate(d) {
    if (this.before?.id !== d.id || d.spent.bytes < this.before.bytes) {
      this.before = { id: d.id, tick: d.tick, bytes: d.spent.bytes };
    }
    const seconds = (d.tick - this.before.tick) * this.tickSeconds;
    return seconds > 1 ? `, ${bytes((d.spent.bytes - this.before.bytes) / seconds)}/s` : '';
  }

  #state(d) {
    const out = [d.at_rest ? 'at rest' : 'moving'];
    if (d.off_screen) {
      out.push('off screen: its agent goes from event to event');
    }
    if (d.hidden) {
      out.push('hidden');
    }
    return out.join(', ');
  }

  #view(table, view) {
    row(table, 'hears of', `${view.length} entities`);
    const errors = view.filter((seen) => seen.error_m !== undefined);
    if (errors.length > 0) {
      const worst = errors.reduce((a, b) => (a.error_m / a.bound_m > b.error_m / b.bound_m ? a : b));
      const mean = errors.reduce((sum, seen) => sum + seen.error_m, 0) / errors.length;
      row(table, 'was sent', `${errors.length} that move, ${mean.toFixed(3)} m off the truth`);
      row(table, 'worst', `${worst.error_m.toFixed(3)} m of ${worst.bound_m.toFixed(3)} m allowed (entity ${worst.id})`);
    }
  }
}
