#include "server/admin/admin_router.h"

#include <openssl/crypto.h>

#include <algorithm>
#include <charconv>
#include <utility>

namespace zoned::admin {

namespace {

constexpr std::string_view kIdPart = "{id}";
constexpr std::string_view kBearer = "Bearer ";

bool equal_in_same_time(std::string_view a, std::string_view b) {
    return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::string_view path_of(std::string_view target) {
    return target.substr(0, target.find('?'));
}

/// "a=1&b=2"; a part without = has an empty value.
std::map<std::string, std::string> query_of(std::string_view target) {
    std::map<std::string, std::string> out;
    const std::size_t mark = target.find('?');
    std::string_view rest = mark == std::string_view::npos ? "" : target.substr(mark + 1);
    while (!rest.empty()) {
        const std::string_view part = rest.substr(0, rest.find('&'));
        rest.remove_prefix(std::min(rest.size(), part.size() + 1));
        const std::size_t equals = std::min(part.find('='), part.size());
        out[std::string(part.substr(0, equals))] =
            std::string(part.substr(std::min(part.size(), equals + 1)));
    }
    return out;
}

bool parse_id(std::string_view text, std::uint32_t& id) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
    return error == std::errc() && end == text.data() + text.size() && id != 0;
}

bool matches(const AdminRoute& route, std::string_view path, std::uint32_t& id) {
    const std::string_view pattern = route.path;
    if (!pattern.ends_with(kIdPart)) {
        return path == pattern;
    }
    const std::string_view front = pattern.substr(0, pattern.size() - kIdPart.size());
    return path.starts_with(front) && parse_id(path.substr(front.size()), id);
}

bool is_plain(std::string_view path) {
    return path.starts_with('/') && path.find("//") == std::string_view::npos &&
           path.find("/.") == std::string_view::npos &&
           std::all_of(path.begin(), path.end(), [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                      c == '/' || c == '-' || c == '_' || c == '.';
           });
}

bool is_json(std::string_view content_type) {
    const std::string_view type = content_type.substr(0, content_type.find(';'));
    return type == "application/json";
}

}  // namespace

bool is_loopback_host(std::string_view host) {
    std::string_view name = host;
    if (name.starts_with('[')) {
        const std::size_t end = name.find(']');
        if (end == std::string_view::npos) {
            return false;
        }
        name = name.substr(1, end - 1);
        host.remove_prefix(end + 1);
    } else {
        name = name.substr(0, name.find(':'));
        host.remove_prefix(name.size());
    }
    const bool port_good =
        host.empty() ||
        (host.starts_with(':') && host.size() <= 6 &&
         std::all_of(host.begin() + 1, host.end(), [](char c) { return c >= '0' && c <= '9'; }));
    const bool four = name.starts_with("127.") && name.size() <= 15 &&
                      std::count(name.begin(), name.end(), '.') == 3 &&
                      std::all_of(name.begin(), name.end(), [](char c) {
                          return c == '.' || (c >= '0' && c <= '9');
                      });
    return port_good && (name == "localhost" || name == "::1" || four);
}

AdminRouter::AdminRouter(std::string token, std::vector<AdminRoute> routes, AdminReach reach)
    : token_(std::move(token)),
      routes_(std::move(routes)),
      reach_(reach),
      wrong_tokens_(kWrongTokensPerSecond, 2.0 * kWrongTokensPerSecond) {
}

void AdminRouter::handle(const AdminRequest& request, double now_s, const AdminReply& reply) {
    ++requests_;
    RequestRefusal refusal;
    Found found;
    const bool refused = refuse_target(request, refusal) || refuse_site(request, refusal) ||
                         !find(request.method, path_of(request.target), found, refusal) ||
                         (!found.route->open && refuse_token(request, now_s, refusal));
    if (!refused && request.method == "POST" && !is_json(request.content_type)) {
        // Forms of foreign pages cannot send this type without being asked first.
        refusal = {"content_type", problem(415, "send the body as Content-Type: application/json")};
    }
    if (refused || !refusal.reason.empty()) {
        count(refusal.reason);
        reply(std::move(refusal.response));
        return;
    }
    found.route->handle(AdminCall{request, found.id, query_of(request.target)}, reply);
}

bool AdminRouter::refuse_target(const AdminRequest& request, RequestRefusal& out) const {
    const std::string& target = request.target;
    if (target.size() > kMaxTargetBytes) {
        out = {"target_long",
               problem(414,
                       "the path and query are " + std::to_string(target.size()) +
                           " bytes; at most " + std::to_string(kMaxTargetBytes) + " are taken")};
    } else if (!is_plain(path_of(target))) {
        out = {"path",
               problem(400,
                       "the path must begin with / and hold letters, digits and - _ . alone, "
                       "without // and without parts that begin with a dot")};
    } else if (target.find("token") != std::string::npos) {
        out = {"token_in_target",
               problem(400,
                       "a token does not belong into an address, where logs keep it: send it as "
                       "Authorization: Bearer TOKEN")};
    } else {
        return false;
    }
    return true;
}

bool AdminRouter::refuse_site(const AdminRequest& request, RequestRefusal& out) const {
    if (reach_ == AdminReach::kThisMachine && !is_loopback_host(request.host)) {
        out = {"host",
               problem(421,
                       "this server answers to localhost and loopback addresses alone; the Host "
                       "header says something else")};
        return true;
    }
    const std::string own =
        (reach_ == AdminReach::kNetwork ? "https://" : "http://") + request.host;
    const bool foreign = !request.origin.empty() && request.origin != own;
    if (foreign || request.fetch_site == "cross-site" || request.fetch_site == "same-site") {
        out = {"origin",
               problem(403, "another site's page may not ask here: the Origin header is foreign")};
        return true;
    }
    return false;
}

bool AdminRouter::refuse_token(const AdminRequest& request, double now_s, RequestRefusal& out) {
    const std::string_view authorization = request.authorization;
    if (authorization.starts_with(kBearer) &&
        equal_in_same_time(authorization.substr(kBearer.size()), token_)) {
        return false;
    }
    if (!wrong_tokens_.take(now_s)) {
        out = {"token_flood", problem(429, "too many requests with a wrong token; wait a second")};
        out.response.headers.emplace_back("Retry-After", "1");
        return true;
    }
    out = {authorization.empty() ? "token_missing" : "token_wrong",
           problem(401,
                   authorization.empty()
                       ? "send the token as Authorization: Bearer TOKEN; it stands in the file "
                         "admin.token of the server's state folder"
                       : "the token is not this server's; it stands in the file admin.token of "
                         "the server's state folder")};
    out.response.headers.emplace_back("WWW-Authenticate", "Bearer");
    return true;
}

bool AdminRouter::find(std::string_view method,
                       std::string_view path,
                       Found& found,
                       RequestRefusal& out) const {
    std::string allowed;
    for (const AdminRoute& route : routes_) {
        if (!matches(route, path, found.id)) {
            continue;
        }
        if (route.method == method) {
            found.route = &route;
            return true;
        }
        allowed += (allowed.empty() ? "" : ", ") + route.method;
    }
    if (allowed.empty()) {
        out = {"not_found", problem(404, "there is nothing at " + std::string(path))};
    } else {
        out = {"method", problem(405, "this path takes " + allowed)};
        out.response.headers.emplace_back("Allow", allowed);
    }
    return false;
}

}  // namespace zoned::admin
