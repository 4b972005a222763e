// ai_update: perception, decisions and steering of all agents in a zone; its output is one
// InputCommand per character.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/ai/agent/ai_settings.h"
#include "server/ai/agent/difficulty.h"
#include "server/ai/agent/decision.h"
#include "server/ai/offscreen/forage.h"
#include "server/ai/offscreen/herd.h"
#include "server/ai/offscreen/proximity_schedule.h"
#include "server/ai/offscreen/suspend_resume.h"
#include "server/ai/offscreen/viewer_coverage.h"
#include "server/ai/pathfinding/path_service.h"
#include "server/ai/steering/formation_following.h"
#include "server/ai/steering/local_avoidance.h"
#include "server/compute/team.h"
#include "server/spatial/point_grid.h"
#include "server/world/entities.h"
#include "shared/motion/static_geometry.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai {

/// What the step reads and moves.
struct AiContext {
    world::Entities& entities;
    const world::TypeTable& types;
    /// Indexes entities.position by row; asked for at most once, and only where somebody needs to
    /// know of others than players.
    std::function<const spatial::PointGrid&()> grid;
    PointsOfInterest& points_of_interest;
    const motion::StaticGeometry& statics;
    compute::Team& team;  ///< helps; results do not depend on it
    /// x, z: who has left the square of this half size around the origin is to be woken, m.
    Vec2 half_size;
    Tick now;
    float dt;                               ///< s
    const physics::Query* query = nullptr;  ///< what lines of sight meet; null: nothing
    PathService* paths = nullptr;           ///< null: none are planned
    float shared_m = 0.0F;  ///< so far within half_size entities may belong to other zones
};

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

/// Working memory of step(), kept so that a tick allocates nothing; and what it tells its zone.
class AiUpdate {
  public:
    /// Changes of tier in the last step, ascending by entity id: whoever fell asleep needs no body,
    /// and who woke up does.
    [[nodiscard]] std::span<const EntityId> suspended() const { return suspended_; }

    [[nodiscard]] std::span<const EntityId> resumed() const { return resumed_; }

    /// The nests of who forages: their scents are part of the zone's state.
    [[nodiscard]] const Nests& nests() const { return nests_; }

    /// Chains what the agents are that had something to decide or an event in the last step.
    void hash(const AgentStore& agents, core::StateHash& hash) const;

    /// `settings` are compiled for world.dt. Writes `command`, `stance` of the rows of active
    /// agents, and points_of_interest those of offscreen ones. Players are the rows with a client
    /// and without kHidden. Rows of hidden or removed entities and of ghosts are left alone. With n
    /// agents that decide in every tick and a budget of b decisions none waits longer than ceil(n /
    /// b) ticks. Results depend neither on the order of rows, nor on the history of add() and
    /// take(), nor on threads. A budget of 0 counts as 1, and one of less than kRaysPerLook rays as
    /// that: who finds no rays left waits, and goes on with what it knew, at most ceil(n / (rays /
    /// kRaysPerLook)) ticks. Steps of herds that nobody sees are no decisions.
    AiReport run(AgentStore& agents, const AiContext& world, const AiSettings& settings);

    /// What a step knows of those before it, for snapshots.
    struct SavedAiState {
        std::vector<EntityId> viewers;  ///< of the last tick, ascending
        std::vector<Vec2>
            covered_from;            ///< x, z of viewers when it was found out what they can see
        float coverage_m = 1.0F;     ///< and how far, > 0
        DifficultyState difficulty;  ///< on which difficulty, and what players have done there
    };

    [[nodiscard]] const SavedAiState& saved_state() const { return saved_; }

    [[nodiscard]] DifficultyState& difficulty() { return saved_.difficulty; }

    /// `agents` are those that the memory belongs to.
    void load(const SavedAiState& memory,
              const Nests::SavedNests& nests,
              const AgentStore& agents,
              const AiSettings& settings);

    /// After `paths` were read: tells them where those who wait are.
    void wait_for(const PathService& paths, const AgentStore& agents);

  private:
    /// An agent that has something to do in this tick.
    struct DueAgent {
        Tick since;  ///< when it should have been done at the latest
        EntityId entity;
        Slot slot;
        world::Row row;
        Tier tier;
        bool decides = true;
        bool waited = false;   ///< offscreen: for stock
        bool changed = false;  ///< it has decided otherwise than before
        bool moved = false;    ///< offscreen: its row is another one than before
        bool roams = false;    ///< offscreen: it takes a step with its herd
        StepEnd end{};         ///< of that
        std::optional<state_machine::StateChange> change{};
        Tick next_event = kNever;
        Tick left = kNever;  ///< offscreen: when it leaves the square that it is in
    };

    /// A offscreen agent that takes a step with its herd, and has nothing else to do.
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
        std::vector<Slot> asking;  ///< who needs a way
        float drift_m = 0.0F;      ///< of herds: the longest way between two steps
        std::uint32_t transitions = 0;
        std::uint32_t steered = 0;
    };

    /// Offscreen agents that decide in this tick, and would trade if only the stock were so.
    struct WaitingTraders {
        const StockWaitList::WaitGroup* group = nullptr;
        bool may = false;     ///< the stock is so
        bool queued = false;  ///< `next` is what it should be
        std::vector<StockWaitList::WaitMember>
            next;  ///< whose turn is still to come, a heap by entity
    };

    static constexpr std::size_t kLanes = 16;
    static constexpr std::size_t kShared = 256;  ///< fewer agents are not worth a second thread

    void follow_viewers(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void watch();
    void follow_suspended(AgentStore& agents, const AiContext& world);
    void check_suspended_seen(AgentStore& agents, const AiContext& world, bool all);
    void next_proximity_check(AgentStore& agents, Slot slot, const AiContext& world);
    void place(Agent& agent, const AiContext& world, world::Row row);
    void index_suspended(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void meet(AgentStore& agents, const AiContext& world);
    void look_around(const AgentStore& agents,
                     const AiContext& world,
                     PerceptionRanges::PerceiverKind kind,
                     world::Row row);
    void check_suspended(AgentStore& agents, const AiContext& world, Slot slot);
    void settle(AgentStore& agents,
                Slot slot,
                Tick left,
                const AiContext& world,
                bool late = false);
    [[nodiscard]] bool meets_nobody(AgentStore& agents,
                                    const DueAgent& due,
                                    const AiContext& world,
                                    Tick calm);
    [[nodiscard]] const Agent* agent_at(const AgentStore& agents,
                                        const world::Entities& entities,
                                        world::Row row) const;
    [[nodiscard]] ProximitySchedule::Scene scene(const AgentStore& agents,
                                                 const AiContext& world) const;
    void resume_seen(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void collect_due(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void keep_to_budgets(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void find_others(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    [[nodiscard]] OffscreenContext offscreen(const AiContext& world) const;
    void decide_due(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void decide_one(AgentStore& agents,
                    DueAgent& due,
                    const AiContext& world,
                    const AiSettings& settings,
                    AiLane& lane);
    void call_up_waiting(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void settle_trades(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void collect_traders(AgentStore& agents, const AiSettings& settings);
    void collect_waiting_traders(AgentStore& agents,
                                 const AiContext& world,
                                 const AiSettings& settings);
    void look_at_stock(const AiContext& world, const AiSettings& settings, EntityId after);
    [[nodiscard]] WaitingTraders* first_waiting_trader();
    bool call_up_trader(AgentStore& agents,
                        const AiContext& world,
                        const AiSettings& settings,
                        Slot slot);
    void trade(AgentStore& agents,
               const AiContext& world,
               const AiSettings& settings,
               std::uint32_t due);
    void plan(AgentStore& agents,
              Slot slot,
              const AiContext& world,
              const AiSettings& settings) const;
    void steer_active(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void call_foragers(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void forage(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    [[nodiscard]] HerdDrift drift_of(const AgentStore& agents, const AiContext& world) const;
    void head_herds(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void walk_herd_steps(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void settle_herd_steps(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    [[nodiscard]] Tick event_after(Agent& agent,
                                   const DueAgent& due,
                                   const AiContext& world,
                                   const AiSettings& settings) const;
    bool set_roaming(Agent& agent,
                     const DueAgent& due,
                     const AiContext& world,
                     const AiSettings& settings);
    void formation_following(AgentStore& agents,
                             const AiContext& world,
                             const AiSettings& settings);
    void local_avoidance(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void watch_changes(AgentStore& agents, const AiContext& world) const;
    void advance_suspended(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void find_paths(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void count_bodies(const AiContext& world);
    void request_paths(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void give_commands(const AgentStore& agents,
                       const AiContext& world,
                       const AiSettings& settings);
    void go_on(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void go_on_from(Agent& agent, Slot slot, const AiContext& world, const AiSettings& settings);
    void suspend_unseen(AgentStore& agents, const AiContext& world, const AiSettings& settings);
    void add_up();
    template <class Work>
    void in_lanes(compute::Team& team, std::size_t count, Work&& work);

    AiReport report_;
    ViewerCoverage viewer_coverage_;
    spatial::PointGrid nobody_;
    const spatial::PointGrid* others_ = &nobody_;
    SavedAiState saved_;
    std::vector<EntityId> viewers_before_;
    Players players_;
    std::vector<world::Row> row_hints_;  // by slot: where the entity was last
    /// By row: of offscreen agents that roam, and of active ones that meet others.
    std::vector<Slot> slot_hints_;
    float drift_m_ = 0.0F;  // so far may animals that nobody sees be from their rows; 0: none are
    std::vector<world::Row> rows_;  // of active agents, in their order; kNoRow: leave it alone
    std::vector<AgentStore::Event> events_;
    std::vector<DueAgent> due_;
    std::vector<HerdStep> herd_steps_;             // ascending by entity
    std::vector<std::uint32_t> traders_;           // of due_, ascending by entity
    std::vector<WaitingTraders> waiting_traders_;  // the first some of them count
    std::size_t waiting_trader_groups_ = 0;
    std::vector<Slot> asking_;   // for paths, ascending by entity
    std::vector<Slot> waiting_;  // for paths that they have asked for
    std::vector<Slot> told_;     // paths
    std::vector<float> body_x_;  // of those whom paths lead around
    std::vector<float> body_z_;
    std::vector<OffscreenGrid::Cell> covered_squares_;  // in which agents may be seen
    std::vector<Slot> left_;
    std::vector<Slot> waking_;
    PerceptionRanges perception_ranges_;
    ProximitySchedule proximity_schedule_;
    std::vector<Slot> met_;  // sleepers, by one who looked whether it might sleep
    std::vector<EntityId> suspended_;
    std::vector<EntityId> resumed_;
    std::array<AiLane, kLanes> lanes_;
    std::vector<AvoidingAgent> walkers_;
    steering::KnownWalls walls_;
    Formations formations_;
    Nests nests_;
    Herds herds_;
    LocalAvoidance local_avoidance_;
};

}  // namespace zoned::ai
