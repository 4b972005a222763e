#include "server/app/runtime/host_settings.h"

#include "server/app/runtime/key_files.h"
#include "server/config/world/world_description.h"
#include "server/net/socket_address.h"

#include <algorithm>
#include <thread>

namespace zoned::app {

session::HostSettings host_settings(const config::Settings& settings) {
    const config::SessionSettings& from = settings.server.session;
    const config::ListenSettings& network = settings.server.network;
    session::HostSettings host;
    host.max_sessions = network.max_clients;
    host.max_load = network.max_load;
    host.max_per_address = network.max_sessions_per_address;
    host.max_per_account = from.max_per_account;
    host.grace_s = from.grace_s;
    host.login_timeout_s = from.login_timeout_s;
    host.silence_timeout_s = network.silence_timeout_s;
    host.max_frame_bytes = network.max_frame_bytes;
    host.max_unacked_events = from.max_unacked_events;
    host.max_commands_per_s = from.max_commands_per_s;
    host.max_datagrams_per_s = from.max_datagrams_per_s;
    host.dev_mode_loopback = from.dev_mode_loopback;
    host.dev_rights = from.dev_rights.value_or(host.dev_rights);
    for (const std::string& file : from.ticket_public_key_files) {
        host.ticket_keys.push_back(read_key_file(file));
    }
    host.config_digest = settings.digest;
    host.world_name = settings.server.cluster.name;
    host.audience = host.world_name.empty() ? settings.world_name : host.world_name;
    host.world = config::describe_world(settings);
    host.tick_rate_hz = settings.tick_rate_hz;
    host.input_window_ticks = from.input_window_ticks;
    host.rate = {static_cast<double>(from.bandwidth.ceiling_bytes_per_s),
                 static_cast<double>(from.bandwidth.floor_bytes_per_s),
                 from.bandwidth.congestion_control};
    host.journaled = settings.server.recovery.on;
    host.testing.drop_event_probability = settings.server.testing.drop_event_probability;
    host.testing.double_event_probability = settings.server.testing.double_event_probability;
    host.testing.seed = settings.seed;
    return host;
}

net::UdpSettings udp_settings(const config::Settings& settings) {
    const config::ListenSettings& network = settings.server.network;
    net::UdpSettings udp;
    udp.bind_address = network.bind_address;
    udp.port = network.udp_port;
    udp.receive_buffer_bytes = static_cast<int>(network.socket_buffer_bytes);
    udp.send_buffer_bytes = static_cast<int>(network.socket_buffer_bytes);
    return udp;
}

net::TlsSettings tls_settings(const config::Settings& settings) {
    const config::ListenSettings& network = settings.server.network;
    const config::SessionSettings& session = settings.server.session;
    net::TlsSettings tls;
    tls.bind_address = network.bind_address;
    tls.port = network.tcp_port;
    if (!session.tls_certificate_file.empty()) {
        tls.certificate.certificate_file = session.tls_certificate_file;
        tls.certificate.key_file = session.tls_key_file;
    }
    tls.certificate.state_dir = session.state_folder;
    tls.limits.handshake_timeout_s = session.login_timeout_s;
    tls.limits.max_frame_bytes = network.max_frame_bytes;
    tls.max_connections = network.max_clients + network.max_clients / 4 + 16;
    return tls;
}

bool is_loopback_address(const std::string& address) {
    const auto parsed = net::parse_address(address, 0);
    return parsed.ok() && parsed->is_loopback();
}

net::TlsSettings websocket_settings(const config::Settings& settings) {
    const config::ListenSettings& network = settings.server.network;
    net::TlsSettings out = tls_settings(settings);
    out.bind_address = network.websocket_address;
    out.port = network.websocket_port.value_or(0);
    out.websocket.emplace();
    out.websocket->origins = network.websocket_origins;
    out.plain = is_loopback_address(network.websocket_address);
    out.number_after = kWebSocketStreams;
    return out;
}

bool admin_is_local(const config::Settings& settings) {
    return is_loopback_address(settings.server.network.admin_address);
}

unsigned thread_count(const config::Settings& settings) {
    const unsigned asked = settings.server.run.threads;
    const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
    const auto zones = static_cast<unsigned>(settings.zones.size());
    return asked > 0 ? asked : std::min(cores, zones);
}

}  // namespace zoned::app
