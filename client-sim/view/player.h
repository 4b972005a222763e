// Player: one client that plays: session, view and commands, driven by advance(now) on any clock.
#pragma once

#include "client-sim/link/client.h"
#include "client-sim/view/input_stream.h"
#include "client-sim/view/view.h"

#include <cstdint>
#include <memory>
#include <string>

namespace zoned::view {

/// Hears of what comes to a player. Calls come from within Player::advance.
class PlayerObserver : public ViewListener {
  public:
    /// A new session: the view begins anew, and is nullptr where the world makes no sense.
    virtual void on_session(const wire::WelcomeMessage& /*welcome*/) {}

    /// The server crashed and came back: the session goes on, its view begins anew.
    virtual void on_new_view() {}

    virtual void on_joined(const wire::JoinedMessage& /*joined*/) {}

    virtual void on_event(const wire::EventMessage& /*event*/) {}

    virtual void on_audit(const wire::AuditRecordMessage& /*record*/) {}

    /// A packet has been applied to the view.
    virtual void on_packet(const link::OpenedPacket& /*packet*/, const PacketResult& /*taken*/) {}

    /// The server's clock was set back: the view went on from an earlier tick.
    virtual void on_set_back() {}

    void on_shown(EntityId /*entity*/, Tick /*publication_tick*/, Tick /*from_tick*/) override {}
};

/// Decides for a player as well.
class PlayerListener : public PlayerObserver {
  public:
    /// The intent of the own avatar for `tick`; asked once for each tick.
    virtual motion::InputCommand command_for(Tick tick) = 0;
};

struct PlayerSettings {
    link::Login login;
    /// Its history is kept only where the session has the right to audits.
    ViewSettings view;
};

class Player final : public link::SessionHandler {
  public:
    Player(link::Transport& transport,
           WorldCache& worlds,
           PlayerListener& listener,
           PlayerSettings settings);

    void start(double now_s);
    void quit(double now_s);

    /// Does all work due at `now_s`; cheap when nothing is due. False: nothing was.
    bool advance(double now_s);

    [[nodiscard]] link::Client& client() { return client_; }

    [[nodiscard]] const link::Client& client() const { return client_; }

    /// nullptr before Welcome.
    [[nodiscard]] const View* view() const { return view_.get(); }

    /// The session is up, the view has a world, and the server's clock is known.
    [[nodiscard]] bool ready() const;

    [[nodiscard]] const InputStream& inputs() const { return inputs_; }

    [[nodiscard]] double now_s() const { return now_s_; }

    /// Present position on the server's clock in ticks, as a view displays it: View::tick() and the
    /// progress towards the next, at most a tick. Needs ready().
    [[nodiscard]] double tick_fraction(double now_s) const;

    /// When the packet that is being applied left, by the server's clock.
    [[nodiscard]] double packet_sent_s() const { return packet_sent_s_; }

    /// Why the newest session has no view; empty: it has one.
    [[nodiscard]] const std::string& bad_world() const { return bad_world_; }

    /// A view that is ahead of the server's clock by this much goes back instead of waiting, s.
    static constexpr double kSetBackS = 0.25;

    /// Bit of the rights: the client may receive the truth.
    static constexpr std::uint32_t kMayAudit = 2;

    void on_welcome(const wire::WelcomeMessage& welcome) override;
    void on_joined(const wire::JoinedMessage& joined) override;
    void on_event(const wire::EventMessage& event) override;
    void on_audit(const wire::AuditRecordMessage& record) override;
    bool on_packet(const link::OpenedPacket& packet) override;

  private:
    void begin_view(std::uint32_t rights);
    void evaluate();
    void probe();
    void housekeeping();

    WorldCache& worlds_;
    PlayerListener& listener_;
    ViewSettings settings_;
    link::Client client_;
    std::shared_ptr<const WorldInfo> world_;
    std::unique_ptr<View> view_;
    InputStream inputs_;
    std::string bad_world_;
    double now_s_ = 0.0;
    double next_wake_s_ = 0.0;
    double next_probe_s_ = 0.0;
    double next_maintenance_s_ = 0.0;
    double packet_sent_s_ = 0.0;
};

}  // namespace zoned::view
