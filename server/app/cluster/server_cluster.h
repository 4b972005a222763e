// ServerCluster: characters come from other worlds of the realm and go there.
#pragma once

#include "server/app/cluster/cluster_figures.h"
#include "server/app/cluster/cluster_seat.h"
#include "server/app/cluster/travel_faults.h"
#include "server/app/storage/server_store.h"
#include "server/app/world/portal_watch.h"
#include "server/cluster/accounts.h"
#include "server/cluster/task_thread.h"
#include "server/session/host/session_host.h"

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace zoned::app {

/// The rest of the server, as the cluster needs it.
struct ClusterPorts {
    std::function<void(std::function<void()>)> on_network;  ///< from any thread
    session::SessionHost* host = nullptr;                   ///< on the network thread
    ServerStore* store = nullptr;
    std::function<void(const std::string&)> stop_server;  ///< on the network thread
    std::function<void(double grace_s)> drain;            ///< on the network thread
    /// Calls back when a crash would bring back all that the world has been given so far; at once
    /// where crashes bring nothing back. On the network thread.
    std::function<void(std::function<void()>)> when_kept;
};

/// The way of an account from this world to another:
///
///   ahead   an avatar comes near to a portal: its client hears where, and connects there already
///   wish    an avatar stands in a portal, and the other world is open
///   probe   a write shows that the board takes writes; until here nothing has changed
///   freeze  the avatar leaves its zone, and all sessions of the account but its own end
///   pack    the records are read from the store, behind all that the leave wrote; where crashes
///           are recovered from, the journal holds the leave, and that the store has the records
///   commit  one compare-and-set gives the account and its records to the other world; as long as
///           its outcome is not known, it is tried again and nothing else happens
///   tell    the other server hears that somebody comes, the client hears where it goes on
///
/// And to this world, when its client logs in or a message says that it comes: the records of the
/// entry go into the store, a compare-and-set says so, and the client is let in.
class ServerCluster {
  public:
    using Place = std::optional<std::array<double, 3>>;

    ServerCluster(const config::Settings& settings, ClusterSeat& seat, ClusterPorts ports);
    ~ServerCluster();

    // On the network thread.

    /// Before listen(): these accounts are in the world as it came back after a crash. The board
    /// says which are not any more: those are returned. Waits for the board. Throws
    /// std::runtime_error when another server has taken the world meanwhile, or the process is
    /// asked to stop.
    [[nodiscard]] std::set<std::string> reclaim(const std::set<std::string>& accounts);

    /// Other servers send players from now on.
    void listen(const config::AdvertiseSettings& advertised,
                std::uint16_t tcp_port,
                const std::string& fingerprint,
                std::function<proto::cluster::WorldLoad()> load);
    /// A login that came with a good ticket. `let_in` gets the place where the avatar appears; it
    /// is not called where the account is not this world's.
    void admit(const session::LoginToStore& login, std::function<void(const Place&)> let_in);
    /// Wishes, approaches and departures of a tick.
    void on_tick(std::span<const TravelWish> wishes,
                 std::span<const TravelAhead> ahead,
                 std::span<const ClientId> departed);
    void set_draining();
    /// No travel any more. What is on its way stays so on the board, or here.
    void stop();

    /// Gives the world back, once all that this server wanted to store is stored.
    void release() { seat_.release(); }

    // From any thread.

    /// Where a client goes on that asks for a world.
    [[nodiscard]] std::optional<proto::Redirect> find_world(const std::string& world) const;
    [[nodiscard]] ClusterFigures figures() const;

  private:
    struct Leaving {
        session::Traveller who;
        std::string to;
        std::string arrival;
        bool frozen = false;
        bool left = false;  ///< its avatar
        double frozen_s = 0.0;
    };

    /// On the worker's thread.
    struct Known {
        std::uint64_t revision = 0;
        proto::cluster::AccountEntry entry;
    };

    using LetIn = std::function<void(const Place&)>;
    using RefuseLogin = std::function<void(const std::string& text, const std::string& world)>;

    // server_cluster.cpp
    void on_lease(cluster::LeaseState state);
    void on_message(const std::string& bytes);
    void look_at_directory(int turn);
    void ask(const std::string& account, LetIn let_in, RefuseLogin refuse, int attempt);
    void unpack(const cluster::AccountClaim& claim, LetIn let_in, RefuseLogin refuse);
    void put_into_store(std::shared_ptr<cluster::AccountClaim> claim, LetIn let_in, RefuseLogin no);
    void accept(std::shared_ptr<cluster::AccountClaim> claim,
                std::shared_ptr<cluster::SettledWrite> write,
                LetIn let_in,
                RefuseLogin refuse);
    void settle(const std::string& account,
                std::uint64_t revision,
                Known known,
                const LetIn& let_in);
    void refuse_login(session::StreamId stream, const std::string& text, const std::string& world);
    [[nodiscard]] Place place_of(const std::string& arrival) const;
    [[nodiscard]] std::optional<proto::Redirect> redirect_to(
        const std::string& world,
        const session::Traveller* traveller) const;

    // server_travel.cpp
    void wish(const TravelWish& wish);
    void left(ClientId client, Leaving& leaving);
    void turn_back(ClientId client, const std::string& text);
    void probe(ClientId client, const std::string& account);
    void freeze(ClientId client);
    void read_records(ClientId client);
    void await_journal(ClientId client, std::shared_ptr<std::vector<store::PutRecord>> records);
    void give(ClientId client, const Leaving& leaving, std::vector<store::PutRecord> records);
    void give_again(ClientId client,
                    const std::string& account,
                    const std::string& to,
                    std::shared_ptr<cluster::SettledWrite> write);
    void gone(ClientId client, const std::string& world);
    void give_up(ClientId client, const std::string& text);

    const config::ServerSettings& settings_;
    ClusterSeat& seat_;
    ClusterPorts ports_;
    TravelFaults faults_;
    cluster::Accounts accounts_;

    // Of the network thread.
    std::map<ClientId, Leaving> leaving_;
    std::map<ClientId, double> notified_s_;  // when a client heard last that the way is closed
    bool draining_ = false;

    // Of the worker's.
    std::map<std::string, Known> known_;  // accounts that logged in here
    std::set<std::string> unpacking_;
    std::uint64_t probe_revision_ = 0;
    std::uint64_t probes_ = 0;

    std::atomic<std::uint64_t> lapses_{0};
    std::atomic<std::uint64_t> travels_out_{0};
    std::atomic<std::uint64_t> travels_in_{0};
    std::atomic<std::uint64_t> travelling_{0};
    std::atomic<std::uint64_t> redirects_{0};
    std::atomic<std::uint64_t> refused_{0};

    std::string directory_trouble_;  // of the directory's thread
    std::unique_ptr<cluster::BoardSubscription> messages_;
    // The last: their tasks use all of the above.
    cluster::TaskThread worker_;
    cluster::TaskThread directory_thread_;
};

}  // namespace zoned::app
