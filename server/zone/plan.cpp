#include "server/zone/plan.h"

namespace zoned::zone {

std::string_view pass_name(Pass pass) {
    static constexpr std::array<std::string_view, kPasses> kNames = {
        "doors",       "inbox",          "rules",     "agents",
        "movement",    "representation", "soft",      "motors",
        "platforms",   "physics",        "particles", "contacts",
        "handoff",     "ghosts",         "interest",  "visibility_filter",
        "replication", "history",        "audit",     "hash"};
    return kNames[static_cast<std::size_t>(pass)];
}

StepPlan plan_for(const Census& census) {
    StepPlan plan;
    const auto decide =
        [&](Pass pass, bool run, std::string_view why_run, std::string_view why_not) {
            plan.runs[static_cast<std::size_t>(pass)] = run;
            plan.reason[static_cast<std::size_t>(pass)] = run ? why_run : why_not;
        };
    const bool live = !census.frozen;
    const std::string_view frozen = "the world is frozen";
    const bool simulated_change =
        census.awake_bodies > 0 || census.awake_soft > 0 || census.moving_characters > 0;

    decide(Pass::kDoors,
           census.turning_doors > 0,
           "doors open or shut",
           census.doors == 0 ? "no doors" : "no door opens or shuts");
    decide(Pass::kInbox, census.inbox > 0, "messages wait", "no message waits");
    decide(Pass::kRules,
           live && (census.rules_busy || census.viewers > 0),
           census.viewers > 0 ? "players are here" : "the rules have something pending",
           census.frozen ? frozen : "no player, nothing pending in the rules");
    decide(Pass::kAgents,
           live && (census.agents > 0 || !census.maps_settled),
           census.agents > 0 ? "agents live here" : "maps of paths follow a door",
           census.frozen ? frozen : "no agents");
    // An awake agent or a player may set another character moving in this very tick: the movement
    // pass looks at all characters. A character that wakes up in the pass moves from the next tick
    // on.
    decide(Pass::kMovement,
           live && census.characters > 0 &&
               (census.moving_characters > 0 || census.active_agents > 0 || census.viewers > 0 ||
                census.turning_doors > 0 || census.moving_platforms > 0),
           "characters move or may begin to",
           census.frozen ? frozen : "no character moves");
    const bool physics =
        live && (census.awake_bodies > 0 || census.awake_soft > 0 || census.moving_characters > 0 ||
                 census.active_agents > 0 || census.viewers > 0 || census.ghosts_moved ||
                 census.rules_busy || census.turning_doors > 0 || census.moving_motors > 0 ||
                 census.moving_platforms > 0);
    decide(Pass::kPhysics,
           physics,
           census.awake_bodies > 0       ? "bodies are awake"
           : census.awake_soft > 0       ? "soft bodies may push bodies"
           : census.moving_motors > 0    ? "motors follow time"
           : census.moving_platforms > 0 ? "platforms move"
                                         : "somebody may touch a body",
           census.frozen ? frozen : "all bodies sleep");
    decide(Pass::kMotors,
           physics && census.motors > 0,
           census.moving_motors > 0 ? "motors follow time" : "motors may have to hold a position",
           census.motors == 0 ? "no joint has a motor"
                              : (census.frozen ? frozen : "physics does not run"));
    decide(Pass::kPlatforms,
           live && census.moving_platforms > 0,
           "platforms move",
           census.platforms == 0 ? "no platforms"
                                 : (census.frozen ? frozen : "all platforms stand at a stop"));
    decide(Pass::kRepresentation,
           physics && census.reducible > 0,
           "props may be less than they are where nobody is near",
           census.frozen ? frozen
                         : (census.reducible == 0 ? "no type may be simulated as less than it is"
                                                  : "physics does not run"));
    decide(Pass::kSoft,
           physics && census.soft_bodies > 0,
           census.awake_soft > 0                     ? "soft bodies are awake"
           : census.rigid_soft == census.soft_bodies ? "rigid hulls may be soft again"
                                                     : "somebody may touch a soft body",
           census.soft_bodies == 0
               ? "no soft body"
               : (census.frozen ? frozen : "all soft bodies sleep and nothing comes near"));
    decide(Pass::kParticles,
           live && census.particles_go_on,
           "particles live or will be born",
           census.particle_systems == 0 ? "no particles that rules ask about"
           : census.frozen              ? frozen
                                        : "all particles are gone and no emitter goes on");
    decide(
        Pass::kContacts, physics, "physics runs", census.frozen ? frozen : "physics does not run");
    decide(Pass::kHandoff,
           live && census.neighbours > 0 &&
               (simulated_change || census.agents > 0 || census.viewers > 0),
           "something moves and there are neighbours",
           census.frozen ? frozen : (census.neighbours == 0 ? "no neighbour" : "nothing moves"));
    decide(Pass::kGhosts, census.neighbours > 0, "there are neighbours", "no neighbour");
    decide(Pass::kInterest, census.viewers > 0, "viewers listen", "no viewer");
    decide(Pass::kVisibilityFilter,
           census.viewers > 0 && census.filtered_types > 0,
           "types conceal themselves",
           census.viewers == 0 ? "no viewer" : "no type conceals itself");
    decide(Pass::kReplication, census.viewers > 0, "viewers listen", "no viewer");
    decide(Pass::kHistory,
           live && census.viewers > 0 && census.rewindable_types > 0,
           "rules may rewind what viewers saw",
           census.frozen ? frozen : (census.viewers == 0 ? "no viewer" : "no type is rewindable"));
    decide(Pass::kAudit, census.audited > 0, "audits are on", "nobody is audited");
    decide(Pass::kHash, true, "always", "");
    return plan;
}

}  // namespace zoned::zone
