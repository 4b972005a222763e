// Bot: one simulated player: session, view and script, driven by advance(now) on any clock.
#pragma once

#include "client-sim/audit/audited_client.h"
#include "client-sim/bot/ledger.h"
#include "client-sim/bot/script.h"
#include "client-sim/view/player.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

namespace zoned::bot {

class Bot;

/// Receives the events of bots; measure implements it. Calls come from within Bot::advance.
class Observer {
  public:
    virtual ~Observer() = default;
    virtual void on_joined(Bot& bot, const wire::JoinedMessage& joined) = 0;
    /// The server's clock was set back: the view began anew at an earlier tick.
    virtual void on_set_back(Bot& bot) = 0;
    virtual void on_event(Bot& bot, const wire::EventMessage& event) = 0;
    virtual void on_audit(Bot& bot, const wire::AuditRecordMessage& record) = 0;
    /// A publication of another entity is displayed from view tick `from_tick` on.
    virtual void on_shown(Bot& bot, EntityId entity, Tick publication_tick, Tick from_tick) = 0;
    /// The bot decided just now that its avatar moves differently from `tick` on.
    virtual void on_changed_course(Bot& bot, Tick tick) = 0;
    /// The server's state of the own avatar after `tick` was `distance_m` away from the prediction.
    virtual void on_correction(Bot& bot, Tick tick, double distance_m) = 0;
};

struct BotSettings {
    link::Login login;
    Script script = Script::kWander;
    MakeOwnScript make_own_script;  ///< plays in place of `script`; empty: none does
    std::uint64_t seed = 1;
    std::size_t index = 0;
    motion::ConvergenceMethod convergence = motion::ConvergenceMethod::kProjectiveVelocity;
    view::ViewKind view = view::ViewKind::kExtrapolate;
    view::DisplayedState displayed_state = view::DisplayedState::kPredicted;
    /// Asks for an audit when none came for this long; 0: never asks. Needs the right to audit.
    double audit_every_s = 1.0;
    bool meter = false;  ///< counts the bytes of packets by purpose
};

class Bot final : public view::PlayerListener, public Voice {
  public:
    Bot(link::Transport& transport,
        view::WorldCache& worlds,
        Observer& observer,
        BotSettings settings);

    void start(double now_s);
    void quit(double now_s);
    /// Does all work due at `now_s`; cheap when nothing is due.
    void advance(double now_s);

    /// A quiet bot sends no commands of its own any more (the end of a run); acks go on.
    void set_quiet(bool quiet) { quiet_ = quiet; }

    [[nodiscard]] link::Client& client() { return player_.client(); }

    [[nodiscard]] const link::Client& client() const { return player_.client(); }

    /// nullptr before Welcome.
    [[nodiscard]] const view::View* view() const { return player_.view(); }

    [[nodiscard]] const view::Player& player() const { return player_; }

    [[nodiscard]] const audit::AuditedClient& audited() const { return audited_; }

    [[nodiscard]] const link::ArrivalLog& arrivals() const { return audited_.arrivals(); }

    [[nodiscard]] const BotSettings& settings() const { return settings_; }

    [[nodiscard]] bool joined() const { return audited_.joined(); }

    [[nodiscard]] double joined_s() const { return joined_s_; }

    [[nodiscard]] Tick joined_tick() const { return joined_tick_; }

    [[nodiscard]] EntityId avatar() const { return audited_.avatar(); }

    [[nodiscard]] const Ledger& ledger() const { return ledger_; }

    [[nodiscard]] double now_s() const { return player_.now_s(); }

    /// As AuditedClient has it.
    [[nodiscard]] Tick settled_tick() const { return audited_.settled_tick(); }

    /// Ticks by which commands are made ahead of the server's clock; 0 before the first command.
    [[nodiscard]] double lead_ticks() const {
        return view() != nullptr ? player_.inputs().lead_s() / view()->world().tick_s : 0.0;
    }

    [[nodiscard]] const view::InputStats& inputs() const { return player_.inputs().stats(); }

    /// When the server had the command for a tick, by its own clock; none when not known.
    [[nodiscard]] std::optional<double> command_arrival_s(Tick tick) const {
        return player_.inputs().arrival_s(tick);
    }

    /// When the packet that is being applied left, by the server's clock.
    [[nodiscard]] double packet_sent_s() const { return player_.packet_sent_s(); }

    [[nodiscard]] std::uint64_t bad_worlds() const { return bad_worlds_; }

    /// Times that the server's clock was set back by more than Player::kSetBackS.
    [[nodiscard]] std::uint64_t set_backs() const { return set_backs_; }

    motion::InputCommand command_for(Tick tick) override;
    void on_session(const wire::WelcomeMessage& welcome) override;
    void on_new_view() override;
    void on_joined(const wire::JoinedMessage& joined) override;
    void on_event(const wire::EventMessage& event) override;
    void on_audit(const wire::AuditRecordMessage& record) override;
    void on_packet(const link::OpenedPacket& packet, const view::PacketResult& taken) override;
    void on_set_back() override;
    void on_shown(EntityId entity, Tick publication_tick, Tick from_tick) override;
    void command(std::uint32_t kind, std::string payload) override;

    [[nodiscard]] std::span<const std::uint32_t> items() const override { return ledger_.items(); }

  private:
    motion::InputCommand decide(Tick tick, bool& changed);
    void answer_players(const wire::EventMessage& event);
    void ask_for_audit();
    void spread_audits();
    [[nodiscard]] bool may_audit() const;

    Observer& observer_;
    BotSettings settings_;
    ScriptRunner script_runner_;
    std::unique_ptr<OwnScript> own_script_;  // or none
    motion::InputCommand own_command_;       // its newest
    audit::AuditedClient audited_;
    view::Player player_;
    bool quiet_ = false;
    double joined_s_ = 0.0;
    Tick joined_tick_ = 0;
    Ledger ledger_;
    std::uint64_t set_backs_ = 0;
    double next_audit_look_s_ = 0.0;
    double last_audit_s_ = 0.0;
    std::uint64_t bad_worlds_ = 0;
};

}  // namespace zoned::bot
