// Start log: tells at the start all that is unusual about a server, so that nobody runs it open by
// mistake.
#pragma once

#include "server/config/settings.h"
#include "server/mailbox/messages.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::app {

class Network;

/// One sentence for each: development mode and its rights, addresses that others reach, faults on
/// purpose, certificates made here, logins that need no ticket.
[[nodiscard]] std::vector<std::string> unusual_of(const config::Settings& settings);

void log_start(const config::Settings& settings);

/// Tells the price, and gives it back.
[[nodiscard]] mailbox::CodecPrice logged(const mailbox::CodecPrice& price);

/// For the ready line: the port of WebSockets where there is one, and the address and ports for
/// players where these are others than the server listens at.
[[nodiscard]] std::string addresses_text(const config::AdvertiseSettings& advertised,
                                         const Network& network);

}  // namespace zoned::app
