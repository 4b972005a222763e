#include "server/app/runtime/host_settings.h"

#include "server/app/runtime/key_files.h"
#include "server/config/world/world_description.h"

namespace zoned::app {

session::HostSettings host_settings(const config::Settings& settings) {
    const proto::Config::Session& from = settings.config.session();
    const proto::Config::Network& network = settings.config.network();
    session::HostSettings host;
    host.max_sessions = network.max_clients();
    host.grace_s = from.grace_s();
    host.login_timeout_s = from.login_timeout_s();
    host.silence_timeout_s = network.silence_timeout_s();
    host.max_frame_bytes = network.max_frame_bytes();
    host.max_unacked_events = from.max_unacked_events();
    host.max_commands_per_s = from.max_commands_per_s();
    host.max_datagrams_per_s = from.max_datagrams_per_s();
    host.dev_mode_loopback = from.dev_mode_loopback();
    if (from.dev_rights_size() > 0) {
        host.dev_rights = 0;
        for (const int right : from.dev_rights()) {
            host.dev_rights |= static_cast<std::uint32_t>(right);
        }
    }
    for (const std::string& file : from.ticket_public_key_file()) {
        host.ticket_keys.push_back(read_key_file(file));
    }
    host.config_digest = settings.digest;
    host.world = config::describe_world(settings);
    host.tick_rate_hz = settings.tick_rate_hz;
    host.input_window_ticks = from.input_window_ticks();
    const proto::Config::Replication& replication = settings.config.replication();
    host.rate.ceiling = replication.budget_bytes_per_s();
    host.rate.floor = replication.least_bytes_per_s();
    host.rate.on = replication.congestion_control();
    const proto::Config::Testing& testing = settings.config.testing();
    if (testing.has_drop_event()) {
        host.testing.drop_event_probability = testing.drop_event().probability();
    }
    if (testing.has_double_event()) {
        host.testing.double_event_probability = testing.double_event().probability();
    }
    host.testing.seed = settings.seed;
    return host;
}

net::UdpSettings udp_settings(const config::Settings& settings) {
    const proto::Config::Network& network = settings.config.network();
    net::UdpSettings udp;
    udp.bind_address = network.bind_address();
    udp.port = static_cast<std::uint16_t>(network.udp_port());
    udp.receive_buffer_bytes = static_cast<int>(network.socket_buffer_bytes());
    udp.send_buffer_bytes = static_cast<int>(network.socket_buffer_bytes());
    return udp;
}

net::TlsSettings tls_settings(const config::Settings& settings) {
    const proto::Config::Network& network = settings.config.network();
    const proto::Config::Session& session = settings.config.session();
    net::TlsSettings tls;
    tls.bind_address = network.bind_address();
    tls.port = static_cast<std::uint16_t>(network.tcp_port());
    if (session.has_tls_certificate_file()) {
        tls.certificate.certificate_file = session.tls_certificate_file();
        tls.certificate.key_file = session.tls_key_file();
    }
    tls.certificate.state_dir = session.state_folder();
    tls.limits.handshake_timeout_s = session.login_timeout_s();
    tls.limits.max_frame_bytes = network.max_frame_bytes();
    tls.max_connections = network.max_clients() + network.max_clients() / 4 + 16;
    return tls;
}

}  // namespace zoned::app
