#include "server/app/cluster/cluster_seat.h"

#include "server/app/log/log.h"
#include "server/app/recovery/world_life.h"
#include "server/app/runtime/tick_loop.h"
#include "server/cluster/cluster_url.h"
#include "server/cluster/local_board.h"
#include "server/cluster/nats_board.h"
#include "server/session/login/secrets.h"
#include "shared/core/signal_stack.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>
#include <utility>

namespace zoned::app {

namespace {

/// While a server waits for a world it looks this often.
constexpr auto kLook = std::chrono::milliseconds(100);
constexpr auto kConnectAgain = std::chrono::seconds(1);
/// A lease is renewed so often within its time, at least.
constexpr double kRenewals = 5.0;
constexpr double kMostRenewEvery_s = 2.0;

std::string host_name() {
    std::array<char, 256> name{};
    return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::string describe(const proto::cluster::WorldEntry& entry) {
    std::string out = entry.machine().empty() ? "a server" : "a server on " + entry.machine();
    return entry.tcp_port() == 0 ? out : out + " (tcp " + std::to_string(entry.tcp_port()) + ")";
}

std::unique_ptr<cluster::Board> connect_or_wait(const config::Settings& settings,
                                                const std::vector<std::string>& urls) {
    const config::ClusterSettings& of = settings.server.cluster;
    bool logged = false;
    while (true) {
        try {
            return open_board(urls, of.realm, "zoned " + of.name, static_cast<int>(of.replicas));
        } catch (const std::invalid_argument&) {
            throw;
        } catch (const std::runtime_error& error) {
            if (!std::exchange(logged, true)) {
                log_of(LogArea::kCluster).warn("{}; trying again", error.what());
            }
            std::this_thread::sleep_for(kConnectAgain);
        }
    }
}

}  // namespace

std::unique_ptr<cluster::Board> open_board(const std::vector<std::string>& urls,
                                           const std::string& realm,
                                           const std::string& name,
                                           int replicas) {
    if (urls.empty()) {
        return cluster::make_local_board(cluster::make_local_hub());
    }
    const auto parsed = cluster::parse_cluster_urls(urls);
    if (!parsed.ok()) {
        throw std::invalid_argument(parsed.error());
    }
    cluster::NatsSettings settings;
    settings.urls = *parsed;
    settings.realm = realm;
    settings.name = name;
    settings.replicas = replicas;
    auto board = cluster::connect_nats_board(settings);
    if (!board.ok()) {
        throw std::runtime_error(board.error());
    }
    return std::move(*board);
}

ClusterSeat::ClusterSeat(const config::Settings& settings, const std::vector<std::string>& urls)
    : world_(settings.server.cluster.name),
      renew_every_s_(std::min(kMostRenewEvery_s, settings.server.cluster.lease_s / kRenewals)),
      machine_(host_name()),
      lock_(settings.server.session.state_folder, settings.server.recovery.on),
      board_(connect_or_wait(settings, urls)),
      directory_(*board_) {
    std::array<std::uint8_t, kLifeBytes> fresh{};
    session::random_bytes(fresh);
    lease_ = std::make_unique<cluster::WorldLease>(
        *board_,
        cluster::LeaseSettings{world_,
                               lock_.instance(),
                               settings.server.cluster.lease_s,
                               settings.server.recovery.on ? kept_life(settings) : std::string(),
                               std::string(fresh.begin(), fresh.end())},
        &steady_seconds);
    lease_->describe([&](proto::cluster::WorldEntry& entry) {
        entry.set_machine(machine_);
        entry.set_config_digest(settings.digest);
    });
    wait_for_the_world();
    read_realm_key();
    keeper_ = std::thread([this] { keep(); });
}

ClusterSeat::~ClusterSeat() {
    release();
}

void ClusterSeat::wait_for_the_world() {
    std::string logged;
    while (lease_->claim() != cluster::LeaseState::kHeld) {
        const std::string trouble = lease_->trouble();
        const std::string text = !trouble.empty() ? trouble
                                                  : "the world " + world_ + " is served by " +
                                                        describe(lease_->owner()) +
                                                        "; this server waits to take its place";
        if (text != logged) {
            log_of(LogArea::kCluster).info("{}", text);
            logged = text;
        }
        std::this_thread::sleep_for(kLook);
    }
    log_of(LogArea::kCluster)
        .info("this server has the world {}, epoch {}", world_, lease_->epoch());
}

void ClusterSeat::read_realm_key() {
    constexpr int kAttempts = 50;
    for (int i = 0; i < kAttempts; ++i) {
        const auto found = board_->get("realm.key");
        proto::cluster::RealmKey key;
        if (found.ok() && *found) {
            if (!key.ParseFromString((*found)->value) ||
                key.private_key().size() != realm_key_.size()) {
                throw std::invalid_argument("the realm's key on the board cannot be read");
            }
            std::copy(key.private_key().begin(), key.private_key().end(), realm_key_.begin());
            return;
        }
        if (found.ok()) {
            session::PrivateKey fresh{};
            session::random_bytes(fresh);
            key.set_private_key(fresh.data(), fresh.size());
            // Written or not, the next look finds what all others will find.
            static_cast<void>(board_->put_if("realm.key", 0, key.SerializeAsString()).ok());
            continue;
        }
        std::this_thread::sleep_for(kLook);
    }
    throw std::runtime_error("the board gives no key of the realm; is the NATS server well?");
}

void ClusterSeat::keep() {
    core::add_signal_stack();
    cluster::LeaseState notified = cluster::LeaseState::kHeld;
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        renew_now_ = false;
        const auto load = load_;
        const auto changed = changed_;
        lock.unlock();
        if (load) {
            const proto::cluster::WorldLoad figures = load();
            lease_->describe([&](auto& entry) { *entry.mutable_load() = figures; });
        }
        const cluster::LeaseState state = lease_->renew();
        if (state != notified && changed) {
            notified = state;
            changed(state);
        }
        lock.lock();
        // A lease that ends meanwhile is told of at once.
        const double until_s = state == cluster::LeaseState::kHeld
                                   ? std::min(renew_every_s_, std::max(0.01, lease_->left_s()))
                                   : std::min(renew_every_s_, 0.5);
        wake_.wait_for(lock, std::chrono::duration<double>(until_s), [this] {
            return stopping_ || renew_now_;
        });
    }
}

void ClusterSeat::listen(const std::function<void(proto::cluster::WorldEntry&)>& address,
                         std::function<proto::cluster::WorldLoad()> load,
                         std::function<void(cluster::LeaseState)> changed) {
    lease_->describe(address);
    const std::lock_guard lock(mutex_);
    load_ = std::move(load);
    changed_ = std::move(changed);
    renew_now_ = true;
    wake_.notify_one();
}

void ClusterSeat::set_draining() {
    lease_->describe([](auto& entry) { entry.set_draining(true); });
    const std::lock_guard lock(mutex_);
    renew_now_ = true;
    wake_.notify_one();
}

void ClusterSeat::release() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
        wake_.notify_one();
    }
    if (keeper_.joinable()) {
        keeper_.join();
        lease_->release();
    }
}

}  // namespace zoned::app
