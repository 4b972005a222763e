// The stream of the admin server: scene, entities and layers, opened again whenever it ends.

const AGAIN_MS = 500;
const REFUSED_AGAIN_MS = 2000;
/** Pieces of geometry that are asked for at the same time. */
const PIECES_AT_ONCE = 3;

export const LAYERS = { joints: 1, softs: 2, particles: 4, ghosts: 8, moved: 16 };

export class Stream {
  /** `on` has scene(scene), entities(buffer), layer(kind, buffer), piece(buffer), state(text). */
  constructor(on) {
    this.on = on;
    this.token = '';
    this.opened = 0;
    this.wish = new ArrayBuffer(16);
    this.wished = '';
  }

  /** Opens the stream with another token. */
  restart(token) {
    clearTimeout(this.timer);
    if (this.socket) {
      this.socket.onclose = null;
      this.socket.close();
    }
    this.start(token);
  }

  start(token) {
    this.token = token;
    if (!token) {
      this.on.state('no token');
      return;
    }
    const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
    const socket = new WebSocket(`${scheme}://${location.host}/api/v1/spectate`, ['zoned', token]);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.wished = '';
    let heard = false;
    socket.onmessage = ({ data }) => {
      heard = true;
      if (typeof data === 'string') {
        this.#begin(JSON.parse(data));
        return;
      }
      const [kind] = new Uint32Array(data, 0, 1);
      if (kind <= 2) {
        this.on.entities(data);
      } else {
        this.on.layer(kind, data);
      }
    };
    socket.onclose = () => {
      ++this.opened; // pieces of this connection count no more
      this.on.state(heard ? 'the connection is gone, trying again' : 'no connection, trying again');
      this.timer = setTimeout(() => this.start(this.token), heard ? AGAIN_MS : REFUSED_AGAIN_MS);
    };
  }

  #begin(scene) {
    const opened = ++this.opened;
    const same = scene.digest === this.digest && this.whole;
    this.digest = scene.digest;
    this.on.scene(scene, same);
    this.on.state('live');
    if (same) {
      return;
    }
    this.whole = false;
    let next = 1;
    let done = 0;
    const fetchNext = async () => {
      while (next <= scene.pieces && opened === this.opened) {
        const answer = await this.get(`api/v1/scene/pieces/${next++}`);
        const piece = answer && (await answer.arrayBuffer());
        if (opened !== this.opened) {
          return;
        }
        if (piece) {
          this.on.piece(piece);
        }
        this.whole = ++done === scene.pieces;
      }
    };
    for (let i = 0; i < PIECES_AT_ONCE; ++i) {
      fetchNext();
    }
  }

  /** Tells the server what is looked at, when that has changed. */
  tell(layers, eye) {
    const text = `${layers},${eye.map((v) => v.toFixed(1))}`;
    if (this.socket?.readyState !== WebSocket.OPEN || text === this.wished) {
      return;
    }
    this.wished = text;
    const view = new DataView(this.wish);
    view.setUint32(0, layers, true);
    eye.forEach((v, i) => view.setFloat32(4 + 4 * i, v, true));
    this.socket.send(this.wish);
  }

  /** The answer to a request, or null. */
  async get(path) {
    try {
      const answer = await fetch(path, { headers: { Authorization: `Bearer ${this.token}` } });
      return answer.ok ? answer : null;
    } catch {
      return null;
    }
  }

  async getJson(path) {
    return (await (await this.get(path))?.json().catch(() => null)) ?? null;
  }

  async post(path, body) {
    try {
      return await fetch(path, {
        method: 'POST',
        headers: { Authorization: `Bearer ${this.token}`, 'Content-Type': 'application/json' },
        body: JSON.stringify(body),
      });
    } catch {
      return null;
    }
  }
}
