// Session settings of a server: limits, times and permission to log in.
#pragma once

#include "server/mailbox/messages.h"
#include "server/session/datagrams/rate_control.h"
#include "proto/session.pb.h"
#include "shared/core/ids.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace zoned::session {

/// Faults on purpose, to test the checkers of clients.
struct EventFaults {
    double drop_event_probability = 0.0;    ///< uses up an event's number and never sends it
    double double_event_probability = 0.0;  ///< sends an event twice, under consecutive numbers
    std::uint64_t seed = 1;
};

/// Settings of the host that may change while it runs.
struct HostLimits {
    std::uint32_t max_sessions = 20000;
    double max_load = 0.9;              ///< share of the time there is; logins beyond are refused
    std::uint32_t max_per_address = 0;  ///< sessions of one network (network_of); 0: any number
    std::uint32_t max_per_account = 0;  ///< a login beyond ends the oldest; 0: any number
    double grace_s = 30.0;              ///< how long a session waits for its client to come back
    double login_timeout_s = 10.0;
    double silence_timeout_s =
        15.0;  ///< neither datagram nor frame for this long: the stream is closed, the grace begins
    std::size_t max_unacked_events = 4096;  ///< more: the client is too slow, it is closed
    // For sessions that begin from now on:
    std::uint32_t max_commands_per_s =
        20;  ///< reliable commands per client; flood limit (burst: 2 s worth)
    std::uint32_t max_datagrams_per_s = 120;
    bool dev_mode_loopback =
        false;  ///< lets in loopback addresses without a ticket, with all rights in dev_rights
    std::uint32_t dev_rights = mailbox::kRightPlay;
    std::vector<std::array<std::uint8_t, 32>>
        ticket_keys;  ///< Ed25519 public keys whose tickets are accepted
};

struct HostSettings : HostLimits {
    std::size_t max_frame_bytes = 65536;   ///< of a client's frame
    std::uint32_t max_frames_per_s = 400;  ///< of any kind; more than twice that at once: closed
    std::size_t max_command_bytes = 4096;  ///< payload of one reliable command
    std::size_t max_tunnel_backlog_bytes =
        65536;  ///< no state packet goes into a stream in which more than this waits
    /// The same for a WebSocket, which is the only way of its client: what waits is old.
    std::size_t max_websocket_backlog_bytes = 8192;
    std::size_t max_remembered_tickets = 1'000'000;  ///< used, not yet expired
    std::uint32_t protocol_version = 8;
    std::string config_digest;
    std::string world_name;  ///< in a cluster; empty: the server is in none
    std::string audience;    ///< the world that a ticket may be for; one for another is refused
    /// Ed25519 public keys of the cluster, whose tickets name this world.
    std::vector<std::array<std::uint8_t, 32>> cluster_keys;
    proto::WorldDescription world;
    double tick_rate_hz = 30.0;
    Tick input_window_ticks =
        32;  ///< commands farther ahead of the current tick are refused; older than 8 ticks too;
             ///< at most kMaxInputWindowTicks (input_gate.h)
    RateSettings rate;  ///< the share of each client's path, as long as it carries it
    /// Inputs are kept so that a crash loses no session: the zones hear of beginnings and progress,
    /// and commands are acknowledged when CommandsKept says so.
    bool journaled = false;
    EventFaults testing;
};

}  // namespace zoned::session
