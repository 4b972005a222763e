#include "server/ai/offscreen/proximity_schedule.h"

#include "server/ai/agent/whereabouts.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace zoned::ai {

namespace {

/// The search range beyond the distance of perception, m.
constexpr float kAhead_m = 96.0F;
/// Twice the greatest distance of a body from where its agent takes itself to be, m, and a rounding
/// error.
constexpr float kBodies_m = 2.0F * kDriftM + 0.1F;
/// A walker may be outside its squares by a rounding error, or by its walk of some ticks, m.
constexpr float kBeside_m = 2.0F;
/// Ticks that a bound is early: positions are from the end of the last tick.
constexpr Tick kEarly = 2;
constexpr float kMostTicks = 1e6F;

Tick ticks_of(float way_m, float speed, float dt) {
    const float step_m = std::max(speed, 1e-3F) * dt;
    return static_cast<Tick>(std::clamp(std::floor(way_m / step_m), -1.0F, kMostTicks)) - kEarly;
}

float perceives_within(const CompiledBrain& brain) {
    return std::max(brain.perception_m, brain.perception.hearing_m);
}

}  // namespace

// ---------------------------------------------------------------- which types look for which

bool PerceptionRanges::set(std::span<const CompiledBrain> brains,
                           std::span<const std::uint16_t> brain_of_type,
                           const world::TypeTable& types) {
    any_ = std::any_of(brains.begin(), brains.end(), [](const CompiledBrain& brain) {
        return brain.perception.concerns_others();
    });
    if (!any_) {
        looks_.clear();
        return false;
    }
    before_.swap(looks_);
    brain_before_.swap(brain_of_);
    types_ = types.size();
    brain_of_.assign(types_, kNoBrain);
    for (std::size_t t = 0; t < types_; ++t) {
        const std::uint16_t agent = brain_of_type.empty() ? types[t].brain : brain_of_type[t];
        brain_of_[t] = agent > 0 ? static_cast<std::uint16_t>(agent - 1) : kNoBrain;
    }
    looks_.assign(brains.size() * types_, -1.0F);
    for (std::size_t m = 0; m < brains.size(); ++m) {
        const Perception& how = brains[m].perception;
        if (!how.concerns_others()) {
            continue;
        }
        for (const auto* wanted : {&how.targets, &how.allies, &how.wards}) {
            for (const TypeIndex type : *wanted) {
                looks_[m * types_ + type] = perceives_within(brains[m]);
            }
        }
        for (std::size_t t = 0; how.succession && t < types_; ++t) {
            if (brain_of_[t] == m) {
                looks_[m * types_ + t] = perceives_within(brains[m]);
            }
        }
    }
    if (before_ == looks_ && brain_before_ == brain_of_) {
        return false;
    }
    sees_.assign(brains.size(), -1.0F);
    seen_.assign(types_, -1.0F);
    for (std::size_t m = 0; m < brains.size(); ++m) {
        for (std::size_t t = 0; t < types_; ++t) {
            sees_[m] = std::max(sees_[m], looks_[m * types_ + t]);
            seen_[t] = std::max(seen_[t], looks_[m * types_ + t]);
        }
    }
    top_speed_.assign(types_, 0.0F);
    fastest_ = 0.0F;
    for (std::size_t t = 0; t < types_; ++t) {
        if (types[t].kind == world::EntityKind::kCharacter) {
            const motion::CharacterLimits& limits = types[t].character;
            top_speed_[t] = limits.speed * std::max(1.0F, limits.sprint_factor);
        }
        fastest_ = std::max(fastest_, top_speed_[t]);
    }
    return true;
}

bool PerceptionRanges::has_strangers(const std::vector<world::Entities::Count>& counts) const {
    for (std::size_t t = 0; t < std::min(counts.size(), types_); ++t) {
        const bool mindless = brain_of_[t] == kNoBrain && counts[t].shown > 0;
        if ((counts[t].ghosts > 0 || mindless) &&
            farthest(kind_of(static_cast<TypeIndex>(t))) >= 0.0F) {
            return true;
        }
    }
    return false;
}

// ---------------------------------------------------------------- suspended agents by square

void ProximitySchedule::clear() {
    for (Slot slot = 0; slot < members_.size(); ++slot) {
        forget(slot);
    }
}

void ProximitySchedule::forget(Slot slot) {
    if (slot < members_.size() && members_[slot].entity) {
        cells_.take(slot);
        looks_.cancel(slot);
        members_[slot] = ScheduledAgent();
    }
}

void ProximitySchedule::grow(std::size_t slots) {
    if (slots > members_.size()) {
        members_.resize(slots);
        cells_.grow(slots);
        looks_.grow(slots);
    }
}

void ProximitySchedule::put(Slot slot,
                            TypeIndex type,
                            const AiContext& ai,
                            bool late,
                            Tick soonest) {
    const Agent& agent = ai.agents.at(slot);
    members_[slot] = {agent.entity, type};
    const Vec2 at = position_at(agent.segment, ai.now - 1, ai.dt);
    const Vec2 anywhere = Vec2::Constant(std::numeric_limits<float>::infinity());
    const Tick left = OffscreenGrid::left_at(agent.segment, at, anywhere, ai.dt, late);
    cells_.put(slot, agent.segment, at, ai.dt, late);
    // A check that is due in this tick stays: it must not depend on what else happens to the agent.
    const Tick first = looks_.at(slot) <= ai.now ? ai.now : ai.now + soonest;
    const Tick look = std::max(std::min(agent.next_proximity_check, left), first);
    if (looks_.at(slot) != look) {
        looks_.schedule(slot, look);
    }
}

ProximitySchedule::Body ProximitySchedule::suspended_body(Slot slot, const AiContext& ai) const {
    const Agent& agent = ai.agents.at(slot);
    const TypeIndex type = members_[slot].type;
    return {{type, agent.brain},
            agent.entity,
            position_at(agent.segment, ai.now - 1, ai.dt),
            ranges_.top_speed(type)};
}

template <class Visit>
void ProximitySchedule::for_each_near(const Vec2& at,
                                      float radius_m,
                                      const AiContext& ai,
                                      Visit&& visit) {
    const auto look = [&](Slot slot) {
        if (is_suspended(slot, ai)) {
            visit(slot);
        }
    };
    const std::array<Vec2, 1> place{at};
    OffscreenGrid::within(place, radius_m + OffscreenGrid::kAside_m + kBeside_m, squares_);
    for (const OffscreenGrid::Cell square : squares_) {
        cells_.visit(square, look);
    }
    cells_.visit_anywhere(look);
}

// ---------------------------------------------------------------- which agents may meet, and when

Tick ProximitySchedule::apart(const Body& a, const Body& b, float reach_m, float dt) {
    const float way = (a.at - b.at).norm() - reach_m - kBodies_m;
    return ticks_of(way, a.speed + b.speed, dt);
}

float ProximitySchedule::within(float reach_m, float speed, Tick ticks, float dt) {
    return reach_m + kBodies_m + speed * static_cast<float>(ticks + kEarly + 1) * dt;
}

Tick ProximitySchedule::apart(const Body& body, const AiContext& ai, std::vector<Slot>& near) {
    const float farthest = ranges_.farthest(body.kind);
    const float fastest = body.speed + ranges_.fastest();
    Tick least = ticks_of(kAhead_m - kBodies_m, fastest, ai.dt);
    const float border = (ai.half_size - body.at.cwiseAbs()).minCoeff() - 2.0F * ai.shared_m;
    if (std::isfinite(border)) {
        least = std::min(least, ticks_of(border - farthest - kBodies_m, body.speed, ai.dt));
    }
    for_each_near(body.at, farthest + kAhead_m, ai, [&](Slot slot) {
        const Body other = suspended_body(slot, ai);
        const float reach = ranges_.between(body.kind, other.kind);
        if (reach < 0.0F || other.entity == body.entity) {
            return;
        }
        const Tick ticks = apart(body, other, reach, ai.dt);
        least = std::min(least, ticks);
        if (ticks < kSoon) {
            near.push_back(slot);
        }
    });
    return least;
}

void ProximitySchedule::look_around(const Body& body,
                                    const AiContext& ai,
                                    std::vector<Slot>& near) {
    const float farthest = ranges_.farthest(body.kind);
    const float fastest = body.speed + ranges_.fastest();
    const float radius = within(farthest, fastest, kTurn + kSoon, ai.dt);
    for_each_near(body.at, radius, ai, [&](Slot slot) {
        const Body other = suspended_body(slot, ai);
        const float reach = ranges_.between(body.kind, other.kind);
        if (reach >= 0.0F && other.entity != body.entity &&
            apart(body, other, reach, ai.dt) < kTurn + kSoon) {
            near.push_back(slot);
        }
    });
}

}  // namespace zoned::ai
