// Admin request and response: HTTP without sockets, as the routes of the admin server see it.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace zoned::admin {

/// The parts of an HTTP request that decide something; a header that is missing is empty.
struct AdminRequest {
    std::string method;
    std::string target;  ///< path and query, as it came
    std::string host;
    std::string origin;
    std::string fetch_site;  ///< Sec-Fetch-Site
    std::string authorization;
    std::string content_type;
    std::string body;
    bool upgrade = false;  ///< asks for a WebSocket
};

struct AdminResponse {
    unsigned status = 200;
    std::string content_type = "application/json";
    std::string body;
    std::vector<std::pair<std::string, std::string>> headers;  ///< besides type and length
};

/// Called once, from any thread.
using AdminReply = std::function<void(AdminResponse)>;

/// An error as problem JSON (RFC 9457): the status names its class, `detail` says what was wrong
/// and what to do.
[[nodiscard]] AdminResponse problem(unsigned status, const std::string& detail);

/// The standard phrase of a status that the admin server uses (RFC 9110, section 15).
[[nodiscard]] const char* status_phrase(unsigned status);

}  // namespace zoned::admin
