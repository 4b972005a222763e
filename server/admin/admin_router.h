// AdminRouter: decides which requests to the admin server are carried out, and hands them to the
// routes.
#pragma once

#include "server/admin/admin_request.h"
#include "shared/core/token_bucket.h"

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace google::protobuf {
class Descriptor;
}

namespace zoned::admin {

/// A request that was let in.
struct AdminCall {
    const AdminRequest& request;
    std::uint32_t id = 0;                      ///< of a route that ends with {id}
    std::map<std::string, std::string> query;  ///< by name
};

/// A number that a request may carry in its query.
struct AdminQuery {
    std::string name;
    std::string meaning;
};

/// The description of the interface says this of a route.
struct AdminRouteDoc {
    std::string summary;
    const google::protobuf::Descriptor* body = nullptr;    ///< of a POST; null: none is read
    const google::protobuf::Descriptor* answer = nullptr;  ///< null: a text
    std::vector<AdminQuery> query = {};
    std::string answer_type = "application/json";
};

struct AdminRoute {
    std::string method;  ///< GET or POST
    std::string path;    ///< exact, or with {id} as its last part: a number from 1 on
    bool open = false;   ///< needs no token
    /// Answers through the reply, at once or later. The call is valid until it returns.
    std::function<void(const AdminCall&, AdminReply)> handle;
    AdminRouteDoc doc = {};
};

/// From where requests may come.
enum class AdminReach : std::uint8_t {
    kThisMachine,  ///< plain: Host must name this machine
    kNetwork,      ///< by TLS: the certificate names the server
};

/// The reasons for a refusal, with their counts.
using AdminCounters = std::map<std::string, std::uint64_t>;

/// Longest target of a request, bytes.
inline constexpr std::size_t kMaxTargetBytes = 1024;
/// Requests that carry a wrong token: so many a second are looked at, the others are refused
/// unread.
inline constexpr double kWrongTokensPerSecond = 10.0;

/// Knows neither sockets nor clock: one thread calls it and passes the time. Nothing from outside
/// is refused without a count.
class AdminRouter {
  public:
    /// `token` is what requests show as "Authorization: Bearer TOKEN".
    AdminRouter(std::string token,
                std::vector<AdminRoute> routes,
                AdminReach reach = AdminReach::kThisMachine);

    /// Replies to every request exactly once; a refusal is a problem document (RFC 9457).
    void handle(const AdminRequest& request, double now_s, const AdminReply& reply);

    /// Counts a refusal of the caller's own, such as of bytes that are no HTTP.
    void count(const std::string& reason) { ++refused_[reason]; }

    [[nodiscard]] const AdminCounters& refused() const { return refused_; }

    [[nodiscard]] std::uint64_t requests() const { return requests_; }

  private:
    struct RequestRefusal {
        std::string reason;  ///< of the counter
        AdminResponse response;
    };

    /// The route and the call; or the refusal.
    struct Found {
        const AdminRoute* route = nullptr;
        std::uint32_t id = 0;
    };

    bool refuse_target(const AdminRequest& request, RequestRefusal& out) const;
    bool refuse_site(const AdminRequest& request, RequestRefusal& out) const;
    bool refuse_token(const AdminRequest& request, double now_s, RequestRefusal& out);
    bool find(std::string_view method,
              std::string_view path,
              Found& found,
              RequestRefusal& out) const;

    std::string token_;
    std::vector<AdminRoute> routes_;
    AdminReach reach_;
    AdminCounters refused_;
    std::uint64_t requests_ = 0;
    core::TokenBucket wrong_tokens_;
};

/// Whether a Host header names this machine itself: localhost or a loopback address, with or
/// without a port. Any other name may be one that a foreign page made to point here (DNS
/// rebinding).
[[nodiscard]] bool is_loopback_host(std::string_view host);

}  // namespace zoned::admin
