#include "server/config/text/store_url.h"

#include <algorithm>

namespace zoned::config {

namespace {

constexpr std::string_view kPassword =
    "holds a password, which would show wherever the config does: put it into PGPASSWORD, or into "
    "a file of the form of ~/.pgpass that ?passfile=FILE names";

bool is_of_port(char c) {
    return c >= '0' && c <= '9';
}

/// True where a colon is followed by something else than a port. A password with a slash looks so.
bool has_odd_port(std::string_view hosts) {
    bool bracket = false;
    for (std::size_t i = 0; i < hosts.size(); ++i) {
        bracket = hosts[i] == '[' || (bracket && hosts[i] != ']');
        if (hosts[i] != ':' || bracket) {
            continue;
        }
        while (i + 1 < hosts.size() && is_of_port(hosts[i + 1])) {
            ++i;
        }
        if (i + 1 < hosts.size() && hosts[i + 1] != ',') {
            return true;
        }
    }
    return false;
}

bool has_password_option(std::string_view query) {
    while (!query.empty()) {
        const std::string_view option = query.substr(0, query.find('&'));
        std::string name(option.substr(0, option.find('=')));
        std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) {
            return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : static_cast<char>(c);
        });
        // A name in %-code may be any name.
        if (name == "password" || name == "sslpassword" || name.find('%') != std::string::npos) {
            return true;
        }
        query.remove_prefix(std::min(query.size(), option.size() + 1));
    }
    return false;
}

}  // namespace

std::string wrong_with_store_url(std::string_view url) {
    const std::size_t scheme = url.find("://");
    if (scheme == std::string_view::npos ||
        (url.substr(0, scheme) != "postgresql" && url.substr(0, scheme) != "postgres")) {
        return "is no URL of a PostgreSQL database; " + store_url_advice();
    }
    if (std::any_of(url.begin(), url.end(), [](unsigned char c) {
            return c <= ' ' || c == 0x7F || c == '#';
        })) {
        return "holds a space, '#' or control character: write it as %20, %23 and so on";
    }
    // libpq looks for a user up to the first slash, whatever else comes before it.
    std::string_view rest = url.substr(scheme + 3);
    const std::string_view front = rest.substr(0, rest.find('/'));
    const std::size_t at = front.rfind('@');
    if (at != std::string_view::npos && front.substr(0, at).find(':') != std::string_view::npos) {
        return std::string(kPassword);
    }
    const std::size_t question = rest.find('?');
    const std::string_view hosts =
        front.substr(0, question)
            .substr(at == std::string_view::npos || at > question ? 0 : at + 1);
    if (has_odd_port(hosts)) {
        return "has a port that is no number, or " + std::string(kPassword);
    }
    if (question != std::string_view::npos && has_password_option(rest.substr(question + 1))) {
        return std::string(kPassword);
    }
    return {};
}

std::string store_url_advice() {
    return "it looks like postgresql://user@host/database, without a password: that belongs into "
           "PGPASSWORD, or into a file that ?passfile=FILE names";
}

}  // namespace zoned::config
