#include "server/ai/agent/ai_settings.h"
#include "server/ai/agent/decision.h"
#include "server/ai/offscreen/herd.h"
#include "server/ai/steering/desired_velocity.h"
#include "server/ai/steering/steering.h"
#include "server/spatial/box_lanes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::ai {

namespace {

/// Cells grow where there would be more than this: clearing more does not pay.
constexpr float kMostMeshCells = 65'536.0F;
/// Padding behind the end of a column: far from all animals.
constexpr float kNowhere_m = 1e9F;

/// The first tick from `now` on at which a simulated animal decides, and then steers by it.
Tick turn_from(const Agent& agent, Tick period, bool far, Tick now) {
    const Tick decides = next_decision(agent.entity, period, now - 1);
    const Tick late = (decides + static_cast<Tick>(agent.entity.value)) % kFarPeriod;
    return far && late != 0 ? decides + kFarPeriod - late : decides;
}

/// Caps a velocity so that a sum of eight stays in range.
Vec2 capped(const Vec2& velocity) {
    return velocity.cwiseMax(-kFastestOfLanes).cwiseMin(kFastestOfLanes);
}

/// The line of a position among `lines` lines of cells. A NaN lies in some line.
std::uint32_t line_at(float cells, std::uint32_t lines) {
    return cells > 0.0F ? std::min(static_cast<std::uint32_t>(cells), lines - 1) : 0U;
}

/// Whether a position lies within the bounds.
bool is_within(const Vec2& at, const Vec2& low, const Vec2& high) {
    return at.x() >= low.x() && at.y() >= low.y() && at.x() <= high.x() && at.y() <= high.y();
}

}  // namespace

/// Adds an animal that walks on along its aim, unless something held it up in its last step.
void Herds::add_animal(const Agent* agent,
                       world::Row row,
                       std::uint32_t number,
                       const Vec2& at,
                       const AiContext& ai) {
    const world::Entities& e = ai.entities;
    const PathSegment* const segment = !e.has(row, world::kDozing) ? nullptr
                                       : number != kNoNumber       ? &agent->segment
                                                                   : drift_->segment_of(e, row);
    Animal animal{};
    animal.entity = e.id[row];
    animal.row = row;
    animal.type = e.type[row];
    animal.agent = agent;
    animal.number = number;
    animal.until = kNever;
    animal.at = at;
    animal.velocity = Vec2(e.velocity[row].x(), e.velocity[row].z());
    if (segment != nullptr) {
        animal.velocity = velocity_at(*segment, ai.now - 1, ai.dt);
        // An animal that takes a step stands where `at` says.
        animal.at = number != kNoNumber ? at : position_at(*segment, ai.now - 1, ai.dt);
    }
    if (agent != nullptr) {
        const CompiledBrain& brain = ai.settings.compiled[agent->brain];
        const BrainState& state = brain.states[agent->current_action];
        const motion::CharacterLimits& limits = ai.types[animal.type].character;
        const Vec2 wanted = wanted_by(agent->aim, limits);
        const bool hindered = animal.velocity.norm() < kHinderedShare * wanted.norm();
        animal.velocity = hindered ? animal.velocity : wanted;
        animal.aim = agent->aim;
        const Tick until = roams_until(brain, ai.now, ai.dt);
        const float time_s = static_cast<float>(until - ai.now) * ai.dt;
        animal.reach = state.radius_m + 2.0F * time_s * roam_speed(state, limits);
        animal.until = number != kNoNumber ? until : kNever;
        if (number != kNoNumber) {
            const Vec3 velocity(animal.velocity.x(), 0.0F, animal.velocity.y());
            animal.body = {roaming_[number].at, velocity, e.yaw[row], true};
            animal.tries = is_barred(animal, time_s * roam_speed(state, limits), ai) ||
                           (hindered && !ai.statics.surfaces().empty());
        }
    }
    found_.push_back(animal);
    among_[row] = true;
}

/// Whether a box or a door may be in its path, as far as it may come.
bool Herds::is_barred(const Animal& animal, float reach_m, const AiContext& ai) const {
    const motion::CharacterLimits& limits = ai.types[animal.type].character;
    const float height = limits.radius + limits.half_segment + limits.step_up;
    const Vec3 reach(reach_m + limits.radius, height + reach_m, reach_m + limits.radius);
    const Vec3& at = animal.body.position;
    bool barred = false;
    ai.statics.for_each_near({at - reach, at + reach},
                             [&barred](std::uint32_t /*box*/) { barred = true; });
    ai.statics.for_each_door_near({at - reach, at + reach},
                                  [&barred](std::uint32_t /*door*/) { barred = true; });
    return barred;
}

Herds::Extent Herds::extent_of_found() const {
    Extent all;
    all.low.setConstant(std::numeric_limits<float>::infinity());
    all.high = -all.low;
    for (const Animal& animal : found_) {
        all.low = all.low.cwiseMin(animal.at);
        all.high = all.high.cwiseMax(animal.at);
        all.reach = std::max(all.reach, animal.reach);
    }
    return all;
}

/// Adds other entities of the same types that an animal on a step may notice.
void Herds::add_others(const AiContext& ai) {
    const world::Entities& e = ai.entities;
    const Extent known = extent_of_found();
    const Vec2 low = known.low.array() - (known.reach + drift_->reach_m);
    const Vec2 high = known.high.array() + (known.reach + drift_->reach_m);
    for (world::Row row = 0; row < e.size(); ++row) {
        if (among_[row] || rank_of(e.type[row]) == types_.size() || e.has(row, world::kHidden)) {
            continue;
        }
        const Vec2 at(e.position[row].x(), e.position[row].z());
        if (!is_within(at, low, high)) {
            continue;
        }
        const bool elsewhere = e.has(row, world::kDozing) || e.has(row, world::kGhost);
        const Agent* const agent = elsewhere ? nullptr : ai.agents.find(e.id[row]);
        const bool foretold = agent != nullptr && roams(*agent, ai.settings.compiled[agent->brain]);
        add_animal(foretold ? agent : nullptr, row, kNoNumber, at, ai);
    }
}

void Herds::gather(const AiContext& ai) {
    const world::Entities& e = ai.entities;
    found_.clear();
    types_.clear();
    ends_.assign(roaming_.size(), StepEnd());
    among_.resize(std::max(among_.size(), e.size()), false);
    for (std::size_t n = 0; n < roaming_.size(); ++n) {
        const Roaming& roaming = roaming_[n];
        const auto number = static_cast<std::uint32_t>(n);
        const Vec2 at(roaming.at.x(), roaming.at.z());
        add_animal(&ai.agents.at(roaming.slot), roaming.row, number, at, ai);
        if (rank_of(found_.back().type) == types_.size()) {
            types_.push_back(found_.back().type);
        }
    }
    std::size_t shown = 0;
    for (const TypeIndex type : types_) {
        shown += e.counts()[type].shown + e.counts()[type].ghosts;
    }
    if (shown != roaming_.size()) {
        add_others(ai);
    }
    for (const Animal& animal : found_) {
        among_[animal.row] = false;
    }
}

/// The number of a type among the types that step; their count where it is none of them.
std::uint32_t Herds::rank_of(TypeIndex type) const {
    return static_cast<std::uint32_t>(std::find(types_.begin(), types_.end(), type) -
                                      types_.begin());
}

/// Lays out cells as wide as the farthest reach of any animal.
void Herds::lay_mesh() {
    const Extent all = extent_of_found();
    const Vec2 size = all.high - all.low;
    float cell_m = std::max(1.0F, all.reach);
    const auto cells = [&] {
        return (std::floor(size.x() / cell_m) + 1.0F) * (std::floor(size.y() / cell_m) + 1.0F);
    };
    while (cells() * static_cast<float>(types_.size()) > kMostMeshCells) {
        cell_m *= 2.0F;
    }
    mesh_.origin = all.low;
    mesh_.per_m = 1.0F / cell_m;
    mesh_.columns = static_cast<std::uint32_t>(size.x() * mesh_.per_m) + 1;
    mesh_.lines = static_cast<std::uint32_t>(size.y() * mesh_.per_m) + 1;
}

/// A counting sort. Within a cell animals keep the order in which they were found; no sum depends
/// on it.
void Herds::sort_by_cells() {
    first_.assign(mesh_.cells() * types_.size() + 1, 0);
    for (Animal& animal : found_) {
        const Vec2 at = (animal.at - mesh_.origin) * mesh_.per_m;
        animal.cell = rank_of(animal.type) * mesh_.cells() +
                      line_at(at.y(), mesh_.lines) * mesh_.columns + line_at(at.x(), mesh_.columns);
        ++first_[animal.cell + 1];
    }
    for (std::size_t c = 1; c < first_.size(); ++c) {
        first_[c] += first_[c - 1];
    }
    const std::size_t size = found_.size();
    animals_.resize(size);
    for (const Animal& animal : found_) {
        animals_[first_[animal.cell]++] = animal;
    }
    std::copy_backward(first_.begin(), first_.end() - 1, first_.end());
    first_[0] = 0;
    x_.assign(size + spatial::kLanes, kNowhere_m);
    z_.assign(size + spatial::kLanes, kNowhere_m);
    velocity_x_.assign(size + spatial::kLanes, 0.0F);
    velocity_z_.assign(size + spatial::kLanes, 0.0F);
    entity_.resize(size);
    for (std::size_t n = 0; n < size; ++n) {
        x_[n] = animals_[n].at.x();
        z_[n] = animals_[n].at.y();
        const Vec2 velocity = capped(animals_[n].velocity);
        velocity_x_[n] = velocity.x();
        velocity_z_[n] = velocity.y();
        entity_[n] = animals_[n].entity;
    }
}

Vec2 Herds::place(std::size_t n, float time_s) const {
    return {x_[n] + velocity_x_[n] * time_s, z_[n] + velocity_z_[n] * time_s};
}

/// Sets the velocity from then on.
void Herds::set_velocity(std::size_t n, const Vec2& wanted, float time_s) {
    const Vec2 velocity = capped(wanted);
    const Vec2 start = place(n, time_s) - velocity * time_s;
    x_[n] = start.x();
    z_[n] = start.y();
    velocity_x_[n] = velocity.x();
    velocity_z_[n] = velocity.y();
}

/// Applies the flocking rule as desired_velocity() and steer() do at a decision. It uses the
/// positions at the end of the tick before.
Vec2 Herds::turned(std::size_t n, const AiContext& ai, Tick now) {
    Animal& animal = animals_[n];
    const Agent& agent = *animal.agent;
    const Vec2 as_before(velocity_x_[n], velocity_z_[n]);
    if (now < agent.detour_until) {
        return as_before;
    }
    const BrainState& state = ai.settings.compiled[agent.brain].states[agent.current_action];
    const motion::CharacterLimits& limits = ai.types[animal.type].character;
    const float time_s = static_cast<float>(now - ai.now) * ai.dt;
    const Vec2 here = place(n, time_s);
    FlockSum sum(state.radius_m);
    const std::uint32_t of_type = animal.cell / mesh_.cells() * mesh_.cells();
    const std::uint32_t line = (animal.cell - of_type) / mesh_.columns;
    const std::uint32_t column = (animal.cell - of_type) % mesh_.columns;
    const std::uint32_t left = column - std::min(column, 1U);
    const std::uint32_t right = std::min(column + 1, mesh_.columns - 1);
    const std::uint32_t top = std::min(line + 1, mesh_.lines - 1);
    for (std::uint32_t z = line - std::min(line, 1U); z <= top; ++z) {
        const std::uint32_t row = of_type + z * mesh_.columns;
        sum.add_run({x_.data(), z_.data(), velocity_x_.data(), velocity_z_.data(), entity_.data()},
                    first_[row + left],
                    first_[row + right + 1],
                    n,
                    here,
                    time_s);
    }
    const Vec2 heading = aim_direction(animal.aim);
    const bool stands = heading == Vec2::Zero();
    const float speed = std::max(0.01F, roam_speed(state, limits));
    FlockPull pull = flock_pull(agent, state, speed, here, ai.points_of_interest);
    pull.heading = heading;
    Vec2 desired = sum.heading(here, pull);
    if (desired.norm() < 1e-3F) {
        if (!stands || animal.number == kNoNumber) {
            return as_before;
        }
        core::Rng& rng = ai.agents.at(roaming_[animal.number].slot).rng;
        desired = Vec2(rng.range(-1.0F, 1.0F), 1.0F);  // anywhere
    }
    const Vec2 direction = desired.normalized();
    if (stands || heading.dot(direction) < kReaimFlockCos) {
        aim_along(animal.aim, Pace{state.speed_factor * agent.band, state.sprint}, direction);
    }
    return wanted_by(animal.aim, limits);
}

/// Turns all animals whose turn it is at `now`: first each looks around, then they turn.
void Herds::turn_all(const AiContext& ai, Tick now) {
    turning_.clear();
    wanted_.clear();
    for (std::size_t n = 0; n < turns_at_.size(); ++n) {
        if (turns_at_[n] == now) {
            turning_.push_back(static_cast<std::uint32_t>(n));
        }
    }
    for (const std::uint32_t n : turning_) {
        wanted_.push_back(turned(n, ai, now));
    }
    const float time_s = static_cast<float>(now - ai.now) * ai.dt;
    for (std::size_t k = 0; k < turning_.size(); ++k) {
        const std::uint32_t n = turning_[k];
        const Agent& agent = *animals_[n].agent;
        set_velocity(n, wanted_[k], time_s);
        turns_at_[n] = turn_from(agent,
                                 decision_period(ai.settings.compiled[agent.brain], ai.dt),
                                 ai.settings.reduce_far && agent.far,
                                 now + 1);
        walk_on(n, ai, now);
    }
}

/// Takes the next piece of the walk of an animal that tries. To others it goes straight to the
/// piece's end.
void Herds::walk_on(std::size_t n, const AiContext& ai, Tick now) {
    Animal& animal = animals_[n];
    const Tick end = std::min(turns_at_[n], animal.until);
    if (!animal.tries || end <= now || !animal.body.grounded) {
        return;
    }
    const motion::CharacterLimits& limits = ai.types[animal.type].character;
    const float time_s = static_cast<float>(end - now) * ai.dt;
    const Vec3 from = animal.body.position;
    animal.body = walked(animal.body, animal.aim, limits, ai.statics, time_s, now).state;
    const Vec3 way = animal.body.position - from;
    set_velocity(n, Vec2(way.x(), way.z()) / time_s, static_cast<float>(now - ai.now) * ai.dt);
}

void Herds::step(const AiContext& ai, const HerdDrift& drift) {
    drift_ = &drift;
    if (roaming_.empty()) {
        return;
    }
    gather(ai);
    lay_mesh();
    sort_by_cells();
    turns_at_.assign(animals_.size(), kNever);
    Tick end = ai.now;
    for (std::size_t n = 0; n < animals_.size(); ++n) {
        if (const Agent* const agent = animals_[n].agent) {
            turns_at_[n] = turn_from(*agent,
                                     decision_period(ai.settings.compiled[agent->brain], ai.dt),
                                     ai.settings.reduce_far && agent->far,
                                     ai.now);
        }
        if (animals_[n].until != kNever) {
            end = std::max(end, animals_[n].until);
            if (turns_at_[n] != ai.now) {
                walk_on(n, ai, ai.now);
            }
        }
    }
    for (Tick now = ai.now; now <= end;) {
        Tick next = kNever;
        const float time_s = static_cast<float>(now - ai.now) * ai.dt;
        for (std::size_t n = 0; n < animals_.size(); ++n) {
            if (animals_[n].until == now) {
                leave(n, ai, time_s);
            }
            next = std::min(next, animals_[n].until);
        }
        for (; now < std::min(next, end); ++now) {
            turn_all(ai, now);
        }
        if (now == end && next == kNever) {
            break;
        }
    }
}

/// Ends the step of an animal. To others it goes straight on.
void Herds::leave(std::size_t n, const AiContext& ai, float time_s) {
    Animal& animal = animals_[n];
    const Roaming& roaming = roaming_[animal.number];
    Agent& agent = ai.agents.at(roaming.slot);
    agent.aim = animal.aim;
    if (animal.tries) {
        ends_[animal.number] = {animal.body.position, animal.body.grounded};
    } else {
        const motion::CharacterLimits& limits = ai.types[animal.type].character;
        const Vec2 velocity = velocity_at(agent.segment, ai.now - 1, ai.dt);
        ends_[animal.number] =
            walk_along({roaming.at, Vec3(velocity.x(), 0.0F, velocity.y()), animal.body.yaw, true},
                       place(n, time_s) - animal.at,
                       time_s,
                       limits,
                       ai.statics,
                       ai.now);
    }
    turns_at_[n] = kNever;
    animal.until = kNever;
}

}  // namespace zoned::ai
