// ProximitySchedule: when agents that nobody sees may come to perceive somebody, or somebody them.
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

/// Who looks for whom, and from how far off one may come to know of the other.
class PerceptionRanges {
  public:
    /// As agents are of brains now, and entities of types. `brain_of_type` as in AiSettings.
    /// Returns whether that has changed.
    bool set(std::span<const CompiledBrain> brains,
             std::span<const std::uint16_t> brain_of_type,
             const world::TypeTable& types);

    /// Stands for the brain of who has none.
    static constexpr std::uint16_t kNoBrain = 0xFFFF;

    /// Of one who meets others.
    struct PerceiverKind {
        TypeIndex type = 0;
        std::uint16_t brain = kNoBrain;
    };

    /// Whether anybody looks for others than players.
    [[nodiscard]] bool any() const { return any_; }

    /// Below 0: neither looks for the other. Else from how far off one may perceive the other, m.
    [[nodiscard]] float between(PerceiverKind a, PerceiverKind b) const {
        return std::max(looks(a.brain, b.type), looks(b.brain, a.type));
    }

    /// The farthest of between() with anybody; below 0: it meets nobody.
    [[nodiscard]] float farthest(PerceiverKind of) const {
        return std::max(of.brain < sees_.size() ? sees_[of.brain] : -1.0F, seen_[of.type]);
    }

    /// The fastest that a character of the type goes on its own account, m/s; of others 0.
    [[nodiscard]] float top_speed(TypeIndex type) const { return top_speed_[type]; }

    /// Of all types.
    [[nodiscard]] float fastest() const { return fastest_; }

    /// Of an entity whose agent is in another zone, or that has none.
    [[nodiscard]] PerceiverKind kind_of(TypeIndex type) const { return {type, brain_of_[type]}; }

    /// Whether some may be met here whose agents are not here: ghosts, and the mindless.
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

/// Pairs of which one looks for the other are kept apart by time: from where both are and how fast
/// they can go follows a tick before which neither can perceive the other, so that none of them
/// needs to look before it (kinetic data structures: Basch, Guibas, Hershberger, "Data Structures
/// for Mobile Data", J. Algorithms 31, 1999, whose certificates are the distances here). Suspended
/// agents are found by the squares that their walks lead through. They are checked against each
/// other when the first of these ticks comes. Simulated ones look around in turn for those whom
/// they might meet until their next turn, and at once when they were put somewhere or go faster
/// than they can by themselves. Both of a pair that may meet soon are resumed. So all that perceive
/// or are perceived are simulated, and the others perceive nobody. The checks of an agent hang on
/// places and speeds alone (Agent::next_proximity_check), not on the order of rows.
class ProximitySchedule {
  public:
    /// Simulated agents look around once in so many ticks, in turn.
    static constexpr Tick kTurn = 16;
    /// An agent that may meet somebody within so many ticks is resumed.
    static constexpr Tick kSoon = 8;

    /// What is met: where, and how fast it may go, m/s.
    struct Body {
        PerceptionRanges::PerceiverKind kind;
        EntityId entity;
        Vec2 at = Vec2::Zero();
        float speed = 0.0F;
    };

    /// Forgets all agents.
    void clear();

    /// Who looks for whom.
    [[nodiscard]] PerceptionRanges& ranges() { return ranges_; }

    [[nodiscard]] const PerceptionRanges& ranges() const { return ranges_; }

    void grow(std::size_t slots);
    /// It is suspended no more.
    void forget(Slot slot);

    /// Whether that agent is here.
    [[nodiscard]] bool knows(Slot slot, EntityId entity) const {
        return slot < members_.size() && members_[slot].entity == entity;
    }

    /// A suspended agent that meets others: it walks by its segment as that is now, and is
    /// checked at Agent::next_proximity_check. `late`: it goes on from the end of its segment.
    void put(Slot slot, TypeIndex type, const AiContext& ai, bool late);

    /// Calls visit(slot) for those whose check is due, in no order. Ticks ascend.
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

    /// One of them, at the end of the last tick.
    [[nodiscard]] Body suspended_body(Slot slot, const AiContext& ai) const;

    /// Ticks within which `body` meets no suspended agent, nor what lies beyond the border; at most
    /// those that it takes to meet one that is farther off than is looked. Appends to `near` whom
    /// it may meet within kSoon.
    Tick apart(const Body& body, const AiContext& ai, std::vector<Slot>& near);

    /// Appends to `near` whom a simulated agent may meet until its next turn.
    void look_around(const Body& body, const AiContext& ai, std::vector<Slot>& near);

    /// Ticks within which two do not meet; may be negative.
    static Tick apart(const Body& a, const Body& b, float reach_m, float dt);

    /// How near, m, whoever one may meet within so many ticks is, who goes at `speed` at most.
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
