// Bot: one simulated player: session, view and script, driven by advance(now) on any clock.
#pragma once

#include "client-sim/bot/command_log.h"
#include "client-sim/bot/ledger.h"
#include "client-sim/bot/script.h"
#include "client-sim/link/arrival_log.h"
#include "client-sim/link/client.h"
#include "client-sim/view/view.h"
#include "shared/clock/input_lead.h"

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
    std::uint64_t seed = 1;
    std::size_t index = 0;
    motion::ConvergenceMethod convergence = motion::ConvergenceMethod::kProjectiveVelocity;
    view::ViewKind view = view::ViewKind::kExtrapolate;
    view::DisplayedState displayed_state = view::DisplayedState::kPredicted;
    /// Asks for an audit when none came for this long; 0: never asks. Needs the right to audit.
    double audit_every_s = 1.0;
    bool meter = false;  ///< counts the bytes of packets by purpose
};

/// Commands in time and missed, by the server's reports.
struct InputStats {
    std::uint64_t ticks =
        0;  ///< ticks that the server has reported, since the first command in time
    std::uint64_t missing = 0;  ///< of these: the command came too late or not at all
};

/// Commands are made for ticks ahead of the server (clock::InputLead), on a clock of their own.
class Bot final : public link::SessionHandler, public view::ViewListener, public Voice {
  public:
    static constexpr std::size_t kCommandsPerPacket = 4;

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

    [[nodiscard]] link::Client& client() { return client_; }

    [[nodiscard]] const link::Client& client() const { return client_; }

    /// nullptr before Welcome.
    [[nodiscard]] const view::View* view() const { return view_.get(); }

    [[nodiscard]] const link::ArrivalLog& arrivals() const { return arrivals_; }

    [[nodiscard]] const BotSettings& settings() const { return settings_; }

    [[nodiscard]] bool joined() const { return joined_; }

    [[nodiscard]] double joined_s() const { return joined_s_; }

    [[nodiscard]] Tick joined_tick() const { return joined_tick_; }

    [[nodiscard]] EntityId avatar() const { return avatar_; }

    [[nodiscard]] const Ledger& ledger() const { return ledger_; }

    [[nodiscard]] double now_s() const { return now_s_; }

    /// The first view tick with clock and view settled, after joining and after each time that the
    /// server's clock was set back; -1 before.
    [[nodiscard]] Tick settled_tick() const { return settled_tick_; }

    /// Ticks by which commands are made ahead of the server's clock; 0 before the first command.
    [[nodiscard]] double lead_ticks() const {
        return lead_ ? lead_->lead_s() / world_->tick_s : 0.0;
    }

    [[nodiscard]] const InputStats& inputs() const { return inputs_; }

    /// When the server had the command for a tick, by its own clock; none when not known.
    [[nodiscard]] std::optional<double> command_arrival_s(Tick tick) const {
        return commands_.arrival_s(tick);
    }

    /// When the packet that is being applied left, by the server's clock.
    [[nodiscard]] double packet_sent_s() const { return packet_sent_s_; }

    [[nodiscard]] std::uint64_t bad_worlds() const { return bad_worlds_; }

    /// Times that the server's clock was set back by more than kSetBackS.
    [[nodiscard]] std::uint64_t set_backs() const { return set_backs_; }

    /// A view that is ahead of the server's clock by this much goes back instead of waiting, s.
    static constexpr double kSetBackS = 0.25;

    void on_welcome(const wire::WelcomeMessage& welcome) override;
    void on_joined(const wire::JoinedMessage& joined) override;
    void on_event(const wire::EventMessage& event) override;
    void on_audit(const wire::AuditRecordMessage& record) override;
    bool on_packet(const link::OpenedPacket& packet) override;
    void on_shown(EntityId entity, Tick publication_tick, Tick from_tick) override;
    void command(std::uint32_t kind, std::string payload) override;

    [[nodiscard]] std::span<const std::uint32_t> items() const override { return ledger_.items(); }

  private:
    void evaluate();
    void set_back(Tick tick);
    void send_inputs();
    void hear_of_commands(const wire::OwnState& own);
    void answer_players(const wire::EventMessage& event);
    void on_path_answers();
    [[nodiscard]] double input_position() const;
    void housekeeping();

    view::WorldCache& worlds_;
    Observer& observer_;
    BotSettings settings_;
    ScriptRunner script_runner_;
    link::Client client_;
    link::ArrivalLog arrivals_;
    std::shared_ptr<const view::WorldInfo> world_;
    std::unique_ptr<view::View> view_;
    double now_s_ = 0.0;
    double next_wake_s_ = 0.0;
    bool quiet_ = false;
    bool joined_ = false;
    double joined_s_ = 0.0;
    Tick joined_tick_ = 0;
    EntityId avatar_;
    Ledger ledger_;
    double settling_since_s_ = 0.0;
    Tick settled_tick_ = -1;
    std::uint64_t set_backs_ = 0;
    double next_probe_s_ = 0.0;
    double next_maintenance_s_ = 0.0;
    double last_audit_s_ = 0.0;
    std::optional<clock::InputLead> lead_;
    CommandLog commands_;
    InputStats inputs_;
    Tick notified_tick_ =
        -1;  // newest tick with a report of the server on its command; -1: no command came in time
    bool notified_missing_ = false;
    double packet_sent_s_ = 0.0;
    Tick next_input_ = -1;
    std::vector<std::uint8_t> body_;
    std::uint64_t bad_worlds_ = 0;
};

}  // namespace zoned::bot
