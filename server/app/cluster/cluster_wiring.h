// ClusterWiring: a server's cluster between its sessions, its store and its ticks; without a
// cluster, the store's part of logins alone.
#pragma once

#include "server/app/cluster/server_cluster.h"
#include "server/app/runtime/network.h"

#include <asio/io_context.hpp>

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace zoned::app {

/// Empty: the server can start with these URLs of NATS servers.
[[nodiscard]] std::string wrong_with_cluster(const std::vector<std::string>& urls,
                                             const config::Settings& settings);

/// On the network thread, but for the functions that say otherwise.
class ClusterWiring {
  public:
    /// `seat` is null for a server that is in no cluster.
    ClusterWiring(asio::io_context& io, ServerStore& store, ClusterSeat* seat);

    /// For the sessions, before they exist. Empty where logins wait for nobody.
    [[nodiscard]] std::function<void(const session::LoginToStore&)> store_login();
    [[nodiscard]] std::function<std::optional<proto::Redirect>(const std::string&)> find_world();

    /// Once the sessions exist.
    void join(const config::Settings& settings,
              Network& network,
              std::function<void(const std::string&)> stop_server,
              std::function<void(double grace_s)> drain);

    [[nodiscard]] bool on() const { return cluster_ != nullptr; }

    /// From here on, whatever another server could undo waits for the journal; `begun` is the tick
    /// that the loop has begun, from any thread.
    void await_journal(std::function<Tick()> begun) { begun_ = std::move(begun); }

    /// A crash from here on would bring back this tick.
    void on_journaled(Tick tick);
    /// As ServerCluster::reclaim(); none without a cluster.
    [[nodiscard]] std::set<std::string> reclaim(const std::set<std::string>& accounts);

    /// The output of a tick, to the clients and to whom it makes travel.
    void deliver(TickResult result);
    void listen(const config::AdvertiseSettings& advertised, const TickLoop& loop);

    /// For the load that others see.
    void note_sessions(std::uint32_t sessions) { sessions_ = sessions; }

    void set_draining();
    void stop();
    /// Gives the world back, once all is stored.
    void release();

    [[nodiscard]] ClusterFigures figures() const { return cluster_->figures(); }

  private:
    void when_kept(std::function<void()> then);
    void keep(const session::LoginToStore& login, const ServerCluster::Place& arrival);

    asio::io_context& io_;
    ServerStore& store_;
    ClusterSeat* seat_;
    Network* network_ = nullptr;
    std::atomic<std::uint32_t> sessions_{0};
    std::function<Tick()> begun_;  // empty: nothing is kept
    std::multimap<Tick, std::function<void()>> waits_for_journal_;
    std::unique_ptr<ServerCluster> cluster_;
};

}  // namespace zoned::app
