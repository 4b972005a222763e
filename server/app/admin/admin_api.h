// AdminApi: what the admin server answers, wired to the tick loop, the sessions and the process.
#pragma once

#include "server/admin/admin_server.h"
#include "server/app/cluster/cluster_figures.h"
#include "server/app/recovery/recovery_figures.h"
#include "server/app/runtime/network.h"
#include "server/app/runtime/tick_loop.h"
#include "server/app/storage/server_store.h"
#include "server/config/expand/reload_plan.h"
#include "server/config/settings.h"
#include "shared/core/result.h"

#include <asio/io_context.hpp>

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace zoned::app {

/// The result of an operator's change of settings.
struct AdminOutcome {
    std::string text;
    std::vector<config::SettingChange> changes;
};

/// Takes the result of a request that takes a while, or why it came to nothing.
using AdminDone = std::function<void(core::Result<AdminOutcome>)>;

/// What the process does for an operator; called on the network thread.
struct AdminActions {
    /// Takes no logins any more, and stops when the last session has gone or the grace is over.
    std::function<void(double grace_s)> drain;
    /// Reads the config again.
    std::function<void(AdminDone)> reload;
    /// Changes one setting, "path" and value as for --set.
    std::function<void(std::string path, std::string value, AdminDone)> set;
    /// Ends the recording, or begins one in a file of this name; empty: by the time.
    std::function<void(bool on, const std::string& name, AdminDone)> record;
    /// Writes the run up to now into a file of this name; empty: by the time.
    std::function<void(const std::string& name, AdminDone)> snapshot;
    /// Empty where the server is in no cluster.
    std::function<ClusterFigures()> cluster = {};
    /// Empty where a crash ends the world.
    std::function<RecoveryFigures()> recovery = {};
};

/// Figures of the network thread at one moment.
struct NetworkSample {
    session::HostStats host;
    session::RttPercentiles rtt;
    net::UdpStats udp;
    net::TlsStats tls;
    net::TlsStats web;                 ///< of WebSockets
    std::size_t websockets = 0;        ///< of `connections`
    std::size_t held_events = 0;       ///< durable ones that wait for the store
    std::uint64_t refused_events = 0;  ///< durable ones that the store did not take
    std::size_t connections = 0;
    std::optional<ClusterFigures> cluster = {};    ///< none: the server is in no cluster
    std::optional<RecoveryFigures> recovery = {};  ///< none: a crash ends the world
};

/// Requests are answered on the admin server's own thread, from what the tick loop publishes.
/// Questions and orders to sessions go to the network thread; a look at an entity goes to the tick
/// loop, which answers between two ticks.
class AdminApi {
  public:
    /// Binds; makes the token. Throws std::system_error or std::runtime_error with a text for the
    /// operator.
    AdminApi(const config::Settings& settings,
             TickLoop& loop,
             asio::io_context& io,
             Network& network,
             ServerStore& store,
             AdminActions actions);

    void start() { server_.start(); }

    void stop() { server_.stop(); }

    /// Answers name the changes among these that wait for a restart from now on; from any thread.
    void set_waiting(const std::vector<config::SettingChange>& changes);

    /// From now on the server is not ready; from any thread.
    void set_draining();

    [[nodiscard]] std::uint16_t port() const { return server_.port(); }

  private:
    using Call = admin::AdminCall;
    using Reply = admin::AdminReply;

    std::vector<admin::AdminRoute> routes();
    std::vector<admin::AdminRoute> orders();
    void add_open_routes(std::vector<admin::AdminRoute>& out);
    void health(const Call& call, const Reply& reply, bool ready);
    void status(const Reply& reply);
    void metrics(const Reply& reply);
    void sessions(const Call& call, const Reply& reply);
    void zones(const Reply& reply);
    void entity(std::uint32_t id, const Reply& reply);
    void kick(const Call& call, const Reply& reply);
    void ban(const Call& call, const Reply& reply);
    void unban(const Call& call, const Reply& reply);
    void bans(const Reply& reply);
    void say(const Call& call, const Reply& reply);
    void drain(const Call& call, const Reply& reply);
    void set(const Call& call, const Reply& reply);
    void reload(const Call& call, const Reply& reply);
    void change_log_level(const Call& call, const Reply& reply);
    void record(const Call& call, const Reply& reply);
    void snapshot(const Call& call, const Reply& reply);
    void spawn(const Call& call, const Reply& reply);
    void move(const Call& call, const Reply& reply);
    /// Posts an order to the zones, and replies when its answer has come back.
    template <class Order>
    void order_zones(Order order, const std::string& text, const Reply& reply);
    /// On the network thread.
    void on_order_done(const mailbox::OrderDone& done);

    /// Takes a sample on the network thread, and goes on with it on the admin server's.
    void with_sample(std::function<void(const NetworkSample&)> work);
    /// Runs the work on the network thread.
    void on_network(std::function<void()> work);
    /// Replies when the change is durable, or that it is not.
    void keep(store::StoreChange change,
              const std::string& text,
              std::size_t count,
              const Reply& reply);
    [[nodiscard]] static AdminDone done(const Reply& reply);

    const config::Settings& settings_;
    TickLoop& loop_;
    asio::io_context& io_;
    Network& network_;
    ServerStore& store_;
    AdminActions actions_;
    double start_s_;
    std::atomic<bool> draining_{false};

    /// On the network thread: orders that the zones have not answered yet.
    struct WaitingOrder {
        std::string text;
        Reply reply;
    };

    std::map<std::uint64_t, WaitingOrder> orders_;
    std::uint64_t last_order_ = 0;
    std::vector<config::SettingChange> waiting_;  ///< on the admin server's thread
    admin::AdminServer server_;
};

}  // namespace zoned::app
