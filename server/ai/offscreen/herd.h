// Herd: suspended animals of a herd go on by the flocking rule, a second at a time.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/ai/ai_context.h"
#include "server/ai/offscreen/suspend_resume.h"
#include "server/ai/steering/herd_drift.h"
#include "server/ai/steering/terrain_walk.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai {

/// Whether the agent goes with a herd.
inline bool roams(const Agent& agent, const CompiledBrain& brain) {
    return brain.states[agent.current_action].action == ActionKind::kFlock;
}

/// The top speed of an animal that goes with a herd, m/s.
float roam_speed(const BrainState& state, const motion::CharacterLimits& limits);

/// An animal that covers less than this share of its desired distance has walked into something.
inline constexpr float kHinderedShare = 0.9F;

/// The length of its last step, m. Its entity was placed at most this far from it.
inline float step_of(const Agent& agent) {
    return (agent.segment.goal - agent.segment.from).norm();
}

/// Whether the agent is on a step with its herd. No other segment of a suspended agent has a speed
/// but no length.
inline bool on_step(const Agent& agent) {
    return agent.tier == Tier::kSuspended && agent.segment.length == 0.0F &&
           agent.segment.speed > 0.0F;
}

/// The greatest distance of a suspended herd animal's entity from the beginning of its step, m.
/// Placing an entity costs every reader of its row.
inline constexpr float kHerdStale_m = 4.0F;

/// Whether an agent at `at` (x, z, m) is at the end of its step. roam() has found that place before
/// (agent.target).
bool at_step_end(const Agent& agent, const Vec2& at);

/// Whether it is time for a step.
inline bool roams_on(const Agent& agent, const CompiledBrain& brain, Tick now) {
    return roams(agent, brain) && (agent.entered || now >= agent.again_at);
}

/// The end of a step that begins now. It is a tick that is a multiple of a second, or of the
/// brain's decision period if that is longer. So all animals of a kind begin their next step
/// together.
Tick roams_until(const CompiledBrain& brain, Tick now, float dt);

/// The end of a step.
struct StepEnd {
    Vec3 at = Vec3::Zero();  ///< m
    bool stands = true;      ///< on the ground; false: the step would leave it
};

/// Takes the step of an animal at `from` until roams_until(). An animal that would leave the ground
/// stays where it is, and is to be resumed. Its end position goes into agent.target.
void take_step(Agent& agent,
               const CompiledBrain& brain,
               const AiContext& ai,
               const Vec3& from,
               const StepEnd& end);

/// Where a character comes that wants to walk `way` (x, z, m) in `time_s`.
StepEnd walk_along(const motion::CharacterState& from,
                   const Vec2& way,
                   float time_s,
                   const motion::CharacterLimits& limits,
                   const motion::StaticGeometry& statics,
                   Tick now);

/// Takes the step of an animal at `from`, along `way` (x, z, m) until roams_until(). It moves as a
/// simulated character does: along walls, over ledges, up and down the ground
/// (motion::apply_input). False: it would leave the ground, stays where it is, and is to be
/// resumed. Its end position goes into agent.target.
bool roam(Agent& agent,
          const CompiledBrain& brain,
          const AiContext& ai,
          world::Row row,
          const Vec3& from,
          const Vec2& way);

/// Whether the end of its step is the agent's only event now: it got as far as it wanted, and
/// decides nothing.
bool only_steps(const Agent& agent,
                const CompiledBrain& brain,
                const AiContext& ai,
                world::Row row);

/// Adds to the hash what such a step changes.
void hash_step(core::StateHash& hash, const Agent& agent);

/// The displacement until then if nothing changes its heading, x, z, m.
Vec2 path_ahead(const Agent& agent,
                const CompiledBrain& brain,
                const AiContext& ai,
                world::Row row);

/// Moves herds by one step. The animals that may come near each other during the step stand in
/// columns, sorted by cell.
///
/// The flocking rule is applied at the very ticks at which a simulated animal would decide and
/// steer. It uses the positions of all animals at that tick. In between animals walk straight.
/// Simulated animals of the herd are predicted by the same rule.
///
/// Cells are large enough: an animal more than one cell away is no neighbour until the step is
/// over. (Chaining mesh: Hockney and Eastwood, "Computer Simulation Using Particles", 1988, section
/// 8-4-1.)
///
/// Two things are ignored until the step is over: barred paths over surfaces, and turns of entities
/// outside the herd.
class Herds {
  public:
    void clear() { roaming_.clear(); }

    /// Adds an animal at `at` (x, z, m), in any order.
    void add(Slot slot, world::Row row, const Vec3& at) { roaming_.push_back({slot, row, at}); }

    /// Takes the step of all animals, and sets their aims as they are at its end.
    void step(const AiContext& ai, const HerdDrift& drift);

    /// The end of the step of the n-th added animal.
    [[nodiscard]] const StepEnd& end(std::size_t n) const { return ends_[n]; }

  private:
    struct Roaming {
        Slot slot;
        world::Row row;
        Vec3 at;
    };

    /// The bounds of all positions, m, and the farthest reach of one animal.
    struct Extent {
        Vec2 low;
        Vec2 high;
        float reach = 0.0F;
    };

    /// The data of an animal that is not in the columns.
    struct Animal {
        EntityId entity;
        world::Row row;
        TypeIndex type;
        const Agent* agent;    // null: it goes straight on
        std::uint32_t number;  // among the animals that step; kNoNumber: it takes no step
        Tick until;            // end of its step, for an animal that steps
        Vec2 at;               // position at the beginning of the step
        Vec2 velocity;         // m/s
        motion::InputCommand aim;
        float reach;  // m: animals within this may matter to it
        bool tries;   // something may be in its path: it tries each piece of the walk
        motion::CharacterState body;  // if it tries: at the end of the current piece
        std::uint32_t cell;
    };

    /// Cells in lines. The cells of one type follow those of another. It has its own grid beside
    /// spatial::PointGrid: animals are sorted by cell into columns, and no search ever asks for
    /// them.
    struct Mesh {
        Vec2 origin = Vec2::Zero();
        float per_m = 1.0F;
        std::uint32_t columns = 1;
        std::uint32_t lines = 1;

        [[nodiscard]] std::uint32_t cells() const { return columns * lines; }
    };

    static constexpr std::uint32_t kNoNumber = 0xFFFFFFFFU;

    void gather(const AiContext& ai);
    void add_animal(const Agent* agent,
                    world::Row row,
                    std::uint32_t number,
                    const Vec2& at,
                    const AiContext& ai);
    [[nodiscard]] bool is_barred(const Animal& animal, float reach_m, const AiContext& ai) const;
    void walk_on(std::size_t n, const AiContext& ai, Tick now);
    void add_others(const AiContext& ai);
    [[nodiscard]] Extent extent_of_found() const;
    void lay_mesh();
    void sort_by_cells();
    [[nodiscard]] std::uint32_t rank_of(TypeIndex type) const;
    [[nodiscard]] Vec2 place(std::size_t n, float time_s) const;
    void turn_all(const AiContext& ai, Tick now);
    [[nodiscard]] Vec2 turned(std::size_t n, const AiContext& ai, Tick now);
    void set_velocity(std::size_t n, const Vec2& velocity, float time_s);
    void leave(std::size_t n, const AiContext& ai, float time_s);

    const HerdDrift* drift_ = nullptr;  // of the current step
    std::vector<Roaming> roaming_;
    std::vector<TypeIndex> types_;  // of the animals that step, each type once
    std::vector<Animal> found_;
    std::vector<Animal> animals_;  // sorted by cell
    Mesh mesh_;
    std::vector<std::uint32_t> first_;  // by cell, and one past the end
    // By animal: its position at the beginning of the step, had it always walked as it does now.
    std::vector<float> x_;
    std::vector<float> z_;
    std::vector<float> velocity_x_;
    std::vector<float> velocity_z_;
    std::vector<EntityId> entity_;
    std::vector<Tick> turns_at_;  // kNever: it goes straight on
    std::vector<std::uint32_t> turning_;
    std::vector<Vec2> wanted_;  // desired velocities of the animals that turn
    std::vector<bool> among_;   // by row: whether its animal was added; all false between two steps
    std::vector<StepEnd> ends_;  // of the animals that step
};

}  // namespace zoned::ai
