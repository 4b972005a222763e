#include "server/zone/faults/decorated_rules.h"

namespace zoned::zone {

template <class Call>
auto DecoratedRules::pass(const char* name, Call&& call) const {
    struct Inside {
        const DecoratedRules& rules;

        ~Inside() { rules.leave(); }
    };

    enter(name);
    const Inside inside{*this};
    return call(*rules_);
}

void DecoratedRules::on_start(RulesContext& context) {
    pass("on_start", [&](Rules& rules) { rules.on_start(context); });
}

void DecoratedRules::on_stop(StopContext& context) const {
    pass("on_stop", [&](const Rules& rules) { rules.on_stop(context); });
}

EntityId DecoratedRules::on_join(RulesContext& context, const JoinRequest& request) {
    return pass("on_join", [&](Rules& rules) { return rules.on_join(context, request); });
}

void DecoratedRules::on_leave(RulesContext& context, ClientId client, EntityId avatar) {
    pass("on_leave", [&](Rules& rules) { rules.on_leave(context, client, avatar); });
}

void DecoratedRules::on_command(RulesContext& context,
                                ClientId client,
                                EntityId avatar,
                                std::uint16_t kind,
                                std::span<const std::uint8_t> payload) {
    pass("on_command",
         [&](Rules& rules) { rules.on_command(context, client, avatar, kind, payload); });
}

void DecoratedRules::on_input(RulesContext& context,
                              EntityId avatar,
                              const motion::InputCommand& command,
                              std::uint16_t pressed) {
    pass("on_input", [&](Rules& rules) { rules.on_input(context, avatar, command, pressed); });
}

void DecoratedRules::on_contact(RulesContext& context, const EntityContact& contact) {
    pass("on_contact", [&](Rules& rules) { rules.on_contact(context, contact); });
}

void DecoratedRules::on_joint_broken(RulesContext& context, const BrokenJoint& joint) {
    pass("on_joint_broken", [&](Rules& rules) { rules.on_joint_broken(context, joint); });
}

void DecoratedRules::on_trigger(RulesContext& context, const TriggerEvent& event) {
    pass("on_trigger", [&](Rules& rules) { rules.on_trigger(context, event); });
}

void DecoratedRules::on_use(RulesContext& context, const LeverUse& use) {
    pass("on_use", [&](Rules& rules) { rules.on_use(context, use); });
}

void DecoratedRules::on_party(RulesContext& context, const PartyChange& change) {
    pass("on_party", [&](Rules& rules) { rules.on_party(context, change); });
}

void DecoratedRules::on_instance(RulesContext& context, const InstanceChange& change) {
    pass("on_instance", [&](Rules& rules) { rules.on_instance(context, change); });
}

void DecoratedRules::on_match(RulesContext& context, const MatchChange& change) {
    pass("on_match", [&](Rules& rules) { rules.on_match(context, change); });
}

ContactWish DecoratedRules::contact_wish(TypeIndex type) const {
    return pass("contact_wish", [&](const Rules& rules) { return rules.contact_wish(type); });
}

bool DecoratedRules::may_hear(const RulesContext& context, EntityId viewer, EntityId entity) const {
    return pass("may_hear",
                [&](const Rules& rules) { return rules.may_hear(context, viewer, entity); });
}

std::vector<TypeField> DecoratedRules::declared_fields() const {
    return pass("declared_fields", [&](const Rules& rules) { return rules.declared_fields(); });
}

ai::state_machine::CodedMachines DecoratedRules::coded_machines() const {
    return pass("coded_machines", [&](const Rules& rules) { return rules.coded_machines(); });
}

void DecoratedRules::on_timer(RulesContext& context, const DueTimer& timer) {
    pass("on_timer", [&](Rules& rules) { rules.on_timer(context, timer); });
}

void DecoratedRules::on_tick(RulesContext& context) {
    pass("on_tick", [&](Rules& rules) { rules.on_tick(context); });
}

void DecoratedRules::on_confirm(RulesContext& context, ClientId client, EventId event) {
    pass("on_confirm", [&](Rules& rules) { rules.on_confirm(context, client, event); });
}

void DecoratedRules::on_message(RulesContext& context,
                                EntityId target,
                                std::span<const std::uint8_t> payload) {
    pass("on_message", [&](Rules& rules) { rules.on_message(context, target, payload); });
}

void DecoratedRules::on_store(RulesContext& context, const mailbox::StoreAnswer& answer) {
    pass("on_store", [&](Rules& rules) { rules.on_store(context, answer); });
}

Bytes DecoratedRules::take_entity(EntityId entity) {
    return pass("take_entity", [&](Rules& rules) { return rules.take_entity(entity); });
}

void DecoratedRules::load_entity(EntityId entity, std::span<const std::uint8_t> state) {
    pass("load_entity", [&](Rules& rules) { rules.load_entity(entity, state); });
}

bool DecoratedRules::save(Bytes& out) const {
    return pass("save", [&](const Rules& rules) { return rules.save(out); });
}

std::string DecoratedRules::load(std::span<const std::uint8_t> bytes) {
    return pass("load", [&](Rules& rules) { return rules.load(bytes); });
}

bool DecoratedRules::busy() const {
    return pass("busy", [&](const Rules& rules) { return rules.busy(); });
}

void DecoratedRules::hash(core::StateHash& hash) const {
    pass("hash", [&](const Rules& rules) { rules.hash(hash); });
}

}  // namespace zoned::zone
