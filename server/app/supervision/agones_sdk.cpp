#include "server/app/supervision/agones_sdk.h"

#include "server/app/ctl/admin_client.h"

#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>

#include <charconv>
#include <chrono>
#include <cstdlib>
#include <exception>

namespace zoned::app {

namespace {

using core::Result;
using google::protobuf::Struct;
using google::protobuf::Value;

constexpr auto kRetry = std::chrono::milliseconds(500);

std::uint16_t sidecar_port() {
    const char* text = std::getenv("AGONES_SDK_HTTP_PORT");
    if (text == nullptr || *text == '\0') {
        return 9358;
    }
    unsigned port = 0;
    const std::string digits(text);
    const char* const end = digits.data() + digits.size();
    if (std::from_chars(digits.data(), end, port).ptr != end || port == 0 || port > 65535) {
        throw std::runtime_error("AGONES_SDK_HTTP_PORT is '" + digits + "', which is no port");
    }
    return static_cast<std::uint16_t>(port);
}

AdminTarget sidecar_at(std::uint16_t port) {
    AdminTarget target;
    target.port = port;
    return target;
}

const Value* member(const Struct& object, const std::string& name) {
    const auto at = object.fields().find(name);
    return at == object.fields().end() ? nullptr : &at->second;
}

std::string text_member(const Struct& object, const std::string& name) {
    const Value* value = member(object, name);
    return value == nullptr ? "" : value->string_value();
}

/// 0: no port of that name.
std::uint16_t port_named(const Struct& status, const std::string& name) {
    const Value* ports = member(status, "ports");
    if (ports == nullptr) {
        return 0;
    }
    for (const Value& entry : ports->list_value().values()) {
        const Value* number = member(entry.struct_value(), "port");
        if (number == nullptr || text_member(entry.struct_value(), "name") != name) {
            continue;
        }
        const double port = number->number_value();
        return port >= 1.0 && port <= 65535.0 ? static_cast<std::uint16_t>(port) : 0;
    }
    return 0;
}

}  // namespace

Result<AgonesAddress> parse_game_server(const std::string& json,
                                        const std::string& tcp_name,
                                        const std::string& udp_name) {
    Struct server;
    if (!google::protobuf::util::JsonStringToMessage(json, &server).ok()) {
        return Result<AgonesAddress>::failure("Agones answers with what is no JSON object");
    }
    const Value* status = member(server, "status");
    if (status == nullptr || text_member(status->struct_value(), "address").empty()) {
        return Result<AgonesAddress>::failure("Agones names no address of this game server yet");
    }
    AgonesAddress out;
    out.address = text_member(status->struct_value(), "address");
    out.tcp_port = port_named(status->struct_value(), tcp_name);
    out.udp_port = port_named(status->struct_value(), udp_name);
    return out;
}

AgonesSdk::AgonesSdk(const config::AgonesSettings& settings,
                     std::function<void(const std::string&)> tell)
    : settings_(settings),
      tell_(std::move(tell)),
      port_(sidecar_port()) {
}

AgonesSdk::~AgonesSdk() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) {
        thread_.join();
    }
}

bool AgonesSdk::post(const std::string& path, std::string& reason) const {
    try {
        const AdminAnswer answer = ask_admin(sidecar_at(port_), "POST", path, "{}");
        reason = "POST " + path + " is answered with status " + std::to_string(answer.status);
        return answer.status == 200;
    } catch (const std::exception& error) {
        reason = error.what();
        return false;
    }
}

Result<AgonesAddress> AgonesSdk::game_server() {
    const auto end =
        std::chrono::steady_clock::now() + std::chrono::duration<double>(settings_.patience_s);
    for (;;) {
        std::string reason;
        try {
            const AdminAnswer answer = ask_admin(sidecar_at(port_), "GET", "/gameserver", "");
            reason = "GET /gameserver is answered with status " + std::to_string(answer.status);
            if (answer.status == 200) {
                auto parsed = parse_game_server(
                    answer.body, settings_.tcp_port_name, settings_.udp_port_name);
                if (parsed.ok()) {
                    return parsed;
                }
                reason = parsed.error();
            }
        } catch (const std::exception& error) {
            reason = error.what();
        }
        if (std::chrono::steady_clock::now() >= end) {
            return Result<AgonesAddress>::failure("network.agones: the sidecar at port " +
                                                  std::to_string(port_) +
                                                  " does not say where this server is: " + reason);
        }
        std::this_thread::sleep_for(kRetry);
    }
}

void AgonesSdk::start() {
    thread_ = std::thread([this] { run(); });
}

void AgonesSdk::run() {
    const auto every = std::chrono::duration<double>(settings_.health_every_s);
    bool ready = false;
    bool failing = false;
    std::unique_lock lock(mutex_);
    while (!stopping_) {
        const bool sign = alive_.exchange(false);
        lock.unlock();
        std::string reason;
        bool good = ready || (ready = post("/ready", reason));
        if (good && sign) {
            good = post("/health", reason);
        }
        if (!good && !failing) {
            tell_("network.agones: " + reason);
        }
        failing = !good;
        lock.lock();
        if (ready) {
            wake_.wait_for(lock, every, [this] { return stopping_; });
        } else {
            wake_.wait_for(lock, kRetry, [this] { return stopping_; });
        }
    }
}

void AgonesSdk::shutdown() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    wake_.notify_all();
    if (thread_.joinable()) {
        thread_.join();
    }
    std::string reason;
    if (!post("/shutdown", reason)) {
        tell_("network.agones: " + reason);
    }
}

}  // namespace zoned::app
