// GameClient: the client behind the C interface: one session of a game, polled.
#pragma once

#include "client-sim/library/game_route.h"
#include "client-sim/library/recent_values.h"
#include "client-sim/library/truth_meter.h"
#include "client-sim/library/zoned_client.h"
#include "client-sim/link/trust.h"
#include "client-sim/view/player.h"

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::library {

struct GameClientSettings {
    link::Login login;
    view::ViewKind view = view::ViewKind::kExtrapolate;
    /// None: anyone on an address of this machine, else the authorities.
    std::optional<link::Trust::TrustKind> trust;
    std::vector<std::uint8_t> pin;
    std::string ca_file;
    bool measure = false;  ///< compares with the truth, where the session may ask for it
    std::optional<zoned_client_sockets> sockets;  ///< none: the system's
    std::string server_name;                      ///< empty: the host
    bool may_start_threads = true;                ///< for the lookup of a name
};

/// The player's wishes until further notice.
struct GameInput {
    std::int8_t move_x = 0;
    std::int8_t move_z = 0;
    std::uint16_t yaw = 0;
    std::int16_t pitch = 0;
    std::uint16_t buttons = 0;
};

/// Not thread-safe.
class GameClient final : public view::PlayerListener {
  public:
    /// More waiting events than these drop the oldest: nobody fetches them.
    static constexpr std::size_t kMostEvents = 4096;
    static constexpr std::size_t kMostEventBytes = std::size_t{16} << 20U;

    explicit GameClient(GameClientSettings settings) : settings_(std::move(settings)) {}

    ~GameClient() override;
    GameClient(const GameClient&) = delete;
    GameClient& operator=(const GameClient&) = delete;

    /// Begins to connect by this route; false while a session is under way.
    bool connect(std::unique_ptr<GameRoute> route);

    [[nodiscard]] const GameClientSettings& settings() const { return settings_; }

    /// Whether the session goes by this route.
    [[nodiscard]] bool uses(const GameRoute* route) const {
        return route != nullptr && route_.get() == route;
    }

    void quit();
    /// All work that is due; a clock that goes back stands still.
    void poll(double now_s);
    /// Ends the session for a reason of this side.
    void fail(const std::string& reason);

    void set_input(const GameInput& input);
    /// False when no session has begun, or too much is unacknowledged.
    bool command(std::uint32_t kind, std::string payload);

    [[nodiscard]] link::SessionState state() const;
    [[nodiscard]] const std::string& trouble() const;

    /// The oldest event that waits; nullptr: none.
    [[nodiscard]] const wire::EventMessage* event() const {
        return events_.empty() ? nullptr : &events_.front();
    }

    void drop_event();

    [[nodiscard]] std::uint64_t events_dropped() const { return events_dropped_; }

    /// nullptr before the server has sent a world.
    [[nodiscard]] const view::View* view() const { return player_ ? player_->view() : nullptr; }

    [[nodiscard]] const view::Player* player() const { return player_.get(); }

    /// Progress of the displayed time beyond the view's tick, and of the own avatar towards its
    /// newest state, both as of the last poll.
    [[nodiscard]] double fraction() const { return fraction_; }

    [[nodiscard]] double own_fraction() const { return own_fraction_; }

    /// The server's clock at the last poll, s; 0 before it is known.
    [[nodiscard]] double server_time() const;

    /// By how many metres the own prediction for a tick was wrong, of the newest states of the
    /// server.
    [[nodiscard]] const RecentValues& corrections() const { return corrections_; }

    [[nodiscard]] const TruthMeter& truth() const { return truth_; }

    /// Hears of what comes to the player from now on, for measurements that most games do without.
    void set_observer(std::unique_ptr<view::PlayerObserver> observer) {
        observer_ = std::move(observer);
    }

    /// nullptr: there is none.
    [[nodiscard]] view::PlayerObserver* observer() const { return observer_.get(); }

    motion::InputCommand command_for(Tick tick) override;
    void on_event(const wire::EventMessage& event) override;
    void on_packet(const link::OpenedPacket& packet, const view::PacketResult& taken) override;
    void on_audit(const wire::AuditRecordMessage& record) override;
    void on_session(const wire::WelcomeMessage& welcome) override;
    void on_new_view() override;
    void on_joined(const wire::JoinedMessage& joined) override;
    void on_set_back() override;

  private:
    void close_session();

    GameClientSettings settings_;
    std::string trouble_;  // of this side; empty: the session's own counts
    bool closed_ = false;  // by this side, whatever the session says
    std::unique_ptr<GameRoute> route_;
    view::WorldCache worlds_;
    std::unique_ptr<view::Player> player_;
    GameInput input_;
    std::uint16_t pressed_ = 0;  // since the last command
    std::list<wire::EventMessage> events_;
    std::size_t event_bytes_ = 0;
    std::uint64_t events_dropped_ = 0;
    std::optional<double> begun_s_;  // the caller's clock at the first poll
    double now_s_ = 1.0;             // since then, and a second: the session takes 0 for never
    double fraction_ = 0.0;
    double own_fraction_ = 0.0;
    RecentValues corrections_;
    TruthMeter truth_;
    std::unique_ptr<view::PlayerObserver> observer_;
};

}  // namespace zoned::library
