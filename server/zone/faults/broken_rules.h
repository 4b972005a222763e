// BrokenRules: rules that fail on purpose in one tick, to test what becomes of their zone.
#pragma once

#include "server/zone/faults/fault_settings.h"
#include "server/zone/rules.h"

#include <memory>
#include <vector>

namespace zoned::zone {

/// Decorates the rules of a studio: all calls go on to them, but that of one tick.
class BrokenRules final : public Rules {
  public:
    BrokenRules(std::unique_ptr<Rules> rules, BreakKind kind, Tick at);

    EntityId on_join(RulesContext& context, const JoinRequest& request) override;
    void on_leave(RulesContext& context, ClientId client, EntityId avatar) override;
    void on_command(RulesContext& context,
                    ClientId client,
                    EntityId avatar,
                    std::uint16_t kind,
                    std::span<const std::uint8_t> payload) override;
    void on_input(RulesContext& context,
                  EntityId avatar,
                  const motion::InputCommand& command,
                  std::uint16_t pressed) override;
    void on_contact(RulesContext& context, const EntityContact& contact) override;
    void on_joint_broken(RulesContext& context, const BrokenJoint& joint) override;
    void on_use(RulesContext& context, const LeverUse& use) override;
    [[nodiscard]] ContactWish contact_wish(TypeIndex type) const override;
    [[nodiscard]] bool may_hear(const RulesContext& context,
                                EntityId viewer,
                                EntityId entity) const override;
    [[nodiscard]] ai::state_machine::CodedMachines coded_machines() const override;
    void on_tick(RulesContext& context) override;
    void on_confirm(RulesContext& context, ClientId client, EventId event) override;
    void on_message(RulesContext& context,
                    EntityId target,
                    std::span<const std::uint8_t> payload) override;
    void on_store(RulesContext& context, const mailbox::StoreAnswer& answer) override;
    Bytes take_entity(EntityId entity) override;
    void load_entity(EntityId entity, std::span<const std::uint8_t> state) override;
    [[nodiscard]] bool busy() const override;
    void hash(core::StateHash& hash) const override;

  private:
    /// A function of its own, so that the stack of a crash names it.
    [[noreturn, gnu::noinline]] void fail() const;

    std::unique_ptr<Rules> rules_;
    BreakKind kind_;
    Tick at_;
};

}  // namespace zoned::zone
