// AdminClient: asks a running server's admin interface; one connection for each question.
#pragma once

#include <cstdint>
#include <string>

namespace zoned::app {

/// Where a server's admin interface is, and what opens it.
struct AdminTarget {
    std::string host = "127.0.0.1";
    std::uint16_t port = 0;
    std::string token;
    bool tls = false;
    /// PEM file with the certificate that the server must show, or with that of its signer; empty:
    /// the system's.
    std::string certificate_file;
};

struct AdminAnswer {
    unsigned status = 0;
    std::string body;
};

/// "HOST:PORT" or "[ADDRESS]:PORT", for TLS with "https://" in front; throws std::invalid_argument
/// that says what is wrong.
AdminTarget parse_admin_address(const std::string& text);

/// Throws std::system_error when the server cannot be reached, std::runtime_error when it does not
/// answer within 35 s or what comes is no HTTP; both with a text for the operator. `body` goes as
/// JSON; empty for GET.
AdminAnswer ask_admin(const AdminTarget& target,
                      const std::string& method,
                      const std::string& path,
                      const std::string& body);

}  // namespace zoned::app
