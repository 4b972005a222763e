#include "server/ai/update/viewer_update.h"

#include <algorithm>
#include <cmath>

namespace zoned::ai {

namespace {

/// Every square in which agents may be seen is checked once in this many ticks, in turn.
constexpr Tick kLookPeriod = 16;
/// An agent that may be seen soon is placed once it has walked this far, m.
constexpr float kStale_m = 8.0F;

/// The distance from viewers at which an agent is resumed, m. The agent is then active before its
/// entity can be seen. The distance allows for two things: the entity is placed only now and then,
/// and both run towards each other between two checks.
float waking_radius(const AiContext& ai) {
    float fastest = 0.0F;
    for (const world::EntityType& type : ai.types) {
        fastest = std::max(fastest, type.character.speed * type.character.sprint_factor);
    }
    return ai.settings.viewer_range_m + kStale_m +
           2.0F * fastest * static_cast<float>(kLookPeriod) * ai.dt;
}

bool outside(const Vec2& at, const Vec2& half_size) {
    return std::abs(at.x()) > half_size.x() || std::abs(at.y()) > half_size.y();
}

}  // namespace

/// Finds where players are. A player that was not here in the last tick counts at once.
void ViewerUpdate::follow_viewers(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings) {
    const world::Entities& e = ai.entities;
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
        return e.discontinuity_tick[e.find(id)] >= ai.now - 1;
    });
    if (appeared || jumped || ai.now % kLookPeriod == 0) {
        saved_.covered_from.clear();
        for (const Vec3& at : players_.at) {
            saved_.covered_from.emplace_back(at.x(), at.z());
        }
        saved_.coverage_m = waking_radius(ai);
        cover();
    }
    // Without viewers, and without a border to leave, their positions do not matter.
    if (!saved_.viewers.empty() || ai.half_size.allFinite()) {
        follow_suspended(ai, turn, meetings);
        check_suspended(ai, turn, appeared || jumped);
    }
}

/// Rebuilds the area in which an entity may be seen from the saved state.
void ViewerUpdate::cover() {
    // A walker may be outside its squares by a rounding error, or by its walk of some ticks.
    constexpr float kRounding_m = 2.0F;
    coverage_.build(saved_.covered_from, saved_.coverage_m);
    OffscreenGrid::within(saved_.covered_from,
                          saved_.coverage_m + OffscreenGrid::kAside_m + kRounding_m,
                          covered_squares_);
}

/// Places each agent that has left its squares. Entity and agent are then always in the squares
/// that the agent was settled in. So a check of a place looks only at agents whose walk comes near
/// it.
void ViewerUpdate::follow_suspended(const AiContext& ai, AiTurn& turn, MeetingUpdate& meetings) {
    left_.clear();
    ai.agents.take_left(ai.now, left_);
    for (const Slot slot : left_) {
        __builtin_prefetch(&turn.row_hints[slot], 1);
    }
    for (const Slot slot : left_) {
        ai.entities.prefetch(turn.row_hints[slot]);
        ai.agents.prefetch_neighbours(slot);
    }
    for (const Slot slot : left_) {
        Agent& agent = ai.agents.at(slot);
        const bool late = agent.next_event < ai.now;
        const Tick left = left_at(agent, ai, late);
        if (left > ai.now) {  // new in this zone
            meetings.settle(ai, turn, slot, left, late);
            continue;
        }
        const world::Row row = row_of(ai.entities, agent.entity, turn.row_hints[slot]);
        turn.row_hints[slot] = row;
        if (row != world::kNoRow) {
            place(agent, ai, turn, row);
        }
        meetings.settle(ai, turn, slot, std::max(left_at(agent, ai, late), ai.now + 1), late);
        if (coverage_.covers(agent.placed) || outside(agent.placed, ai.half_size)) {
            turn.waking.push_back(slot);
        }
    }
}

/// Finds agents that may be seen. Each tick checks a share of the squares that viewers cover, or
/// all of them at once where `all`.
void ViewerUpdate::check_suspended(const AiContext& ai, AiTurn& turn, bool all) {
    const auto share = static_cast<std::size_t>(ai.now % kLookPeriod);
    if (all || share == 0) {
        ai.agents.visit_anywhere([&](Slot slot) { check(ai, turn, slot); });
    }
    for (std::size_t k = all ? 0 : share; k < covered_squares_.size();
         k += all ? 1 : static_cast<std::size_t>(kLookPeriod)) {
        ai.agents.visit(covered_squares_[k], [&](Slot slot) { check(ai, turn, slot); });
    }
}

void ViewerUpdate::check(const AiContext& ai, AiTurn& turn, Slot slot) {
    Agent& agent = ai.agents.at(slot);
    const Vec2 at = position_at(agent.segment, ai.now - 1, ai.dt);
    const bool seen = coverage_.covers(at) || outside(at, ai.half_size);
    const bool stale =
        (agent.segment.length > 0.0F || on_step(agent)) && (at - agent.placed).norm() >= kStale_m;
    if (!seen && !stale) {
        return;
    }
    const world::Row row = row_of(ai.entities, agent.entity, turn.row_hints[slot]);
    if (row == world::kNoRow) {
        return;
    }
    if (seen) {
        turn.waking.push_back(slot);
    } else {
        place(agent, ai, turn, row);
    }
}

void ViewerUpdate::load(const SavedViewers& saved) {
    saved_ = saved;
    cover();
}

}  // namespace zoned::ai
