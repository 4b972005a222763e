// Controls: search, layers, types, charts and the pace of the world.

import { spreadColourText } from './meshes.js';
import { COLOURINGS, SIZES } from './renderer.js';
import { find } from './search.js';
import { LAYERS } from './stream.js';

const element = (id) => document.getElementById(id);

/** Boxes to tick: name, whether at first, and what it switches. */
const SWITCHES = [
  ['joints', true], ['soft bodies', true], ['particles', true], ['ghosts', false],
  ['statics', true], ['zones', true], ['ghost margin', false],
  ['agent: path and senses', true], ['aura and nimbus', true], ['sent beside truth', true], ['walkable ground', false], ['flow field', false],
];

export class Controls {
  constructor(with_) {
    Object.assign(this, with_);
    this.counts = []; // by type
    this.chartsOpen = false;
    this.sessions = [];
    this.boxes = new Map();
    for (const [name, on] of SWITCHES) {
      this.boxes.set(name, this.#box(element('layers'), name, on, () => this.#switch()));
    }
    const colouring = element('colouring');
    for (const name of COLOURINGS) {
      colouring.add(new Option(name, name));
    }
    colouring.addEventListener('change', () => {
      this.renderer.colouring = colouring.value;
      this.page.dirty = true;
    });
    const size = element('size');
    for (const name of Object.keys(SIZES)) {
      size.add(new Option(name, name));
    }
    size.addEventListener('change', () => {
      this.renderer.fixedScale = SIZES[size.value];
      this.page.dirty = true;
    });
    element('above').addEventListener('click', this.toggleAbove);
    element('follow').addEventListener('click', this.toggleFollow);
    element('close').addEventListener('click', () => this.choose(0));
    element('charts-button').addEventListener('click', () => this.toggleCharts());
    this.#listenForSearch();
    this.#listenForPace();
  }

  #box(parent, name, on, changed) {
    const label = document.createElement('label');
    const box = document.createElement('input');
    box.type = 'checkbox';
    box.checked = on;
    box.addEventListener('change', changed);
    label.append(box, ` ${name}`);
    parent.append(label);
    return box;
  }

  #is(name) {
    return this.boxes.get(name).checked;
  }

  #switch() {
    this.renderer.shown.statics = this.#is('statics');
    this.renderer.shown.zones = this.#is('zones');
    const { shown } = this.overlay;
    shown.margin = this.#is('ghost margin');
    shown.agent = this.#is('agent: path and senses');
    shown.reach = this.#is('aura and nimbus');
    shown.view = this.#is('sent beside truth');
    shown.walkable = this.#is('walkable ground');
    shown.flow = this.#is('flow field');
    if (!this.#is('soft bodies')) {
      this.renderer.softs.clear();
    }
    if (!this.#is('particles')) {
      this.renderer.points.clear();
    }
    this.page.dirty = true;
  }

  /** Bits of LAYERS that the server is to send. */
  layers() {
    return (this.#is('joints') ? LAYERS.joints : 0) + (this.#is('soft bodies') ? LAYERS.softs : 0) +
      (this.#is('particles') ? LAYERS.particles : 0) + (this.#is('ghosts') ? LAYERS.ghosts : 0) +
      (this.movesByRules ? LAYERS.moved : 0);
  }

  setScene(scene) {
    element('pace').hidden = !scene.development;
    this.recorded = scene.recorded_ticks > 0;
    this.movesByRules = [...scene.doors, ...scene.platforms].some((moving) => moving.by_rules);
    const list = element('types');
    list.replaceChildren(list.querySelector('legend'));
    this.typeCounts = scene.types.map((type, i) => {
      const box = this.#box(list, '', !this.renderer.hiddenTypes.has(i), () => {
        this.renderer.hideType(i, !box.checked);
        this.page.dirty = true;
      });
      const label = box.parentElement;
      const mark = document.createElement('span');
      mark.className = 'mark';
      mark.style.background = spreadColourText(i);
      const count = document.createElement('span');
      label.append(mark, ` ${type.name} `, count);
      return { label, count };
    });
  }

  /** Counts of types, twice a second. */
  refresh() {
    if (!this.typeCounts) {
      return;
    }
    this.counts = new Array(this.typeCounts.length).fill(0);
    for (const slot of this.entities.slotOf.values()) {
      ++this.counts[this.entities.type(slot)];
    }
    this.typeCounts.forEach(({ label, count }, i) => {
      label.hidden = this.counts[i] === 0;
      count.textContent = String(this.counts[i]);
    });
  }

  async toggleCharts() {
    this.chartsOpen = !this.chartsOpen;
    element('charts').hidden = !this.chartsOpen;
    element('charts-button').setAttribute('aria-expanded', String(this.chartsOpen));
    if (this.chartsOpen) {
      await this.charts.open();
    }
  }

  #listenForSearch() {
    const field = element('find');
    const list = element('found');
    const search = () => {
      const found = find(field.value, this.entities, this.renderer.types, this.sessions);
      list.hidden = field.value.trim() === '';
      list.replaceChildren(...found.map(({ id, name }) => {
        const button = document.createElement('button');
        button.textContent = name;
        button.addEventListener('click', () => {
          list.hidden = true;
          this.choose(id);
          if (!this.page.follows) {
            this.toggleFollow();
          }
        });
        const item = document.createElement('li');
        item.append(button);
        return item;
      }));
      if (found.length === 0) {
        list.append(Object.assign(document.createElement('li'), { textContent: 'nothing has this name or number' }));
      }
    };
    field.addEventListener('focus', async () => {
      // Nobody is logged in to a recording.
      this.sessions = this.recorded ? [] : (await this.stream.getJson('api/v1/sessions'))?.sessions ?? [];
    });
    field.addEventListener('input', search);
    element('search').addEventListener('submit', (event) => {
      event.preventDefault();
      search();
      list.querySelector('button')?.click();
    });
    field.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') {
        field.value = '';
        list.hidden = true;
        element('world').focus();
      }
    });
  }

  #listenForPace() {
    const set = async (body) => {
      const answer = await this.stream.post('api/v1/pace', body);
      if (answer?.ok) {
        this.showPace((await answer.json()).time_scale);
      }
    };
    element('pause').addEventListener('click', () => set({ scale: this.scale === 0 ? 1 : 0 }));
    element('step').addEventListener('click', () => set({ scale: 0, steps: 1 }));
    element('scale').addEventListener('change', () => set({ scale: Number(element('scale').value) }));
    this.scale = 1;
  }

  showPace(scale) {
    this.scale = scale;
    element('pause').setAttribute('aria-pressed', String(scale === 0));
    element('pause').textContent = scale === 0 ? 'Go on' : 'Pause';
    if (scale > 0) {
      element('scale').value = String(scale);
    }
  }
}
