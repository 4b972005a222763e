// Herd: animals of a herd that nobody sees go on by the rule of the flock, a second at a time.
#pragma once

#include "server/ai/agent/agent_store.h"
#include "server/ai/ai_context.h"
#include "server/ai/offscreen/suspend_resume.h"
#include "server/ai/steering/herd_drift.h"
#include "shared/motion/apply_input.h"

#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai {

/// Whether the agent goes with a herd.
inline bool roams(const Agent& agent, const CompiledBrain& brain) {
    return brain.states[agent.current_action].action == ActionKind::kFlock;
}

/// The fastest that one walks who roams so, m/s.
float roam_speed(const BrainState& state, const motion::CharacterLimits& limits);

/// Of a command, as motion::apply_input() has it, x, z, m/s.
Vec2 wanted_by(const motion::InputCommand& command, const motion::CharacterLimits& limits);

/// Who got on by less than this share of what it wanted walks into something.
inline constexpr float kHinderedShare = 0.9F;

/// The way of its last step, m: so far it may have come from where its entity was put.
inline float step_of(const Agent& agent) {
    return (agent.segment.goal - agent.segment.from).norm();
}

/// Whether the agent is on a step with its herd: no other segment leads on without an end.
inline bool on_step(const Agent& agent) {
    return agent.tier == Tier::kSuspended && agent.segment.length == 0.0F &&
           agent.segment.speed > 0.0F;
}

/// How far the entity of such a one may be from where a step of it begins, m: to place it costs
/// whoever reads its row.
inline constexpr float kHerdStale_m = 4.0F;

/// Whether such a one is at the end of its step, where roam() has found that it will stand
/// (agent.target), when it is at `at` (x, z, m).
bool at_step_end(const Agent& agent, const Vec2& at);

/// Whether it is time for a step.
inline bool roams_on(const Agent& agent, const CompiledBrain& brain, Tick now) {
    return roams(agent, brain) && (agent.entered || now >= agent.again_at);
}

/// Until when a step leads that begins now: a tick that is a multiple of a second, or of the
/// decisions of the brain where these are rarer, so that all animals of a kind begin the next one
/// together.
Tick roams_until(const CompiledBrain& brain, Tick now, float dt);

/// Where a step leads.
struct StepEnd {
    Vec3 at = Vec3::Zero();  ///< m
    bool stands = true;      ///< there; else it would leave the ground
};

/// The step of an animal that is at `from` to where it leads until roams_until(). Who would leave
/// the ground stands where it is, and is to be resumed. Where it comes to stand is agent.target.
void take_step(Agent& agent,
               const CompiledBrain& brain,
               const AiContext& ai,
               const Vec3& from,
               const StepEnd& end);

/// A character that moves along: along walls, over ledges, up and down the ground
/// (motion::apply_input). `free`: nothing was in the way.
struct Walked {
    motion::CharacterState state;
    bool free = true;
};

/// For `time_s` by a command that is held, which is longer than a tick: in one piece where the
/// ground is even and free, else in so many as follow it; ledges are climbed, and ground that falls
/// away is followed down, once in each.
Walked walked(const motion::CharacterState& from,
              const motion::InputCommand& command,
              const motion::CharacterLimits& limits,
              const motion::StaticGeometry& statics,
              float time_s,
              Tick now);

/// Where one comes that wants to go along `way` (x, z, m) in `time_s` from where it stands.
StepEnd walk_along(const motion::CharacterState& from,
                   const Vec2& way,
                   float time_s,
                   const motion::CharacterLimits& limits,
                   const motion::StaticGeometry& statics,
                   Tick now);

/// The step of an animal that is at `from`, along `way` (x, z, m) until roams_until(): as a
/// character moves that is simulated, so along walls, over ledges, up and down the ground
/// (motion::apply_input). False: it would leave the ground; it stands where it is, and is to be
/// resumed. Where it comes to stand is agent.target.
bool roam(Agent& agent,
          const CompiledBrain& brain,
          const AiContext& ai,
          world::Row row,
          const Vec3& from,
          const Vec2& way);

/// Whether nothing happens to it now but that its step is over: it came on as it wanted, and
/// decides nothing.
bool only_steps(const Agent& agent,
                const CompiledBrain& brain,
                const AiContext& ai,
                world::Row row);

/// Chains what such a step changes.
void hash_step(core::StateHash& hash, const Agent& agent);

/// The way that it goes until then where nothing changes its heading, x, z, m.
Vec2 path_ahead(const Agent& agent,
                const CompiledBrain& brain,
                const AiContext& ai,
                world::Row row);

/// Herds for a step: all animals that may come near each other until it is over stand in columns by
/// cells, and the rule is asked at the very ticks at which a simulated animal would decide and
/// steer, by where all of them are then: cells are so large that who is farther off than one is no
/// neighbour until the step is over (Hockney and Eastwood, "Computer Simulation Using Particles",
/// 1988, section 8-4-1, chaining mesh). In between they walk straight. Animals of the herd that are
/// simulated are foretold by the same rule. What is left out until the step is over is that paths
/// over surfaces may be barred, and that others turn who are not of a herd.
class Herds {
  public:
    void clear() { roaming_.clear(); }

    /// In any order: one that is at `at`, x, z, m.
    void add(Slot slot, world::Row row, const Vec3& at) { roaming_.push_back({slot, row, at}); }

    /// Sets their aims as they are at the end of their steps.
    void step(const AiContext& ai, const HerdDrift& drift);

    /// Where the n-th that was added comes.
    [[nodiscard]] const StepEnd& end(std::size_t n) const { return ends_[n]; }

  private:
    struct Roaming {
        Slot slot;
        world::Row row;
        Vec3 at;
    };

    /// Where all of them are, m, and the farthest that one reaches.
    struct Extent {
        Vec2 low;
        Vec2 high;
        float reach = 0.0F;
    };

    /// What is known of one beside the columns.
    struct Animal {
        EntityId entity;
        world::Row row;
        TypeIndex type;
        const Agent* agent;    // null: it goes straight on
        std::uint32_t number;  // of those who step; kNoNumber: it does not
        Tick until;            // who steps: when that is over
        Vec2 at;               // when it begins
        Vec2 velocity;         // m/s
        motion::InputCommand aim;
        float reach;                  // m: whom it may come to know of
        bool tries;                   // something may be in the way: it tries each piece of its way
        motion::CharacterState body;  // then: at the end of the piece that it walks
        std::uint32_t cell;
    };

    /// Cells in lines; those of a type follow those of another.
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

    const HerdDrift* drift_ = nullptr;  // of the step that is going on
    std::vector<Roaming> roaming_;
    std::vector<TypeIndex> types_;  // of those who step, each once
    std::vector<Animal> found_;
    std::vector<Animal> animals_;  // by cells
    Mesh mesh_;
    std::vector<std::uint32_t> first_;  // by cell, and one past the end
    // By animal: where it would be when the step begins if it always walked as it does now.
    std::vector<float> x_;
    std::vector<float> z_;
    std::vector<float> velocity_x_;
    std::vector<float> velocity_z_;
    std::vector<EntityId> entity_;
    std::vector<Tick> turns_at_;  // kNever: it goes straight on
    std::vector<std::uint32_t> turning_;
    std::vector<Vec2> wanted_;   // velocities of those who turn
    std::vector<bool> among_;    // by row: it is one of them; all false between two steps
    std::vector<StepEnd> ends_;  // of those who step
};

}  // namespace zoned::ai
