// ClusterSeat: the place of a server in its cluster: the board, the world that it has, and the
// thread that keeps it.
#pragma once

#include "server/app/cluster/state_lock.h"
#include "server/cluster/board.h"
#include "server/cluster/directory.h"
#include "server/cluster/world_lease.h"
#include "server/config/settings.h"
#include "server/session/login/ticket.h"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace zoned::app {

/// The board that the URLs name; without any, one within this process. Throws std::runtime_error.
[[nodiscard]] std::unique_ptr<cluster::Board> open_board(const std::vector<std::string>& urls,
                                                         const std::string& realm,
                                                         const std::string& name,
                                                         int replicas);

class ClusterSeat {
  public:
    /// Waits until the world is this server's: as long as another one has it, and as long as the
    /// board is out of reach. Throws std::runtime_error where waiting does not help.
    ClusterSeat(const config::Settings& settings, const std::vector<std::string>& urls);
    /// Gives the world back.
    ~ClusterSeat();
    ClusterSeat(const ClusterSeat&) = delete;
    ClusterSeat& operator=(const ClusterSeat&) = delete;

    /// From now on others see where the server listens. `load` is asked at each renewal, and
    /// `changed` hears of each new state of the lease; both on the thread that renews.
    void listen(const std::function<void(proto::cluster::WorldEntry&)>& address,
                std::function<proto::cluster::WorldLoad()> load,
                std::function<void(cluster::LeaseState)> changed);
    void set_draining();
    /// Gives the world back, so that another server can take it at once.
    void release();

    [[nodiscard]] cluster::Board& board() { return *board_; }

    [[nodiscard]] const cluster::WorldLease& lease() const { return *lease_; }

    [[nodiscard]] cluster::Directory& directory() { return directory_; }

    /// The key by which the servers of the realm sign tickets for each other.
    [[nodiscard]] const session::PrivateKey& realm_key() const { return realm_key_; }

    [[nodiscard]] const std::string& machine() const { return machine_; }

    /// See cluster::WorldLease::life().
    [[nodiscard]] std::string life() const { return lease_->life(); }

    [[nodiscard]] const std::string& world() const { return world_; }

  private:
    void wait_for_the_world();
    void read_realm_key();
    void keep();

    std::string world_;
    double renew_every_s_;
    std::string machine_;
    StateLock lock_;
    std::unique_ptr<cluster::Board> board_;
    std::unique_ptr<cluster::WorldLease> lease_;
    cluster::Directory directory_;
    session::PrivateKey realm_key_{};
    std::mutex mutex_;
    std::condition_variable wake_;
    bool stopping_ = false;
    bool renew_now_ = false;
    std::function<proto::cluster::WorldLoad()> load_;
    std::function<void(cluster::LeaseState)> changed_;
    std::thread keeper_;
};

}  // namespace zoned::app
