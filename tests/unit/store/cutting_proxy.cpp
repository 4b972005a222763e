#include "tests/unit/store/cutting_proxy.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <stdexcept>
#include <string_view>

namespace zoned::store::test {

namespace {

constexpr int kPollMs = 20;

sockaddr_un address_of(const std::string& path) {
    sockaddr_un out{};
    out.sun_family = AF_UNIX;
    std::strncpy(out.sun_path, path.c_str(), sizeof(out.sun_path) - 1);
    return out;
}

bool readable(int socket, int patience_ms) {
    pollfd wait{socket, POLLIN, 0};
    return ::poll(&wait, 1, patience_ms) > 0;
}

}  // namespace

CuttingProxy::CuttingProxy(const std::string& folder)
    : server_(folder + "/.s.PGSQL.5432"),
      socket_(folder + "/.s.PGSQL.5433") {
    listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_un address = address_of(socket_);
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
        ::listen(listener_, 4) != 0) {
        throw std::runtime_error("no socket " + socket_);
    }
    thread_ = std::thread([this] { run(); });
}

CuttingProxy::~CuttingProxy() {
    ends_ = true;
    thread_.join();
    ::close(listener_);
    ::unlink(socket_.c_str());
}

void CuttingProxy::run() {
    while (!ends_) {
        if (readable(listener_, kPollMs)) {
            const int client = ::accept(listener_, nullptr, nullptr);
            serve(client);
            ::close(client);
        }
    }
}

void CuttingProxy::serve(int client) {
    const int server = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_un address = address_of(server_);
    std::array<char, 65536> bytes{};
    const auto pass = [&](int from, int to) {
        const ssize_t got = ::read(from, bytes.data(), bytes.size());
        return got > 0 &&
               ::send(to, bytes.data(), static_cast<std::size_t>(got), MSG_NOSIGNAL) == got;
    };
    bool goes_on =
        ::connect(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
    while (goes_on && !ends_) {
        std::array<pollfd, 2> wait{{{client, POLLIN, 0}, {server, POLLIN, 0}}};
        ::poll(wait.data(), wait.size(), kPollMs);
        if (wait[1].revents != 0) {
            goes_on = pass(server, client);
        }
        if (!goes_on || wait[0].revents == 0) {
            continue;
        }
        const ssize_t got = ::read(client, bytes.data(), bytes.size());
        if (got <= 0) {
            break;
        }
        const auto size = static_cast<std::size_t>(got);
        Cut how = Cut::kNone;
        if (std::string_view(bytes.data(), size).find("COMMIT") != std::string_view::npos) {
            how = cut.exchange(Cut::kNone);
        }
        if (how != Cut::kBeforeCommit) {
            goes_on = ::send(server, bytes.data(), size, MSG_NOSIGNAL) == got;
        }
        if (how == Cut::kAfterCommit) {
            // The answer says that the server is done, and goes nowhere.
            readable(server, 10000);
        }
        goes_on = goes_on && how == Cut::kNone;
    }
    ::close(server);
}

}  // namespace zoned::store::test
