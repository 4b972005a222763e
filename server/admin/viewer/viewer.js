// The viewer: opens the stream of the admin server, draws what comes, and asks about what is chosen.

import { Charts } from './charts.js';
import { TickClock } from './clock.js';
import { Controls } from './controls.js';
import { Entities } from './entities.js';
import { Layers } from './layers.js';
import { Overlay } from './overlay.js';
import { Panel } from './panel.js';
import { listen } from './pointer.js';
import { Renderer } from './renderer.js';
import { Replay } from './replay.js';
import { Stream } from './stream.js';
import { Geometry } from './terrain.js';

const DETAILS_MS = 400;
const WISH_MS = 250;
const FIGURES_MS = 500;
const CHARTS_MS = 1000;
/** Heat halves in about two seconds. */
const FADE_MS = 250;
const FADE = 0.92;

const element = (id) => document.getElementById(id);
const canvas = element('world');
const entities = new Entities();
const clock = new TickClock();
const renderer = new Renderer(canvas);
const layers = new Layers(renderer);
const overlay = new Overlay(renderer);
const panel = new Panel();
const charts = new Charts();

const page = { state: 'connecting', chosen: 0, follows: false, updates: 0, frames: 0, dirty: true, firstPicture_ms: 0 };

const stream = new Stream({
  scene(scene, same) {
    entities.clear();
    layers.clear();
    clock.reset();
    clock.tickSeconds = 1 / scene.tick_rate_hz;
    if (!same) {
      renderer.setScene(scene, new Geometry(scene));
      placeCamera();
    }
    controls.setScene(scene);
    replay.setScene(scene.recorded_ticks);
    element('title').textContent = scene.world;
    document.title = `${scene.world}: zoned`;
  },
  entities(buffer) {
    entities.take(buffer);
    clock.hear(entities.tick);
    ++page.updates;
    page.dirty = true;
  },
  layer(kind, buffer) {
    layers.take(kind, buffer, entities);
    page.dirty = true;
  },
  piece(buffer) {
    renderer.geometry.take(buffer);
    page.dirty = true;
  },
  state(text) {
    page.state = text;
    showFigures();
  },
});

const controls = new Controls({ entities, renderer, overlay, stream, choose, page, charts, toggleAbove, toggleFollow });

const replay = new Replay(stream);

// For tests, and for a look from the browser's console.
window.zoned = {
  entities, renderer, clock, layers, overlay, panel, charts, stream, replay,
  counts: () => ({
    updates: page.updates, frames: page.frames, state: page.state, chosen: page.chosen, first_picture_ms: page.firstPicture_ms,
  }),
  choose,
  draw,
};

function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get('token');
  if (given) {
    sessionStorage.setItem('token', given);
    history.replaceState(null, '', location.pathname);
  }
  const token = sessionStorage.getItem('token') ?? '';
  element('login').hidden = token !== '';
  return token;
}

/** Once it is known where most things are, a camera over a large empty world would show little. */
function placeCamera() {
  const { camera, scene } = renderer;
  camera.pitch = 0.5;
  camera.target[1] = scene.ground_height_m;
}

function choose(id) {
  page.chosen = id;
  page.dirty = true;
  overlay.details = null;
  overlay.walkable = new Float32Array(0);
  overlay.flow = new Float32Array(0);
  element('follow').disabled = id === 0;
  if (id) {
    panel.wait(id);
    describe();
  } else {
    page.follows = false;
    panel.hide();
  }
  element('follow').setAttribute('aria-pressed', String(page.follows));
}

async function describe() {
  const id = page.chosen;
  if (!id) {
    return;
  }
  const details = await stream.getJson(`api/v1/inspect/${id}`);
  if (id !== page.chosen) {
    return;
  }
  if (!details) {
    if (page.state === 'live' && !entities.slotOf.has(id)) {
      panel.gone(id);
    }
    return;
  }
  panel.tickSeconds = clock.tickSeconds;
  overlay.details = details;
  page.dirty = true;
  panel.show(details);
  if (overlay.shown.walkable) {
    const [x, , z] = details.position;
    const zone = 1 + renderer.scene.zones.findIndex((known) => known.name === details.zone);
    const lines = await stream.get(`api/v1/walkable/${zone}?x=${x}&z=${z}&reach=50`);
    overlay.walkable = new Float32Array(lines ? await lines.arrayBuffer() : 0);
  }
  if (overlay.shown.flow) {
    const lines = details.agent && (await stream.get(`api/v1/flow/${id}?reach=60`));
    overlay.flow = new Float32Array(lines ? await lines.arrayBuffer() : 0);
  }
  panel.noteFlow(id, overlay.shown.flow ? overlay.flow.length > 0 : null);
}

function toggleAbove() {
  renderer.camera.above = !renderer.camera.above;
  element('above').setAttribute('aria-pressed', String(renderer.camera.above));
  page.dirty = true;
}

function toggleFollow() {
  page.follows = !page.follows && page.chosen !== 0;
  element('follow').setAttribute('aria-pressed', String(page.follows));
  if (page.follows) {
    renderer.camera.distance = Math.min(renderer.camera.distance, 40);
  }
  page.dirty = true;
}

listen(canvas, renderer.camera, {
  moved(shifted) {
    page.dirty = true;
    if (shifted && page.follows) {
      toggleFollow();
    }
  },
  choose(x, y) {
    const slot = renderer.pick(entities, clock, x, y);
    choose(slot < 0 ? 0 : entities.id(slot));
  },
  key(name) {
    const keys = {
      t: toggleAbove,
      f: toggleFollow,
      c: () => controls.toggleCharts(),
      '/': () => element('find').focus(),
      Escape: () => choose(0),
    };
    keys[name]?.();
    return Boolean(keys[name]);
  },
});
element('login').addEventListener('submit', (event) => {
  event.preventDefault();
  sessionStorage.setItem('token', element('token').value.trim());
  stream.restart(takeToken());
});
// The same page is opened again with a token: the browser does not load it anew.
window.addEventListener('hashchange', () => stream.restart(takeToken()));
window.addEventListener('resize', () => { page.dirty = true; });
// A machine that slept or a driver that fell takes all buffers away: only a new page draws again. The token is kept.
canvas.addEventListener('webglcontextlost', (event) => {
  event.preventDefault();
  page.state = 'the picture is gone, waiting for the graphics card';
  showFigures();
});
canvas.addEventListener('webglcontextrestored', () => location.reload());
window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { page.dirty = true; });

/** Where an entity is shown; null when it is not known. */
function placeOf(id) {
  const slot = entities.slotOf.get(id);
  return slot === undefined ? null : entities.place(slot, clock.shown, clock.tickSeconds);
}

/** Draws the moment that the clock shows. */
function draw() {
  const { lines } = renderer;
  lines.clear();
  if (renderer.shown.zones) {
    overlay.zones(lines);
  }
  layers.draw(lines);
  const place = page.chosen ? placeOf(page.chosen) : null;
  if (place) {
    if (page.follows) {
      renderer.camera.target = [...place];
    }
    overlay.chosen(lines, place, placeOf);
    overlay.ground(lines);
  }
  renderer.draw(entities, clock, page.chosen);
}

let drawnAt = 0; // of the frame before, where it drew; else 0
let toldAt = 0;
let fadedAt = 0;
function frame(now) {
  requestAnimationFrame(frame);
  if (renderer.types.length === 0) {
    return;
  }
  const before = clock.shown;
  clock.advance(now);
  const draws = page.dirty || Math.abs(clock.shown - before) > 0.02;
  if (draws && drawnAt > 0) {
    renderer.adapt(now - drawnAt);
  }
  drawnAt = draws ? now : 0;
  if (now - fadedAt > FADE_MS) {
    fadedAt = now;
    entities.fade(FADE);
  }
  if (draws) {
    page.dirty = false;
    draw();
    ++page.frames;
    if (page.firstPicture_ms === 0 && entities.size > 0) {
      page.firstPicture_ms = performance.now(); // since the page was opened
    }
  }
  if (now - toldAt > WISH_MS) {
    toldAt = now;
    stream.tell(controls.layers(), renderer.camera.eye());
  }
}

function showFigures() {
  element('figures').textContent = page.state === 'live'
    ? `tick ${entities.tick}, ${entities.size.toLocaleString('en')} entities`
    : page.state;
}

setInterval(() => {
  showFigures();
  controls.refresh();
  replay.refresh(entities.tick);
}, FIGURES_MS);
setInterval(describe, DETAILS_MS);
setInterval(async () => {
  if (page.state === 'live' && (page.chosen || controls.chartsOpen)) {
    const figures = await stream.getJson('api/v1/charts');
    if (figures) {
      charts.take(figures);
      controls.showPace(figures.time_scale);
    }
  }
}, CHARTS_MS);

stream.start(takeToken());
requestAnimationFrame(frame);
