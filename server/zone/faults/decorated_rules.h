// DecoratedRules: passes all calls on to other rules; a subclass does something beside them.
#pragma once

#include "server/zone/rules.h"

#include <memory>
#include <utility>

namespace zoned::zone {

class DecoratedRules : public Rules {
  public:
    explicit DecoratedRules(std::unique_ptr<Rules> rules) : rules_(std::move(rules)) {}

    void on_start(RulesContext& context) override;
    void on_stop(StopContext& context) const override;
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
    void on_trigger(RulesContext& context, const TriggerEvent& event) override;
    void on_use(RulesContext& context, const LeverUse& use) override;
    void on_party(RulesContext& context, const PartyChange& change) override;
    void on_instance(RulesContext& context, const InstanceChange& change) override;
    void on_match(RulesContext& context, const MatchChange& change) override;
    [[nodiscard]] ContactWish contact_wish(TypeIndex type) const override;
    [[nodiscard]] bool may_hear(const RulesContext& context,
                                EntityId viewer,
                                EntityId entity) const override;
    [[nodiscard]] std::vector<TypeField> declared_fields() const override;
    [[nodiscard]] ai::state_machine::CodedMachines coded_machines() const override;
    void on_timer(RulesContext& context, const DueTimer& timer) override;
    void on_tick(RulesContext& context) override;
    void on_confirm(RulesContext& context, ClientId client, EventId event) override;
    void on_message(RulesContext& context,
                    EntityId target,
                    std::span<const std::uint8_t> payload) override;
    void on_store(RulesContext& context, const mailbox::StoreAnswer& answer) override;
    Bytes take_entity(EntityId entity) override;
    void load_entity(EntityId entity, std::span<const std::uint8_t> state) override;
    [[nodiscard]] bool save(Bytes& out) const override;
    std::string load(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] bool busy() const override;
    void hash(core::StateHash& hash) const override;

  protected:
    /// Around each call, by its name.
    virtual void enter(const char* call) const { (void)call; }

    virtual void leave() const {}

  private:
    template <class Call>
    auto pass(const char* name, Call&& call) const;

    std::unique_ptr<Rules> rules_;
};

}  // namespace zoned::zone
