// WebClient: the client library as a WebAssembly module, with a WebSocket of the page. Its types are zoned_client.d.ts.

const SCRATCH_BYTES = 1 << 20;
const WISH_OPEN = 1;
const WISH_CLOSE = 2;
const TOO_SMALL = -3;
const ENTITY_NUMBERS = 15;

export const IDLE = 0;
export const CONNECTING = 1;
export const ONLINE = 2;
/** The connection was lost; the client tries again by itself, and resumes. */
export const WAITING = 3;
/** For good: `trouble` says why. */
export const CLOSED = 4;
export type State = typeof IDLE | typeof CONNECTING | typeof ONLINE | typeof WAITING | typeof CLOSED;

/** Bits of Input.buttons; 4 to 15 are the game's. */
export const JUMP = 1;
export const SPRINT = 2;

/** Right-handed, y up, m: world coordinates. */
export type Vector = [x: number, y: number, z: number];
export type Quaternion = [x: number, y: number, z: number, w: number];

export interface Settings {
  /** Shown to others, 1 to 32 bytes; a ticket's name wins. */
  name: string;
  team?: string;
  /** A login ticket's bytes; none where the server lets anyone in. */
  ticket?: Uint8Array;
  /** 0: the server's present, predicted; 1: smooth, a little late. */
  view?: 0 | 1;
}

/** Wishes of the avatar from now on; those that are left out are 0. */
export interface Input {
  buttons?: number;
  /** Wanted direction along world x and z, -1 to 1 of full speed. */
  moveX?: number;
  moveZ?: number;
  /** Where it looks, rad: 0 along +z, growing towards +x. */
  yaw?: number;
  /** Up is positive. */
  pitch?: number;
}

/** Another entity as it is displayed now. */
export interface Entity {
  id: number;
  /** Index of types(). */
  type: number;
  zone: number;
  position: Vector;
  orientation: Quaternion;
  /** m/s */
  velocity: Vector;
  /** 16 bits of the game's rules. */
  appearance: number;
  atRest: boolean;
}

/** The own avatar, predicted from the own input. */
export interface Avatar {
  id: number;
  zone: number;
  grounded: boolean;
  /** It rides on something. */
  carried: boolean;
  yaw: number;
  position: Vector;
  eye: Vector;
  velocity: Vector;
  /** Of its newest command. */
  tick: number;
}

export interface GameEvent {
  /** Up to 15 the server's own, from 16 on the game's. */
  kind: number;
  tick: number;
  payload: Uint8Array;
}

export interface World {
  types: number;
  zones: number;
  rights: number;
  tickSeconds: number;
  serverTime: number;
  tick: number;
}

export interface TypeInfo {
  name: string;
  upright: boolean;
  character: boolean;
  /** Of a character's upright capsule, m. */
  radius: number;
  halfSegment: number;
  seats: number;
}

export interface ZoneInfo {
  id: number;
  min_x: number;
  min_z: number;
  max_x: number;
  max_z: number;
  ground: number;
  boxes: number;
  triangles: number;
}

export type FieldValue = number | string | boolean;

export interface FieldInfo {
  name: string;
  /** 0 number, 1 enum, 2 boolean, 3 text. */
  kind: number;
  minimum: number;
  maximum: number;
  quantum: number;
  /** How many an enum has. */
  values: number;
}

/** The sights along a ray, by which a server judges a shot. */
export interface Aim {
  past: boolean;
  tick: number;
  fraction: number;
  /** Entity; 0: none. */
  hit: number;
  sight: { entity: number; publication: number; place: Vector }[];
}

export interface Stats {
  rttMs: number;
  leadMs: number;
  bytesIn: number;
  bytesOut: number;
  packetsIn: number;
  malformed: number;
  resumed: number;
  inputs: number;
  inputsMissing: number;
  /** How often the server compared the avatar's prediction, and by how much it was off. */
  corrections: number;
  correctionM: number;
  correctionM_p99: number;
  correctionM_max: number;
  /** With the right to audits: entities compared with the truth, and the error displayed. */
  audits: number;
  displayedM_p50: number;
  displayedM_p99: number;
  ownM_p99: number;
  judged: number;
  beyond: number;
  missing: number;
  extra: number;
  wrongValues: number;
  predictedM_max: number;
  verdict: string;
}

type Call = 'aim' | 'alloc' | 'boxes' | 'create' | 'entities' | 'error' | 'event' | 'field' | 'field_info' | 'free' | 'input' | 'judged' |
  'name' | 'own' | 'rows' | 'stats' | 'type' | 'verdict' | 'world' | 'zone';
type LibraryCall = 'begin' | 'command' | 'deform' | 'get_state' | 'next_frame' | 'poll' | 'quit' | 'stream_closed' | 'stream_frame' | 'stream_opened' |
  'stream_wish' | 'triangles' | 'trouble';

/** The compiled module, for as many clients as wanted. */
export type ClientModule = Record<`web_${Call}` | `zoned_client_${LibraryCall}`, (...numbers: number[]) => number> & {
  readonly memory: WebAssembly.Memory;
};

/** The system that the module asks for: it writes a line when it has to stop. */
function system(memory: () => WebAssembly.Memory, complain: (text: string) => void) {
  return {
    fd_write(_file: number, list: number, count: number, written: number) {
      const view = new DataView(memory().buffer);
      let text = '';
      let bytes = 0;
      for (let i = 0; i < count; ++i) {
        const [at, size] = [view.getUint32(list + 8 * i, true), view.getUint32(list + 8 * i + 4, true)];
        text += new TextDecoder().decode(new Uint8Array(memory().buffer, at, size).slice());
        bytes += size;
      }
      view.setUint32(written, bytes, true);
      complain(text);
      return 0;
    },
    fd_close: () => 8, // no such file
    fd_seek: () => 8,
    proc_exit(code: number) {
      throw new Error(`the client ended with ${code}`);
    },
  };
}

/** Compiles zoned_client.wasm: of a response, or of bytes. */
export async function load(source: Response | BufferSource, complain = (text: string) => console.error(text)): Promise<ClientModule> {
  let memory: WebAssembly.Memory;
  const imports = { wasi_snapshot_preview1: system(() => memory, complain) };
  const { instance } = source instanceof Response
    ? await WebAssembly.instantiateStreaming(source, imports)
    : await WebAssembly.instantiate(source, imports);
  const code = instance.exports as unknown as ClientModule & { _initialize(): void };
  memory = code.memory;
  code._initialize();
  return code;
}

/** One session. Each frame: input(), poll(), event() until there is none; then own() and entities(), and draw. */
export class WebClient {
  readonly #code: ClientModule;
  #size = SCRATCH_BYTES;
  #scratch: number;
  readonly #numbersAt: number;
  readonly #client: number;
  #url = '';
  /** null while there is no connection. */
  socket: WebSocket | null = null;

  /** Throws where settings are wrong. */
  constructor(code: ClientModule, { name, team = '', ticket = new Uint8Array(0), view = 0 }: Settings) {
    this.#code = code;
    this.#scratch = code.web_alloc(this.#size);
    this.#numbersAt = code.web_alloc(8 * 64);
    const texts = [name, team].map((text) => this.#text(text));
    const bytes = code.web_alloc(Math.max(1, ticket.length));
    this.#bytes(bytes, ticket.length).set(ticket);
    this.#client = code.web_create(texts[0], texts[1], bytes, ticket.length, view);
    [...texts, bytes].forEach((at) => code.web_free(at));
    if (this.#client === 0) {
      throw new Error(this.#read(code.web_error()));
    }
  }

  #bytes(at: number, size: number): Uint8Array {
    return new Uint8Array(this.#code.memory.buffer, at, size);
  }

  #numbers(count = 64): Float64Array {
    return new Float64Array(this.#code.memory.buffer, this.#numbersAt, count);
  }

  #text(text: string): number {
    const bytes = new TextEncoder().encode(`${text}\0`);
    const at = this.#code.web_alloc(bytes.length);
    this.#bytes(at, bytes.length).set(bytes);
    return at;
  }

  #read(at: number): string {
    const bytes = new Uint8Array(this.#code.memory.buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  #reserve(size: number): void {
    if (size > this.#size) {
      this.#code.web_free(this.#scratch);
      this.#size = 2 ** Math.ceil(Math.log2(size));
      this.#scratch = this.#code.web_alloc(this.#size);
    }
  }

  /** Begins a session at a WebSocket's address; poll() goes on. */
  begin(url: string): void {
    this.#url = url;
    this.#code.zoned_client_begin(this.#client);
  }

  #open(): void {
    this.#drop();
    let socket: WebSocket;
    try {
      socket = new WebSocket(this.#url, ['zoned']);
    } catch (error) {
      this.#closed((error as Error).message); // the page's policy forbids the address, or it is none
      return;
    }
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    socket.onopen = () => {
      this.#code.zoned_client_stream_opened(this.#client);
      this.poll();
    };
    socket.onmessage = ({ data }) => {
      if (typeof data === 'string') {
        return;
      }
      this.#reserve(data.byteLength);
      this.#bytes(this.#scratch, data.byteLength).set(new Uint8Array(data));
      this.#code.zoned_client_stream_frame(this.#client, this.#scratch, data.byteLength);
      this.poll(); // now, and not with the next picture: the clock is known by when packets came
    };
    socket.onclose = ({ reason, wasClean }) => {
      this.socket = null;
      this.#closed(reason || (wasClean ? '' : 'the connection was lost or refused'));
    };
  }

  #closed(reason: string): void {
    const text = this.#text(reason);
    this.#code.zoned_client_stream_closed(this.#client, text);
    this.#code.web_free(text);
  }

  #drop(): void {
    if (this.socket) {
      this.socket.onopen = this.socket.onmessage = this.socket.onclose = null;
      this.socket.close();
      this.socket = null;
    }
  }

  /** All that is due; returns the state. */
  poll(): State {
    const code = this.#code;
    const state = code.zoned_client_poll(this.#client, performance.now() / 1000);
    this.#flush();
    return state as State;
  }

  #flush(): void {
    const code = this.#code;
    for (;;) {
      const size = code.zoned_client_next_frame(this.#client, this.#scratch, this.#size);
      if (size === 0) {
        break;
      }
      if (size > this.#size) {
        this.#reserve(size);
      } else if (this.socket?.readyState === WebSocket.OPEN) {
        this.socket.send(this.#bytes(this.#scratch, size));
      }
    }
    const wish = code.zoned_client_stream_wish(this.#client);
    if (wish === WISH_OPEN) {
      this.#open();
    } else if (wish === WISH_CLOSE) {
      this.#drop();
    }
  }

  /** Says goodbye. */
  quit(): void {
    this.#code.zoned_client_quit(this.#client);
    this.#flush();
    this.#drop();
  }

  get state(): State {
    return this.#code.zoned_client_get_state(this.#client) as State;
  }

  /** Why it is closed or waiting, in one line. */
  get trouble(): string {
    return this.#read(this.#code.zoned_client_trouble(this.#client));
  }

  /** Holds until the next one. */
  input({ buttons = 0, moveX = 0, moveZ = 0, yaw = 0, pitch = 0 }: Input): void {
    this.#code.web_input(this.#client, buttons, moveX, moveZ, yaw, pitch);
  }

  /** A reliable command of the game; false: not now. */
  command(kind: number, payload: Uint8Array): boolean {
    this.#reserve(payload.length);
    this.#bytes(this.#scratch, payload.length).set(payload);
    return this.#code.zoned_client_command(this.#client, kind, this.#scratch, payload.length) === 0;
  }

  /** The next event, once and in order, or null. */
  event(): GameEvent | null {
    const code = this.#code;
    let got = code.web_event(this.#client, this.#numbersAt, this.#scratch, this.#size);
    if (got === TOO_SMALL) {
      this.#reserve(this.#numbers()[2]);
      got = code.web_event(this.#client, this.#numbersAt, this.#scratch, this.#size);
    }
    if (got !== 1) {
      return null;
    }
    const [kind, tick, size] = this.#numbers();
    return { kind, tick, payload: this.#bytes(this.#scratch, size).slice() };
  }

  /** null before there is an avatar. */
  own(): Avatar | null {
    if (this.#code.web_own(this.#client, this.#numbersAt) !== 1) {
      return null;
    }
    const n = [...this.#numbers(15)];
    return {
      id: n[0], zone: n[1], grounded: n[2] !== 0, carried: n[3] !== 0, yaw: n[4],
      position: [n[5], n[6], n[7]], eye: [n[8], n[9], n[10]], velocity: [n[11], n[12], n[13]], tick: n[14],
    };
  }

  /** The entities displayed now, by ascending id and without the own avatar. */
  entities(): Entity[] {
    const count = this.#code.web_entities(this.#client, 0, 0);
    this.#reserve(8 * ENTITY_NUMBERS * count);
    this.#code.web_entities(this.#client, this.#scratch, count);
    const all = new Float64Array(this.#code.memory.buffer, this.#scratch, ENTITY_NUMBERS * count);
    return Array.from({ length: count }, (_, i) => {
      const n = all.subarray(ENTITY_NUMBERS * i);
      return {
        id: n[0], type: n[1], zone: n[2], appearance: n[3], atRest: n[4] !== 0,
        position: [n[5], n[6], n[7]], orientation: [n[8], n[9], n[10], n[11]], velocity: [n[12], n[13], n[14]],
      };
    });
  }

  /** Value of an entity's declared field, by name or index; null: there is none. */
  field(entity: number, nameOrIndex: string | number): FieldValue | null {
    const named = typeof nameOrIndex === 'string';
    const name = named ? this.#text(nameOrIndex) : 0;
    const got = this.#code.web_field(this.#client, entity, named ? 0 : nameOrIndex, name, this.#numbersAt);
    if (named) {
      this.#code.web_free(name);
    }
    if (got !== 1) {
      return null;
    }
    const [kind, number] = this.#numbers(2);
    return [number, this.#read(this.#code.web_name()), number !== 0, this.#read(this.#code.web_name())][kind];
  }

  /** The fields that a type declares. */
  fields(type: number): FieldInfo[] {
    const out: FieldInfo[] = [];
    while (this.#code.web_field_info(this.#client, type, out.length, this.#numbersAt) === 1) {
      const [kind, minimum, maximum, quantum, values] = this.#numbers(5);
      out.push({ name: this.#read(this.#code.web_name()), kind, minimum, maximum, quantum, values });
    }
    return out;
  }

  /**
   * Deforms places on the undeformed soft body, three numbers each, as it is deformed now; the entity's pose is applied to them
   * afterwards. False, and nothing changes, where the entity is not known or has no deformation.
   */
  deform(entity: number, places: Float32Array): boolean {
    this.#reserve(places.byteLength);
    const inside = () => new Float32Array(this.#code.memory.buffer, this.#scratch, places.length);
    inside().set(places);
    if (this.#code.zoned_client_deform(this.#client, entity, this.#scratch, places.length / 3) !== 1) {
      return false;
    }
    places.set(inside());
    return true;
  }

  /** null before the server has described the world. */
  world(): World | null {
    if (this.#code.web_world(this.#client, this.#numbersAt) !== 1) {
      return null;
    }
    const [types, zones, rights, tickSeconds, serverTime, tick] = this.#numbers();
    return { types, zones, rights, tickSeconds, serverTime, tick };
  }

  types(): TypeInfo[] {
    const out: TypeInfo[] = [];
    while (this.#code.web_type(this.#client, out.length, this.#numbersAt) === 1) {
      const [upright, character, radius, halfSegment, seats] = this.#numbers(5);
      out.push({ name: this.#read(this.#code.web_name()), upright: upright !== 0, character: character !== 0, radius, halfSegment, seats });
    }
    return out;
  }

  zones(): ZoneInfo[] {
    const out: ZoneInfo[] = [];
    while (this.#code.web_zone(this.#client, out.length, this.#numbersAt) === 1) {
      const n = this.#numbers();
      out.push({ id: n[0], min_x: n[1], min_z: n[2], max_x: n[3], max_z: n[4], ground: n[5], boxes: n[6], triangles: n[7] });
    }
    return out;
  }

  /** Ten numbers for each solid box of a zone: walls (0), doors that are shut now (1), or platforms where they are now (2). */
  boxes(zone: number, kind: 0 | 1 | 2): Float32Array {
    const count = this.#code.web_boxes(this.#client, zone, kind, 0, 0);
    this.#reserve(40 * count);
    this.#code.web_boxes(this.#client, zone, kind, this.#scratch, count);
    return new Float32Array(this.#code.memory.buffer, this.#scratch, 10 * count).slice();
  }

  /** Nine numbers for each triangle of a zone. */
  triangles(zone: number): Float32Array {
    const count = this.#code.zoned_client_triangles(this.#client, zone, 0, 0);
    this.#reserve(72 * count);
    this.#code.zoned_client_triangles(this.#client, zone, this.#scratch, count);
    return Float32Array.from(new Float64Array(this.#code.memory.buffer, this.#scratch, 9 * count));
  }

  /** The scene as it is displayed now, for the viewer's renderer; null before there is a world. */
  rows(ownType: number): ArrayBuffer | null {
    for (;;) {
      const bytes = this.#code.web_rows(this.#client, ownType, this.#scratch, this.#size);
      if (bytes === 0) {
        return null;
      }
      if (bytes + 44 <= this.#size) {
        return this.#bytes(this.#scratch, bytes).slice().buffer;
      }
      this.#reserve(2 * this.#size);
    }
  }

  stats(): Stats | null {
    if (this.#code.web_stats(this.#client, this.#numbersAt) !== 1) {
      return null;
    }
    const n = [...this.#numbers(17)];
    this.#code.web_judged(this.#client, this.#numbersAt);
    const [judged, beyondM, beyondRad, missing, extra, wrongValues, predictedM_max] = this.#numbers(7);
    return {
      rttMs: n[0], leadMs: n[1], bytesIn: n[2], bytesOut: n[3], packetsIn: n[4], malformed: n[5], resumed: n[6],
      inputs: n[7], inputsMissing: n[8], corrections: n[9], correctionM: n[10], correctionM_p99: n[11], correctionM_max: n[12],
      audits: n[13], displayedM_p50: n[14], displayedM_p99: n[15], ownM_p99: n[16],
      judged, beyond: beyondM + beyondRad, missing, extra, wrongValues, predictedM_max, verdict: this.verdict,
    };
  }

  /** By the rules for bots: "consistent", or "inconsistent" with its reasons; empty: nothing was compared. */
  get verdict(): string {
    return this.#read(this.#code.web_verdict(this.#client));
  }

  /** Characters along a ray, as a server must know them to judge a shot. */
  aim(eye: Vector, direction: Vector, range: number): Aim | null {
    const n = this.#numbers();
    n.set(eye, 0);
    n.set(direction, 3);
    const at = this.#numbersAt;
    const sights = this.#code.web_aim(this.#client, at, at + 24, range, at + 48);
    if (sights < 0) {
      return null;
    }
    const [past, tick, fraction, hit] = this.#numbers().slice(6, 10);
    const sight = Array.from({ length: sights }, (_, i) => {
      const [entity, publication, x, y, z] = this.#numbers().slice(10 + 5 * i, 15 + 5 * i);
      return { entity, publication, place: [x, y, z] as Vector };
    });
    return { past: past !== 0, tick, fraction, hit, sight };
  }
}
