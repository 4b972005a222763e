// The commands and events of the sandbox game (proto/sandbox.proto), as far as the page has them.

export const CHAT = 1;
export const SHOOT = 2;
export const PICK_UP = 3;
export const THROW = 4;
export const PUSH = 5;
export const RIDE = 7;
// An event of it, to the owner of what is carried.
export const INVENTORY = 22;

/** Writes the fields of a Protocol Buffers message; those that are 0 or empty are left out. */
class Writer {
  bytes = [];

  #varint(value) {
    let rest = BigInt.asUintN(64, BigInt(value));
    while (rest >= 128n) {
      this.bytes.push(Number(rest & 127n) | 128);
      rest >>= 7n;
    }
    this.bytes.push(Number(rest));
  }

  number(field, value) {
    if (value) {
      this.#varint(8 * field);
      this.#varint(value);
    }
    return this;
  }

  zigzag(field, value) {
    return this.number(field, value < 0 ? -2n * BigInt(value) - 1n : 2n * BigInt(value));
  }

  float(field, value) {
    if (value !== 0) {
      this.#varint(8 * field + 5);
      this.bytes.push(...new Uint8Array(new Float32Array([value]).buffer));
    }
    return this;
  }

  part(field, bytes) {
    if (bytes.length > 0) {
      this.#varint(8 * field + 2);
      this.#varint(bytes.length);
      this.bytes.push(...bytes);
    }
    return this;
  }

  text(field, text) {
    return this.part(field, new TextEncoder().encode(text));
  }

  get done() {
    return Uint8Array.from(this.bytes);
  }
}

/** Fields of a message by number: numbers, and bytes of what has a length. Lists keep all. */
export function read(bytes) {
  const out = new Map();
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = 0;
  const varint = () => {
    let value = 0;
    for (let shift = 0; ; shift += 7) {
      const byte = bytes[at++];
      value += (byte & 127) * 2 ** shift;
      if (!(byte & 128)) {
        return value;
      }
    }
  };
  while (at < bytes.length) {
    const key = varint();
    const [field, kind] = [Math.floor(key / 8), key % 8];
    let value;
    if (kind === 0) {
      value = varint();
    } else if (kind === 2) {
      const size = varint();
      value = bytes.subarray(at, at + size);
      at += size;
    } else if (kind === 5) {
      value = view.getFloat32(at, true);
      at += 4;
    } else {
      value = view.getFloat64(at, true);
      at += 8;
    }
    out.set(field, [...(out.get(field) ?? []), value]);
  }
  return {
    number: (field) => out.get(field)?.at(-1) ?? 0,
    text: (field) => new TextDecoder().decode(out.get(field)?.at(-1) ?? new Uint8Array(0)),
    /** Of a packed list. */
    numbers(field) {
      const list = [];
      for (const part of out.get(field) ?? []) {
        if (typeof part === 'number') {
          list.push(part);
          continue;
        }
        for (let i = 0, value = 0, scale = 1; i < part.length; ++i) {
          value += (part[i] & 127) * scale;
          scale *= 128;
          if (!(part[i] & 128)) {
            list.push(value);
            [value, scale] = [0, 1];
          }
        }
      }
      return list;
    },
  };
}

export function chat(text) {
  return new Writer().text(1, 'world').text(2, text).done;
}

export function entity(id) {
  return new Writer().number(1, id).done;
}

export function thrown(item, [x, y, z]) {
  return new Writer().number(1, item).float(2, x).float(3, y).float(4, z).done;
}

/** A shot with what was seen: `aim` of WebClient.aim(). */
export function shot(tick, [x, y, z], aim) {
  const seen = new Writer().number(1, aim.past ? 1 : 0).number(2, aim.tick).number(3, Math.floor(65536 * aim.fraction)).number(4, aim.hit);
  for (const { entity: id, publication, place } of aim.sight) {
    const steps = place.map((v) => Math.round(4096 * v));
    seen.part(5, new Writer().number(1, id).zigzag(2, steps[0]).zigzag(3, steps[1]).zigzag(4, steps[2]).number(5, publication).done);
  }
  return new Writer().number(1, tick).float(2, x).float(3, y).float(4, z).part(40, seen.done).done;
}

/** An event as a line for players, or an empty text. */
export function describe({ kind, payload }, own) {
  const m = read(payload);
  const who = (id) => (id === own ? 'you' : `player ${id}`);
  const lines = {
    10: () => `Operator: ${m.text(1)}`,
    16: () => `${m.text(3)} has come`,
    17: () => `${m.text(3)} has gone`,
    18: () => `${m.text(2)}: ${m.text(3)}`,
    19: () => (m.number(1) === own || m.number(2) === own ? `${who(m.number(1))} hit ${who(m.number(2))}: ${m.number(4)} left` : ''),
    20: () => `${who(m.number(1))} killed ${who(m.number(2))}`,
    24: () => `Not done: ${m.text(2)}`,
  };
  return lines[kind]?.() ?? '';
}
