#include "server/app/supervision/supervision.h"

#include "server/app/log/log.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

namespace zoned::app {

namespace {

/// As sd_watchdog_enabled(3) recommends: twice within the time.
constexpr double kWatchdogShare = 0.5;

}  // namespace

Supervision::Supervision(asio::io_context& io,
                         const config::ServerSettings& settings,
                         std::function<std::uint64_t()> turns)
    : settings_(settings),
      turns_(std::move(turns)),
      timer_(io) {
    if (settings.agones.enabled) {
        agones_ = std::make_unique<AgonesSdk>(settings.agones, [](const std::string& text) {
            log_of(LogArea::kServer).error("{}", text);
        });
        period_s_ = settings.agones.health_every_s;
    }
    if (notice_.watchdog_s()) {
        const double half = kWatchdogShare * *notice_.watchdog_s();
        period_s_ = period_s_ > 0.0 ? std::min(period_s_, half) : half;
    }
}

config::AdvertiseSettings Supervision::find_address() {
    config::AdvertiseSettings out = settings_.network.advertise;
    if (agones_) {
        const auto found = agones_->game_server();
        if (!found.ok()) {
            throw std::runtime_error(found.error());
        }
        // What the config names goes first.
        out.address = out.address.empty() ? found->address : out.address;
        out.tcp_port = out.tcp_port == 0 ? found->tcp_port : out.tcp_port;
        out.udp_port = out.udp_port == 0 ? found->udp_port : out.udp_port;
    }
    return out;
}

void Supervision::ready(const std::string& text) {
    notice_.send("READY=1\nSTATUS=" + text);
    if (agones_) {
        agones_->start();
    }
    if (period_s_ > 0.0) {
        look();
    }
}

void Supervision::arm() {
    timer_.expires_after(std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(period_s_)));
    timer_.async_wait([this](const asio::error_code& error) {
        if (!error && !ended_) {
            look();
        }
    });
}

/// A process that answers while its world stands still is not alive.
void Supervision::look() {
    const std::uint64_t turns = turns_();
    const bool moves = turns != last_turns_ || turns == 0;
    last_turns_ = turns;
    if (moves) {
        notice_.send("WATCHDOG=1");
        if (agones_) {
            agones_->alive();
        }
    } else if (!stuck_) {
        log_of(LogArea::kServer)
            .error("the world has not ticked for {} s: no sign of life is given", period_s_);
    }
    stuck_ = !moves;
    arm();
}

void Supervision::stopping(const std::string& why) {
    notice_.send("STOPPING=1\nSTATUS=stopping: " + why);
}

void Supervision::stopped() {
    ended_ = true;
    timer_.cancel();
    if (agones_) {
        agones_->shutdown();
    }
}

}  // namespace zoned::app
