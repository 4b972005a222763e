#include "server/ai/coarse.h"

#include "server/ai/decision.h"
#include "server/ai/quiet.h"
#include "shared/motion/apply_input.h"
#include "shared/motion/capsule_sweep.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// How much higher the ground may be after a way of 1 m (and lower, where it is looked for).
constexpr float kSteepest = 1.2F;
/// Nobody rises by more at once than this, m: what is above that is a roof.
constexpr float kMostRise = 2.5F;

/// The place at (x, z) where a character stands that came from `before`.
Vec3 standing_at(const motion::StaticGeometry& statics,
                 const motion::CharacterLimits& limits,
                 const Vec3& before,
                 const Vec2& at) {
    const float way = (at - Vec2(before.x(), before.z())).norm();
    const float rise = std::min(kSteepest * way + limits.step_up, kMostRise);
    const float drop = rise + kSteepest * way + limits.step_down;
    const Vec3 above(at.x(), before.y() + rise, at.y());
    const Aabb area = Aabb{above - Vec3(0.0F, drop, 0.0F), above}.grown(2.0F * limits.radius);
    const motion::CapsuleSweep sweep(statics, {limits.radius, limits.half_segment}, area);
    const Vec3 begin = sweep.parted(above);
    const motion::SweepHit hit = sweep.sweep_down(begin, drop, [&](const motion::SweepHit& h) {
        return h.normal.y() >= limits.max_slope_cos;
    });
    Vec3 place = begin - Vec3(0.0F, hit.fraction * drop, 0.0F);
    if (hit.ground_plane) {
        place.y() = sweep.floor_height();
    }
    return place;
}

/// Velocity at the end of `tick`, x and z, m/s.
Vec2 velocity_of(const Leg& leg, Tick tick, float dt) {
    const bool walks = leg.length > 0.0F && position_at(leg, tick, dt) != leg.from;
    return walks ? Vec2(leg.direction * leg.speed) : Vec2(Vec2::Zero());
}

/// What `velocity` makes of a walk at `speed` along `direction`: exact for constant acceleration
/// (shared/motion/apply_input), of which the part across the way is left out.
float lag_of(const Vec2& velocity, const Vec2& direction, float speed, float acceleration) {
    if (!(acceleration > 0.0F)) {
        return 0.0F;
    }
    const float time = (direction * speed - velocity).norm() / acceleration;
    return 0.5F * time * (speed - velocity.dot(direction));
}

/// What the mind's command makes of a character, m/s.
float commanded_speed(const Mind& mind, const motion::CharacterLimits& limits) {
    const float share = Vec2(mind.aim.move_x, mind.aim.move_z).norm() / 127.0F;
    const bool sprints = (mind.aim.buttons & motion::kButtonSprint) != 0;
    return std::min(share, 1.0F) * limits.speed * (sprints ? limits.sprint_factor : 1.0F);
}

const motion::CharacterLimits& limits_of(const CoarseWorld& in, world::Row row) {
    return in.types[in.entities.type[row]].character;
}

/// Stands from where it will have come to a halt.
void halt(Mind& mind, const CoarseWorld& in, world::Row row, const Vec2& velocity) {
    const float brake = limits_of(in, row).acceleration;
    const Vec2 slide =
        brake > 0.0F ? Vec2(velocity * (0.5F * velocity.norm() / brake)) : Vec2(Vec2::Zero());
    mind.leg = Leg{};
    mind.leg.from = in.around(row).here() + slide;
    mind.leg.since = in.now - 1;
    mind.aim.move_x = mind.aim.move_z = 0;
    mind.aim.buttons = 0;
}

/// First tick in which steering would find the goal of the leg reached.
Tick arrival(const Leg& leg, float dt) {
    const float ticks = std::floor((leg.length + leg.lag_m) / (leg.speed * dt));
    return leg.since + 2 + static_cast<Tick>(std::clamp(ticks, 0.0F, 1e9F));
}

/// Where a command leads that is held: its heading is one of few, so that it passes the goal a
/// little to the side; the length to where the goal counts as reached. Where it would pass by
/// farther than that, steering puts it right on the way: straight to the goal.
void head_for(const Vec2& wish, const Mind& mind, Leg& leg) {
    const Vec2 heading = aim_direction(mind);
    const float along = wish.dot(heading);
    const float aside2 = std::max(0.0F, wish.squaredNorm() - along * along);
    if (aside2 < 0.25F * kArriveM * kArriveM) {
        leg.direction = heading;
        leg.length = along - std::sqrt(kArriveM * kArriveM - aside2);
    } else {
        leg.direction = wish / wish.norm();
        leg.length = wish.norm() - kArriveM;
    }
    leg.length = std::max(leg.length, 1e-3F);
}

void set_out(Mind& mind,
             const State& state,
             const CoarseWorld& in,
             world::Row row,
             const Wish& wish,
             const Vec2& velocity) {
    const Vec2 here = in.around(row).here();
    aim_along(mind, state, wish.direction / wish.direction.norm());
    const motion::CharacterLimits& limits = limits_of(in, row);
    const float speed = commanded_speed(mind, limits);
    if (!(speed > 0.0F)) {
        halt(mind, in, row, velocity);
        return;
    }
    Leg leg;
    leg.from = here;
    leg.goal = wish.goal;
    head_for(wish.direction, mind, leg);
    leg.speed = speed;
    leg.lag_m = lag_of(velocity, leg.direction, speed, limits.acceleration);
    leg.since = in.now - 1;
    mind.leg = leg;
}

/// A tick before which no trade that the mind still wants can be done: it may be at once where the
/// mind is, and elsewhere not before it can have walked there.
Tick trades_from(const Mind& mind,
                 const CompiledMachine& machine,
                 const CoarseWorld& in,
                 world::Row row) {
    const std::vector<Trade>& trades = machine.states[mind.doing].trades;
    const float step_m = mind.leg.speed * in.dt;
    Tick from = kNever;
    for (std::size_t t = 0; mind.wants != 0 && t < trades.size(); ++t) {
        const float way = in.places.outside(trades[t].place, in.around(row).here()) - kAtPlaceM;
        if ((mind.wants & 1U << t) == 0 || (way > 0.0F && !(step_m > 0.0F))) {
            continue;
        }
        const float ticks = way > 0.0F ? std::min(way / step_m, 1e9F) : 0.0F;
        from = std::min(from, in.now + static_cast<Tick>(ticks));
    }
    return std::max(from, in.now + 1);
}

}  // namespace

bool can_sleep(const Mind& mind, const CompiledMachine& machine) {
    const State& state = machine.states[mind.doing];
    // A blend and a policy do a little else at each decision.
    const bool even = machine.choices[mind.fsm.state()].blend < 0 &&
                      !std::holds_alternative<PolicyChoice>(state.choice);
    return machine.sleeps && even && !mind.prey;
}

void fall_asleep(Mind& mind,
                 const CompiledMachine& machine,
                 const CoarseWorld& in,
                 world::Row row) {
    world::Entities& e = in.entities;
    const Vec3 velocity = e.velocity[row];
    mind.leg = Leg{};
    mind.leg.from = in.around(row).here();
    mind.leg.direction = Vec2(velocity.x(), velocity.z());
    mind.leg.speed = mind.leg.direction.norm();
    mind.leg.since = in.now - 1;
    mind.leg.direction /= std::max(mind.leg.speed, 1e-6F);
    mind.placed = mind.leg.from;
    plan_leg(mind, machine, in, row);
    e.command[row] = motion::InputCommand{};
    e.command[row].yaw = e.yaw[row];
    e.velocity[row].setZero();
    e.acceleration[row].setZero();
    e.set(row, world::kAtRest, true);
    e.set(row, world::kDozing, true);
    e.discontinuity_tick[row] = in.now;
}

void catch_up(Mind& mind, const CoarseWorld& in, world::Row row) {
    world::Entities& e = in.entities;
    const Vec2 at = position_at(mind.leg, in.now - 1, in.dt);
    if (at != in.around(row).here()) {
        e.position[row] = standing_at(in.statics, limits_of(in, row), e.position[row], at);
        e.discontinuity_tick[row] = in.now;
    }
    mind.placed = at;
}

void plan_leg(Mind& mind, const CompiledMachine& machine, const CoarseWorld& in, world::Row row) {
    const State& state = machine.states[mind.doing];
    const Surroundings around = in.around(row);
    const bool entered = mind.entered;
    if (entered) {
        begin_deed(mind, state, around);
        mind.entered = false;
    }
    const Vec2 velocity = mind.leg.length > 0.0F ? velocity_of(mind.leg, in.now - 1, in.dt)
                                                 : Vec2(mind.leg.direction * mind.leg.speed);
    const bool herd = state.action == ActionKind::kFlock;
    const Wish wish =
        herd ? Wish() : wish_of(mind, state, std::max(0.01F, full_speed(state, around)), around);
    mind.fresh = false;
    if (!wish.has_goal || !(wish.direction.norm() > 1e-3F)) {
        if (mind.leg.speed > 0.0F) {
            halt(mind, in, row, velocity);
        }
        return;
    }
    // The same goal at the same gait: it just walks on.
    const bool same = !entered && mind.leg.length > 0.0F && wish.goal == mind.leg.goal;
    if (!same) {
        set_out(mind, state, in, row, wish, velocity);
    }
}

Tick next_event(Mind& mind,
                const CompiledMachine& machine,
                const CoarseWorld& in,
                world::Row row,
                bool settled) {
    const Tick period = decision_period(machine, in.dt);
    Tick quiet = in.now + 1;
    if (settled) {
        Senses senses;
        sense(mind, machine, Sight::none(), in.entities.position[row], in.places, in.now, senses);
        quiet =
            quiet_until(mind, machine, senses, {mind.leg.speed, in.places.day_s(), in.dt}, in.now);
        quiet = std::min(quiet, trades_from(mind, machine, in, row));
    }
    mind.next_decision = quiet == kNever ? kNever : next_decision(mind.entity, period, quiet - 1);
    const Tick arrives = mind.leg.length > 0.0F ? arrival(mind.leg, in.dt) : kNever;
    return std::min(mind.next_decision, std::max(arrives, in.now + 1));
}

void wake_up(Mind& mind, const CompiledMachine& machine, const CoarseWorld& in, world::Row row) {
    world::Entities& e = in.entities;
    catch_up(mind, in, row);
    const Vec2 velocity = velocity_of(mind.leg, in.now - 1, in.dt);
    e.velocity[row] = Vec3(velocity.x(), 0.0F, velocity.y());
    e.yaw[row] = mind.aim.yaw;
    e.orientation[row] = motion::orientation_from_yaw(mind.aim.yaw);
    e.set(row, world::kAtRest, velocity == Vec2::Zero());
    e.set(row, world::kDozing, false);
    e.set(row, world::kGrounded, true);
    e.discontinuity_tick[row] = in.now;
    mind.leg = Leg{};
    mind.unseen_since = kNever;
    mind.detour_until = 0;
    mind.next_decision = next_decision(mind.entity, decision_period(machine, in.dt), in.now - 1);
    restart_progress(mind, e.position[row], in.now);
}

}  // namespace zoned::ai
