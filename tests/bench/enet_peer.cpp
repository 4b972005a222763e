#include "tests/bench/enet_peer.h"

#include "tests/bench/cpu_clock.h"

#include <enet/enet.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

namespace zoned::bench {

namespace {

constexpr double kConnect_s = 30.0;
constexpr std::size_t kChannels = 1;

using Host = std::unique_ptr<ENetHost, decltype(&enet_host_destroy)>;

Host made(const ENetAddress* address, int peers) {
    Host host(enet_host_create(address, static_cast<std::size_t>(peers), kChannels, 0, 0),
              &enet_host_destroy);
    if (!host) {
        throw std::runtime_error("ENet makes no host for " + std::to_string(peers) + " peers");
    }
    return host;
}

/// What both sides share.
struct Exchange {
    std::atomic<int> connected{0};
    std::atomic<bool> measure{false};
    std::atomic<bool> stop{false};
    std::atomic<std::uint64_t> down{0};
    std::atomic<std::uint64_t> up{0};
};

/// Handles what came, until the next tick is due.
template <class OnConnect>
void serve_until(ENetHost& host,
                 std::int64_t due_ns,
                 std::atomic<std::uint64_t>& received,
                 const Exchange& exchange,
                 const OnConnect& on_connect) {
    ENetEvent event;
    for (;;) {
        const std::int64_t left_ms = (due_ns - wall_ns()) / 1'000'000;
        const auto wait = static_cast<enet_uint32>(std::max<std::int64_t>(left_ms, 0));
        const int result = enet_host_service(&host, &event, wait);
        if (result > 0 && event.type == ENET_EVENT_TYPE_RECEIVE) {
            received += exchange.measure ? 1 : 0;
            enet_packet_destroy(event.packet);
        } else if (result > 0 && event.type == ENET_EVENT_TYPE_CONNECT) {
            on_connect();
        } else if (result <= 0 && left_ms <= 0) {
            return;
        }
    }
}

void send_to_all(ENetHost& host, const std::vector<std::uint8_t>& bytes) {
    for (std::size_t p = 0; p < host.peerCount; ++p) {
        ENetPeer& peer = host.peers[p];
        if (peer.state == ENET_PEER_STATE_CONNECTED) {
            ENetPacket* packet = enet_packet_create(bytes.data(), bytes.size(), 0);
            if (enet_peer_send(&peer, 0, packet) < 0) {
                enet_packet_destroy(packet);
            }
        }
    }
    enet_host_flush(&host);
}

/// One side: a packet to everybody each tick. `cpu_ns` gets the thread's CPU time while measured.
void run_side(ENetHost& host,
              const DuplexLoad& load,
              std::size_t bytes,
              Exchange& exchange,
              std::atomic<std::uint64_t>& received,
              bool counts_connected,
              std::int64_t& cpu_ns) {
    const std::vector<std::uint8_t> payload(bytes, 0x5A);
    const auto period_ns = static_cast<std::int64_t>(1e9 / load.rate_hz);
    std::int64_t due_ns = wall_ns();
    bool measured = false;
    std::int64_t begin_ns = 0;
    while (!exchange.stop) {
        due_ns = std::max(due_ns + period_ns, wall_ns());
        serve_until(host, due_ns, received, exchange, [&] {
            exchange.connected += counts_connected ? 1 : 0;
        });
        if (exchange.measure != measured) {
            measured = exchange.measure;
            (measured ? begin_ns : cpu_ns) =
                measured ? thread_cpu_ns() : thread_cpu_ns() - begin_ns;
        }
        send_to_all(host, payload);
    }
}

}  // namespace

DuplexCost enet_duplex(const DuplexLoad& load) {
    if (enet_initialize() != 0) {
        throw std::runtime_error("ENet does not start");
    }
    ENetAddress address{};
    enet_address_set_host_ip(&address, "127.0.0.1");
    const Host server = made(&address, load.clients);
    const Host clients = made(nullptr, load.clients);
    ENetAddress to{};
    enet_socket_get_address(server->socket, &to);
    enet_address_set_host_ip(&to, "127.0.0.1");
    for (int c = 0; c < load.clients; ++c) {
        if (enet_host_connect(clients.get(), &to, kChannels, 0) == nullptr) {
            throw std::runtime_error("ENet has no peer left");
        }
    }
    Exchange exchange;
    std::int64_t server_ns = 0;
    std::int64_t clients_ns = 0;
    std::thread serving(
        [&] { run_side(*server, load, load.down_bytes, exchange, exchange.up, true, server_ns); });
    std::thread playing([&] {
        run_side(*clients, load, load.up_bytes, exchange, exchange.down, false, clients_ns);
    });
    const auto pause = [](double seconds) {
        std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    };
    for (double waited = 0.0; exchange.connected < load.clients && waited < kConnect_s;
         waited += 0.05) {
        pause(0.05);
    }
    const bool all = exchange.connected == load.clients;
    const std::int64_t begin_ns = wall_ns();
    if (all) {
        exchange.measure = true;
        pause(load.seconds);
        exchange.measure = false;
        pause(4.0 / load.rate_hz);  // both sides note the end at a tick
    }
    const double seconds = static_cast<double>(wall_ns() - begin_ns) * 1e-9 - 4.0 / load.rate_hz;
    exchange.stop = true;
    serving.join();
    playing.join();
    if (!all) {
        throw std::runtime_error("of " + std::to_string(load.clients) + " ENet clients " +
                                 std::to_string(exchange.connected) + " connected");
    }
    const double of_each = seconds * load.clients;
    return {1e-3 * static_cast<double>(server_ns) / (of_each * load.rate_hz),
            static_cast<double>(exchange.down) / of_each,
            static_cast<double>(exchange.up) / of_each};
}

}  // namespace zoned::bench
