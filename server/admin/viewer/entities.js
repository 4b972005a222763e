// The entities as the server's messages tell them (server/admin/spectator_hub.h).

const ROW_BYTES = 28;

export class Entities {
  constructor() {
    this.clear();
  }

  clear() {
    this.rows = new Map(); // id -> row
    this.tick = 0;
  }

  /** Takes one message; throws on anything malformed. */
  take(buffer) {
    const view = new DataView(buffer);
    const kind = view.getUint32(0, true);
    this.tick = view.getUint32(4, true);
    const removed = view.getUint32(8, true);
    const count = view.getUint32(12, true);
    if ((kind !== 1 && kind !== 2) || buffer.byteLength !== 16 + 4 * removed + ROW_BYTES * count) {
      throw new Error('a message of the server is malformed');
    }
    if (kind === 1) {
      this.rows.clear();
    }
    let at = 16;
    for (let i = 0; i < removed; ++i, at += 4) {
      this.rows.delete(view.getUint32(at, true));
    }
    for (let i = 0; i < count; ++i, at += ROW_BYTES) {
      const id = view.getUint32(at, true);
      let row = this.rows.get(id);
      if (!row) {
        row = { id, p: [0, 0, 0], q: [0, 0, 0, 1], type: 0, flags: 0, zone: 0 };
        this.rows.set(id, row);
      }
      for (let k = 0; k < 3; ++k) {
        row.p[k] = view.getFloat32(at + 4 + 4 * k, true);
      }
      for (let k = 0; k < 4; ++k) {
        row.q[k] = view.getInt16(at + 16 + 2 * k, true) / 32767;
      }
      row.type = view.getUint16(at + 24, true);
      row.flags = view.getUint8(at + 26);
      row.zone = view.getUint8(at + 27);
    }
  }
}
