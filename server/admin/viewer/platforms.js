// Platforms: where their times have them at a tick, as shared/motion/platforms does it.

/** How far along its way it is, in ticks of travel. */
function alongOf(platform, tick) {
  const { stops, back_ticks: back, wait_ticks: wait, shift_ticks: shift } = platform;
  if (platform.by_rules) {
    return platform.along_ticks ?? platform.start_ticks; // until the server says more
  }
  const at = stops.map(({ ticks }) => ticks);
  const length = at[at.length - 1] + back;
  const period = back > 0 ? length + at.length * wait : 2 * length + (2 * at.length - 2) * wait;
  const round = back > 0 ? [...at, length] : [...at, ...at.slice(0, -1).reverse()];
  let phase = (((tick + shift) % period) + period) % period;
  for (let i = 0; i + 1 < round.length; ++i) {
    const ticks = Math.abs(round[i + 1] - round[i]);
    if (phase < wait + ticks) {
      return round[i] + Math.sign(round[i + 1] - round[i]) * Math.max(0, phase - wait);
    }
    phase -= wait + ticks;
  }
  return at[0];
}

/** The centre of its box. */
export function placeOf(platform, tick) {
  const { stops, back_ticks: back, p } = platform;
  const along = alongOf(platform, tick);
  const i = stops.findLastIndex(({ ticks }) => ticks <= along);
  const from = stops[i];
  const last = i + 1 === stops.length;
  const to = last ? stops[0] : stops[i + 1];
  const ticks = last ? back : to.ticks - from.ticks;
  const share = ticks > 0 ? (along - from.ticks) / ticks : 0;
  return p.map((x, axis) => x + from.offset[axis] + share * (to.offset[axis] - from.offset[axis]));
}
