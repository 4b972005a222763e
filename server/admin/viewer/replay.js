// A slider over a recording: where it is let go, the server simulates to.

const element = (id) => document.getElementById(id);

export class Replay {
  constructor(stream) {
    this.stream = stream;
    this.held = false;
    this.target = 0; // the server is on its way to this tick; 0: it plays
    this.last = 0;
    const slider = element('slider');
    slider.addEventListener('input', () => {
      this.held = true;
      this.#say(Number(slider.value));
    });
    slider.addEventListener('change', () => this.seek(Number(slider.value)));
  }

  /** `ticks`: of the recording; 0: the world lives. */
  setScene(ticks) {
    this.last = ticks;
    element('replay').hidden = ticks === 0;
    element('slider').max = String(ticks);
  }

  #say(tick, more = '') {
    element('slider-tick').textContent = `${tick} of ${this.last}${more}`;
  }

  async seek(tick) {
    this.target = tick;
    const answer = await this.stream.post('api/v1/replay', { tick });
    this.held = false;
    if (!answer?.ok) {
      this.target = 0;
    }
  }

  /** A few times a second; `tick` is the one that is shown. */
  async refresh(tick) {
    if (this.last === 0 || this.held) {
      return;
    }
    if (this.target > 0) {
      const state = await this.stream.getJson('api/v1/replay');
      if (state && state.target === 0) {
        this.target = 0;
      }
    }
    if (this.target > 0) {
      this.#say(tick, `, on the way to ${this.target}`);
    } else if (!this.held) {
      element('slider').value = String(tick);
      this.#say(tick);
    }
  }
}
