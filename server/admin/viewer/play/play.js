// The page to play on: a session by WebSocket, drawn by the viewer's renderer.

import { Entities } from '../entities.js';
import { Renderer } from '../renderer.js';
import { Geometry } from '../terrain.js';
import { drawRopes } from '../softs.js';
import { PlayerControls } from './controls.js';
import { deformSofts, surfacesOf } from './deformed.js';
import * as sandbox from './sandbox.js';
import { CLOSED, ONLINE, WebClient, load } from '../../../../client-sim/web/zoned_client.ts';

const FIGURES_MS = 250;
const DOORS_MS = 200;
/** Pages in the background draw nothing, but their session goes on. */
const BEHIND_MS = 250;
const SHOT_M = 100;
const REACH_M = 3;
const MOST_TRIANGLES = 1000000;
const MOST_LINES = 8;
const LINE_MS = 12000;
const NEAR_CAMERA_M = 0.05;
const FAR_CAMERA_M = 5;

const element = (id) => document.getElementById(id);
const canvas = element('world');
const entities = new Entities();
const renderer = new Renderer(canvas);
const clock = { shown: 0, tickSeconds: 1 / 30 };
const page = { code: null, told: null, client: null, ready: false, own: null, ownType: 0, ownFields: [], seats: [], surfaces: [], frames: 0, items: [], behind: true, doors: '', travels: [] };

const controls = new PlayerControls(canvas, { act });

// For tests, and for a look from the browser's console.
window.zoned = {
  renderer, entities, controls, page,
  counts: () => ({ frames: page.frames, state: page.client?.state ?? 0, entities: entities.size, trouble: page.client?.trouble ?? '' }),
  own: () => page.client?.own() ?? null,
  stats: () => page.client?.stats() ?? null,
  cut: () => page.client?.socket?.close(),
  act, frame: advance,
};

function say(text) {
  const line = document.createElement('li');
  line.textContent = text;
  element('lines').append(line);
  while (element('lines').children.length > MOST_LINES) {
    element('lines').firstChild.remove();
  }
  setTimeout(() => line.remove(), LINE_MS);
}

function address() {
  const { websocket_port: port, websocket_tls: tls } = page.told;
  return `${tls || location.protocol === 'https:' ? 'wss' : 'ws'}://${location.hostname}:${port}/`;
}

/** Types, zones and what stands: once the server has described the world. */
function buildScene() {
  const { client, told } = page;
  const looks = new Map(told.types.map((type) => [type.name, type]));
  const types = client.types().map(({ name, character, radius, halfSegment }) => looks.get(name) ?? {
    name, character, shape: character ? 'round' : 'box', size: character ? [radius, halfSegment, radius] : [0.5, 0.5, 0.5],
  });
  const zones = client.zones();
  const surfaces = [];
  const triangles = zones.map((zone, i) => (zone.triangles > 0 && zone.triangles < MOST_TRIANGLES ? client.triangles(i) : null));
  for (const corners of triangles) {
    if (corners) {
      surfaces.push({ p: [0, 0, 0], q: [0, 0, 0, 1], vertices: corners.length / 3, triangles: corners.length / 9 });
    }
  }
  const geometry = new Geometry({ surfaces });
  triangles.filter(Boolean).forEach((corners, i) => {
    const surface = geometry.surfaces[i];
    surface.take(0, corners.length / 3, corners);
    surface.take(0, corners.length / 9, Uint32Array.from({ length: corners.length / 3 }, (_, k) => k));
    geometry.ready.push(surface);
  });
  clock.tickSeconds = client.world().tickSeconds;
  renderer.setScene({ types, zones, doors: [], platforms: [], surfaces, ground_height_m: told.ground_height_m }, geometry);
  const player = types.findIndex(({ name }) => name === 'player');
  page.ownType = player >= 0 ? player : Math.max(0, types.findIndex(({ character }) => character));
  page.ownFields = client.fields(page.ownType);
  page.surfaces = surfacesOf(types, looks);
  page.seats = client.types().map(({ seats }) => seats);
  page.doors = '-';
  page.travels = client.zones().map((_, i) => i).filter((i) => client.boxes(i, 2).length > 0);
  layBoxes();
  page.ready = true;
}

/** Platforms where they are now: one that zones share comes twice in the same place. */
function layPlatforms() {
  renderer.layPlatforms(page.travels.flatMap((zone) => [...page.client.boxes(zone, 2)]));
}

/** Walls, and the doors that are shut. Zones share what stands at their borders. */
function layBoxes() {
  const { client } = page;
  const zones = client.zones();
  const shut = zones.map((_, i) => client.boxes(i, 1));
  const key = shut.map((boxes) => boxes.join()).join(';');
  if (key === page.doors) {
    return;
  }
  page.doors = key;
  const seen = new Set();
  const all = [];
  for (const boxes of [...zones.map((_, i) => client.boxes(i, 0)), ...shut]) {
    for (let at = 0; at < boxes.length; at += 10) {
      const box = boxes.subarray(at, at + 10);
      const name = box.join();
      if (!seen.has(name)) {
        seen.add(name);
        all.push(...box);
      }
    }
  }
  renderer.geometry.boxes = all.length > 0 ? [new Float32Array(all)] : [];
  renderer.boxChunks = -1;
}

/** The entity before the eye that can be reached, or 0. */
function inReach() {
  const { eye, id } = page.own;
  const along = controls.direction();
  let best = 0;
  let least = Infinity;
  for (const [other, slot] of entities.slotOf) {
    const away = entities.place(slot, clock.shown, clock.tickSeconds).map((v, k) => v - eye[k]);
    const length = Math.hypot(...away);
    const ahead = away.reduce((sum, v, k) => sum + v * along[k], 0);
    if (other !== id && length < REACH_M && ahead > 0 && length - ahead < least) {
      least = length - ahead;
      best = other;
    }
  }
  return best;
}

/** The nearest entity with seats that can be reached, or 0. */
function vehicleInReach() {
  let best = 0;
  let least = REACH_M;
  for (const [other, slot] of entities.slotOf) {
    const away = Math.hypot(...entities.place(slot, clock.shown, clock.tickSeconds).map((v, k) => v - page.own.position[k]));
    if (page.seats[entities.type(slot)] > 0 && away < least) {
      least = away;
      best = other;
    }
  }
  return best;
}

function act(name) {
  const { client, own } = page;
  if (!own) {
    return;
  }
  const acts = {
    shoot() {
      const aim = client.aim(own.eye, controls.direction(), SHOT_M);
      if (aim) {
        client.command(sandbox.SHOOT, sandbox.shot(own.tick, controls.direction(), aim));
      }
    },
    push() {
      const id = inReach();
      return id && client.command(sandbox.PUSH, sandbox.entity(id));
    },
    pick_up() {
      const id = inReach();
      return id && client.command(sandbox.PICK_UP, sandbox.entity(id));
    },
    throw() {
      const item = page.items[0];
      return item && client.command(sandbox.THROW, sandbox.thrown(item, controls.direction()));
    },
    ride() {
      const id = own.carried ? 0 : vehicleInReach();
      if (!own.carried && id === 0) {
        say('There is nothing near to ride on');
        return;
      }
      client.command(sandbox.RIDE, sandbox.entity(id));
    },
    chat() {
      document.exitPointerLock?.();
      element('say').hidden = false;
      element('text').focus();
    },
    view() {
      page.behind = !page.behind;
    },
  };
  acts[name]?.();
}

function takeEvents() {
  for (let event = page.client.event(); event; event = page.client.event()) {
    if (event.kind === sandbox.INVENTORY) {
      page.items = sandbox.read(event.payload).numbers(1);
    }
    const text = sandbox.describe(event, page.own?.id);
    if (text) {
      say(text);
    }
  }
}

/** The eye is on the line of sight, so that what is in the middle of the picture is what is aimed at. */
function placeCamera() {
  const { camera } = renderer;
  const { eye } = page.own;
  camera.target = [...eye];
  camera.yaw = controls.yaw + Math.PI;
  camera.pitch = -controls.pitch;
  const above = eye[1] - renderer.scene.ground_height_m - 0.3;
  const down = Math.sin(controls.pitch);
  camera.distance = page.behind ? Math.max(NEAR_CAMERA_M, Math.min(FAR_CAMERA_M, down > 0 ? above / down : FAR_CAMERA_M)) : NEAR_CAMERA_M;
}

function draw() {
  const rows = page.client.rows(page.ownType);
  if (!rows || !page.own) {
    return;
  }
  entities.take(rows);
  clock.shown = entities.tick;
  renderer.hiddenTypes.clear();
  if (!page.behind) {
    hideOwn();
  }
  renderer.lines.clear();
  deformSofts(renderer.softs, page.surfaces, entities, page.client);
  drawRopes(renderer.softs, renderer.lines);
  placeCamera();
  renderer.draw(entities, clock, 0);
  ++page.frames;
}

/** Through its own eyes a player sees no own body. */
function hideOwn() {
  const slot = entities.slotOf.get(page.own.id);
  if (slot !== undefined) {
    entities.bytes[40 * slot + 36] |= 128;
  }
}

let drawnAt = 0;
function frame(now) {
  requestAnimationFrame(frame);
  if (page.client) {
    advance(now);
  }
}

/** Input, what has come, and the picture. */
function advance(now = performance.now()) {
  const { client } = page;
  client.input(controls.input());
  const state = client.poll();
  takeEvents();
  page.own = client.own();
  if (state === CLOSED) {
    end(client.trouble);
    return;
  }
  if (client.world() && !page.ready) {
    buildScene();
  }
  if (page.ready) {
    if (drawnAt > 0) {
      renderer.adapt(now - drawnAt);
    }
    drawnAt = now;
    if (page.travels.length > 0) {
      layPlatforms();
    }
    draw();
  }
}

/** What the game declares for the own avatar, say its health. */
function ownFields(client) {
  return page.ownFields.map(({ name }) => `${name} ${client.field(page.own.id, name) ?? '?'}, `).join('');
}

function figures() {
  const { client } = page;
  if (!client) {
    return;
  }
  const stats = client.stats();
  const names = ['', 'connecting', 'online', 'the connection is gone, trying again', 'closed'];
  const cm = (metres) => `${(100 * metres).toFixed(2)} cm`;
  let text = names[client.state];
  const own = page.own && page.ready ? ownFields(client) : '';
  if (client.state === ONLINE && stats) {
    text = `${entities.size} in sight, ${stats.rttMs.toFixed(0)} ms, correction ${cm(stats.correctionM)} (p99 ${cm(stats.correctionM_p99)})`;
    text = own + text;
    if (stats.audits > 0) {
      text += `, error shown ${cm(stats.displayedM_p50)} (p99 ${cm(stats.displayedM_p99)})`;
    }
    if (stats.judged > 0) {
      text += `, ${stats.judged} states judged, ${stats.beyond} beyond their bound: ${stats.verdict}`;
    }
  }
  element('figures').textContent = text;
}

function begin({ name, ticket, view }) {
  const client = new WebClient(page.code, { name, ticket, view });
  page.client = client;
  page.ready = false;
  client.begin(address());
  element('enter').hidden = true;
  element('leave').hidden = false;
  const touch = matchMedia('(pointer: coarse)').matches;
  element('stick').hidden = element('jump').hidden = !touch;
  canvas.focus();
}

function end(trouble) {
  page.client = null;
  page.own = null;
  page.ready = false;
  drawnAt = 0;
  document.exitPointerLock?.();
  element('enter').hidden = false;
  element('leave').hidden = element('stick').hidden = element('jump').hidden = true;
  element('trouble').textContent = trouble;
  element('figures').textContent = trouble || 'not in the world';
}

element('enter').addEventListener('submit', async (event) => {
  event.preventDefault();
  element('trouble').textContent = '';
  try {
    const [file] = element('ticket').files;
    const ticket = file ? new Uint8Array(await file.arrayBuffer()) : undefined;
    begin({ name: element('name').value.trim(), ticket, view: Number(element('view').value) });
  } catch (error) {
    end(error.message);
  }
});
element('say').addEventListener('submit', (event) => {
  event.preventDefault();
  const text = element('text').value.trim();
  if (text) {
    page.client?.command(sandbox.CHAT, sandbox.chat(text));
  }
  element('text').value = '';
  element('say').hidden = true;
  canvas.focus();
});
element('text').addEventListener('keydown', (event) => {
  if (event.key === 'Escape') {
    element('say').hidden = true;
    canvas.focus();
  }
});
element('leave').addEventListener('click', () => {
  page.client?.quit();
  end('');
});
window.addEventListener('pagehide', () => page.client?.quit());
controls.useTouch(element('stick'), element('jump'));
setInterval(figures, FIGURES_MS);
setInterval(() => page.ready && layBoxes(), DOORS_MS);
setInterval(() => document.hidden && page.client?.poll(), BEHIND_MS);

async function start() {
  page.told = await (await fetch('play.json')).json();
  element('title').textContent = page.told.world;
  document.title = `Play ${page.told.world}: zoned`;
  element('ticket-row').hidden = element('ticket-note').hidden = page.told.development;
  if (page.told.websocket_port === 0) {
    end('This server takes no WebSockets: set network.websocket_port in its config');
    return;
  }
  page.code = await load(await fetch('zoned_client.wasm'));
  element('figures').textContent = 'not in the world';
}

start().catch((error) => end(`The client could not be loaded: ${error.message}`));
requestAnimationFrame(frame);
