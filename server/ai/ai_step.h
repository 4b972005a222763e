// ai_step: perception, decisions and steering of all minds in a zone; its output is one
// InputCommand per character.
#pragma once

#include "server/ai/machine.h"
#include "server/spatial/point_grid.h"
#include "server/world/entities.h"
#include "shared/core/rng.h"
#include "shared/core/state_hash.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai {

struct Settings {
    std::vector<Machine> machines;            ///< as written
    std::vector<CompiledMachine> compiled{};  ///< the same for the world's time step: compile()
    std::uint32_t max_decisions_per_tick =
        4096;  ///< counted units of work; what does not fit waits, the longest waiting first
    bool reduce_far = true;  ///< minds farther than far_m from every player steer every 4th tick
    float far_m = 150.0F;
    std::uint32_t max_plan_nodes = 1024;  ///< that one search for a plan may create
};

/// Fills in `compiled`, where inner machines stay empty; `dt` in s.
void compile(Settings& settings, float dt);

/// No plan was made yet: more facts than a domain may have.
inline constexpr goap::World kUnplanned = ~goap::World{0};

/// The mind of one entity: part of snapshots, handoffs and hashes. Positions are zone-local.
struct Mind {
    EntityId entity;
    std::uint16_t machine = 0;       ///< index into Settings::machines
    fsm::OneState fsm;               ///< where it is in it
    std::uint16_t doing = 0;         ///< index into CompiledMachine::states
    goap::World facts = kUnplanned;  ///< as its last plan found them, where its state plans
    std::array<float, kMaxVariables> variables{};  ///< as of variables_at
    Tick variables_at = 0;
    Tick next_decision = 0;
    Vec3 home = Vec3::Zero();
    Vec3 target = Vec3::Zero();
    std::uint8_t corner = 0;
    EntityId prey;  ///< nearest player noticed at the last decision
    core::Rng rng;
    bool entered = true;       ///< the state is new: its action has not begun yet
    bool fresh = true;         ///< decided since it steered last
    bool far = false;          ///< no player within far_m at the last decision
    motion::InputCommand aim;  ///< what it repeats until steering changes it (its tick is not used)
    Vec3 anchor = Vec3::Zero();  ///< where it last made progress
    Tick anchor_since = 0;       ///< when that was
    Tick detour_until = 0;       ///< until then it walks around what blocked it
    float band = 1.0F;           ///< factor of speed of a state with a rubber band
};

/// Puts a mind into the first state of its machine, with variables as they start.
void begin(Mind& mind, const CompiledMachine& machine, Tick now);

/// Moves all positions of a mind by `offset`, m: for a zone with another origin.
void shift(Mind& mind, const Vec3& offset);

struct Report {
    std::uint32_t minds = 0;
    std::uint32_t decisions = 0;
    std::uint32_t steered = 0;
    std::uint32_t postponed = 0;  ///< decisions that the budget moved to a later tick
    std::uint32_t transitions = 0;
    std::uint32_t plans = 0;
    std::uint32_t plans_cut_off = 0;      ///< their search met its bound
    std::uint32_t plans_unreachable = 0;  ///< no sequence of actions makes the goal true
};

/// What decisions need while they are made, and count; holds no state.
struct Thinking {
    std::uint32_t max_plan_nodes = 1024;
    std::optional<goap::Planner> planner{};  ///< once some mind plans
    goap::Plan plan{};
    std::uint32_t plans = 0;
    std::uint32_t plans_cut_off = 0;
    std::uint32_t plans_unreachable = 0;
};

/// All minds of one zone, ascending by entity id.
class Minds {
  public:
    /// `machine` must exist in the settings; `rng` is seeded per entity by the caller.
    void add(const Mind& mind);
    /// Removes and returns (for a handoff); the entity must have one.
    Mind take(EntityId entity);
    [[nodiscard]] const Mind* find(EntityId entity) const;

    [[nodiscard]] std::size_t size() const { return minds_.size(); }

    [[nodiscard]] std::span<Mind> all() { return minds_; }

    void hash(core::StateHash& hash) const;

    /// Working memory of step(), kept so that a tick allocates nothing; holds no state.
    struct Scratch {
        std::vector<world::Row> rows;    ///< row of each mind, kNoRow = leave it alone
        std::vector<std::uint32_t> due;  ///< minds that want to decide
        Thinking thinking;
    };

    [[nodiscard]] Scratch& scratch() { return scratch_; }

  private:
    std::vector<Mind> minds_;
    Scratch scratch_;
};

/// `settings` are compiled for `dt`. Writes `command`, `behaviour` of the rows that have a mind.
/// `grid` indexes entities.position by row; `dt` in s. Players are the rows with a client and
/// without kHidden. Rows of hidden or removed entities and of ghosts are left alone. With n minds
/// and a budget of b decisions none waits longer than ceil(n / b) ticks. Results depend neither on
/// the order of rows nor on the history of add() and take(). A budget of 0 counts as 1.
Report step(Minds& minds,
            world::Entities& entities,
            const world::TypeTable& types,
            const spatial::PointGrid& grid,
            const Settings& settings,
            Tick now,
            float dt);

}  // namespace zoned::ai
