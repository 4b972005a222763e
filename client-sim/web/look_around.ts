// Joins a server, walks by W A S D, and shows from above what it sees: look_around.html?server=ws://HOST:PORT/&name=ann
import { CLOSED, JUMP, WebClient, load } from './zoned_client.js';
import type { Avatar, Entity, Input } from './zoned_client.js';

const PIXELS_PER_M = 4;
const TURN = { KeyW: [0, 1], KeyS: [0, -1], KeyA: [1, 0], KeyD: [-1, 0] } as const;

function find<Kind extends Element>(selector: string, kind: new () => Kind): Kind {
  const found = document.querySelector(selector);
  if (!(found instanceof kind)) {
    throw new Error(`the page has no ${selector}`);
  }
  return found;
}

const status = find('#status', HTMLParagraphElement);
const canvas = find('#map', HTMLCanvasElement);
const held = new Set<string>();
addEventListener('keydown', ({ code }) => held.add(code));
addEventListener('keyup', ({ code }) => held.delete(code));

/** North is up, and east, where x falls, on the right. */
function wishes(): Input {
  const input = { buttons: held.has('Space') ? JUMP : 0, moveX: 0, moveZ: 0 };
  for (const [key, [x, z]] of Object.entries(TURN)) {
    if (held.has(key)) {
      input.moveX += x;
      input.moveZ += z;
    }
  }
  return input;
}

function draw(own: Avatar, others: Entity[]): void {
  const context = canvas.getContext('2d');
  if (!context) {
    return;
  }
  context.clearRect(0, 0, canvas.width, canvas.height);
  const dot = ({ position: [x, , z] }: Avatar | Entity, colour: string) => {
    context.fillStyle = colour;
    context.fillRect(canvas.width / 2 - PIXELS_PER_M * (x - own.position[0]) - 2, canvas.height / 2 - PIXELS_PER_M * (z - own.position[2]) - 2, 4, 4);
  };
  others.forEach((entity) => dot(entity, entity.atRest ? 'gray' : 'crimson'));
  dot(own, 'royalblue');
}

/** One line of what there is. */
function describe(client: WebClient, own: Avatar, others: Entity[]): string {
  const types = client.types();
  const counts = new Map<string, number>();
  for (const { type } of others) {
    counts.set(types[type].name, (counts.get(types[type].name) ?? 0) + 1);
  }
  const seen = [...counts].map(([name, count]) => `${count} ${name}`).join(', ');
  return `me at ${own.position.map((v) => v.toFixed(2)).join(' ')}; ${seen}; ${client.stats()?.rttMs.toFixed(0) ?? '?'} ms`;
}

function frame(client: WebClient): void {
  client.input(wishes());
  const state = client.poll();
  for (let event = client.event(); event; event = client.event()) {
    console.log(`event ${event.kind} of tick ${event.tick}, ${event.payload.length} bytes`);
  }
  const own = client.own();
  if (state === CLOSED) {
    status.textContent = client.trouble;
    return;
  }
  if (own) {
    const others = client.entities();
    draw(own, others);
    status.textContent = describe(client, own, others);
  }
  requestAnimationFrame(() => frame(client));
}

const query = new URLSearchParams(location.search);
const client = new WebClient(await load(await fetch('zoned_client.wasm')), { name: query.get('name') ?? 'walker' });
client.begin(query.get('server') ?? 'ws://127.0.0.1:7780/');
Object.assign(window, { client }); // for a look from the browser's console
frame(client);
