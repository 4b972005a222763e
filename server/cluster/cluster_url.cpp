#include "server/cluster/cluster_url.h"

#include <algorithm>
#include <cctype>

namespace zoned::cluster {

namespace {

using Urls = core::Result<std::vector<std::string>>;

std::string wrong_with(const std::string& url) {
    const std::size_t scheme = url.find("://");
    if (scheme == std::string::npos ||
        (url.compare(0, scheme, "nats") != 0 && url.compare(0, scheme, "tls") != 0)) {
        return "begins with neither nats:// nor tls://";
    }
    const std::string rest = url.substr(scheme + 3);
    const std::size_t at = rest.rfind('@');
    const std::string place = at == std::string::npos ? rest : rest.substr(at + 1);
    const std::size_t colon = place.rfind(':');
    if (place.empty() || colon == 0 || place.find('/') != std::string::npos) {
        return "names no host";
    }
    if (colon != std::string::npos && place.back() != ']') {
        const std::string port = place.substr(colon + 1);
        const bool digits = !port.empty() && port.size() <= 5 &&
                            std::all_of(port.begin(), port.end(), [](unsigned char c) {
                                return std::isdigit(c) != 0;
                            });
        if (!digits || std::stoi(port) < 1 || std::stoi(port) > 65535) {
            return "has a port that is not in 1..65535";
        }
    }
    return {};
}

}  // namespace

std::string without_secrets(const std::string& url) {
    const std::size_t scheme = url.find("://");
    const std::size_t at = url.rfind('@');
    if (at == std::string::npos) {
        return url;
    }
    return (scheme == std::string::npos || scheme > at ? std::string()
                                                       : url.substr(0, scheme + 3)) +
           url.substr(at + 1);
}

Urls parse_cluster_urls(const std::vector<std::string>& texts) {
    std::vector<std::string> out;
    for (const std::string& text : texts) {
        std::size_t begin = 0;
        while (begin <= text.size()) {
            const std::size_t comma = std::min(text.find(',', begin), text.size());
            const std::string url = text.substr(begin, comma - begin);
            if (const std::string wrong = wrong_with(url); !wrong.empty()) {
                return Urls::failure("--cluster wants nats://HOST:PORT or tls://HOST:PORT; " +
                                     without_secrets(url) + " " + wrong);
            }
            out.push_back(url);
            begin = comma + 1;
        }
    }
    return out;
}

}  // namespace zoned::cluster
