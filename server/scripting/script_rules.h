// ScriptRules: game rules that a script decides. Whatever it does, the zone's tick goes on.
#pragma once

#include "server/scripting/callbacks.h"
#include "server/scripting/script_settings.h"
#include "server/scripting/state/state_table.h"
#include "server/zone/rules.h"

#include <array>
#include <cstdint>
#include <memory>
#include <set>
#include <string>

namespace zoned::scripting {

struct Host;
class LoadedScript;
struct ScriptError;

class ScriptRules final : public zone::Rules {
  public:
    /// Throws std::runtime_error as make_rules does. `log` gets what the script prints, and its
    /// errors, each once for its place.
    ScriptRules(const ScriptSettings& settings,
                const zone::RulesSettings& rules,
                const world::TypeTable& types,
                ScriptLog log);
    ~ScriptRules() override;

    void on_start(zone::RulesContext& context) override;
    void on_stop(zone::StopContext& context) const override;
    EntityId on_join(zone::RulesContext& context, const zone::JoinRequest& request) override;
    void on_leave(zone::RulesContext& context, ClientId client, EntityId avatar) override;
    void on_command(zone::RulesContext& context,
                    ClientId client,
                    EntityId avatar,
                    std::uint16_t kind,
                    std::span<const std::uint8_t> payload) override;
    void on_input(zone::RulesContext& context,
                  EntityId avatar,
                  const motion::InputCommand& command,
                  std::uint16_t pressed) override;
    void on_contact(zone::RulesContext& context, const zone::EntityContact& contact) override;
    void on_joint_broken(zone::RulesContext& context, const zone::BrokenJoint& joint) override;
    void on_trigger(zone::RulesContext& context, const zone::TriggerEvent& event) override;
    void on_use(zone::RulesContext& context, const zone::LeverUse& use) override;
    [[nodiscard]] zone::ContactWish contact_wish(TypeIndex type) const override;
    [[nodiscard]] bool may_hear(const zone::RulesContext& context,
                                EntityId viewer,
                                EntityId entity) const override;
    [[nodiscard]] std::vector<zone::TypeField> declared_fields() const override;
    void on_timer(zone::RulesContext& context, const zone::DueTimer& timer) override;
    void on_party(zone::RulesContext& context, const zone::PartyChange& change) override;
    void on_match(zone::RulesContext& context, const zone::MatchChange& change) override;
    void on_instance(zone::RulesContext& context, const zone::InstanceChange& change) override;
    void on_tick(zone::RulesContext& context) override;
    void on_confirm(zone::RulesContext& context, ClientId client, EventId event) override;
    void on_message(zone::RulesContext& context,
                    EntityId target,
                    std::span<const std::uint8_t> payload) override;
    void on_store(zone::RulesContext& context, const mailbox::StoreAnswer& answer) override;
    zone::Bytes take_entity(EntityId entity) override;
    void load_entity(EntityId entity, std::span<const std::uint8_t> state) override;
    [[nodiscard]] bool save(zone::Bytes& out) const override;
    std::string load(std::span<const std::uint8_t> bytes) override;
    [[nodiscard]] bool busy() const override;
    void hash(core::StateHash& hash) const override;

    /// Takes over the state of rules that ran until now, by another script perhaps, without their
    /// errors. Empty text: done; otherwise why not, and these rules are of no use.
    std::string go_on_from(const ScriptRules& before);

    /// Calls that failed or overran so far, in all callbacks.
    [[nodiscard]] std::uint64_t errors() const;

    [[nodiscard]] std::uint64_t errors(Callback callback) const {
        return errors_[static_cast<std::size_t>(callback)];
    }

  private:
    /// Before each call: the first of a tick has its whole budget.
    void prepare(zone::RulesContext& context);
    [[nodiscard]] bool is_called(Callback callback) const;
    /// False where the script was not called, or failed.
    template <class Push>
    bool call(zone::RulesContext& context, Callback callback, Push&& push);
    void note_not_called(Callback callback);
    void note_error(Callback callback, const ScriptError& error);
    void log_error(Callback callback, const ScriptError& error) const;
    template <class Archive>
    void serialize(Archive& archive);

    ScriptSettings settings_;
    TypeIndex avatar_ = 0;
    StateBudget state_budget_;
    // Behind a pointer: asking may_hear changes no state, yet runs the script.
    std::unique_ptr<Host> host_;
    std::unique_ptr<LoadedScript> script_;
    Tick tick_ = 0;  // of the newest call
    std::array<std::uint64_t, kCallbacks> errors_{};
    mutable std::set<std::string> logged_;  // places
};

}  // namespace zoned::scripting
