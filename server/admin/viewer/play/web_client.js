// WebClient: the client library as a WebAssembly module (client-sim/web), with a WebSocket of the page.

const SCRATCH_BYTES = 1 << 20;
const WISH_OPEN = 1;
const WISH_CLOSE = 2;
const TOO_SMALL = -3;

export const IDLE = 0;
export const CONNECTING = 1;
export const ONLINE = 2;
export const WAITING = 3;
export const CLOSED = 4;

/** What the module asks of a system: it writes a line when it has to stop. */
function system(memory, complain) {
  return {
    fd_write(file, list, count, written) {
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
    proc_exit(code) {
      throw new Error(`the client ended with ${code}`);
    },
  };
}

/** Compiles the module; `source` is a response or bytes. */
export async function load(source, complain = (text) => console.error(text)) {
  let memory = null;
  const imports = { wasi_snapshot_preview1: system(() => memory, complain) };
  const { instance } = source instanceof Response
    ? await WebAssembly.instantiateStreaming(source, imports)
    : await WebAssembly.instantiate(source, imports);
  memory = instance.exports.memory;
  instance.exports._initialize();
  return instance.exports;
}

export class WebClient {
  /** `code`: of load(). `settings`: name, team, ticket (bytes), view (0 or 1). Throws where they are wrong. */
  constructor(code, { name, team = '', ticket = new Uint8Array(0), view = 0 }) {
    this.code = code;
    this.size = SCRATCH_BYTES;
    this.scratch = code.web_alloc(this.size);
    this.numbersAt = code.web_alloc(8 * 64);
    const texts = [name, team].map((text) => this.#text(text));
    const bytes = code.web_alloc(Math.max(1, ticket.length));
    this.#bytes(bytes, ticket.length).set(ticket);
    this.client = code.web_create(texts[0], texts[1], bytes, ticket.length, view);
    [...texts, bytes].forEach((at) => code.web_free(at));
    if (this.client === 0) {
      throw new Error(this.#read(code.web_error()));
    }
    this.socket = null;
  }

  #bytes(at, size) {
    return new Uint8Array(this.code.memory.buffer, at, size);
  }

  #numbers(count = 64) {
    return new Float64Array(this.code.memory.buffer, this.numbersAt, count);
  }

  #text(text) {
    const bytes = new TextEncoder().encode(`${text}\0`);
    const at = this.code.web_alloc(bytes.length);
    this.#bytes(at, bytes.length).set(bytes);
    return at;
  }

  #read(at) {
    const bytes = new Uint8Array(this.code.memory.buffer, at);
    return new TextDecoder().decode(bytes.slice(0, bytes.indexOf(0)));
  }

  #reserve(size) {
    if (size > this.size) {
      this.code.web_free(this.scratch);
      this.size = 2 ** Math.ceil(Math.log2(size));
      this.scratch = this.code.web_alloc(this.size);
    }
  }

  /** Begins a session at a WebSocket's address; poll() goes on. */
  begin(url) {
    this.url = url;
    this.code.zoned_client_begin(this.client);
  }

  #open() {
    this.#drop();
    let socket;
    try {
      socket = new WebSocket(this.url, ['zoned']);
    } catch (error) {
      this.#closed(error.message); // the page's policy forbids the address, or it is none
      return;
    }
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    socket.onopen = () => {
      this.code.zoned_client_stream_opened(this.client);
      this.poll();
    };
    socket.onmessage = ({ data }) => {
      if (typeof data === 'string') {
        return;
      }
      this.#reserve(data.byteLength);
      this.#bytes(this.scratch, data.byteLength).set(new Uint8Array(data));
      this.code.zoned_client_stream_frame(this.client, this.scratch, data.byteLength);
      this.poll(); // now, and not with the next picture: the clock is known by when packets came
    };
    socket.onclose = ({ reason, wasClean }) => {
      this.socket = null;
      this.#closed(reason || (wasClean ? '' : 'the connection was lost or refused'));
    };
  }

  #closed(reason) {
    const text = this.#text(reason);
    this.code.zoned_client_stream_closed(this.client, text);
    this.code.web_free(text);
  }

  #drop() {
    if (this.socket) {
      this.socket.onopen = this.socket.onmessage = this.socket.onclose = null;
      this.socket.close();
      this.socket = null;
    }
  }

  /** All that is due; returns the state. */
  poll() {
    const { code } = this;
    const state = code.zoned_client_poll(this.client, performance.now() / 1000);
    this.#flush();
    return state;
  }

  #flush() {
    const { code } = this;
    for (;;) {
      const size = code.zoned_client_next_frame(this.client, this.scratch, this.size);
      if (size === 0) {
        break;
      }
      if (size > this.size) {
        this.#reserve(size);
      } else if (this.socket?.readyState === WebSocket.OPEN) {
        this.socket.send(this.#bytes(this.scratch, size));
      }
    }
    const wish = code.zoned_client_stream_wish(this.client);
    if (wish === WISH_OPEN) {
      this.#open();
    } else if (wish === WISH_CLOSE) {
      this.#drop();
    }
  }

  quit() {
    this.code.zoned_client_quit(this.client);
    this.#flush();
    this.#drop();
  }

  get state() {
    return this.code.zoned_client_get_state(this.client);
  }

  get trouble() {
    return this.#read(this.code.zoned_client_trouble(this.client));
  }

  input({ buttons, moveX, moveZ, yaw, pitch }) {
    this.code.web_input(this.client, buttons, moveX, moveZ, yaw, pitch);
  }

  command(kind, payload) {
    this.#reserve(payload.length);
    this.#bytes(this.scratch, payload.length).set(payload);
    return this.code.zoned_client_command(this.client, kind, this.scratch, payload.length) === 0;
  }

  /** The next event, or null. */
  event() {
    const { code } = this;
    let got = code.web_event(this.client, this.numbersAt, this.scratch, this.size);
    if (got === TOO_SMALL) {
      this.#reserve(this.#numbers()[2]);
      got = code.web_event(this.client, this.numbersAt, this.scratch, this.size);
    }
    if (got !== 1) {
      return null;
    }
    const [kind, tick, size] = this.#numbers();
    return { kind, tick, payload: this.#bytes(this.scratch, size).slice() };
  }

  /** null before there is an avatar. */
  own() {
    if (this.code.web_own(this.client, this.numbersAt) !== 1) {
      return null;
    }
    const n = [...this.#numbers(15)];
    return {
      id: n[0], zone: n[1], grounded: n[2] !== 0, carried: n[3] !== 0, yaw: n[4],
      position: n.slice(5, 8), eye: n.slice(8, 11), velocity: n.slice(11, 14), tick: n[14],
    };
  }

  /** Value of an entity's declared field, by name or index: a number, a boolean or a text; null: there is none. */
  field(entity, nameOrIndex) {
    const named = typeof nameOrIndex === 'string';
    const name = named ? this.#text(nameOrIndex) : 0;
    const got = this.code.web_field(this.client, entity, named ? 0 : nameOrIndex, name, this.numbersAt);
    if (named) {
      this.code.web_free(name);
    }
    if (got !== 1) {
      return null;
    }
    const [kind, number] = this.#numbers(2);
    return [number, this.#read(this.code.web_name()), number !== 0, this.#read(this.code.web_name())][kind];
  }

  /** The fields that a type declares: name, kind (0 number, 1 enum, 2 boolean, 3 text), range. */
  fields(type) {
    const out = [];
    while (this.code.web_field_info(this.client, type, out.length, this.numbersAt) === 1) {
      const [kind, minimum, maximum, quantum, values] = this.#numbers(5);
      out.push({ name: this.#read(this.code.web_name()), kind, minimum, maximum, quantum, values });
    }
    return out;
  }

  /** null before the server has described the world. */
  world() {
    if (this.code.web_world(this.client, this.numbersAt) !== 1) {
      return null;
    }
    const [types, zones, rights, tickSeconds, serverTime, tick] = this.#numbers();
    return { types, zones, rights, tickSeconds, serverTime, tick };
  }

  types() {
    const out = [];
    while (this.code.web_type(this.client, out.length, this.numbersAt) === 1) {
      const [upright, character, radius, halfSegment, seats] = this.#numbers(5);
      out.push({ name: this.#read(this.code.web_name()), upright, character: character !== 0, radius, halfSegment, seats });
    }
    return out;
  }

  zones() {
    const out = [];
    while (this.code.web_zone(this.client, out.length, this.numbersAt) === 1) {
      const n = this.#numbers();
      out.push({ id: n[0], min_x: n[1], min_z: n[2], max_x: n[3], max_z: n[4], ground: n[5], boxes: n[6], triangles: n[7] });
    }
    return out;
  }

  /** Ten numbers for each solid box of a zone: walls, or the doors that are shut now. */
  boxes(zone, doors) {
    const count = this.code.web_boxes(this.client, zone, doors ? 1 : 0, 0, 0);
    this.#reserve(40 * count);
    this.code.web_boxes(this.client, zone, doors ? 1 : 0, this.scratch, count);
    return new Float32Array(this.code.memory.buffer, this.scratch, 10 * count).slice();
  }

  /** Nine numbers for each triangle of a zone. */
  triangles(zone) {
    const count = this.code.zoned_client_triangles(this.client, zone, 0, 0);
    this.#reserve(72 * count);
    this.code.zoned_client_triangles(this.client, zone, this.scratch, count);
    return Float32Array.from(new Float64Array(this.code.memory.buffer, this.scratch, 9 * count));
  }

  /** What is displayed now, as entities.js takes it; null before there is a world. */
  rows(ownType) {
    for (;;) {
      const bytes = this.code.web_rows(this.client, ownType, this.scratch, this.size);
      if (bytes === 0) {
        return null;
      }
      if (bytes + 44 <= this.size) {
        return this.#bytes(this.scratch, bytes).slice().buffer;
      }
      this.#reserve(2 * this.size);
    }
  }

  stats() {
    if (this.code.web_stats(this.client, this.numbersAt) !== 1) {
      return null;
    }
    const n = [...this.#numbers(17)];
    this.code.web_judged(this.client, this.numbersAt);
    const [judged, beyondM, beyondRad, missing, extra, wrongValues, predictedM_max] = this.#numbers(7);
    return {
      rttMs: n[0], leadMs: n[1], bytesIn: n[2], bytesOut: n[3], packetsIn: n[4], malformed: n[5], resumed: n[6],
      inputs: n[7], inputsMissing: n[8], corrections: n[9], correctionM: n[10], correctionM_p99: n[11], correctionM_max: n[12],
      audits: n[13], displayedM_p50: n[14], displayedM_p99: n[15], ownM_p99: n[16],
      judged, beyond: beyondM + beyondRad, missing, extra, wrongValues, predictedM_max, verdict: this.verdict,
    };
  }

  /** By the rules for bots: "consistent", or "inconsistent" with its reasons; empty: nothing was compared. */
  get verdict() {
    return this.#read(this.code.web_verdict(this.client));
  }

  /** Characters along a ray, as a server must know them to judge a shot. */
  aim(eye, direction, range) {
    const n = this.#numbers();
    n.set(eye, 0);
    n.set(direction, 3);
    const at = this.numbersAt;
    const sights = this.code.web_aim(this.client, at, at + 24, range, at + 48);
    if (sights < 0) {
      return null;
    }
    const [past, tick, fraction, hit] = this.#numbers().slice(6, 10);
    const sight = Array.from({ length: sights }, (_, i) => {
      const [entity, publication, ...place] = this.#numbers().slice(10 + 5 * i, 15 + 5 * i);
      return { entity, publication, place };
    });
    return { past: past !== 0, tick, fraction, hit, sight };
  }
}
