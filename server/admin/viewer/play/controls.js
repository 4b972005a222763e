// Keys, mouse and touch of a player, as wishes of the avatar.

const JUMP = 1;
const SPRINT = 2;
const STICK_PIXELS = 56;
const KEYS = { KeyW: 'ahead', ArrowUp: 'ahead', KeyS: 'back', ArrowDown: 'back', KeyA: 'left', ArrowLeft: 'left', KeyD: 'right', ArrowRight: 'right', Space: 'jump', ShiftLeft: 'sprint', ShiftRight: 'sprint' };

export class PlayerControls {
  /** `on` has act(name) for "shoot", "push", "pick_up", "throw", "ride", "chat", "view". */
  constructor(canvas, on) {
    this.canvas = canvas;
    this.on = on;
    this.held = new Set();
    this.yaw = 0; // rad; 0 looks along +z, and it grows towards +x
    this.pitch = 0; // up is positive
    this.stick = [0, 0]; // to the right, ahead
    this.#keys();
    this.#mouse();
  }

  /** Where it looks. */
  direction() {
    const level = Math.cos(this.pitch);
    return [level * Math.sin(this.yaw), Math.sin(this.pitch), level * Math.cos(this.yaw)];
  }

  /** The avatar's wishes now. */
  input() {
    const pressed = (name) => (this.held.has(name) ? 1 : 0);
    const right = pressed('right') - pressed('left') + this.stick[0];
    const ahead = pressed('ahead') - pressed('back') + this.stick[1];
    const [s, c] = [Math.sin(this.yaw), Math.cos(this.yaw)];
    return {
      buttons: JUMP * pressed('jump') + SPRINT * pressed('sprint'),
      moveX: ahead * s - right * c,
      moveZ: ahead * c + right * s,
      yaw: this.yaw,
      pitch: this.pitch,
    };
  }

  turn(dx, dy) {
    this.yaw = (this.yaw - 0.003 * dx) % (2 * Math.PI);
    this.pitch = Math.min(1.5, Math.max(-1.5, this.pitch - 0.003 * dy));
  }

  #keys() {
    const acts = { KeyE: 'push', KeyQ: 'pick_up', KeyG: 'throw', KeyR: 'ride', Enter: 'chat', KeyV: 'view' };
    window.addEventListener('keydown', (event) => {
      if (event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement || event.ctrlKey || event.metaKey) {
        return;
      }
      if (KEYS[event.code]) {
        this.held.add(KEYS[event.code]);
        event.preventDefault();
      } else if (acts[event.code] && !event.repeat) {
        this.on.act(acts[event.code]);
        event.preventDefault();
      }
    });
    window.addEventListener('keyup', (event) => this.held.delete(KEYS[event.code]));
    window.addEventListener('blur', () => this.held.clear());
  }

  #mouse() {
    const { canvas } = this;
    const locked = () => document.pointerLockElement === canvas;
    canvas.addEventListener('pointerdown', (event) => {
      if (event.pointerType === 'touch') {
        canvas.setPointerCapture(event.pointerId);
      } else if (locked()) {
        this.on.act('shoot');
      } else {
        canvas.focus();
        canvas.requestPointerLock?.()?.catch?.(() => {});
      }
    });
    canvas.addEventListener('pointermove', (event) => {
      if (locked() || event.pointerType === 'touch' || event.buttons === 1) {
        this.turn(event.movementX, event.movementY);
      }
    });
  }

  /** A stick and a button for fingers. */
  useTouch(stick, jump) {
    const move = (event) => {
      const box = stick.getBoundingClientRect();
      const x = (event.clientX - box.left - box.width / 2) / STICK_PIXELS;
      const y = (event.clientY - box.top - box.height / 2) / STICK_PIXELS;
      const length = Math.max(1, Math.hypot(x, y));
      this.stick = [x / length, -y / length];
    };
    const stop = () => { this.stick = [0, 0]; };
    stick.addEventListener('pointerdown', (event) => {
      stick.setPointerCapture(event.pointerId);
      move(event);
    });
    stick.addEventListener('pointermove', (event) => event.buttons && move(event));
    stick.addEventListener('pointerup', stop);
    stick.addEventListener('pointercancel', stop);
    jump.addEventListener('pointerdown', () => this.held.add('jump'));
    jump.addEventListener('pointerup', () => this.held.delete('jump'));
    jump.addEventListener('pointercancel', () => this.held.delete('jump'));
  }
}
