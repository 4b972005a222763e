// Suite `server`: what a client costs a server over real, encrypted sockets, beside ENet, which
// does not encrypt.
#include "tests/bench/cpu_clock.h"
#include "tests/bench/enet_peer.h"
#include "tests/bench/file_text.h"
#include "tests/bench/server_process.h"
#include "tests/bench/statistics.h"
#include "tests/bench/suite.h"
#include "shared/wire/seal.h"

#include <chrono>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>
#include <thread>

namespace zoned::bench {

namespace {

const std::string kUpdates = "updates_20hz";

constexpr double kUpdates_hz = 20.0;
constexpr double kVisible = 24.0;
constexpr double kNimbus_m = 30.0;
constexpr double kRampPerS = 200.0;
constexpr double kSettle_s = 2.0;

/// Walking players and nothing else; so many that each has `kVisible` others within its nimbus.
std::string server_config(int clients) {
    const double half_m =
        0.5 * std::sqrt(clients * std::numbers::pi * kNimbus_m * kNimbus_m / kVisible);
    std::ostringstream text;
    text << "world { name: \"walkers\" seed: 7 tick_rate_hz: " << kUpdates_hz
         << " min_x_m: " << -half_m << " min_z_m: " << -half_m << " max_x_m: " << half_m
         << " max_z_m: " << half_m << " }\nzones { zone_grid { columns: 1 rows: 1 } }\n"
         << "type { name: \"player\" kind: CHARACTER capsule { radius_m: 0.4 length_m: 1 } "
            "mass_kg: 80 aura_m { normal: "
         << kNimbus_m << " } nimbus_m { normal: " << kNimbus_m
         << " } max_acceleration_mps2: 20 max_velocity_jump_mps: 15 character { } }\n"
         << "lod { position_bound_m: 0.05 orientation_bound_rad: 0.1 }\n"
         << "replication { silence_ticks: 10 quantization { horizontal_extent_m: "
         << 2.0 * half_m + 128.0
         << " } }\nsession { dev_mode_loopback: true }\nrun { threads: 1 }\nstore { kind: "
            "STORE_NONE }\n";
    // Everybody begins in a place of its own.
    const int side = static_cast<int>(std::ceil(std::sqrt(clients)));
    for (int i = 0; i < side * side; ++i) {
        const auto at = [&](int k) {
            return 0.95 * half_m * (2.0 * (k + 0.5) / side - 1.0);
        };
        text << "spawn { x_m: " << at(i % side) << " z_m: " << at(i / side) << " }\n";
    }
    return text.str();
}

void rest(double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

/// CPU time to seal a datagram of so many bytes and to open another one, us.
double seal_us(std::size_t down_bytes, std::size_t up_bytes) {
    wire::Seal ours{wire::SealKey()};
    const std::vector<std::uint8_t> head(6, 1);
    const std::vector<std::uint8_t> down(down_bytes, 2);
    const std::vector<std::uint8_t> up(up_bytes, 3);
    std::vector<std::uint8_t> sealed_up;
    ours.seal(1, head, up, sealed_up);
    constexpr int kTimes = 20000;
    std::vector<std::uint8_t> out;
    const std::int64_t begin = thread_cpu_ns();
    for (int i = 0; i < kTimes; ++i) {
        out.clear();
        ours.seal(static_cast<std::uint64_t>(i) + 2, head, down, out);
        ours.open(1, head, sealed_up, out);
    }
    return 1e-3 * static_cast<double>(thread_cpu_ns() - begin) / kTimes;
}

struct Traffic {
    double down_packet_bytes = 100.0;  ///< UDP payload
    double up_packet_bytes = 40.0;
};

/// CPU time of the server for an update, us, in each of so many seconds.
std::vector<double> update_costs_us(const ServerProcess& server, int clients, double seconds) {
    std::vector<double> out;
    for (double second = 0.0; second < seconds; second += 1.0) {
        const double before_s = server.cpu().all_s;
        const std::int64_t begin = wall_ns();
        rest(1.0);
        const double updates =
            1e-9 * static_cast<double>(wall_ns() - begin) * clients * kUpdates_hz;
        out.push_back(1e6 * (server.cpu().all_s - before_s) / updates);
    }
    return out;
}

/// Our server under bots of another process.
Traffic run_zoned(Session& session, int clients, double seconds) {
    ServerProcess server(server_config(clients));
    const std::string report = testing_process::scratch_folder() + "/bots.json";
    const double ramp_s = clients / kRampPerS + kSettle_s;
    testing_process::Child bots("client-sim",
                                {"--connect",
                                 "127.0.0.1:" + std::to_string(server.port()),
                                 "--bots",
                                 std::to_string(clients),
                                 "--seconds",
                                 std::to_string(seconds + kSettle_s + 1.0),
                                 "--ramp-per-s",
                                 std::to_string(kRampPerS),
                                 "--behaviour",
                                 "wander",
                                 "--no-audit",
                                 "--no-freeze",
                                 "--quiet",
                                 "--report",
                                 report});
    rest(ramp_s);
    const ProcessCpu before = server.cpu();
    const std::int64_t begin = wall_ns();
    const std::vector<double> slices_us = update_costs_us(server, clients, seconds);
    const ProcessCpu after = server.cpu();
    const double measured_s = 1e-9 * static_cast<double>(wall_ns() - begin);
    const int code = bots.wait(120.0);
    const std::string of_bots = text_of_file(report);
    const std::string of_server = server.stop();
    if (code != 0) {
        session.note("server, " + std::to_string(clients) + " clients: client-sim ended with " +
                     std::to_string(code) + ": " +
                     bots.output().substr(bots.output().rfind("verdict")));
    }
    const double updates = measured_s * clients * kUpdates_hz;
    const double packets_out = number_in_json(of_server, "packets_out");
    const double packets_in = number_in_json(of_server, "packets_in");
    const Traffic traffic{number_in_json(of_server, "bytes_out") / packets_out,
                          number_in_json(of_server, "bytes_in") / packets_in};
    Row row;
    row.suite = "server";
    row.scene = kUpdates;
    row.parameter = "clients=" + std::to_string(clients);
    row.time_us_p50 = median(slices_us);
    row.time_us_p99 = largest(slices_us);
    row.error = number_in_json(of_bots, "down_bytes_per_s_p50");
    row.error_unit = "B/s down";
    const double crypto_us = seal_us(static_cast<std::size_t>(traffic.down_packet_bytes),
                                     static_cast<std::size_t>(traffic.up_packet_bytes));
    const double packets_an_update = 0.5 * (packets_out + packets_in) /
                                     std::max(1.0, clients * number_in_json(of_server, "ticks"));
    row.metric("clients", clients);
    row.metric("cores", (after.all_s - before.all_s) / measured_s);
    row.metric("user_us", 1e6 * (after.user_s - before.user_s) / updates);
    row.metric("system_us", 1e6 * (after.system_s - before.system_s) / updates);
    row.metric("seal_us", crypto_us * packets_an_update);
    row.metric("up_Bps", number_in_json(of_bots, "up_bytes_per_s_p50"));
    row.metric("down_packet_bytes", traffic.down_packet_bytes);
    row.metric("up_packet_bytes", traffic.up_packet_bytes);
    row.metric("tick_ms_p99", number_in_json(of_server, "tick_ms_p99"));
    row.metric("updates_per_s", number_in_json(of_bots, "updates_per_s"));
    row.metric("inputs_missing", number_in_json(of_server, "inputs_missing"));
    session.add({row});
    return traffic;
}

void run_enet(Session& session, int clients, double seconds, const Traffic& traffic) {
    DuplexLoad load;
    load.clients = clients;
    load.rate_hz = kUpdates_hz;
    load.down_bytes = static_cast<std::size_t>(traffic.down_packet_bytes);
    load.up_bytes = static_cast<std::size_t>(traffic.up_packet_bytes);
    load.seconds = seconds;
    const DuplexCost cost = enet_duplex(load);
    Row row;
    row.suite = "server";
    row.scene = kUpdates;
    row.method = "duplex";
    row.peer = "enet";
    row.parameter = "clients=" + std::to_string(clients);
    row.time_us_p50 = cost.us_per_update;
    row.time_us_p99 = cost.us_per_update;
    row.error = cost.down_per_s * traffic.down_packet_bytes;
    row.error_unit = "B/s down";
    row.metric("clients", clients);
    row.metric("down_per_s", cost.down_per_s);
    row.metric("up_per_s", cost.up_per_s);
    session.add({row});
}

void run_server(Session& session) {
    if (!session.wants_scene(kUpdates)) {
        return;
    }
    const double seconds = session.quick ? 2.0 : 15.0;
    for (const int clients :
         session.quick ? std::vector<int>{50} : std::vector<int>{50, 200, 500}) {
        Traffic traffic;
        if (session.wants_method("default", "")) {
            session.progress("server: " + std::to_string(clients) + " clients");
            traffic = run_zoned(session, clients, seconds);
        }
        if (session.wants_method("duplex", "enet")) {
            session.progress("server: " + std::to_string(clients) + " clients of ENet");
            run_enet(session, clients, seconds, traffic);
        }
    }
    session.note(
        "server: CPU time of the whole process for a client and a tick of 20 Hz: physics, "
        "interest, "
        "replication, TLS and sealed datagrams both ways; 24 others are in sight, bounds of 5 cm. "
        "ENet carries packets of the same sizes and does nothing else");
}

const Registration kServer({"server",
                            "what a client costs over real, encrypted sockets, beside ENet",
                            {kUpdates},
                            {"default", "enet/duplex"},
                            run_server});

}  // namespace

}  // namespace zoned::bench
