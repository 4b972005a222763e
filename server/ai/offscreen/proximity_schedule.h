// ProximitySchedule: when suspended agents may come to perceive an entity, or be perceived.
#pragma once

#include "server/ai/agent/agent_event_queue.h"
#include "server/ai/agent/agent_store.h"
#include "server/ai/agent/offscreen_grid.h"
#include "server/ai/ai_context.h"
#include "server/world/entities.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace zoned::ai {

/// Which types look for which, and from how far off one may notice the other.
class PerceptionRanges {
  public:
    /// Reads the current brains and the brain of each type. `brain_of_type` as in AiSettings.
    /// Returns whether anything has changed.
    bool set(std::span<const CompiledBrain> brains,
             std::span<const std::uint16_t> brain_of_type,
             const world::TypeTable& types);

    /// Stands for the brain of an entity without one.
    static constexpr std::uint16_t kNoBrain = 0xFFFF;

    /// The kind of an entity that meets others.
    struct PerceiverKind {
        TypeIndex type = 0;
        std::uint16_t brain = kNoBrain;
    };

    /// Whether any agent looks for other entities than players.
    [[nodiscard]] bool any() const { return any_; }

    /// The distance from which one may perceive the other, m; below 0: neither looks for the other.
    [[nodiscard]] float between(PerceiverKind a, PerceiverKind b) const {
        return std::max(looks(a.brain, b.type), looks(b.brain, a.type));
    }

    /// The greatest between() with any kind; below 0: it meets no entity.
    [[nodiscard]] float farthest(PerceiverKind of) const {
        return std::max(of.brain < sees_.size() ? sees_[of.brain] : -1.0F, seen_[of.type]);
    }

    /// The top speed of a character of the type by its own effort, m/s; 0 for other types.
    [[nodiscard]] float top_speed(TypeIndex type) const { return top_speed_[type]; }

    /// Of all types.
    [[nodiscard]] float fastest() const { return fastest_; }

    /// The kind of an entity without an agent, or with its agent in another zone.
    [[nodiscard]] PerceiverKind kind_of(TypeIndex type) const { return {type, brain_of_[type]}; }

    /// Whether entities without an agent in this zone may be met here: ghosts, and entities without
    /// a brain.
    [[nodiscard]] bool has_strangers(const std::vector<world::Entities::Count>& counts) const;

  private:
    [[nodiscard]] float looks(std::uint16_t brain, TypeIndex type) const {
        const std::size_t at = brain * types_ + type;
        return brain != kNoBrain && at < looks_.size() ? looks_[at] : -1.0F;
    }

    std::size_t types_ = 0;
    bool any_ = false;
    float fastest_ = 0.0F;
    std::vector<float> looks_;  // by brain x type
    std::vector<float> before_;
    std::vector<float> sees_;  // by brain
    std::vector<float> seen_;  // by type
    std::vector<float> top_speed_;
    std::vector<std::uint16_t> brain_of_;  // by type
    std::vector<std::uint16_t> brain_before_;
};

/// Schedules checks between pairs of which one looks for the other. The positions and top speeds of
/// a pair give a tick before which neither can perceive the other. So neither needs to look before
/// that tick. (Kinetic data structures: Basch, Guibas, Hershberger, "Data Structures for Mobile
/// Data", J. Algorithms 31, 1999. Their certificates are the distances here.)
///
/// - Suspended agents are indexed by the squares that their walks lead through. They are checked
///   against each other at the first of these ticks.
/// - Simulated agents look around in turn, for all that they might meet until their next turn. An
///   agent that was teleported, or goes faster than its own top speed, looks at once.
/// - Both agents of a pair that may meet soon are resumed.
/// So every agent that perceives or is perceived is simulated, and the other agents perceive
/// nothing. The checks of an agent depend on positions and speeds alone
/// (Agent::next_proximity_check), not on the order of rows.
class ProximitySchedule {
  public:
    /// Simulated agents look around once in this many ticks, in turn.
    static constexpr Tick kTurn = 16;
    /// An agent that may meet an entity within this many ticks is resumed.
    static constexpr Tick kSoon = 8;

    /// A body that may be met: its position, and its top speed, m/s.
    struct Body {
        PerceptionRanges::PerceiverKind kind;
        EntityId entity;
        Vec2 at = Vec2::Zero();
        float speed = 0.0F;
    };

    /// Forgets all agents.
    void clear();

    /// Which types look for which.
    [[nodiscard]] PerceptionRanges& ranges() { return ranges_; }

    [[nodiscard]] const PerceptionRanges& ranges() const { return ranges_; }

    void grow(std::size_t slots);
    /// Forgets an agent that is no longer suspended.
    void forget(Slot slot);

    /// Whether that agent is in the schedule.
    [[nodiscard]] bool knows(Slot slot, EntityId entity) const {
        return slot < members_.size() && members_[slot].entity == entity;
    }

    /// Adds a suspended agent that meets others. It walks by its current segment, and is checked at
    /// Agent::next_proximity_check, and not before `soonest` ticks from now. `late`: it goes on
    /// from the end of its segment.
    void put(Slot slot, TypeIndex type, const AiContext& ai, bool late, Tick soonest = 1);

    /// Calls visit(slot) for the agents whose check is due, in no order. Ticks ascend.
    template <class Visit>
    void take_due(const AiContext& ai, Visit&& visit) {
        due_.clear();
        looks_.take_due(ai.now, [&](Slot slot, Tick /*at*/) { due_.push_back(slot); });
        for (const Slot slot : due_) {
            if (is_suspended(slot, ai)) {
                visit(slot);
            }
        }
    }

    /// The body of a scheduled agent, at the end of the last tick.
    [[nodiscard]] Body suspended_body(Slot slot, const AiContext& ai) const;

    /// Ticks within which `body` meets no suspended agent, and nothing beyond the border. The
    /// answer is at most the ticks to meet a body just outside the search range. Appends to `near`
    /// the agents that it may meet within kSoon.
    Tick apart(const Body& body, const AiContext& ai, std::vector<Slot>& near);

    /// Appends to `near` the agents that a simulated agent may meet until its next turn.
    void look_around(const Body& body, const AiContext& ai, std::vector<Slot>& near);

    /// Ticks within which two bodies do not meet; may be negative.
    static Tick apart(const Body& a, const Body& b, float reach_m, float dt);

    /// The greatest distance, m, of any body that one may meet within this many ticks. `speed`
    /// bounds their closing speed.
    static float within(float reach_m, float speed, Tick ticks, float dt);

  private:
    struct ScheduledAgent {
        EntityId entity;
        TypeIndex type = 0;
    };

    [[nodiscard]] bool is_suspended(Slot slot, const AiContext& ai) const {
        const Agent& agent = ai.agents.at(slot);
        return agent.entity && agent.tier == Tier::kSuspended && knows(slot, agent.entity);
    }

    template <class Visit>
    void for_each_near(const Vec2& at, float radius_m, const AiContext& ai, Visit&& visit);

    PerceptionRanges ranges_;
    OffscreenGrid cells_;
    AgentEventQueue looks_;
    std::vector<ScheduledAgent> members_;  // by slot
    std::vector<Slot> due_;
    std::vector<OffscreenGrid::Cell> squares_;
};

}  // namespace zoned::ai
