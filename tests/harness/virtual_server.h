// VirtualServer: a server without sockets, on virtual time, behind a bad network. It has zones and
// sessions.
#pragma once

#include "client-sim/link/conditioner.h"
#include "client-sim/link/link.h"
#include "server/mailbox/address.h"
#include "server/mailbox/messages.h"
#include "server/mailbox/store_messages.h"

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

// Tests that look into the world, its settings or its sessions include the headers of these, which
// take most of the time that a test compiles. The others do without.
namespace zoned::app {
class World;
}

namespace zoned::config {
struct Settings;
}

namespace zoned::zone {
class Rules;
}

namespace zoned::session {
class SessionHost;
struct SessionOutput;
}  // namespace zoned::session

namespace zoned::harness {

class VirtualTransport;

/// An interval of virtual time, s.
struct Span {
    double from_s = 0.0;
    double until_s = 0.0;
};

/// A store that outlives its server: the records by scope, account, character and key.
using Records = std::map<std::tuple<mailbox::StoreScope, std::string, std::string, std::string>,
                         std::vector<std::uint8_t>>;

/// Takes rules and gives others in their place.
using WrapRules = std::function<std::unique_ptr<zone::Rules>(std::unique_ptr<zone::Rules>)>;

struct VirtualServerSettings {
    std::string config;  ///< a config file, or its text
    bool config_is_text = false;
    std::vector<std::string> sets;      ///< "path.to.field=value"
    link::ConditionerSettings network;  ///< both directions alike; every client draws its own fate
    unsigned threads = 1;
    double step_s = 1.0 / 480.0;  ///< resolution of virtual time
    double skew_s = 0.0;          ///< by how much clients' clocks run ahead of the server's
    double drift = 0.0;           ///< by how much faster they run, s/s
    /// The machine under the server is starved: nothing comes in, no tick runs, and server time
    /// stands still, as when ticks are dropped. Ascending, apart.
    std::vector<Span> server_stalls;
    /// Outlives the server, as a file does: the next one finds what this one's rules stored. Null:
    /// each server begins with an empty store.
    std::shared_ptr<Records> records;
};

/// Same settings and calls, same run, bit for bit. Not thread-safe.
class VirtualServer {
  public:
    /// Throws std::runtime_error with all mistakes of the config.
    explicit VirtualServer(const VirtualServerSettings& settings);
    ~VirtualServer();

    /// Before the first step: puts other rules around those of each zone.
    void wrap_rules(const WrapRules& wrap);

    /// A new client's path to this server.
    std::unique_ptr<link::Transport> connect();

    /// One step of virtual time: due packets arrive, and the world ticks when its period is over.
    /// Call the clients' own advance(client_time_s()) after it.
    void step();

    [[nodiscard]] double now_s() const { return now_s_; }

    /// The time that the server's clock shows: now_s() less its stalls.
    [[nodiscard]] double server_time_s() const { return now_s_ - stalled_s_; }

    /// The time that the clients' clocks show.
    [[nodiscard]] double client_time_s() const {
        return now_s_ * (1.0 + settings_.drift) + settings_.skew_s;
    }

    /// Cuts all TCP streams (the UDP path stays): clients come back and resume.
    void cut_streams();
    /// The network is good from now on.
    void heal();
    /// The paths of datagrams to the clients, in order of connection: their bottlenecks can be
    /// changed and read.
    [[nodiscard]] std::vector<link::Conditioner*> paths_down();
    /// An item for the world's next tick, as operators and reloads send.
    void give(mailbox::InboxItem item);
    /// Sends all clients the notice that the server closes.
    void shutdown();

    /// The last tick that the world has simulated.
    [[nodiscard]] Tick simulated() const;
    /// The state hashes of the zones after it.
    void hash_zones(std::vector<std::uint64_t>& hashes) const;

    [[nodiscard]] app::World& world() { return *world_; }

    /// What the world was given before its last tick.
    [[nodiscard]] const std::vector<mailbox::InboxItem>& last_items() const { return last_items_; }

    [[nodiscard]] session::SessionHost& host() { return *host_; }

    [[nodiscard]] const config::Settings& settings() const { return *config_; }

  private:
    friend class VirtualTransport;

    [[nodiscard]] bool stalls();
    void deliver_up();
    void deliver_down();
    void tick();
    void answer_store_requests();
    session::SessionOutput output();

    VirtualServerSettings settings_;
    std::unique_ptr<config::Settings> config_;
    std::unique_ptr<app::World> world_;
    std::unique_ptr<session::SessionHost> host_;
    std::vector<VirtualTransport*> transports_;           // in order of connection
    std::map<std::uint64_t, VirtualTransport*> streams_;  // by session::StreamId
    std::map<mailbox::Address, VirtualTransport*> addresses_;
    std::vector<mailbox::InboxItem> inbox_;
    std::vector<mailbox::InboxItem> last_items_;
    std::vector<mailbox::OutboxItem> outbox_;
    std::uint64_t next_stream_ = 0;
    std::uint32_t next_address_ = 0;
    double now_s_ = 0.0;
    double stalled_s_ = 0.0;
    std::int64_t steps_ = 0;
};

}  // namespace zoned::harness
