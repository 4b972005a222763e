// ServerSettings: the settings of a config for the server process, as plain structs: network,
// sessions, threads, topics, faults on purpose.
#pragma once

#include "server/interest/topics.h"
#include "server/zone/faults/fault_settings.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::config {

// Defaults are those of the schema (a test compares them).

/// Where players reach the server when it is not where it listens.
struct AdvertiseSettings {
    std::string address;         ///< empty: none is named
    std::uint16_t tcp_port = 0;  ///< 0: the one that it listens at
    std::uint16_t udp_port = 0;

    bool operator==(const AdvertiseSettings&) const = default;
};

/// The Agones sidecar.
struct AgonesSettings {
    bool enabled = false;
    double health_every_s = 2.0;
    double patience_s = 30.0;
    std::string tcp_port_name = "tcp";  ///< of the GameServer's ports
    std::string udp_port_name = "udp";

    bool operator==(const AgonesSettings&) const = default;
};

struct ListenSettings {
    std::string bind_address = "::";
    std::uint16_t tcp_port = 0;  ///< 0: any free one
    std::uint16_t udp_port = 0;
    std::uint32_t max_clients = 20000;
    double max_load = 0.9;                       ///< beyond this share of the time nobody is let in
    std::uint32_t max_sessions_per_address = 0;  ///< 0: any number
    std::size_t socket_buffer_bytes = 4194304;
    std::size_t max_frame_bytes = 65536;
    double silence_timeout_s = 15.0;
    bool admin = true;
    std::string admin_address = "127.0.0.1";
    std::uint16_t admin_port = 0;        ///< 0: any free one
    std::string admin_certificate_file;  ///< empty: the sessions' certificate
    std::string admin_key_file;
    std::optional<std::uint16_t> websocket_port;  ///< none: no WebSockets; 0: any free one
    std::string websocket_address = "127.0.0.1";
    std::vector<std::string> websocket_origins;
    AdvertiseSettings advertise;

    bool operator==(const ListenSettings&) const = default;
};

/// Bytes per second sent to a client.
struct BandwidthSettings {
    std::uint32_t ceiling_bytes_per_s = 16000;
    std::uint32_t floor_bytes_per_s = 2000;
    bool congestion_control = true;

    bool operator==(const BandwidthSettings&) const = default;
};

struct SessionSettings {
    double grace_s = 30.0;
    double login_timeout_s = 10.0;
    std::string tls_certificate_file;  ///< empty: one is made in state_folder
    std::string tls_key_file;
    std::string state_folder = "state";
    bool dev_mode_loopback = false;
    std::optional<std::uint32_t> dev_rights;  ///< bits of proto::config::Right; none: PLAY
    std::vector<std::string> ticket_public_key_files;
    std::uint32_t max_per_account = 0;  ///< 0: any number
    std::uint32_t max_commands_per_s = 20;
    std::uint32_t max_datagrams_per_s = 120;
    std::uint32_t max_unacked_events = 4096;
    std::uint32_t input_window_ticks = 32;
    BandwidthSettings bandwidth;

    bool operator==(const SessionSettings&) const = default;
};

enum class LogLevel : std::uint8_t {
    kDebug,
    kInfo,
    kWarning,
    kError,
};

/// The rules threw: this happens.
enum class RulesException : std::uint8_t {
    kStopZone,
    kStopServer,
};

struct RunSettings {
    unsigned threads = 0;  ///< 0: one per core, at most one per zone
    std::uint32_t max_catch_up_ticks = 3;
    std::size_t mailbox_capacity = 65536;  ///< messages per zone and tick
    LogLevel log_level = LogLevel::kInfo;
    RulesException on_exception = RulesException::kStopZone;

    bool operator==(const RunSettings&) const = default;
};

/// The subjects of the log, each with a level of its own.
enum class LogArea : std::uint8_t {
    kServer,   ///< start, stop, config
    kSession,  ///< logins, leaves, refusals
    kAdmin,    ///< orders of operators
    kTick,     ///< overruns, delays
    kWorld,    ///< limits exceeded, bodies and zones in trouble
    kNetwork,  ///< queues and sockets
    kAgents,
    kCluster,  ///< leases, travel between worlds, the link to the NATS server
    kCount,
};

inline constexpr std::size_t kLogAreas = static_cast<std::size_t>(LogArea::kCount);
/// In the order of LogArea.
inline constexpr std::array<std::string_view, kLogAreas>
    kLogAreaNames{"server", "session", "admin", "tick", "world", "network", "agents", "cluster"};

/// Number of an area by its name; kLogAreas: there is none.
[[nodiscard]] inline std::size_t find_log_area(std::string_view name) {
    std::size_t area = 0;
    while (area < kLogAreas && kLogAreaNames[area] != name) {
        ++area;
    }
    return area;
}

/// "server, session, ...", for people.
[[nodiscard]] inline std::string log_area_list() {
    std::string out;
    for (const std::string_view name : kLogAreaNames) {
        out += (out.empty() ? "" : ", ") + std::string(name);
    }
    return out;
}

struct LogSettings {
    bool json = false;
    std::array<LogLevel, kLogAreas> levels{
        LogLevel::kInfo,
        LogLevel::kInfo,
        LogLevel::kInfo,
        LogLevel::kInfo,
        LogLevel::kInfo,
        LogLevel::kInfo,
        LogLevel::kInfo,
        LogLevel::kInfo,
    };
    double lines_per_s = 100.0;  ///< of one area

    bool operator==(const LogSettings&) const = default;
};

enum class StoreKind : std::uint8_t {
    kNone,
    kSqlite,
    kPostgresql,
};

enum class StoreDurability : std::uint8_t {
    kProcess,
    kPower,
};

/// The store keeps accounts, bans and rules' records over a restart: where, and how surely.
struct StoreSettings {
    StoreKind kind = StoreKind::kSqlite;
    std::string file = "state/store.db";
    StoreDurability durability = StoreDurability::kPower;
    std::uint32_t max_waiting_mb = 64;
    std::string url;  ///< kPostgresql; holds no password

    bool operator==(const StoreSettings&) const = default;
};

/// A world that goes on after a crash from the tick at which it died.
struct RecoverySettings {
    bool on = false;
    double snapshot_every_s = 10.0;
    StoreDurability durability = StoreDurability::kPower;
    bool over_restarts = false;

    bool operator==(const RecoverySettings&) const = default;
};

/// A server of a cluster of several, each with a world.
struct ClusterSettings {
    std::string name;  ///< of the world; empty: the server is in no cluster
    std::string realm = "zoned";
    double lease_s = 12.0;
    std::uint32_t replicas = 1;

    bool operator==(const ClusterSettings&) const = default;
};

/// Where players from another world appear, world coordinates, m.
struct ArrivalSettings {
    std::string name;
    std::array<double, 3> position_m{};

    bool operator==(const ArrivalSettings&) const = default;
};

/// A box, world coordinates, m, from which players go to another world.
struct PortalSettings {
    std::string name;
    std::array<double, 3> lower_m{};
    std::array<double, 3> upper_m{};
    std::string to_world;
    std::string arrival;  ///< empty: a spawn point
    double wait_s = 0.0;

    bool operator==(const PortalSettings&) const = default;
};

/// As proto::config::TravelStep.
enum class TravelStep : std::uint8_t {
    kNone,
    kWished,
    kProbed,
    kFrozen,
    kPacked,
    kCommitted,
    kTold,
    kRedirected,
    kHeard,
    kUnpacked,
    kAccepted,
    kJoined,
};

struct TravelFaultSettings {
    TravelStep die_at = TravelStep::kNone;
    std::uint32_t die_after = 1;
    std::string journal;  ///< empty: none
    bool keep_avatar = false;
    bool lose_records = false;
};

/// The device that computes large particle systems.
struct ComputeSettings {
    std::string device = "auto";
    std::string cache_folder;  ///< for built programs; empty: none are kept

    bool operator==(const ComputeSettings&) const = default;
};

/// One zone does not step for a while.
struct StallSettings {
    std::string zone;  ///< empty: the first
    Tick at_tick = 300;
    Tick ticks = 60;
};

/// The rules of one zone fail within their tick.
struct BreakSettings {
    std::string zone;  ///< empty: the first
    Tick at_tick = 300;
    zone::BreakKind kind = zone::BreakKind::kThrow;
};

/// Limits sent to clients in place of the declared ones.
struct WrongLimitSettings {
    std::string type;  ///< empty: all
    float max_acceleration_mps2 = 0.1F;
    float max_velocity_jump_mps = 0.0F;
};

/// Faults on purpose, to check the checkers.
struct TestingSettings {
    zone::FaultSettings faults;          ///< of all zones
    zone::ShareFault leak_topic;         ///< these clients receive all topics
    std::optional<StallSettings> stall;  ///< of one
    std::optional<BreakSettings> broken;
    double drop_event_probability = 0.0;
    double double_event_probability = 0.0;
    std::optional<WrongLimitSettings> wrong_limit;
    double wrong_clock = 0.0;  ///< share by which rates of shared clocks are wrong
    TravelFaultSettings travel;
};

/// All settings of the server process.
struct ServerSettings {
    ListenSettings network;
    SessionSettings session;
    RunSettings run;
    LogSettings log;
    AgonesSettings agones;
    ComputeSettings compute;
    std::vector<interest::HistoryRule> topics;  ///< topics that keep events for late subscribers
    std::string recording_file;                 ///< empty: nothing is recorded
    double ring_s = 60.0;                       ///< inputs kept for after a crash; 0: none
    StoreSettings store;
    RecoverySettings recovery;
    ClusterSettings cluster;
    std::vector<ArrivalSettings> arrivals;
    std::vector<PortalSettings> portals;
    TestingSettings testing;
    /// network.max_clients as the process was started with: its sockets are made for so many.
    std::uint32_t started_max_clients = 0;
};

}  // namespace zoned::config
