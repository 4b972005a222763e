// The tick that is shown: it runs on between the server's messages, and never far beyond the newest.

/** Ticks that it may run ahead of the newest that was told. */
const MOST_AHEAD = 3;

export class TickClock {
  constructor() {
    this.tickSeconds = 1 / 30;
    this.reset();
  }

  reset() {
    this.told = 0;
    this.shown = 0;
    this.at = 0; // ms, of the last frame
  }

  /** A message told a tick. */
  hear(tick) {
    if (this.told === 0 || tick < this.shown - 30 || tick > this.shown + 30) {
      this.shown = tick;
    }
    this.told = tick;
  }

  /** The tick to show at a moment, broken: it keeps an even pace and is drawn to what was told. */
  advance(now) {
    const elapsed = Math.min(250, now - this.at) / 1000;
    this.at = now;
    const next = this.shown + elapsed / this.tickSeconds;
    const ahead = next - this.told;
    this.shown = Math.min(next - 0.1 * (ahead - 0.5), this.told + MOST_AHEAD);
    return this.shown;
  }
}
