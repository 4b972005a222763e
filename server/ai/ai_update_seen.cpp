#include "server/ai/ai_update.h"
#include "server/ai/ai_update_lookup.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// All squares in which agents may be seen are looked at once in so many ticks, in turn.
constexpr Tick kLookPeriod = 16;
/// Who may be seen soon is put where it is when it has walked so far, m.
constexpr float kStale_m = 8.0F;

/// From how far off an agent is woken, m: so that it is active when its entity can be seen, though
/// that is put where it is now and then only, and both run towards each other between two looks.
float waking_radius(const AiContext& world, const AiSettings& settings) {
    float fastest = 0.0F;
    for (const world::EntityType& type : world.types) {
        fastest = std::max(fastest, type.character.speed * type.character.sprint_factor);
    }
    return settings.viewer_range_m + kStale_m +
           2.0F * fastest * static_cast<float>(kLookPeriod) * world.dt;
}

bool outside(const Vec2& at, const Vec2& half_size) {
    return std::abs(at.x()) > half_size.x() || std::abs(at.y()) > half_size.y();
}

}  // namespace

/// Where players are. One who was not here a tick ago, or is back, is heard of at once.
void AiUpdate::follow_viewers(AgentStore& agents,
                              const AiContext& world,
                              const AiSettings& settings) {
    const world::Entities& e = world.entities;
    viewers_before_.swap(saved_.viewers);
    saved_.viewers.clear();
    for (const world::Row row : players_.rows) {
        saved_.viewers.push_back(e.id[row]);
    }
    std::sort(saved_.viewers.begin(), saved_.viewers.end());
    const bool appeared = !std::includes(viewers_before_.begin(),
                                         viewers_before_.end(),
                                         saved_.viewers.begin(),
                                         saved_.viewers.end());
    const bool jumped = std::any_of(saved_.viewers.begin(), saved_.viewers.end(), [&](EntityId id) {
        return e.discontinuity_tick[e.find(id)] >= world.now - 1;
    });
    if (appeared || jumped || world.now % kLookPeriod == 0) {
        saved_.covered_from.clear();
        for (const Vec3& at : players_.at) {
            saved_.covered_from.emplace_back(at.x(), at.z());
        }
        saved_.coverage_m = waking_radius(world, settings);
        watch();
    }
    // Without anybody to see them, and nowhere to go to, it does not matter where they are.
    if (!saved_.viewers.empty() || world.half_size.allFinite()) {
        follow_suspended(agents, world);
        check_suspended_seen(agents, world, appeared || jumped);
    }
}

/// Where somebody may see an entity, from what the memory says.
void AiUpdate::watch() {
    // Who walks may be a rounding beside its squares, or what one walks in some ticks.
    constexpr float kRounding_m = 2.0F;
    viewer_coverage_.build(saved_.covered_from, saved_.coverage_m);
    OffscreenGrid::within(saved_.covered_from,
                          saved_.coverage_m + OffscreenGrid::kAside_m + kRounding_m,
                          covered_squares_);
}

/// Who has left its squares is put where it is: entity and agent are always in those that it was
/// settled in. So who looks at a place looks at those alone that come through around it.
void AiUpdate::follow_suspended(AgentStore& agents, const AiContext& world) {
    left_.clear();
    agents.take_left(world.now, left_);
    for (const Slot slot : left_) {
        __builtin_prefetch(&row_hints_[slot], 1);
    }
    for (const Slot slot : left_) {
        world.entities.prefetch(row_hints_[slot]);
        agents.prefetch_neighbours(slot);
    }
    for (const Slot slot : left_) {
        Agent& agent = agents.at(slot);
        const bool late = agent.next_event < world.now;
        const Tick left = left_at(agent, world, late);
        if (left > world.now) {  // it is new here
            settle(agents, slot, left, world, late);
            continue;
        }
        const world::Row row = row_of(world.entities, agent.entity, row_hints_[slot]);
        row_hints_[slot] = row;
        if (row != world::kNoRow) {
            place(agent, world, row);
        }
        settle(agents, slot, std::max(left_at(agent, world, late), world.now + 1), world, late);
        if (viewer_coverage_.covers(agent.placed) || outside(agent.placed, world.half_size)) {
            waking_.push_back(slot);
        }
    }
}

/// Wakes who may be seen: a share of the squares that can be seen in each tick, at once where
/// `all`.
void AiUpdate::check_suspended_seen(AgentStore& agents, const AiContext& world, bool all) {
    const auto turn = static_cast<std::size_t>(world.now % kLookPeriod);
    if (all || turn == 0) {
        agents.visit_anywhere([&](Slot slot) { next_proximity_check(agents, slot, world); });
    }
    for (std::size_t k = all ? 0 : turn; k < covered_squares_.size();
         k += all ? 1 : static_cast<std::size_t>(kLookPeriod)) {
        agents.visit(covered_squares_[k],
                     [&](Slot slot) { next_proximity_check(agents, slot, world); });
    }
}

void AiUpdate::next_proximity_check(AgentStore& agents, Slot slot, const AiContext& world) {
    Agent& agent = agents.at(slot);
    const Vec2 at = position_at(agent.segment, world.now - 1, world.dt);
    const bool wakes = viewer_coverage_.covers(at) || outside(at, world.half_size);
    const bool stale =
        (agent.segment.length > 0.0F || on_step(agent)) && (at - agent.placed).norm() >= kStale_m;
    if (!wakes && !stale) {
        return;
    }
    const world::Row row = row_of(world.entities, agent.entity, row_hints_[slot]);
    if (row == world::kNoRow) {
        return;
    }
    if (wakes) {
        waking_.push_back(slot);
    } else {
        place(agent, world, row);
    }
}

void AiUpdate::place(Agent& agent, const AiContext& world, world::Row row) {
    catch_up(agent, offscreen(world), row);
    world.entities.touch(row);
    report_.moved = true;
}

void AiUpdate::resume_seen(AgentStore& agents, const AiContext& world, const AiSettings& settings) {
    std::sort(waking_.begin(), waking_.end(), [&](Slot a, Slot b) {
        return agents.at(a).entity < agents.at(b).entity;
    });
    for (const Slot slot : waking_) {
        Agent& agent = agents.at(slot);
        // Some are here since the last tick.
        const world::Row row = row_of(world.entities, agent.entity);
        if (!agent.entity || agent.tier != Tier::kSuspended || row == world::kNoRow) {
            continue;
        }
        resume(agent, brain_of(agent, settings), offscreen(world), row);
        agents.resume(slot);
        proximity_schedule_.forget(slot);
        resumed_.push_back(agent.entity);
        report_.moved = true;
    }
    waking_.clear();
}

}  // namespace zoned::ai
