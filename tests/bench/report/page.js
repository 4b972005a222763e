// The report's script: draws each plot when it comes into view, by Chart.js; themes and keys.

const charts = JSON.parse(document.getElementById('charts').textContent);
const drawn = new Map();
const announcer = document.getElementById('announcer');

const MARKS = {
  default: { light: '#0b57b0', dark: '#7fb5f5', pointStyle: 'circle', pointRadius: 7 },
  own: { light: '#1b6e2f', dark: '#7bd58f', pointStyle: 'rect', pointRadius: 5 },
  peer: { light: '#b3400a', dark: '#ffb083', pointStyle: 'triangle', pointRadius: 7 },
};

function theme() {
  return document.documentElement.dataset.theme;
}

/** Zeros have no place on a logarithmic axis: they lie a decade below the least value. */
function floorOf(values) {
  const positive = values.filter((v) => v > 0);
  return positive.length === 0 ? 1e-12 : Math.min(...positive) / 10;
}

function placed(points, floors) {
  return points.map((p) => ({ ...p, shownX: p.x, shownY: p.y, x: p.x > 0 ? p.x : floors.x, y: p.y > 0 ? p.y : floors.y }));
}

/** The number of each point, as in the table. */
const numbers = {
  id: 'numbers',
  afterDatasetsDraw(chart) {
    const g = chart.ctx;
    g.save();
    g.font = '10px sans-serif';
    g.fillStyle = chart.options.color;
    chart.data.datasets.forEach((set, i) => {
      if (set.front || !chart.isDatasetVisible(i)) return;
      chart.getDatasetMeta(i).data.forEach((mark, j) => {
        if (set.line && j < set.data.length - 1) return;
        g.fillText(set.line ? set.label : set.data[j].n, mark.x + 8, mark.y - 4);
      });
    });
    g.restore();
  },
};

function dataset(series, look, floors) {
  const mark = MARKS[series.role];
  const colour = mark[look];
  return {
    label: series.name,
    data: placed(series.points, floors),
    line: series.line,
    showLine: series.line,
    borderColor: colour,
    borderWidth: series.role === 'peer' ? 2 : 1.5,
    borderDash: series.role === 'peer' ? [2, 3] : [],
    backgroundColor: series.role === 'peer' ? 'transparent' : colour,
    pointStyle: mark.pointStyle,
    pointRadius: series.line ? 3 : mark.pointRadius,
    pointHoverRadius: mark.pointRadius + 3,
  };
}

function axis(text, look) {
  const colour = look === 'dark' ? '#e8e8e8' : '#1a1a1a';
  return {
    type: 'logarithmic',
    title: { display: true, text, color: colour },
    ticks: { color: colour, maxTicksLimit: 8, callback: (v) => (Math.abs(Math.log10(v) - Math.round(Math.log10(v))) < 1e-9 ? `1e${Math.round(Math.log10(v))}` : '') },
    grid: { color: look === 'dark' ? '#33383d' : '#e2e2e2' },
  };
}

function draw(figure, look = theme()) {
  const canvas = document.getElementById(figure.id).querySelector('canvas');
  drawn.get(figure.id)?.destroy();
  const all = figure.series.flatMap((s) => s.points);
  const floors = { x: floorOf(all.map((p) => p.x)), y: floorOf(all.map((p) => p.y)) };
  const datasets = figure.series.map((s) => dataset(s, look, floors));
  if (figure.front.length > 0) {
    const colour = look === 'dark' ? '#d0d0d0' : '#555';
    datasets.push({ label: 'front', front: true, data: placed(figure.front, floors), showLine: true, stepped: 'before', borderColor: colour, borderWidth: 1.5, borderDash: [6, 4], pointRadius: 0, pointHitRadius: 0 });
  }
  drawn.set(figure.id, new Chart(canvas, {
    type: 'scatter',
    data: { datasets },
    plugins: [numbers],
    options: {
      animation: false,
      maintainAspectRatio: false,
      color: look === 'dark' ? '#e8e8e8' : '#1a1a1a',
      layout: { padding: { right: 40 } },
      scales: { x: axis(figure.x, look), y: axis(figure.y, look) },
      plugins: {
        legend: { display: figure.series.length <= 12, labels: { color: look === 'dark' ? '#e8e8e8' : '#1a1a1a', usePointStyle: true } },
        tooltip: { filter: (item) => !item.dataset.front, callbacks: { label: (item) => item.raw.t } },
      },
    },
  }));
  return drawn.get(figure.id);
}

function chartFor(id) {
  return drawn.get(id) ?? draw(charts.find((c) => c.id === id));
}

/** Arrow keys go from point to point, by rising error. */
function listen(figure) {
  const canvas = document.getElementById(figure.id).querySelector('canvas');
  let at = -1;
  canvas.addEventListener('keydown', (event) => {
    const chart = chartFor(figure.id);
    const marks = figure.series.flatMap((s, i) => s.points.map((p, j) => ({ datasetIndex: i, index: j, x: p.x, text: p.t })));
    marks.sort((a, b) => a.x - b.x);
    const next = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: marks.length - 1, Escape: -1 }[event.key];
    if (next === undefined) return;
    event.preventDefault();
    at = event.key === 'Escape' ? -1 : Math.min(Math.max(next, 0), marks.length - 1);
    const chosen = at < 0 ? [] : [marks[at]];
    chart.setActiveElements(chosen);
    chart.tooltip.setActiveElements(chosen, { x: 0, y: 0 });
    chart.update();
    announcer.textContent = at < 0 ? '' : marks[at].text;
  });
}

function redraw(look) {
  for (const id of [...drawn.keys()]) draw(charts.find((c) => c.id === id), look);
}

function setTheme(look) {
  document.documentElement.dataset.theme = look;
  const button = document.getElementById('theme');
  button.textContent = look === 'dark' ? 'Light theme' : 'Dark theme';
  redraw(look);
}

const prefersDark = matchMedia('(prefers-color-scheme: dark)');
setTheme(prefersDark.matches ? 'dark' : 'light');
prefersDark.addEventListener('change', () => setTheme(prefersDark.matches ? 'dark' : 'light'));
document.getElementById('theme').addEventListener('click', () => setTheme(theme() === 'dark' ? 'light' : 'dark'));

// Paper is light, and shows all plots.
let before = theme();
addEventListener('beforeprint', () => {
  before = theme();
  document.documentElement.dataset.theme = 'light';
  for (const figure of charts) draw(figure, 'light');
});
addEventListener('afterprint', () => setTheme(before));

const watcher = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    if (entry.isIntersecting) {
      watcher.unobserve(entry.target);
      chartFor(entry.target.id);
    }
  }
}, { rootMargin: '400px' });
for (const figure of charts) {
  watcher.observe(document.getElementById(figure.id));
  listen(figure);
}
// The first plot does not wait until it is looked for.
if (charts.length > 0) {
  chartFor(charts[0].id);
  performance.mark('first-plot');
}
window.zonedReport = { charts, drawn, chartFor };
