// The viewer: opens the stream of the admin server, draws what comes, and asks about what is clicked.

import { Entities } from './entities.js';
import { Renderer } from './renderer.js';

const element = (id) => document.getElementById(id);
const canvas = element('world');
const entities = new Entities();
const renderer = new Renderer(canvas);
let token = '';
let chosen = 0;
let changed = true;
let updates = 0;
let frames = 0;
let state = 'connecting';

// For tests, and for a look from the browser's console.
window.zoned = { entities, renderer, counts: () => ({ updates, frames, state }) };

function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get('token');
  if (given) {
    sessionStorage.setItem('token', given);
    history.replaceState(null, '', location.pathname);
  }
  token = sessionStorage.getItem('token') ?? '';
  element('login').hidden = token !== '';
}

function connect() {
  if (!token) {
    state = 'no token';
    return;
  }
  const socket = new WebSocket(`ws://${location.host}/api/v1/spectate`, ['zoned', token]);
  socket.binaryType = 'arraybuffer';
  let heard = false;
  socket.onmessage = (event) => {
    heard = true;
    if (typeof event.data === 'string') {
      const scene = JSON.parse(event.data);
      entities.clear();
      renderer.setScene(scene);
      element('title').textContent = scene.world;
      document.title = `${scene.world}: zoned`;
      state = 'live';
    } else {
      entities.take(event.data);
      ++updates;
    }
    changed = true;
  };
  socket.onclose = () => {
    state = heard ? 'the connection is gone, trying again' : 'no connection, trying again';
    setTimeout(connect, heard ? 500 : 2000);
  };
}

async function describe(id) {
  const details = element('details');
  details.hidden = false;
  try {
    const answer = await fetch(`api/v1/entities/${id}`, { headers: { Authorization: `Bearer ${token}` } });
    const figures = await answer.json();
    if (id !== chosen) {
      return;
    }
    const numbers = (list) => list.map((v) => v.toFixed(2)).join(', ');
    details.textContent = answer.ok
      ? `${figures.type} ${figures.id}, zone ${figures.zone}${figures.client ? `, client ${figures.client}` : ''}\n` +
        `position ${numbers(figures.position_m)} m\nvelocity ${numbers(figures.velocity_mps)} m/s\n` +
        `${figures.at_rest ? 'at rest' : 'moving'}, stance ${figures.stance}\n${figures.agent}`
      : figures.detail;
  } catch {
    details.textContent = 'the server does not answer';
  }
}

function choose(row) {
  chosen = row ? row.id : 0;
  changed = true;
  if (row) {
    describe(row.id);
  } else {
    element('details').hidden = true;
  }
}

function toggleAbove() {
  renderer.camera.above = !renderer.camera.above;
  element('above').setAttribute('aria-pressed', String(renderer.camera.above));
  changed = true;
}

const pointers = new Map();
let moved = 0;
canvas.addEventListener('pointerdown', (event) => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  moved = 0;
});
canvas.addEventListener('pointermove', (event) => {
  const before = pointers.get(event.pointerId);
  if (!before) {
    return;
  }
  const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
  if (pointers.size === 2) {
    const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const span = (at) => Math.max(1, Math.hypot(at[0] - other[0], at[1] - other[1]));
    renderer.camera.zoom(span(before) / span([event.clientX, event.clientY]));
  } else if (event.shiftKey || event.buttons === 2 || renderer.camera.above) {
    renderer.camera.shift(dx, dy);
  } else {
    renderer.camera.turn(dx, dy);
  }
  pointers.set(event.pointerId, [event.clientX, event.clientY]);
  moved += Math.abs(dx) + Math.abs(dy);
  changed = true;
});
canvas.addEventListener('pointerup', (event) => {
  pointers.delete(event.pointerId);
  if (moved < 6) {
    choose(renderer.pick(entities, event.clientX, event.clientY));
  }
});
canvas.addEventListener('pointercancel', (event) => pointers.delete(event.pointerId));
canvas.addEventListener('contextmenu', (event) => event.preventDefault());
canvas.addEventListener('wheel', (event) => {
  event.preventDefault();
  renderer.camera.zoom(Math.exp(0.001 * event.deltaY));
  changed = true;
}, { passive: false });
canvas.addEventListener('keydown', (event) => {
  const keys = {
    ArrowLeft: () => renderer.camera.turn(20, 0),
    ArrowRight: () => renderer.camera.turn(-20, 0),
    ArrowUp: () => renderer.camera.turn(0, 20),
    ArrowDown: () => renderer.camera.turn(0, -20),
    '+': () => renderer.camera.zoom(0.85),
    '-': () => renderer.camera.zoom(1.18),
    t: toggleAbove,
    Escape: () => choose(null),
  };
  if (keys[event.key]) {
    keys[event.key]();
    changed = true;
    event.preventDefault();
  }
});
element('above').addEventListener('click', toggleAbove);
element('login').addEventListener('submit', (event) => {
  event.preventDefault();
  sessionStorage.setItem('token', element('token').value.trim());
  takeToken();
  connect();
});
window.addEventListener('resize', () => { changed = true; });

let drawnAt = 0; // of the frame before, where it drew; else 0
function frame(now) {
  const draws = changed && renderer.types.length > 0;
  if (draws && drawnAt > 0) {
    renderer.adapt(now - drawnAt);
  }
  drawnAt = draws ? now : 0;
  if (draws) {
    changed = false;
    renderer.place(entities, chosen);
    renderer.draw();
    ++frames;
  }
  requestAnimationFrame(frame);
}

setInterval(() => {
  element('figures').textContent = state === 'live'
    ? `tick ${entities.tick}, ${entities.rows.size} entities`
    : state;
  if (chosen) {
    describe(chosen);
  }
}, 500);

takeToken();
connect();
requestAnimationFrame(frame);
