// Plan: the contents of the scene, and the passes of the step that run because of them.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <string_view>

namespace zoned::zone {

/// The passes of a step in their order.
enum class Pass : std::uint8_t {
    kDoors,
    kInbox,
    kRules,
    kAgents,
    kMovement,
    kRepresentation,
    kSoft,
    kMotors,
    kPlatforms,
    kPhysics,
    kParticles,
    kContacts,
    kHandoff,
    kGhosts,
    kInterest,
    kVisibilityFilter,
    kReplication,
    kHistory,
    kAudit,
    kHash,
};

inline constexpr std::size_t kPasses = static_cast<std::size_t>(Pass::kHash) + 1;

std::string_view pass_name(Pass pass);

/// The contents of the scene at the beginning of a tick (all counts).
struct Census {
    std::uint32_t entities = 0;  ///< owned
    std::uint32_t ghosts = 0;
    std::uint32_t characters = 0;         ///< owned characters that are not hidden
    std::uint32_t moving_characters = 0;  ///< of these: not at rest, or with a command that moves
    std::uint32_t agents = 0;
    bool maps_settled = true;         ///< no map of paths is being brought up to date
    std::uint32_t active_agents = 0;  ///< those whose entities are simulated
    std::uint32_t awake_bodies = 0;   ///< dynamic
    std::uint32_t reducible = 0;      ///< owned props that may be simulated as less than they are
    std::uint32_t soft_bodies = 0;
    std::uint32_t awake_soft = 0;  ///< of these
    std::uint32_t rigid_soft = 0;  ///< of these, simulated as rigid hulls
    std::uint32_t joints = 0;
    std::uint32_t motors = 0;            ///< of joints
    std::uint32_t moving_motors = 0;     ///< of these: with a target that follows time
    std::uint32_t particle_systems = 0;  ///< simulated here
    std::uint32_t viewers = 0;
    std::uint32_t filtered_types = 0;    ///< of the world: kinds that are asked about
    std::uint32_t rewindable_types = 0;  ///< of the world: kinds whose poses are remembered
    std::uint32_t audited = 0;           ///< viewers whose ticket allows audits
    std::uint32_t inbox = 0;
    std::uint32_t neighbours = 0;
    std::uint32_t doors = 0;
    std::uint32_t turning_doors = 0;  ///< of these, that open or shut in this tick
    std::uint32_t platforms = 0;
    std::uint32_t moving_platforms = 0;  ///< of these, that move in this tick or have just stopped
    bool particles_go_on = false;        ///< one of these has particles or will have
    bool rules_busy = false;
    bool ghosts_moved = false;  ///< a neighbour's ghost changed in the last tick
    bool frozen = false;
};

/// Which passes run and, for those that do not, why.
struct StepPlan {
    std::bitset<kPasses> runs;
    std::array<std::string_view, kPasses> reason{};  ///< static text, for running passes too

    [[nodiscard]] bool has(Pass pass) const { return runs[static_cast<std::size_t>(pass)]; }
};

/// Compiles the plan. A pass runs only when the census holds something for it to do.
StepPlan plan_for(const Census& census);

/// One pass in a step's report.
struct PassReport {
    bool ran = false;
    std::uint64_t ns = 0;  ///< thread time as the caller's stopwatch tells it; 0 without one
    std::uint32_t count =
        0;  ///< units of work: items, decisions, characters, contacts, pairs, packets, ...
};

using PassReports = std::array<PassReport, kPasses>;

}  // namespace zoned::zone
