// Charts of the server's figures, by Chart.js: loaded when they are first opened, updated once a second.

import { spreadColourText } from './meshes.js';
import { bytes } from './panel.js';

const HISTORY = 120; // seconds
/** Passes with less than this share of the tick are drawn as one. */
const LEAST_SHARE = 0.02;

function load(file) {
  return new Promise((resolve, reject) => {
    const script = document.createElement('script');
    script.src = file;
    script.onload = resolve;
    script.onerror = reject;
    document.head.append(script);
  });
}

/** Counts since the sample before, a second. */
function rates(now, before, seconds) {
  const out = {};
  for (const [name, value] of Object.entries(now)) {
    out[name] = Math.max(0, value - (before[name] ?? 0)) / seconds;
  }
  return out;
}

export class Charts {
  constructor() {
    this.charts = new Map();
    this.before = null;
    this.samples = 0;
  }

  async open() {
    if (!window.Chart) {
      await load('chart.js');
    }
    if (this.charts.size > 0) {
      return;
    }
    window.Chart.defaults.animation = false;
    window.Chart.defaults.font.size = 11;
    this.#make('passes', 'Tick by pass, ms', true);
    this.#make('traffic', 'State sent by reason, kB/s', true);
    this.#make('errors', 'Error of moving entities, share of the bound', false);
    this.#make('sessions', 'Sessions', false);
    this.#make('rejected', 'Rejected by reason, a second', false);
  }

  #make(name, title, stacked) {
    const canvas = document.getElementById(`chart-${name}`);
    canvas.setAttribute('aria-label', title);
    const axis = { stacked, beginAtZero: true, grid: { color: 'rgba(128,128,128,0.2)' } };
    this.charts.set(name, new window.Chart(canvas, {
      type: 'line',
      data: { labels: [], datasets: [] },
      options: {
        responsive: true,
        maintainAspectRatio: false,
        elements: { point: { radius: 0 }, line: { borderWidth: 1.5 } },
        plugins: { title: { display: true, text: title }, legend: { labels: { boxWidth: 8, boxHeight: 8 } } },
        scales: { x: { display: false }, y: axis },
      },
    }));
  }

  /** Takes one answer of /api/v1/charts. */
  take(figures) {
    const { before } = this;
    this.before = figures;
    const seconds = before ? figures.time_s - before.time_s : 0;
    if (seconds <= 0 || figures.ticks <= before.ticks) {
      return;
    }
    const ticks = figures.ticks - before.ticks;
    const perTick = rates(figures.passes, before.passes, 1e6 * ticks); // ms a tick, over all zones
    const traffic = rates(figures.bytes, before.bytes, 1000 * seconds);
    // Sums of traffic are renewed now and then: no change says nothing.
    if (Object.values(traffic).some((v) => v > 0)) {
      this.trafficNow = traffic;
    }
    ++this.samples;
    if (this.charts.size === 0) {
      return;
    }
    this.#colours();
    this.#add('passes', this.#largest(perTick));
    this.#add('traffic', this.trafficNow ?? { 'all datagrams': (figures.bytes_out - before.bytes_out) / (1000 * seconds) });
    this.#add('errors', { median: figures.errors.p50, 'p99': figures.errors.p99, bound: 1 });
    this.#add('sessions', { sessions: figures.sessions });
    const rejected = rates(figures.rejected, before.rejected, seconds);
    this.#add('rejected', Object.keys(rejected).length > 0 ? rejected : { 'nothing so far': 0 });
    document.getElementById('summary').textContent =
      `tick p50 ${figures.tick_ms_p50.toFixed(2)} ms, p99 ${figures.tick_ms_p99.toFixed(2)} ms, ${figures.overruns} overruns; ` +
      `${figures.sessions} sessions, ${bytes((figures.bytes_out - before.bytes_out) / seconds)}/s out; ` +
      `${figures.awake_bodies} bodies awake`;
  }

  #largest(values) {
    const sum = Object.values(values).reduce((a, b) => a + b, 0);
    const out = {};
    let rest = 0;
    for (const [name, value] of Object.entries(values)) {
      if (value > LEAST_SHARE * sum || this.charts.get('passes').data.datasets.some((set) => set.label === name)) {
        out[name] = value;
      } else {
        rest += value;
      }
    }
    return { ...out, 'all others': rest };
  }

  #colours() {
    const text = getComputedStyle(document.body).color;
    if (text !== this.text) {
      this.text = text;
      for (const chart of this.charts.values()) {
        chart.options.color = text;
        chart.options.plugins.title.color = text;
        chart.options.plugins.legend.labels.color = text;
        chart.options.scales.y.ticks.color = text;
      }
    }
  }

  #add(name, values) {
    const chart = this.charts.get(name);
    const { labels, datasets } = chart.data;
    const before = labels.length;
    labels.push('');
    for (const [label, value] of Object.entries(values)) {
      let set = datasets.find((known) => known.label === label);
      if (!set) {
        const stacked = chart.options.scales.y.stacked;
        const own = label === 'bound' ? 'rgb(220,60,60)' : spreadColourText(datasets.length);
        set = { label, data: new Array(before).fill(0), borderColor: own, backgroundColor: own, fill: stacked };
        datasets.push(set);
      }
      set.data.push(value);
    }
    for (const set of datasets) {
      while (set.data.length < labels.length) {
        set.data.push(0);
      }
      set.data.splice(0, Math.max(0, set.data.length - HISTORY));
    }
    labels.splice(0, Math.max(0, labels.length - HISTORY));
    chart.update('none');
  }
}
