// Agent: all state of one entity's agent; part of snapshots, handoffs and hashes.
#pragma once

#include "server/ai/agent/brain/brain.h"
#include "server/ai/agent/path_segment.h"
#include "shared/core/ids.h"
#include "shared/core/rng.h"
#include "shared/core/state_hash.h"
#include "shared/math/types.h"
#include "shared/motion/input_command.h"

#include <array>
#include <cstdint>

namespace zoned::ai {

/// How closely the server simulates an agent.
enum class Tier : std::uint8_t {
    kActive,     ///< decides at its period and steers its entity
    kSuspended,  ///< off screen: it goes from event to event, and its entity is not simulated
};

/// The stock that a suspended, waiting agent watches. The agent stands still, and its decisions
/// change nothing until time or this stock changes something.
struct StockWait {
    /// Clauses of its leaf, by bit Clause::stock_number. The agent waits until their conditions on
    /// stock differ from `held`.
    std::uint32_t clauses = 0;
    std::uint32_t held = 0;
    std::uint8_t trades = 0;  ///< of its action that can be done, by bit

    /// Clauses with larger numbers are not waited for. They are checked at each decision.
    static constexpr std::uint16_t kMostClauses = 32;

    [[nodiscard]] bool any() const { return clauses != 0 || trades != 0; }

    friend bool operator==(const StockWait&, const StockWait&) = default;
};

/// No plan was made yet: the value holds more facts than a domain may have.
inline constexpr goap::FactSet kUnplanned = ~goap::FactSet{0};

/// The position on a spline of an agent that follows one, and its time there (spline_following.h).
struct SplineWalk {
    splines::LaneId lane = splines::kNoLane;
    splines::LaneId from = splines::kNoLane;  ///< lane that it leaves; none: no lane change
    float s = 0.0F;          ///< on `lane`, m: at the segment's end, or where a lane change begins
    float from_s = 0.0F;     ///< where the lane change begins on lane `from`, m
    float changed = 0.0F;    ///< from the start of the lane change to the segment's end, m
    float to_change = 0.0F;  ///< distance until another lane is drawn, m
    Tick due = 0;            ///< it is to reach the end of its segment at the end of this tick ...
    float due_s = 0.0F;      ///< ... plus this time, s
};

/// Positions are zone-local.
struct Agent {
    EntityId entity;
    std::uint16_t brain = 0;                   ///< index into AiSettings::brains
    state_machine::ActiveState state_machine;  ///< its current states in the state machine
    std::uint16_t current_action = 0;          ///< index into CompiledBrain::states
    goap::FactSet facts = kUnplanned;          ///< as found by its last plan, in a state that plans
    std::array<float, kMaxVariables> variables{};  ///< at variables_at; grown since
    std::array<float, kMaxBlended> degrees{};      ///< of a blend's states, while the blend runs
    Tick variables_at = 0;
    Tick next_decision = 0;
    Vec3 home = Vec3::Zero();
    Vec3 target = Vec3::Zero();
    std::uint8_t corner = 0;  ///< of a patrol round; other actions document their own use
    /// Foraging: the cells walked since home or food. Formation: the number of members when the
    /// agent got its slot.
    std::uint16_t steps = 0;
    EntityId prey;              ///< its target at the last decision; the nearest player by default
    EntityId ward;              ///< the entity that it looks after, at the last decision
    bool noticed = true;        ///< the target was noticed; false: it is remembered
    Vec3 known = Vec3::Zero();  ///< where the target was noticed last, by agents that can remember
    Tick known_at = 0;          ///< and when
    core::Rng rng;
    std::uint8_t wants = 0;      ///< trades of its action that are still to be done, by bit
    bool entered = true;         ///< the state is new: its action has not begun yet
    bool fresh = true;           ///< it has decided since it steered last
    bool far = false;            ///< no player within far_m at the last decision
    Tick next_steering = 0;      ///< where `far`: no steering before this tick
    motion::InputCommand aim;    ///< repeated until it steers again (its tick is not used)
    Vec3 anchor = Vec3::Zero();  ///< where it last made progress
    Tick anchor_since = 0;       ///< when that was
    Tick detour_until = 0;       ///< until then it walks around the obstacle that blocked it
    float band = 1.0F;           ///< speed factor of a state with a rubber band
    Tier tier = Tier::kActive;
    Tick offscreen_since = kNever;  ///< active: off screen since this tick
    bool timed = false;  ///< it follows its segment by timetable; always so when suspended
    PathSegment segment;
    SplineWalk track;            ///< of an agent that follows a spline
    bool on_path = false;        ///< timed: its segment is part of a requested path to segment.goal
    Tick again_at = kNever;      ///< timed, standing: when it requests a path again
    Vec2 placed = Vec2::Zero();  ///< suspended: x, z where its entity was placed last
    Tick next_event = kNever;    ///< suspended
    Tick next_proximity_check = kNever;  ///< suspended: it meets no entity before this tick
                                         ///< (proximity_schedule.h); kNever: it never will
    StockWait wait;                      ///< suspended
};

/// Puts an agent into the first state of its brain, with the initial values of its variables.
void begin(Agent& agent, const CompiledBrain& brain, Tick now);

/// Moves all positions of an agent by `offset`, m: for a zone with another origin.
void shift(Agent& agent, const Vec3& offset);

/// Adds the whole agent to the hash.
void hash(core::StateHash& hash, const Agent& agent);

/// Adds the fields that may change at the end of a segment without a decision.
void hash_walk(core::StateHash& hash, const Agent& agent);

}  // namespace zoned::ai
