// Host settings: turns the checked config into the settings of sessions, sockets and threads.
#pragma once

#include "server/config/settings.h"
#include "server/net/tls_listener.h"
#include "server/net/udp_endpoint.h"
#include "server/session/host/session_host.h"

namespace zoned::app {

/// Reads the public keys of tickets; throws with a text that names the file.
session::HostSettings host_settings(const config::Settings& settings);

net::UdpSettings udp_settings(const config::Settings& settings);
net::TlsSettings tls_settings(const config::Settings& settings);

/// Streams of WebSockets have higher numbers than this, all others lower ones.
inline constexpr net::StreamNumber kWebSocketStreams = net::StreamNumber{1} << 62U;

/// Needs network.websocket_port.
net::TlsSettings websocket_settings(const config::Settings& settings);

/// Threads that step the zones.
[[nodiscard]] unsigned thread_count(const config::Settings& settings);

[[nodiscard]] bool is_loopback_address(const std::string& address);

/// Whether the admin server listens to this machine alone; else it speaks TLS.
[[nodiscard]] bool admin_is_local(const config::Settings& settings);

}  // namespace zoned::app
