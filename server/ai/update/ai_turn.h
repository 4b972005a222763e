// AiTurn: the data that the parts of an update hand to each other within a tick.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/ai/agent/ai_settings.h"
#include "server/ai/agent/decision.h"
#include "server/ai/ai_context.h"
#include "server/ai/offscreen/herd.h"
#include "server/ai/offscreen/suspend_resume.h"
#include "server/ai/steering/local_avoidance.h"
#include "server/compute/team.h"
#include "server/world/entities.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace zoned::ai {

struct AiReport {
    std::uint32_t agents = 0;
    std::uint32_t active = 0;
    std::uint32_t decisions = 0;
    std::uint32_t events = 0;  ///< suspended agents; the ones that decide count as decisions too
    std::uint32_t steered = 0;
    std::uint32_t postponed = 0;  ///< decisions that a budget moved to a later tick
    std::uint32_t blinded = 0;    ///< postponed decisions that the ray budget caused
    std::uint32_t transitions = 0;
    std::uint32_t trades = 0;
    std::uint32_t trades_refused = 0;  ///< an agent at the place lacked goods, or room
    std::uint32_t plans = 0;
    std::uint32_t plans_cut_off = 0;      ///< their search reached its node limit
    std::uint32_t plans_unreachable = 0;  ///< no sequence of actions makes the goal true
    std::uint64_t delivered = 0;          ///< food brought to nests, in total
    LocalAvoidanceReport avoidance;       ///< pairs of agents that avoided each other
    bool moved = false;                   ///< some entity was placed: the grid is out of date
};

/// An agent that has something to do in this tick.
struct DueAgent {
    Tick since;  ///< the tick in which it was due at the latest
    EntityId entity;
    Slot slot;
    world::Row row;
    Tier tier;
    bool decides = true;
    bool waited = false;   ///< suspended: it waited for stock
    bool changed = false;  ///< it has decided otherwise than before
    bool moved = false;    ///< suspended: its row has changed
    bool roams = false;    ///< suspended: it takes a step with its herd
    StepEnd end{};         ///< end of that step
    std::optional<state_machine::StateChange> change{};
    Tick next_event = kNever;
    Tick left = kNever;  ///< suspended: when it leaves its current square
};

/// A suspended agent that takes a step with its herd, and does nothing else.
struct HerdStep {
    EntityId entity;
    Slot slot;
    world::Row row;
    StepEnd end{};
    Tick left = kNever;
};

/// One thread's share of the agents.
struct AiLane {
    DecisionScratch scratch;
    std::vector<Slot> asking;  ///< agents that need a path
    float drift_m = 0.0F;      ///< of herds: the longest distance between two steps
    std::uint32_t transitions = 0;
    std::uint32_t steered = 0;
};

/// Buffers kept from tick to tick, so that a tick allocates nothing.
struct AiTurn {
    static constexpr std::size_t kLanes = 16;
    static constexpr std::size_t kShared = 256;  ///< fewer agents do not pay for a second thread

    AiReport report;
    std::vector<world::Row> row_hints;  ///< by slot: the last known row of the entity
    /// By row: slots of suspended agents that go with a herd, and of active agents that meet
    /// others.
    std::vector<Slot> slot_hints;
    std::vector<world::Row> rows;  ///< of active agents, in their order; kNoRow: skip the agent
    std::vector<AgentStore::Event> events;
    std::vector<DueAgent> due;
    std::vector<HerdStep> herd_steps;  ///< ascending by entity
    std::vector<Slot> waking;          ///< agents to be resumed
    std::array<AiLane, kLanes> lanes;
    /// The greatest distance of suspended herd animals from the positions in their rows; 0: no such
    /// animals.
    float drift_m = 0.0F;

    /// Calls work(lane, begin, end) for consecutive ranges that cover [0, count).
    template <class Work>
    void in_lanes(compute::Team& team, std::size_t count, Work&& work) {
        if (count < kShared) {
            work(lanes[0], std::size_t{0}, count);
            return;
        }
        const compute::Team::Shift shift(team);
        team.run(kLanes, 1, [&](std::size_t first, std::size_t last) {
            for (std::size_t lane = first; lane < last; ++lane) {
                work(lanes[lane], count * lane / kLanes, count * (lane + 1) / kLanes);
            }
        });
    }
};

inline const CompiledBrain& brain_of(const Agent& agent, const AiSettings& settings) {
    ZONED_ASSERT(agent.brain < settings.compiled.size(), "the brain of an agent exists");
    return settings.compiled[agent.brain];
}

/// Whether an agent steers in this tick. Far from all players it steers only now and then. A newly
/// entered state steers at once, so that no old command is repeated into it.
inline bool steers_now(const Agent& agent, const AiSettings& settings, Tick now) {
    return !settings.reduce_far || !agent.far || agent.entered || now >= agent.next_steering;
}

inline bool has_herds(const AiSettings& settings) {
    return std::any_of(settings.compiled.begin(),
                       settings.compiled.end(),
                       [](const CompiledBrain& brain) { return brain.flocks; });
}

/// The row of an entity whose agent may act; kNoRow: skip the agent. `hint`: its last known row.
inline world::Row row_of(const world::Entities& entities,
                         EntityId entity,
                         world::Row hint = world::kNoRow) {
    const bool known = hint < entities.size() && entities.id[hint] == entity;
    const world::Row row = known ? hint : entities.find(entity);
    return row != world::kNoRow &&
                   (entities.has(row, world::kHidden) || entities.has(row, world::kGhost))
               ? world::kNoRow
               : row;
}

/// The tick at which the agent leaves the square that its entity is in.
inline Tick left_at(const Agent& agent, const AiContext& ai, bool goes_on = false) {
    return OffscreenGrid::left_at(agent.segment, agent.placed, ai.half_size, ai.dt, goes_on);
}

/// Schedules the event that next_event() has found for a suspended agent.
inline void schedule_event(const AiContext& ai, Slot slot) {
    ai.agents.schedule(slot, decision_period(brain_of(ai.agents.at(slot), ai.settings), ai.dt));
}

/// Places the entity of a suspended agent at the agent's current position.
inline void place(Agent& agent, const AiContext& ai, AiTurn& turn, world::Row row) {
    catch_up(agent, ai, row);
    ai.entities.touch(row);
    turn.report.moved = true;
}

}  // namespace zoned::ai
