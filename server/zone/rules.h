// Rules: the interface that a studio implements, and the server's only knowledge of the game.
#pragma once

#include "server/ai/decision/state_machine/coded_state_machine.h"
#include "server/zone/rules_context.h"
#include "shared/core/state_hash.h"
#include "shared/wire/declared/declared_fields.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace zoned::zone {

struct InstanceChange;
struct MatchChange;
struct PartyChange;
class StopContext;

struct JoinRequest {
    ClientId client;
    std::string name;
    std::string team;
    Vec3 spawn_position = Vec3::Zero();  ///< zone-local, on or above the ground
    std::string account;                 ///< of the ticket; empty: it cannot be known again
};

/// A field that rules declare for the entities of a type.
struct TypeField {
    std::string type;
    wire::DeclaredField field;       ///< wire::number_field and the like
    double max_changes_per_s = 0.0;  ///< clients hear of no more; 0: of each tick's
};

/// One instance per zone. Calls come from Zone::step only, never concurrently, in a recorded order:
/// no clock, no threads, no global state in here, or replays will differ. Throwing is a mistake of
/// the programmer.
class Rules {
  public:
    virtual ~Rules() = default;

    /// Once in the life of a zone, in its first tick and before any other call; not again where the
    /// zone comes back from a snapshot.
    virtual void on_start(RulesContext& context) { (void)context; }

    /// Once, when the server ends in an orderly way (a signal, `--seconds`, a drained server):
    /// after the last tick, and in the order of the zones. Changes nothing: a replay, a recovered
    /// zone and one that stopped after a fault do not call it.
    virtual void on_stop(StopContext& context) const { (void)context; }

    /// Spawns and returns the avatar (with SpawnDef::client set).
    virtual EntityId on_join(RulesContext& context, const JoinRequest& request) = 0;
    /// The client left for good; whether its avatar stays is the rules' choice (the server does not
    /// despawn it).
    virtual void on_leave(RulesContext& context, ClientId client, EntityId avatar) = 0;
    /// A reliable command. `payload` is hostile.
    virtual void on_command(RulesContext& context,
                            ClientId client,
                            EntityId avatar,
                            std::uint16_t kind,
                            std::span<const std::uint8_t> payload) = 0;
    /// An avatar consumes a command this tick (called before it moves). `pressed` are the buttons
    /// that were up a tick ago.
    virtual void on_input(RulesContext& context,
                          EntityId avatar,
                          const motion::InputCommand& command,
                          std::uint16_t pressed) = 0;
    /// A contact is reported in each zone that simulates it: with a ghost, in the zones of both
    /// owners.
    virtual void on_contact(RulesContext& context, const EntityContact& contact) = 0;

    /// A joint broke in the last step; it is gone.
    virtual void on_joint_broken(RulesContext& context, const BrokenJoint& joint) {
        (void)context;
        (void)joint;
    }

    /// After physics. Each zone tells of the entities that it owns: on a border an entity leaves in
    /// one zone and enters in the other.
    virtual void on_trigger(RulesContext& context, const TriggerEvent& event) {
        (void)context;
        (void)event;
    }

    /// After on_input of the player who pressed the button, in the zone that owns the lever; one
    /// tick later where that is another zone.
    virtual void on_use(RulesContext& context, const LeverUse& use) {
        (void)context;
        (void)use;
    }

    /// Asked when an entity of that type gets a body, a ghost too. A pair of bodies reports
    /// contacts if either type asks for it. A contact ends in the zone that an entity leaves and
    /// begins in the one that it comes to. The next step in which physics runs reports an end.
    [[nodiscard]] virtual ContactWish contact_wish(TypeIndex type) const {
        (void)type;
        return {};
    }

    /// Whether a viewer may know of an entity within its radii: fog of war, stealth. Asked for
    /// types with `visibility_filter: RULES` alone, now and then (VisibilityFilterSettings); must
    /// depend on nothing but the state of the zone and of these rules, and change nothing.
    [[nodiscard]] virtual bool may_hear(const RulesContext& context,
                                        EntityId viewer,
                                        EntityId entity) const {
        (void)context;
        (void)viewer;
        (void)entity;
        return true;
    }

    /// Fields beside those of the config, behind these on the wire. Asked once, when a config is
    /// read, of rules of their own: the types of the world have none of them yet. Always the same
    /// answer.
    [[nodiscard]] virtual std::vector<TypeField> declared_fields() const { return {}; }

    /// The state machines in code that brains of the config may name (`brain { coded: "..." }`).
    /// Asked once when a zone begins, and when its brains are read anew; always the same answer.
    [[nodiscard]] virtual ai::state_machine::CodedMachines coded_machines() const { return {}; }

    /// A timer is due (RulesContext::start_timer), before the inputs of its tick.
    virtual void on_timer(RulesContext& context, const DueTimer& timer) {
        (void)context;
        (void)timer;
    }

    /// News since the last tick of a player in a party, or of an order to RulesParties.
    virtual void on_party(RulesContext& context, const PartyChange& change) {
        (void)context;
        (void)change;
    }

    /// News of a match, of a player in one, or of an order to RulesMatches.
    virtual void on_match(RulesContext& context, const MatchChange& change) {
        (void)context;
        (void)change;
    }

    /// News of an instance, of a player in one, or of an order to RulesInstances.
    virtual void on_instance(RulesContext& context, const InstanceChange& change) {
        (void)context;
        (void)change;
    }

    /// Once per tick, before AI and physics.
    virtual void on_tick(RulesContext& context) = 0;
    /// A recipient confirmed an event that asked for it.
    virtual void on_confirm(RulesContext& context, ClientId client, EventId event) = 0;
    /// From message() of any zone. `payload` was written by these rules.
    virtual void on_message(RulesContext& context,
                            EntityId target,
                            std::span<const std::uint8_t> payload) = 0;

    /// The durable store has done what was asked, or not. `answer.value` was written by these
    /// rules, perhaps by an older version of them.
    virtual void on_store(RulesContext& context, const mailbox::StoreAnswer& answer) {
        (void)context;
        (void)answer;
    }

    /// State that the rules keep for an entity: leaves with it on a handoff and into snapshots.
    /// take = save and forget.
    virtual Bytes take_entity(EntityId entity) = 0;
    virtual void load_entity(EntityId entity, std::span<const std::uint8_t> state) = 0;

    /// The whole state of these rules, for a snapshot of the zone; false: they have none, and
    /// worlds with them cannot be saved.
    [[nodiscard]] virtual bool save(Bytes& out) const {
        (void)out;
        return false;
    }

    /// Takes the place of the whole state, in rules that have not run yet. `bytes` may be damaged.
    /// Empty text: done; otherwise the error.
    virtual std::string load(std::span<const std::uint8_t> bytes) {
        (void)bytes;
        return "these rules have no saved state";
    }

    /// True while something is pending that must run although nobody moves or watches, timers
    /// aside: on_tick is called.
    [[nodiscard]] virtual bool busy() const = 0;
    /// Chains at least the changes since the last call: bookkeeping for that is no state.
    virtual void hash(core::StateHash& hash) const = 0;
};

/// Defined by exactly one link target, the rules of the game that a server is built with.
/// Throws std::runtime_error with a clear message when a setting or a needed entity type is missing
/// or wrong.
std::unique_ptr<Rules> make_rules(const RulesSettings& settings, const world::TypeTable& types);

}  // namespace zoned::zone
