// Sandbox: the game shipped with the server, an example of the Rules interface. This file is its
// table of contents.
#pragma once

#include "server/rules/game.h"
#include "server/zone/rules.h"

namespace zoned::rules {

/// Move, jump, push and throw props, hitscan shots, pick up items, chat. Commands and events are in
/// proto/sandbox.proto.
class Sandbox final : public zone::Rules {
  public:
    /// Throws std::runtime_error as make_rules does.
    Sandbox(const zone::RulesSettings& settings, const world::TypeTable& types);

    EntityId on_join(RulesContext& context, const zone::JoinRequest& request) override;
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
    void on_contact(RulesContext& context, const zone::EntityContact& contact) override;
    void on_tick(RulesContext& context) override;
    void on_confirm(RulesContext& context, ClientId client, EventId event) override;
    void on_message(RulesContext& context,
                    EntityId target,
                    std::span<const std::uint8_t> payload) override;
    void on_store(RulesContext& context, const mailbox::StoreAnswer& answer) override;
    zone::Bytes take_entity(EntityId entity) override;
    void load_entity(EntityId entity, std::span<const std::uint8_t> state) override;
    [[nodiscard]] bool save(zone::Bytes& out) const override;
    std::string load(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] bool busy() const override;
    [[nodiscard]] ai::state_machine::CodedMachines coded_machines() const override;
    void hash(core::StateHash& hash) const override;

    [[nodiscard]] const GameStats& stats() const { return game_.stats; }

    /// The record of a character, or nullptr.
    [[nodiscard]] const CharacterRecord* find(EntityId character) const;

  private:
    void survey(const RulesContext& context);
    void run_timers(RulesContext& context);

    Game game_;
    std::vector<EntityId> due_;  // scratch
};

}  // namespace zoned::rules
