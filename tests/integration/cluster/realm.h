// Realm: two servers, a NATS server and players with tickets, as a test needs them.
#pragma once

#include "client-sim/link/client.h"
#include "client-sim/link/socket_transport.h"
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
    std::vector<double> gaps_s;

  private:
    std::string account_;
    std::function<std::string()> ticket_;
    std::unique_ptr<link::SocketNetwork> network_;
    std::unique_ptr<link::SocketTransport> transport_;
    std::unique_ptr<link::Client> client_;
    bool joined_ = false;
    double next_input_s_ = 0.0;
    double next_login_s_ = 0.0;
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
    std::vector<std::string> findings();

    [[nodiscard]] std::uint64_t travels() const;

    int zoned(const std::vector<std::string>& arguments);

    std::string folder;
    std::unique_ptr<test::NatsServer> nats;
    session::KeyPair keys;
    World castle{"castle", {}, {}, 0, nullptr};
    World meadow{"meadow", {}, {}, 0, nullptr};
    std::vector<std::unique_ptr<Wanderer>> players;
    std::string cluster_lines = "lease_s: 12";
    double portal_wait_s = 0.3;
    bool by_rules = false;  ///< send players on, in place of portals
    bool recorded = false;  ///< each server's run, in NAME.zrec
    std::string said;
    std::string complained;
};

}  // namespace zoned::testing_cluster
