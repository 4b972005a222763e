// Agent: all that the agent of one entity is made of; part of snapshots, handoffs and hashes.
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

/// How closely an agent is followed.
enum class Tier : std::uint8_t {
    kActive,     ///< decides at its period and steers its entity
    kSuspended,  ///< nobody can see it: it goes from event to event, and its entity is not
                 ///< simulated
};

/// What a suspended agent that stands and looks waits for besides time: that stock becomes other
/// than it was. As long as it does not, the agent's decisions change nothing.
struct StockWait {
    /// Clauses of its leaf's whose conditions on stock become other than `held` says, by bit
    /// Clause::stock_number.
    std::uint32_t clauses = 0;
    std::uint32_t held = 0;
    std::uint8_t trades = 0;  ///< of what it does that can be done, by bit

    /// Clauses with larger numbers are not waited for but looked at, at each decision.
    static constexpr std::uint16_t kMostClauses = 32;

    [[nodiscard]] bool any() const { return clauses != 0 || trades != 0; }

    friend bool operator==(const StockWait&, const StockWait&) = default;
};

/// No plan was made yet: more facts than a domain may have.
inline constexpr goap::FactSet kUnplanned = ~goap::FactSet{0};

/// Where on a track one is who follows it, and when (follow_spline.h).
struct SplineWalk {
    splines::LaneId lane = splines::kNoLane;
    splines::LaneId from = splines::kNoLane;  ///< it changes over from that one; none: it does not
    float s = 0.0F;  ///< on the lane, m: the end of the segment; where it changes: the beginning
    float from_s = 0.0F;     ///< where the change begins on that one, m
    float changed = 0.0F;    ///< way since then until the end of the segment, m
    float to_change = 0.0F;  ///< way until another lane is drawn, m
    Tick due = 0;            ///< it is to be at the end of its segment at the end of this tick ...
    float due_s = 0.0F;      ///< ... and so much later, s
};

/// Positions are zone-local.
struct Agent {
    EntityId entity;
    std::uint16_t brain = 0;                   ///< index into AiSettings::brains
    state_machine::ActiveState state_machine;  ///< where it is in it
    std::uint16_t current_action = 0;          ///< index into CompiledBrain::states
    goap::FactSet facts = kUnplanned;  ///< as its last plan found them, where its state plans
    std::array<float, kMaxVariables> variables{};  ///< as of variables_at: they grow since
    std::array<float, kMaxBlended> degrees{};      ///< of a blend's states, while it runs
    Tick variables_at = 0;
    Tick next_decision = 0;
    Vec3 home = Vec3::Zero();
    Vec3 target = Vec3::Zero();
    std::uint8_t corner = 0;  ///< of a round; what other actions keep there they say
    /// From cell to cell since it left home or food, where it forages; where it forms up, with how
    /// many it was when it got its slot.
    std::uint16_t steps = 0;
    EntityId
        prey;  ///< its target at the last decision: the nearest player, if nothing else is said
    EntityId ward;              ///< whom it looks after, likewise
    bool noticed = true;        ///< the target was; else it is remembered
    Vec3 known = Vec3::Zero();  ///< where it was noticed last, by agents that can remember
    Tick known_at = 0;          ///< and when
    core::Rng rng;
    std::uint8_t wants = 0;    ///< trades of what it does that are still to be done, by bit
    bool entered = true;       ///< the state is new: its action has not begun yet
    bool fresh = true;         ///< decided since it steered last
    bool far = false;          ///< no player within far_m at the last decision
    Tick next_steering = 0;    ///< where it is far: nothing is to be steered before
    motion::InputCommand aim;  ///< what it repeats until steering changes it (its tick is not used)
    Vec3 anchor = Vec3::Zero();  ///< where it last made progress
    Tick anchor_since = 0;       ///< when that was
    Tick detour_until = 0;       ///< until then it walks around what blocked it
    float band = 1.0F;           ///< factor of speed of a state with a rubber band
    Tier tier = Tier::kActive;
    Tick offscreen_since = kNever;  ///< active: since when nobody can see it
    bool timed = false;             ///< it goes by its segment; always where suspended
    PathSegment segment;
    SplineWalk track;  ///< of who follows one
    bool on_path =
        false;  ///< timed: its segment is one of a way to segment.goal, which it has asked for
    Tick again_at = kNever;      ///< timed, and stands: when it looks for a way again
    Vec2 placed = Vec2::Zero();  ///< suspended: x, z where its entity was put last
    Tick next_event = kNever;    ///< suspended
    Tick next_proximity_check =
        kNever;  ///< suspended: before then it meets nobody (proximity_schedule.h); kNever: ever
    StockWait wait;  ///< suspended
};

/// Puts an agent into the first state of its brain, with variables as they start.
void begin(Agent& agent, const CompiledBrain& brain, Tick now);

/// Moves all positions of an agent by `offset`, m: for a zone with another origin.
void shift(Agent& agent, const Vec3& offset);

/// All of it.
void hash(core::StateHash& hash, const Agent& agent);

/// What of an agent may become other where its segment ends, and it decides nothing.
void hash_walk(core::StateHash& hash, const Agent& agent);

}  // namespace zoned::ai
