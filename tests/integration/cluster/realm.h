// Realm: two servers, a NATS server and players with tickets, as a test needs them.
#pragma once

#include "client-sim/link/client.h"
#include "client-sim/link/socket_transport.h"
#include "server/cluster/board.h"
#include "server/session/login/ticket.h"
#include "tests/harness/nats_server.h"
#include "tests/integration/process/child.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace zoned::testing_cluster {

using testing_process::Child;

inline constexpr double kPatience = 60.0;

[[nodiscard]] double now_s();

/// A player who logs in again, with a new ticket, whenever its session has ended.
class Wanderer final : public link::SessionHandler {
  public:
    Wanderer(std::string account, std::function<std::string()> ticket)
        : account_(std::move(account)),
          ticket_(std::move(ticket)) {}

    /// Logs in at that port of this machine, when it has no session.
    void enter(std::uint16_t port);
    void advance();
    void quit();

    [[nodiscard]] bool closed() const {
        return !client_ || client_->state() == link::SessionState::kClosed;
    }

    /// Its avatar is in a world.
    [[nodiscard]] bool plays() const { return joined_ && !closed() && !client_->on_its_way(); }

    [[nodiscard]] const std::string& account() const { return account_; }

    [[nodiscard]] std::string trouble() const { return client_ ? client_->trouble() : ""; }

    [[nodiscard]] const link::SessionStats& stats() const { return client_->stats(); }

    /// With those of the sessions before the one that it has or had last.
    [[nodiscard]] std::uint64_t total(std::uint64_t link::SessionStats::*of,
                                      std::uint64_t before) const {
        return before + (client_ ? client_->stats().*of : 0);
    }

    void on_welcome(const wire::WelcomeMessage& welcome) override {
        joined_ = joined_ && welcome.resumed;
        world = welcome.world_name;
    }

    void on_joined(const wire::JoinedMessage&) override {
        joined_ = true;
        ++joins;
    }

    void on_event(const wire::EventMessage&) override {}

    void on_audit(const wire::AuditRecordMessage&) override {}

    bool on_packet(const link::OpenedPacket&) override { return true; }

    std::string world;  ///< the one it is in, or was in last
    int joins = 0;
    std::uint64_t travels = 0;  ///< of sessions before this one
    std::uint64_t recovered = 0;
    /// Each time without an avatar in a world, from the end of the one before.
    std::vector<double> gaps_s;

  private:
    std::string account_;
    std::function<std::string()> ticket_;
    std::unique_ptr<link::SocketNetwork> network_;
    std::unique_ptr<link::SocketTransport> transport_;
    std::unique_ptr<link::Client> client_;
    bool joined_ = false;
    double gone_s_ = -1.0;  // since when it has no avatar; below 0: it has one, or never had
    double next_input_s_ = 0.0;
    double next_login_s_ = 0.0;
};

/// Findings of the checker of travel about a run.
struct TravelFinding {
    enum class Wrong : std::uint8_t {
        kTwoOwners,
        kLost,
        kDoubled,
        kUnknown
    };

    Wrong wrong = Wrong::kUnknown;
    std::string text;
};

/// The worlds "castle" and "meadow", whose players go to and fro.
class Realm : public ::testing::Test {
  protected:
    void SetUp() override;
    void TearDown() override;

    struct World {
        std::string name;
        std::string config;
        std::string state;
        std::uint16_t port = 0;
        std::unique_ptr<Child> server;
    };

    /// `more` are settings, as --set takes them.
    void write_config(World& world, const std::string& other, const std::string& more);
    static std::string sends_on(const std::string& other);
    void start(World& world, const std::vector<std::string>& sets = {}, bool wait = true);
    void wait_until_ready(World& world);
    void stop(World& world);

    std::string ticket(const std::string& account);
    Wanderer& add(const std::string& account);
    /// All players go on until `done`, and come back to `world` (or both in turn) when they are
    /// out.
    bool play_until(const std::function<bool()>& done, double seconds);

    /// The record that each account has of its own.
    void give_tokens(const World& world, const std::vector<std::string>& accounts);
    /// Faults of owners by the journal, and with records by the board and the stores of
    /// servers that have stopped; empty: nothing.
    std::vector<TravelFinding> findings();

    /// Each finding is a failure of the test.
    void expect_clean();
    std::unique_ptr<cluster::Board> board() const;

    /// Both servers, and that many players whose tokens the castle's store has.
    void begin(int count, const std::vector<std::string>& sets = {});
    [[nodiscard]] bool all_play() const;
    /// The first login is in the castle, whose store has the tokens.
    void enter_the_castle();
    /// `all_play` and nothing more to travel: portals stay, so it is a moment.
    void settle();
    /// All players quit, and both servers stop in good order.
    void end();

    [[nodiscard]] std::uint64_t travels() const;
    /// Returns to sessions of a server that had died.
    [[nodiscard]] std::uint64_t recovered() const;

    int zoned(const std::vector<std::string>& arguments);

    std::string folder;
    /// Of the NATS servers, as --cluster takes them.
    [[nodiscard]] std::string board_urls() const;

    std::unique_ptr<test::NatsServer> nats;
    std::vector<std::unique_ptr<test::NatsServer>> more_nats;  ///< of one group with it
    session::KeyPair keys;
    World castle{"castle", {}, {}, 0, nullptr};
    World meadow{"meadow", {}, {}, 0, nullptr};
    std::vector<std::unique_ptr<Wanderer>> players;
    std::string cluster_lines = "lease_s: 12";
    double portal_wait_s = 0.3;
    bool by_rules = false;  ///< send players on, in place of portals
    bool recovers = false;  ///< worlds come back after a crash
    bool recorded = false;  ///< each server's run, in NAME.zrec
    std::string said;
    std::string complained;
};

}  // namespace zoned::testing_cluster
