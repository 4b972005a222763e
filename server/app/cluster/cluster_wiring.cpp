#include "server/app/cluster/cluster_wiring.h"

#include "server/cluster/cluster_url.h"

#include <asio/post.hpp>

#include <utility>

namespace zoned::app {

std::string wrong_with_cluster(const std::vector<std::string>& urls,
                               const config::Settings& settings) {
    if (!urls.empty() && settings.server.cluster.name.empty()) {
        return "--cluster: the config names no world; set cluster.name";
    }
    const auto parsed = cluster::parse_cluster_urls(urls);
    return parsed.ok() ? std::string() : parsed.error();
}

ClusterWiring::ClusterWiring(asio::io_context& io, ServerStore& store, ClusterSeat* seat)
    : io_(io),
      store_(store),
      seat_(seat) {
}

std::function<void(const session::LoginToStore&)> ClusterWiring::store_login() {
    if (seat_ != nullptr) {
        return [this](const session::LoginToStore& login) {
            cluster_->admit(login, [this, login](const ServerCluster::Place& arrival) {
                keep(login, arrival);
            });
        };
    }
    if (!store_.on()) {
        return {};
    }
    return [this](const session::LoginToStore& login) {
        keep(login, std::nullopt);
    };
}

std::function<std::optional<proto::Redirect>(const std::string&)> ClusterWiring::find_world() {
    if (seat_ == nullptr) {
        return {};
    }
    return [this](const std::string& world) {
        return cluster_->find_world(world);
    };
}

void ClusterWiring::join(const config::Settings& settings,
                         Network& network,
                         std::function<void(const std::string&)> stop_server,
                         std::function<void(double)> drain) {
    network_ = &network;
    if (seat_ == nullptr) {
        return;
    }
    ClusterPorts ports;
    ports.on_network = [this](std::function<void()> work) {
        asio::post(io_, std::move(work));
    };
    ports.host = &network.host();
    ports.store = &store_;
    ports.stop_server = std::move(stop_server);
    ports.drain = std::move(drain);
    ports.when_kept = [this](std::function<void()> then) {
        when_kept(std::move(then));
    };
    cluster_ = std::make_unique<ServerCluster>(settings, *seat_, std::move(ports));
}

std::set<std::string> ClusterWiring::reclaim(const std::set<std::string>& accounts) {
    return cluster_ ? cluster_->reclaim(accounts) : std::set<std::string>();
}

void ClusterWiring::when_kept(std::function<void()> then) {
    if (!begun_) {
        then();
        return;
    }
    store_.settle([this, then = std::move(then)] {
        asio::post(io_, [this, then] {
            // All that was posted up to now is in the inbox of the tick after the one that has
            // begun, at the latest.
            waits_for_journal_.emplace(begun_() + 1, then);
        });
    });
}

void ClusterWiring::on_journaled(Tick tick) {
    while (!waits_for_journal_.empty() && waits_for_journal_.begin()->first <= tick) {
        const std::function<void()> then = std::move(waits_for_journal_.begin()->second);
        waits_for_journal_.erase(waits_for_journal_.begin());
        then();
    }
}

/// `arrival` is where a character appears that came from another world.
void ClusterWiring::keep(const session::LoginToStore& login, const ServerCluster::Place& arrival) {
    if (!store_.on()) {
        network_->host().on_login_stored(login.stream, true, arrival, steady_seconds());
        return;
    }
    store_.log_in(login, [this, stream = login.stream, arrival](const store::LoginResult& result) {
        asio::post(io_, [this, stream, result, arrival] {
            ServerCluster::Place place = arrival;
            if (!place && result.place) {
                place = result.place->position_m;
            }
            network_->host().on_login_stored(stream, result.stored, place, steady_seconds());
        });
    });
}

void ClusterWiring::deliver(TickResult result) {
    const std::vector<TravelWish> wishes = std::move(result.wishes);
    const std::vector<TravelAhead> ahead = std::move(result.ahead);
    const std::vector<ClientId> departed = std::move(result.departed);
    network_->deliver(std::move(result));
    if (cluster_) {
        cluster_->on_tick(wishes, ahead, departed);
    }
}

void ClusterWiring::listen(const config::AdvertiseSettings& advertised, const TickLoop& loop) {
    if (!cluster_) {
        return;
    }
    cluster_->listen(advertised, network_->tcp_port(), network_->fingerprint(), [this, &loop] {
        const LoopStats stats = loop.stats();
        proto::cluster::WorldLoad out;
        out.set_sessions(sessions_.load());
        out.set_entities(stats.entities);
        out.set_tick_ms_p99(stats.wall_ms.percentile(0.99));
        return out;
    });
}

void ClusterWiring::set_draining() {
    if (cluster_) {
        cluster_->set_draining();
    }
}

void ClusterWiring::stop() {
    if (cluster_) {
        cluster_->stop();
    }
}

void ClusterWiring::release() {
    if (cluster_) {
        cluster_->release();
    }
}

}  // namespace zoned::app
