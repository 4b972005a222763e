#include "server/zone/faults/broken_rules.h"

#include <csignal>
#include <stdexcept>
#include <utility>

namespace zoned::zone {

BrokenRules::BrokenRules(std::unique_ptr<Rules> rules, BreakKind kind, Tick at)
    : rules_(std::move(rules)),
      kind_(kind),
      at_(at) {
}

void BrokenRules::on_tick(RulesContext& context) {
    rules_->on_tick(context);
    if (context.now() >= at_) {
        fail();
    }
}

void BrokenRules::fail() const {
    if (kind_ != BreakKind::kThrow) {
        std::raise(kind_ == BreakKind::kCrash ? SIGSEGV : SIGABRT);
    }
    throw std::runtime_error("testing.break_zone: the rules throw on purpose");
}

bool BrokenRules::busy() const {
    return true;  // so that its tick comes in a world at rest too
}

EntityId BrokenRules::on_join(RulesContext& context, const JoinRequest& request) {
    return rules_->on_join(context, request);
}

void BrokenRules::on_leave(RulesContext& context, ClientId client, EntityId avatar) {
    rules_->on_leave(context, client, avatar);
}

void BrokenRules::on_command(RulesContext& context,
                             ClientId client,
                             EntityId avatar,
                             std::uint16_t kind,
                             std::span<const std::uint8_t> payload) {
    rules_->on_command(context, client, avatar, kind, payload);
}

void BrokenRules::on_input(RulesContext& context,
                           EntityId avatar,
                           const motion::InputCommand& command,
                           std::uint16_t pressed) {
    rules_->on_input(context, avatar, command, pressed);
}

void BrokenRules::on_contact(RulesContext& context, const EntityContact& contact) {
    rules_->on_contact(context, contact);
}

void BrokenRules::on_joint_broken(RulesContext& context, const BrokenJoint& joint) {
    rules_->on_joint_broken(context, joint);
}

void BrokenRules::on_use(RulesContext& context, const LeverUse& use) {
    rules_->on_use(context, use);
}

ContactWish BrokenRules::contact_wish(TypeIndex type) const {
    return rules_->contact_wish(type);
}

bool BrokenRules::may_hear(const RulesContext& context, EntityId viewer, EntityId entity) const {
    return rules_->may_hear(context, viewer, entity);
}

ai::state_machine::CodedMachines BrokenRules::coded_machines() const {
    return rules_->coded_machines();
}

void BrokenRules::on_confirm(RulesContext& context, ClientId client, EventId event) {
    rules_->on_confirm(context, client, event);
}

void BrokenRules::on_message(RulesContext& context,
                             EntityId target,
                             std::span<const std::uint8_t> payload) {
    rules_->on_message(context, target, payload);
}

void BrokenRules::on_store(RulesContext& context, const mailbox::StoreAnswer& answer) {
    rules_->on_store(context, answer);
}

Bytes BrokenRules::take_entity(EntityId entity) {
    return rules_->take_entity(entity);
}

void BrokenRules::load_entity(EntityId entity, std::span<const std::uint8_t> state) {
    rules_->load_entity(entity, state);
}

void BrokenRules::hash(core::StateHash& hash) const {
    rules_->hash(hash);
}

}  // namespace zoned::zone
