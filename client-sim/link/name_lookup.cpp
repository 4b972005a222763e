#include "client-sim/link/name_lookup.h"

#include <mutex>
#include <thread>

namespace zoned::link {

bool is_loopback(const std::string& host) {
    asio::error_code not_an_address;
    const auto address = asio::ip::make_address(host, not_an_address);
    return host == "localhost" || (!not_an_address && address.is_loopback());
}

Address look_up(const std::string& host, const std::string& port) {
    asio::io_context io;
    asio::ip::tcp::resolver resolver(io);
    asio::error_code error;
    auto found = resolver.resolve(host, port, error);
    if ((error || found.empty()) && host == "localhost") {
        // Its meaning is fixed (RFC 6761, 6.3), also on a machine without /etc/hosts.
        found = resolver.resolve("127.0.0.1", port, error);
    }
    if (error || found.empty()) {
        return Address::failure("cannot resolve " + host + ":" + port + ": " + error.message() +
                                "; check host and port");
    }
    for (const auto& entry : found) {
        if (entry.endpoint().address().is_v4()) {
            return entry.endpoint();
        }
    }
    return found.begin()->endpoint();
}

struct NameLookup::Shared {
    std::mutex mutex;
    std::optional<Address> answer;
};

NameLookup::NameLookup(const std::string& host, const std::string& port)
    : shared_(std::make_shared<Shared>()) {
    asio::error_code a_name;
    asio::ip::make_address(host, a_name);
    if (!a_name || host == "localhost") {
        shared_->answer = look_up(host, port);
        return;
    }
    std::thread([shared = shared_, host, port] {
        Address found = look_up(host, port);
        const std::lock_guard lock(shared->mutex);
        shared->answer = std::move(found);
    }).detach();
}

std::optional<Address> NameLookup::answer() const {
    const std::lock_guard lock(shared_->mutex);
    return shared_->answer;
}

}  // namespace zoned::link
