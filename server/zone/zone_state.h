// ZoneState: all data of one zone; the stages of the step are functions over it.
#pragma once

#include "server/ai/ai_update.h"
#include "server/interest/matcher.h"
#include "server/physics/particles/particle_systems.h"
#include "server/physics/scene/scene.h"
#include "server/physics/soft/soft_bodies.h"
#include "server/replication/replicator.h"
#include "server/spatial/point_grid.h"
#include "server/world/entities.h"
#include "server/world/visibility.h"
#include "server/zone/assemblies/assembly_state.h"
#include "server/zone/context/rules_timers.h"
#include "server/zone/groups/rules_instances.h"
#include "server/zone/groups/rules_matches.h"
#include "server/zone/groups/rules_parties.h"
#include "server/zone/plan.h"
#include "server/zone/pose_history.h"
#include "server/zone/rules.h"
#include "server/zone/simulation/deformation_fit.h"
#include "server/zone/zone_messages.h"
#include "server/zone/zone_settings.h"
#include "shared/core/rng.h"
#include "shared/core/state_hash.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::compute {
class Team;
}

namespace zoned::zone {

/// The output of a tick. Cleared at the beginning of each tick.
struct StepOutput {
    std::vector<mailbox::StatePacket> packets;
    std::vector<mailbox::OutboxItem> messages;  ///< Joined, Kick, AuditRecord
    std::vector<PendingEvent> events;
    std::vector<BurstOut> bursts;
    std::vector<ClockChange> clocks;
    std::vector<DoorChange> doors;
    std::vector<PlatformChange> platforms;
    std::vector<TopicChange> topics;
    std::vector<RulesMessage> rules_messages;
    std::vector<Handoff> handoffs;
    std::vector<ClientId> departed;  ///< clients that left the world for good
    std::vector<mailbox::StoreRequest> store;
    std::vector<TravelWish> travels;
    std::vector<std::string> lines;  ///< of the rules, for the log
    std::vector<RulesFigure> figures;
    std::vector<PartyOrder> party_orders;
    std::vector<InstanceOrder> instance_orders;
    std::vector<MatchOrder> match_orders;

    void clear();
};

/// The work of a tick, for metrics; never read by the simulation.
struct StepReport {
    Tick tick = 0;
    Census census;
    StepPlan plan;
    PassReports passes{};
    physics::StepStats physics;
    physics::soft::SoftStats soft;
    physics::ParticleReport particles;
    ai::AiReport ai;
    std::optional<ai::LevelChange> level_change;
    interest::InterestReport interest;
    replication::ReplicationReport replication;
    /// Soft bodies whose shape the control points could not hold within its bound.
    std::uint32_t deformations_beyond = 0;
    std::uint32_t handoffs_out = 0;
    std::uint32_t out_of_world = 0;    ///< entities that left the world and were put back
    std::uint32_t refused_items = 0;   ///< inbox items for clients or entities that are not here
    std::uint32_t fields_clamped = 0;  ///< numbers of rules beyond the range of a declared field
    std::uint32_t fields_refused = 0;  ///< values of rules that a declared field cannot hold
};

/// An entry of another zone's export, for the length of an import.
struct GhostArrival {
    const EntityState* state = nullptr;
    ZoneId owner;
    Vec3 shift = Vec3::Zero();
    double outside_m = 0.0;  ///< of this zone's region
};

/// A ghost whose body is not yet where its owner's entity is.
struct LedGhost {
    EntityId entity;
    ZoneId owner;
    std::uint32_t place = 0;  ///< in the owner's export
};

/// An owned prop touched a neighbour's ghost.
struct GhostContact {
    EntityId prop;
    ZoneId owner;  ///< of the ghost
};

/// The zone's simulated particles, empty where the world has none, and when cosmetic bursts were
/// let out last.
struct ParticlesOfZone {
    struct System {
        std::string name;
        physics::ParticleSystemId id;
        std::optional<motion::BurstKind> burst;
        std::uint32_t characters_met = 0;
        Vec3 focus = Vec3::Zero();  ///< the characters nearest to here are met
    };

    struct NearCharacter {
        float distance2 = 0.0F;
        EntityId id;
        world::Row row = world::kNoRow;
    };

    physics::ParticleSystems simulated;
    std::vector<System> systems;
    std::uint64_t bursts = 0;                  ///< so far: each gets a seed of its own
    std::uint64_t cosmetic_bursts = 0;         ///< counted apart: they change nothing simulated
    std::vector<double> cosmetic_due;          ///< of each cosmetic burst: the tick up to which the
                                               ///< events so far are paid for
    std::vector<NearCharacter> near;           ///< scratch
    std::vector<physics::ParticleBall> balls;  ///< scratch
};

/// The bodies that doors have while they are shut, in the order of StaticGeometry::doors(). Empty
/// where the zone has no door.
struct DoorBodies {
    std::vector<BodyId> body;
    Tick next_turn = 0;  ///< of any of them
};

/// Which body an owned entity is.
struct SoftLink {
    EntityId entity;
    physics::soft::SoftId body;
    // Where it has stepped down to a rigid hull, see simulation/soft_hull.h:
    Quat start = Quat::Identity();  ///< the hull's orientation then
    Quat turn = Quat::Identity();   ///< from the hull's orientation to the entity's
};

/// The soft bodies of a zone and whose they are. Made with the first one.
struct SoftMatter {
    physics::soft::SoftBodies bodies;
    std::vector<SoftLink> links;  ///< ascending by entity
    /// By EntityType::solid; null until a body of that type has moved.
    std::vector<std::unique_ptr<DeformationFit>> fits;
    std::vector<Vec3> moved;           ///< work: displacements of the nodes of one body, m
    std::vector<std::uint32_t> codes;  ///< work: of its control points
};

/// The last answer for one viewer and an entity that may be concealed.
struct FilteredPair {
    EntityId entity;
    Tick asked = -1;      ///< -1: never
    bool answer = false;  ///< of then
    Tick known = -1;      ///< newest tick in which it was to be known; -1: never
    Tick since = -1;      ///< in the viewer's set since this tick; -1: not in it
};

struct ViewerFilter {
    ClientId client;
    std::vector<FilteredPair> seen;  ///< ascending by entity
};

/// One pair that is to be asked about.
struct DuePair {
    Tick asked = -1;
    std::uint32_t viewer = 0;
    std::uint32_t sight = 0;
};

/// The visibility filter within the radii; empty where no type conceals itself.
struct FilteredVisibility {
    world::Visibility heard;            ///< by the radii alone: the matcher's sets
    std::vector<ViewerFilter> viewers;  ///< in the order of `heard`
    std::uint32_t checks = 0;           ///< in this tick
    std::uint32_t overdue = 0;          ///< pairs that were due and not asked about
    std::vector<DuePair> due;           ///< scratch, as is the rest
    std::vector<FilteredPair> listed;
    std::vector<world::Visible> before;
    std::vector<ViewerFilter> aligned_viewers;
    world::Visibility aligned_notified;
    std::vector<ClientId> fresh;  // viewers whose sets are new
};

/// Whether the radii of an entity are those of a tick ago, for audits.
struct AuditedRadii {
    EntityId entity;
    std::uint8_t stance = 0;
    Tick changed = 0;  ///< 0: never since it came here
};

struct ZoneState {
    ZoneSettings settings;
    Tick now = 0;
    bool frozen = false;
    bool brains_replaced = false;   ///< agents live by other brains than the config's
    std::uint32_t next_entity = 0;  ///< counter of ids handed out
    std::uint64_t next_event = 0;
    std::uint64_t next_store_request = 0;

    world::Entities entities;
    physics::Scene scene;
    AssemblyState assemblies;
    std::unique_ptr<SoftMatter> soft;  ///< null until there is a soft body
    compute::Team* team =
        nullptr;  ///< helps where a stage is large; outlives this; null: nobody does
    ParticlesOfZone particles;
    ai::AgentStore agents;
    ai::AiUpdate ai_update;
    ai::PointsOfInterest points_of_interest;
    ai::PathService paths;  ///< empty where none are planned
    DoorBodies doors;
    std::vector<BodyId> platforms;  ///< of the zone, in the order of StaticGeometry::platforms()
    /// The statics without platforms, which agents plan on; null: the statics have none.
    std::unique_ptr<const motion::StaticGeometry> fixed_ground;
    TriggerState triggers;
    std::unique_ptr<Rules> rules;
    bool rules_started = false;  ///< on_start was called
    RulesTimers timers;
    RulesParties parties;      ///< of the world; without a book where it has none
    RulesInstances instances;  ///< likewise
    RulesMatches matches;      ///< likewise
    /// Of entities that the config placed, in all zones.
    std::map<std::string, EntityId, std::less<>> entity_names;
    /// The pass that runs now: where a zone stopped, or the process crashed.
    std::optional<Pass> running;
    core::Rng rng;
    std::vector<ZoneClient> clients;  ///< ascending by client id

    spatial::PointGrid grid;
    bool grid_valid = false;            ///< grid matches entities.position of this moment
    std::vector<world::Row> grid_rows;  ///< scratch of the same
    interest::Matcher matcher;
    bool filters_visibility = false;  ///< some type of the world conceals itself
    std::vector<world::Viewer> viewers;
    world::Visibility visibility;
    FilteredVisibility filtered;
    replication::Replicator replicator;
    std::vector<AuditedRadii> audited_radii;  ///< by row; kept while somebody is audited

    PoseHistory history;  ///< empty where no type of the world is rewindable
    std::vector<std::pair<EntityId, world::Row>> history_rows;  ///< scratch

    world::RowSet near_border;            ///< rows that neighbours heard of in the last export
    std::vector<EntityState> ghosts_out;  ///< this tick's export, ascending by row
    bool ghosts_out_changed = true;
    // What the last export changed; nothing of it is saved, and the first export is all anew.
    bool ghosts_out_anew = true;                  ///< other entities than before
    std::vector<world::Row> ghosts_out_rows;      ///< of ghosts_out
    std::vector<std::uint32_t> ghosts_out_fresh;  ///< else: the places in it that may have changed
    std::vector<EntityId> ghost_ids;              ///< imported, ascending
    std::vector<ZoneId> ghost_owners;             ///< of ghost_ids, in their order
    std::vector<LedGhost> led_ghosts;             ///< of the last import, ascending by entity
    std::vector<GhostArrival> ghost_arrivals;     ///< scratch of the import
    std::vector<GhostContact> ghost_contacts;
    bool accepted = false;                          ///< a handoff came in during this tick
    std::vector<replication::OwnInput> own_inputs;  ///< scratch of the replication pass
    std::vector<EntityContact> contacts;            ///< scratch of the contacts pass
    std::vector<Vec3> players;        ///< scratch of the representation pass: where players are
    std::vector<BodyId> bodies_near;  ///< scratch of the same
    std::vector<world::Row> representation_rows;  ///< scratch of the same
    bool ghosts_moved = false;                    ///< some imported ghost changed in the last tick
    std::vector<RulesMessage> messages_in;

    core::StateHash hash;
    bool hashed = false;  ///< at least once: entities placed at rest are in the hash
    std::vector<world::Row> changed_rows;  ///< those that the last hash pass went over
    StepOutput out;
    StepReport report;

    ZoneState(ZoneSettings zone_settings, std::unique_ptr<Rules> game_rules);
};

/// The sets that the matcher keeps: by the radii alone.
world::Visibility& matched_sets(ZoneState& state);
const world::Visibility& matched_sets(const ZoneState& state);

/// Index of the client in state.clients, or -1.
int find_client(const ZoneState& state, ClientId client);

/// The grid over all rows' positions, made anew if something moved since: of those that stir and
/// that were touched since the others were kept.
const spatial::PointGrid& current_grid(ZoneState& state);

}  // namespace zoned::zone
