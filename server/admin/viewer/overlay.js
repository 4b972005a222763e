// Lines over the world: zones, and what there is to know about the chosen entity.

const PATH = [70, 200, 255, 255];
const TARGET = [255, 90, 90, 255];
const SIGHT = [255, 205, 70, 255];
const HEARING = [255, 150, 60, 160];
const AURA = [120, 220, 120, 255];
const NIMBUS = [110, 160, 255, 255];
const HEARD = [110, 160, 255, 110];
const SHOWN = [255, 80, 200, 255];
const FLOW = [255, 120, 40, 230];
const FLOW_TAIL = [255, 190, 120, 60];
const BORDER = [60, 120, 190, 255];
const MARGIN = [60, 120, 190, 90];

/** Far borders are told by so many pieces, so that they follow the ground. */
const BORDER_STEP_M = 20;
const MOST_BORDER_STEPS = 60;

export class Overlay {
  constructor(renderer) {
    this.renderer = renderer;
    this.details = null; // of the chosen entity, as the server told them last
    this.walkable = new Float32Array(0);
    this.flow = new Float32Array(0);
    this.shown = { agent: true, reach: true, view: true, walkable: false, flow: false };
  }

  #height(x, z) {
    const { scene, geometry } = this.renderer;
    return geometry.heightAt(x, z, scene.ground_height_m) + 0.15;
  }

  /** A line along the ground. */
  #along(lines, [x0, z0], [x1, z1], colour) {
    const steps = Math.min(MOST_BORDER_STEPS, Math.max(1, Math.ceil(Math.hypot(x1 - x0, z1 - z0) / BORDER_STEP_M)));
    let before = null;
    for (let i = 0; i <= steps; ++i) {
      const [x, z] = [x0 + ((x1 - x0) * i) / steps, z0 + ((z1 - z0) * i) / steps];
      const here = [x, this.#height(x, z), z];
      if (before) {
        lines.line(before, here, colour);
      }
      before = here;
    }
  }

  /** Borders change with the ground alone: they are laid out once for each state of it. */
  zones(lines) {
    const { geometry } = this.renderer;
    const key = `${geometry.drawn.length},${this.shown.margin}`;
    if (this.laidOut !== geometry || this.laidOutFor !== key) {
      this.laidOut = geometry;
      this.laidOutFor = key;
      this.borders = [];
      this.#layOut({ line: (a, b, colour) => this.borders.push([a, b, colour]) });
    }
    for (const [a, b, colour] of this.borders) {
      lines.line(a, b, colour);
    }
  }

  #layOut(lines) {
    const { scene } = this.renderer;
    for (const zone of scene.zones) {
      const corners = [[zone.min_x, zone.min_z], [zone.max_x, zone.min_z], [zone.max_x, zone.max_z], [zone.min_x, zone.max_z]];
      corners.forEach((corner, i) => this.#along(lines, corner, corners[(i + 1) % 4], BORDER));
    }
    if (scene.zones.length > 1 && this.shown.margin) {
      for (const zone of scene.zones) {
        const m = scene.ghost_margin_m;
        const corners = [[zone.min_x - m, zone.min_z - m], [zone.max_x + m, zone.min_z - m],
          [zone.max_x + m, zone.max_z + m], [zone.min_x - m, zone.max_z + m]];
        corners.forEach((corner, i) => this.#along(lines, corner, corners[(i + 1) % 4], MARGIN));
      }
    }
  }

  /** `place` is where the chosen entity is shown; `placeOf(id)` where another one is, or null. */
  chosen(lines, place, placeOf) {
    const { details } = this;
    const feet = [place[0], place[1], place[2]];
    const base = [place[0], place[1] - 0.2, place[2]];
    lines.circle(base, 1.1, [255, 240, 90, 255]);
    if (!details) {
      return;
    }
    if (this.shown.reach) {
      if (details.aura_m > 0 && details.aura_m < 1e5) {
        lines.circle(base, details.aura_m, AURA);
      }
      if (details.nimbus_m > 0 && details.nimbus_m < 1e5 && details.client) {
        lines.circle(base, details.nimbus_m, NIMBUS);
      }
      if (details.cone_m > 0 && details.client) {
        lines.circle(base, details.cone_m, NIMBUS, details.yaw_rad - details.cone_half_rad, 2 * details.cone_half_rad);
      }
    }
    if (this.shown.agent && details.agent) {
      this.#agent(lines, feet, base, details, placeOf);
    }
    if (this.shown.view && details.view) {
      this.#view(lines, feet, details.view, placeOf);
    }
  }

  #agent(lines, feet, base, details, placeOf) {
    const { agent } = details;
    let from = feet;
    for (const corner of agent.path) {
      lines.line(from, corner, PATH);
      lines.cross(corner, 0.3, PATH);
      from = corner;
    }
    if (agent.perception_m < 1e5) {
      const arc = Math.min(2 * Math.PI, 2 * agent.half_angle_rad);
      lines.circle(base, agent.perception_m, SIGHT, arc < 6.28 ? details.yaw_rad - arc / 2 : 0, arc);
      if (agent.around_m > 0 && arc < 6.28) {
        lines.circle(base, agent.around_m, SIGHT);
      }
    }
    if (agent.hearing_m > 0) {
      lines.circle(base, agent.hearing_m, HEARING);
    }
    const prey = agent.prey && (agent.noticed ? placeOf(agent.prey) : agent.known);
    if (prey) {
      lines.line(feet, prey, TARGET);
      lines.cross(prey, 0.7, TARGET);
    }
  }

  /** Entities that the client hears of, and where it shows those that move. */
  #view(lines, feet, view, placeOf) {
    for (const seen of view) {
      const at = placeOf(seen.id);
      if (at) {
        lines.line(feet, at, HEARD);
      }
      if (seen.shown) {
        lines.cross(seen.shown, 0.5, SHOWN);
        lines.line(seen.shown, seen.truth, SHOWN);
      }
    }
  }

  ground(lines) {
    if (this.shown.walkable) {
      const w = this.walkable;
      for (let i = 0; i + 5 < w.length; i += 6) {
        lines.line([w[i], w[i + 1] + 0.1, w[i + 2]], [w[i + 3], w[i + 4] + 0.1, w[i + 5]], [40, 170, 160, 200]);
      }
    }
    if (this.shown.flow) {
      const f = this.flow;
      for (let i = 0; i + 5 < f.length; i += 6) {
        lines.corner([f[i], this.#height(f[i], f[i + 2]), f[i + 2]], FLOW_TAIL);
        lines.corner([f[i + 3], this.#height(f[i + 3], f[i + 5]), f[i + 5]], FLOW);
      }
    }
  }
}
