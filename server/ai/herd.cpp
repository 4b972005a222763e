#include "server/ai/herd.h"

#include "server/ai/decision.h"
#include "server/ai/steering.h"
#include "shared/motion/apply_input.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

constexpr float kRoam_s = 1.0F;
/// Whoever ends up with another velocity than it wants, by this share of it, has met something.
constexpr float kMetShare = 0.01F;
/// The steepest ground that is followed downwards in one piece: a rise of so much per metre.
constexpr float kSteepestRoam = 1.2F;
constexpr int kMostPieces = 32;
/// Who has so little left of the way is at its end, but for rounding.
constexpr float kAtEndShare = 1e-3F;
constexpr std::uint32_t kNoPlace = 0xFFFFFFFFU;
/// Who got on by less than this share of what it wanted walks into something.
constexpr float kHinderedShare = 0.9F;

Vec2 flat_part(const Vec3& v) {
    return {v.x(), v.z()};
}

/// Of the command, as motion::apply_input() has it, m/s.
Vec2 wanted_by(const motion::InputCommand& command, const motion::CharacterLimits& limits) {
    const Vec2 move(static_cast<float>(command.move_x) / kFullMove,
                    static_cast<float>(command.move_z) / kFullMove);
    const bool sprints = (command.buttons & motion::kButtonSprint) != 0;
    return move / std::max(1.0F, move.norm()) *
           (limits.speed * (sprints ? limits.sprint_factor : 1.0F));
}

/// A step: where it leads, and whether anything was in the way.
struct Walked {
    motion::CharacterState state;
    bool free = true;
};

/// In one piece where the ground is even and free, else in so many as follow it: ledges are
/// climbed, and ground that falls away is followed down, once in each.
Walked walked(const motion::CharacterState& from,
              const motion::InputCommand& command,
              const motion::CharacterLimits& limits,
              const motion::StaticGeometry& statics,
              float time_s,
              Tick now) {
    const Vec2 wanted = wanted_by(command, limits);
    Walked out{motion::apply_input(from, command, limits, statics, time_s, now)};
    const float off = (flat_part(out.state.velocity) - wanted).norm();
    if (out.state.grounded && off <= kMetShare * wanted.norm()) {
        return out;
    }
    const float piece_m = std::max(limits.step_down, 0.1F) / kSteepestRoam;
    const auto pieces =
        std::clamp(static_cast<int>(std::ceil(wanted.norm() * time_s / piece_m)), 2, kMostPieces);
    out = {from, false};
    for (int k = 0; k < pieces && out.state.grounded; ++k) {
        out.state = motion::apply_input(
            out.state, command, limits, statics, time_s / static_cast<float>(pieces), now);
    }
    return out;
}

/// The command that leads along `way` (m) in `time_s`; `limits` say how fast it can be.
motion::InputCommand command_along(const Vec2& way,
                                   float time_s,
                                   const motion::CharacterLimits& limits) {
    motion::InputCommand command;
    float share = way.norm() / (time_s * std::max(limits.speed, 1e-3F));
    if (share > 1.0F) {
        command.buttons = motion::kButtonSprint;
        share /= std::max(limits.sprint_factor, 1e-3F);
    }
    if (share > 0.0F) {
        const Vec2 move = way * (kFullMove * std::min(share, 1.0F) / way.norm());
        command.move_x = static_cast<std::int8_t>(std::lround(move.x()));
        command.move_z = static_cast<std::int8_t>(std::lround(move.y()));
    }
    return command;
}

/// The first tick from `now` on at which a simulated animal decides, and then steers by that.
Tick turn_from(const Mind& mind, Tick period, bool far, Tick now) {
    const Tick decides = next_decision(mind.entity, period, now - 1);
    const Tick late = (decides + static_cast<Tick>(mind.entity.value)) % kFarPeriod;
    return far && late != 0 ? decides + kFarPeriod - late : decides;
}

}  // namespace

const Leg* Drift::leg_of(const world::Entities& entities, world::Row row) const {
    const EntityId entity = entities.id[row];
    if (row < slots.size() && slots[row] < minds.slots()) {
        const Mind& hinted = minds.at(slots[row]);
        if (hinted.entity == entity) {
            return &hinted.leg;
        }
    }
    const Mind* const mind = minds.find(entity);
    return mind != nullptr ? &mind->leg : nullptr;
}

Vec3 place_on_step(const Mind& mind, const Vec3& body, const Vec2& at) {
    const Vec2 here = flat_part(body);
    const float left = (flat_part(mind.target) - here).norm();
    const float way = (at - here).norm();
    if (!(way < left * (1.0F - kAtEndShare))) {
        return mind.target;
    }
    return {at.x(), body.y() + (mind.target.y() - body.y()) * (way / left), at.y()};
}

float roam_speed(const State& state, const motion::CharacterLimits& limits) {
    return limits.speed * std::clamp(state.speed_factor, 0.0F, 1.0F) *
           (state.sprint ? limits.sprint_factor : 1.0F);
}

Tick roams_until(const CompiledMachine& machine, Tick now, float dt) {
    const Tick period =
        std::max<Tick>(decision_period(machine, dt), std::max(1L, std::lround(kRoam_s / dt)));
    return (now / period + 1) * period;
}

Vec2 way_ahead(const Mind& mind,
               const CompiledMachine& machine,
               const CoarseWorld& in,
               world::Row row) {
    const auto ticks = static_cast<float>(roams_until(machine, in.now, in.dt) - in.now);
    return wanted_by(mind.aim, in.types[in.entities.type[row]].character) * (ticks * in.dt);
}

bool roam(Mind& mind,
          const CompiledMachine& machine,
          const CoarseWorld& in,
          world::Row row,
          const Vec2& way) {
    const motion::CharacterLimits& limits = in.types[in.entities.type[row]].character;
    const Tick until = roams_until(machine, in.now, in.dt);
    const float time_s = static_cast<float>(until - in.now) * in.dt;
    const Vec2 velocity = velocity_at(mind.leg, in.now - 1, in.dt);
    const Vec2 here = flat_part(in.entities.position[row]);
    const motion::CharacterState begin{in.entities.position[row],
                                       Vec3(velocity.x(), 0.0F, velocity.y()),
                                       in.entities.yaw[row],
                                       true};
    const Walked to =
        walked(begin, command_along(way, time_s, limits), limits, in.statics, time_s, in.now);
    const Vec2 end = to.free ? Vec2(here + way) : flat_part(to.state.position);
    const bool stands = to.state.grounded;
    const float length = stands ? (end - here).norm() : 0.0F;
    mind.leg = Leg();
    mind.leg.from = here;
    mind.leg.goal = stands ? end : here;
    mind.leg.since = in.now - 1;
    if (length > 0.0F) {
        mind.leg.direction = (end - here) / length;
        mind.leg.speed = length / time_s;
    }
    mind.target = Vec3(mind.leg.goal.x(), to.state.position.y(), mind.leg.goal.y());
    mind.placed = here;
    mind.timed = true;
    mind.on_way = false;
    mind.fresh = false;
    mind.again_at = until;
    return stands;
}

/// One that walks on along its aim, unless something held it up in its last step.
std::uint32_t Herds::add_animal(const Mind* mind, world::Row row, const Scene& scene) {
    const world::Entities& e = scene.entities;
    const bool dozes = e.has(row, world::kDozing);
    const Leg* const leg = dozes ? scene.drift.leg_of(e, row) : nullptr;
    const auto place = static_cast<std::uint32_t>(at_.size());
    place_of_row_[row] = place;
    row_.push_back(row);
    entity_.push_back(e.id[row]);
    mind_.push_back(mind);
    from_.push_back(flat_part(e.position[row]));
    at_.push_back(flat_part(e.position[row]));
    velocity_.push_back(flat_part(e.velocity[row]));
    if (leg != nullptr) {
        velocity_.back() = velocity_at(*leg, scene.now - 1, scene.dt);
        // Who steps was put where it is, clear of what stands there.
        at_.back() = mind != nullptr ? at_.back() : position_at(*leg, scene.now - 1, scene.dt);
    }
    since_.push_back(scene.now - 1);
    aim_.push_back(mind != nullptr ? mind->aim : motion::InputCommand());
    turns_at_.push_back(kNever);
    if (mind != nullptr) {
        const Vec2 wanted = wanted_by(mind->aim, scene.types[e.type[row]].character);
        const bool hindered = velocity_.back().norm() < kHinderedShare * wanted.norm();
        velocity_.back() = hindered ? velocity_.back() : wanted;
        turns_at_.back() = turn_from(*mind,
                                     decision_period(scene.machines[mind->machine], scene.dt),
                                     scene.reduce_far && mind->far,
                                     scene.now);
    }
    wanted_.push_back(velocity_.back());
    return place;
}

void Herds::gather(const Minds& minds, const Scene& scene) {
    row_.clear();
    entity_.clear();
    mind_.clear();
    from_.clear();
    at_.clear();
    since_.clear();
    velocity_.clear();
    aim_.clear();
    turns_at_.clear();
    wanted_.clear();
    first_.clear();
    sees_.clear();
    way_.assign(roaming_.size(), Vec2::Zero());
    place_of_row_.resize(std::max(place_of_row_.size(), scene.entities.size()), kNoPlace);
    for (const Roaming& roaming : roaming_) {
        add_animal(&minds.at(roaming.slot), roaming.row, scene);
    }
}

/// The place of a neighbour among the columns, at their end where it is new.
std::uint32_t Herds::place_of(const Minds& minds, world::Row row, const Scene& scene) {
    if (place_of_row_[row] != kNoPlace) {
        return place_of_row_[row];
    }
    const world::Entities& e = scene.entities;
    const bool elsewhere = e.has(row, world::kDozing) || e.has(row, world::kGhost);
    const Mind* const mind = elsewhere ? nullptr : minds.find(e.id[row]);
    const bool foretold = mind != nullptr && roams(*mind, scene.machines[mind->machine]);
    return add_animal(foretold ? mind : nullptr, row, scene);
}

/// Whom the n-th may come to know of before the step is over; of one that is foretold, as far as
/// those are known.
void Herds::see(const Minds& minds, std::size_t n, const Scene& scene) {
    first_.push_back(static_cast<std::uint32_t>(sees_.size()));
    const Mind* const mind = mind_[n];
    if (mind == nullptr) {
        return;
    }
    const world::Entities& e = scene.entities;
    const world::Row self = row_[n];
    const CompiledMachine& machine = scene.machines[mind->machine];
    const State& state = machine.states[mind->doing];
    const float time_s =
        static_cast<float>(roams_until(machine, scene.now, scene.dt) - scene.now) * scene.dt;
    const float nearer = 2.0F * time_s * roam_speed(state, scene.types[e.type[self]].character);
    const float reach = state.radius_m + nearer;
    const Vec2 here = from_[n];
    const bool steps = n < roaming_.size();
    scene.grid.for_each_within(
        here.x(), here.y(), reach + scene.drift.reach_m, [&](world::Row row, float) {
            const bool other = row == self || e.type[row] != e.type[self] ||
                               e.has(row, world::kHidden) ||
                               (!steps && place_of_row_[row] == kNoPlace);
            const std::uint32_t place = other ? kNoPlace : place_of(minds, row, scene);
            if (place != kNoPlace && (at_[place] - here).squaredNorm() <= reach * reach) {
                sees_.push_back(place);
            }
        });
}

/// Straight on to the end of tick `end`.
void Herds::walk_until(std::size_t n, Tick end, float dt) {
    at_[n] += velocity_[n] * (static_cast<float>(end - since_[n]) * dt);
    since_[n] = end;
}

/// The rule, as wish_of() and steer() ask it at a decision; by where all are at the end of the tick
/// before.
void Herds::turn(Minds& minds, std::size_t n, const Scene& scene, Tick now) {
    const Mind& mind = *mind_[n];
    const State& state = scene.machines[mind.machine].states[mind.doing];
    const motion::CharacterLimits& limits = scene.types[scene.entities.type[row_[n]]].character;
    wanted_[n] = velocity_[n];
    if (now < mind.detour_until) {
        return;
    }
    const auto place = [&](std::uint32_t m) {
        return Vec2(at_[m] + velocity_[m] * (static_cast<float>(now - 1 - since_[m]) * scene.dt));
    };
    const Vec2 here = place(static_cast<std::uint32_t>(n));
    FlockSum sum(state.radius_m);
    for (std::uint32_t k = first_[n]; k < first_[n + 1]; ++k) {
        const std::uint32_t m = sees_[k];
        sum.add(place(m) - here, velocity_[m], entity_[n] < entity_[m]);
    }
    const Vec2 heading = aim_direction(aim_[n]);
    const bool stands = heading == Vec2::Zero();
    const float speed = std::max(0.01F, roam_speed(state, limits));
    FlockPull pull = flock_pull(mind, state, speed, here, scene.places);
    pull.heading = heading;
    Vec2 wish = sum.heading(here, pull);
    if (wish.norm() < 1e-3F) {
        if (!stands || n >= roaming_.size()) {
            return;
        }
        wish = Vec2(minds.at(roaming_[n].slot).rng.range(-1.0F, 1.0F), 1.0F);  // anywhere
    }
    const Vec2 direction = wish.normalized();
    if (stands || heading.dot(direction) < kReaimFlockCos) {
        aim_along(aim_[n], Pace{state.speed_factor * mind.band, state.sprint}, direction);
    }
    wanted_[n] = wanted_by(aim_[n], limits);
}

/// All whose turn it is at `now`: first each looks around, then they turn.
void Herds::turn_all(Minds& minds, const Scene& scene, Tick now) {
    for (std::size_t n = 0; n < at_.size(); ++n) {
        if (turns_at_[n] == now) {
            turn(minds, n, scene, now);
        }
    }
    for (std::size_t n = 0; n < at_.size(); ++n) {
        if (turns_at_[n] == now) {
            const Mind& mind = *mind_[n];
            walk_until(n, now - 1, scene.dt);
            velocity_[n] = wanted_[n];
            turns_at_[n] = turn_from(mind,
                                     decision_period(scene.machines[mind.machine], scene.dt),
                                     scene.reduce_far && mind.far,
                                     now + 1);
        }
    }
}

void Herds::step(Minds& minds, const Scene& scene) {
    if (roaming_.empty()) {
        return;
    }
    gather(minds, scene);
    for (std::size_t n = 0; n < at_.size(); ++n) {
        see(minds, n, scene);
    }
    first_.push_back(static_cast<std::uint32_t>(sees_.size()));
    const auto until = [&](std::size_t n) {
        return roams_until(scene.machines[mind_[n]->machine], scene.now, scene.dt);
    };
    Tick end = scene.now;
    for (std::size_t n = 0; n < roaming_.size(); ++n) {
        end = std::max(end, until(n));
    }
    for (Tick now = scene.now; now < end; ++now) {
        for (std::size_t n = 0; n < roaming_.size(); ++n) {
            if (until(n) == now) {
                leave(minds, n, now, scene.dt);
            }
        }
        turn_all(minds, scene, now);
    }
    for (std::size_t n = 0; n < roaming_.size(); ++n) {
        if (until(n) == end) {
            leave(minds, n, end, scene.dt);
        }
    }
    for (const world::Row row : row_) {
        place_of_row_[row] = kNoPlace;
    }
}

/// Its step is over: others see it go straight on.
void Herds::leave(Minds& minds, std::size_t n, Tick now, float dt) {
    walk_until(n, now - 1, dt);
    minds.at(roaming_[n].slot).aim = aim_[n];
    way_[n] = at_[n] - from_[n];
    turns_at_[n] = kNever;
}

}  // namespace zoned::ai
