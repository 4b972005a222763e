// AiTurn: what the parts of an update hand to each other within a tick.
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
    std::uint32_t events =
        0;  ///< of the offscreen tier; those that are decisions count as such too
    std::uint32_t steered = 0;
    std::uint32_t postponed = 0;  ///< decisions that a budget moved to a later tick
    std::uint32_t blinded = 0;    ///< of these: by the budget of rays
    std::uint32_t transitions = 0;
    std::uint32_t trades = 0;
    std::uint32_t trades_refused = 0;  ///< somebody who was there had not enough, or no room
    std::uint32_t plans = 0;
    std::uint32_t plans_cut_off = 0;      ///< their search met its bound
    std::uint32_t plans_unreachable = 0;  ///< no sequence of actions makes the goal true
    std::uint64_t delivered = 0;          ///< food that was brought to nests, so far
    LocalAvoidanceReport avoidance;       ///< who met whom
    bool moved = false;                   ///< some entity was placed: the grid is no longer true
};

/// An agent that has something to do in this tick.
struct DueAgent {
    Tick since;  ///< when it should have been done at the latest
    EntityId entity;
    Slot slot;
    world::Row row;
    Tier tier;
    bool decides = true;
    bool waited = false;   ///< suspended: for stock
    bool changed = false;  ///< it has decided otherwise than before
    bool moved = false;    ///< suspended: its row is another one than before
    bool roams = false;    ///< suspended: it takes a step with its herd
    StepEnd end{};         ///< of that
    std::optional<state_machine::StateChange> change{};
    Tick next_event = kNever;
    Tick left = kNever;  ///< suspended: when it leaves the square that it is in
};

/// A suspended agent that takes a step with its herd, and has nothing else to do.
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
    std::vector<Slot> asking;  ///< who needs a path
    float drift_m = 0.0F;      ///< of herds: the longest way between two steps
    std::uint32_t transitions = 0;
    std::uint32_t steered = 0;
};

/// Kept from tick to tick, so that a tick allocates nothing.
struct AiTurn {
    static constexpr std::size_t kLanes = 16;
    static constexpr std::size_t kShared = 256;  ///< fewer agents are not worth a second thread

    AiReport report;
    std::vector<world::Row> row_hints;  ///< by slot: where the entity was last
    /// By row: of suspended agents that roam, and of active ones that meet others.
    std::vector<Slot> slot_hints;
    std::vector<world::Row> rows;  ///< of active agents, in their order; kNoRow: leave it alone
    std::vector<AgentStore::Event> events;
    std::vector<DueAgent> due;
    std::vector<HerdStep> herd_steps;  ///< ascending by entity
    std::vector<Slot> waking;          ///< who is to be resumed
    std::array<AiLane, kLanes> lanes;
    /// So far may animals that nobody sees be from their rows; 0: none are.
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

/// Whether an agent steers in this tick: where no player is near, it does so now and then only.
/// A state that was just entered begins at once, so that no command is ever repeated into it.
inline bool steers_now(const Agent& agent, const AiSettings& settings, Tick now) {
    return !settings.reduce_far || !agent.far || agent.entered || now >= agent.next_steering;
}

inline bool has_herds(const AiSettings& settings) {
    return std::any_of(settings.compiled.begin(),
                       settings.compiled.end(),
                       [](const CompiledBrain& brain) { return brain.flocks; });
}

/// The row of an entity whose agent may do something; kNoRow: leave it alone. `hint`: where it was.
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

/// When it leaves the square that its entity is in.
inline Tick left_at(const Agent& agent, const AiContext& ai, bool goes_on = false) {
    return OffscreenGrid::left_at(agent.segment, agent.placed, ai.half_size, ai.dt, goes_on);
}

/// Of a suspended agent: what its next_event() has found.
inline void schedule_event(const AiContext& ai, Slot slot) {
    ai.agents.schedule(slot, decision_period(brain_of(ai.agents.at(slot), ai.settings), ai.dt));
}

/// Puts the entity of a suspended agent where that has come to.
inline void place(Agent& agent, const AiContext& ai, AiTurn& turn, world::Row row) {
    catch_up(agent, ai, row);
    ai.entities.touch(row);
    turn.report.moved = true;
}

}  // namespace zoned::ai
