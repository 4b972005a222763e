#include "server/app/runtime/network.h"

#include "server/app/log/log.h"
#include "server/app/log/session_log.h"
#include "server/app/runtime/host_settings.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace zoned::app {

namespace {

static_assert(HeldOutput::kWithdrawnEvent == proto::CORE_EVENT_WITHDRAWN);

constexpr auto kTimerPeriod = std::chrono::milliseconds(50);
constexpr double kSessionsEvery_s = 0.075;  ///< at least, however slow the loop is
constexpr double kUnixTimePeriod = 60.0;
constexpr double kLoadEvery_s = 0.25;

/// Adds its own lifetime to a sum, s.
class TimeSum {
  public:
    explicit TimeSum(double& sum_s) : sum_s_(sum_s), begin_s_(steady_seconds()) {}

    ~TimeSum() { sum_s_ += steady_seconds() - begin_s_; }

    TimeSum(const TimeSum&) = delete;
    TimeSum& operator=(const TimeSum&) = delete;

  private:
    double& sum_s_;
    double begin_s_;
};

std::chrono::steady_clock::time_point steady_moment(double time_s) {
    using Clock = std::chrono::steady_clock;
    return Clock::time_point(
        std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(time_s)));
}

double unix_seconds() {
    using Clock = std::chrono::system_clock;
    return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

}  // namespace

Network::Network(asio::io_context& io,
                 const config::Settings& settings,
                 std::function<void(mailbox::InboxItem)> to_zones,
                 std::function<void(const session::LoginToStore&)> store_login,
                 std::function<std::optional<proto::Redirect>(const std::string&)> find_world)
    : to_zones_(std::move(to_zones)),
      udp_(io,
           udp_settings(settings),
           [this](std::span<const net::Datagram> datagrams) { on_datagrams(datagrams); }),
      tls_(io, tls_settings(settings), callbacks()),
      host_(host_settings(settings), output(std::move(store_login), std::move(find_world))),
      timer_(io),
      pacing_(io),
      reading_(io),
      gathering_(static_cast<std::size_t>(std::max(0, udp_.stats().receive_buffer_bytes))),
      tick_period_s_(1.0 / settings.tick_rate_hz) {
    host_.set_udp_port(udp_.port());
    if (settings.server.network.websocket_port) {
        origins_ = settings.server.network.websocket_origins;
        web_ = std::make_unique<net::TlsListener>(io, websocket_settings(settings), callbacks());
    }
}

void Network::allow_origins(std::vector<std::string> origins) {
    if (web_) {
        origins.insert(origins.end(), origins_.begin(), origins_.end());
        web_->set_origins(std::move(origins));
    }
}

net::TlsCallbacks Network::callbacks() {
    net::TlsCallbacks callbacks;
    callbacks.on_open =
        [this](
            net::StreamNumber stream, const mailbox::Address& from, bool loopback, double spent_s) {
            host_.on_stream_open(session::StreamId(stream), loopback, steady_seconds() - spent_s);
            host_.set_peer(session::StreamId(stream), from);
        };
    callbacks.on_websocket =
        [this](net::StreamNumber stream, const mailbox::Address& from, bool local, double spent_s) {
            host_.on_websocket_open(session::StreamId(stream), local, steady_seconds() - spent_s);
            host_.set_peer(session::StreamId(stream), from);
        };
    callbacks.on_frame = [this](net::StreamNumber stream, std::span<const std::uint8_t> frame) {
        host_.on_frame(session::StreamId(stream), frame, steady_seconds());
    };
    callbacks.on_closed = [this](net::StreamNumber stream, const std::string&) {
        host_.on_stream_closed(session::StreamId(stream), steady_seconds());
    };
    return callbacks;
}

session::SessionOutput Network::output(
    std::function<void(const session::LoginToStore&)> store_login,
    std::function<std::optional<proto::Redirect>(const std::string&)> find_world) {
    session::SessionOutput output;
    output.find_world = std::move(find_world);
    output.store_login = std::move(store_login);
    output.send_frame = [this](session::StreamId stream, session::Bytes frame) {
        listener_of(stream).send(stream.value, frame);
    };
    output.send_long_frame =
        [this](session::StreamId stream, session::Bytes head, session::SharedBytes tail) {
            listener_of(stream).send(stream.value, head, std::move(tail));
        };
    output.note = [](const session::SessionNote& note) {
        log_session(note);
    };
    output.close_stream = [this](session::StreamId stream) {
        listener_of(stream).close(stream.value);
    };
    output.send_datagram = [this](const mailbox::Address& to, session::Bytes datagram) {
        udp_.queue_send(to, datagram);
        host_.recycle(std::move(datagram));
    };
    output.to_zones = [this](mailbox::InboxItem item) {
        to_zones_(std::move(item));
    };
    output.stream_backlog = [this](session::StreamId stream) {
        return listener_of(stream).backlog(stream.value);
    };
    return output;
}

std::map<std::string, std::uint64_t> Network::rejected() const {
    std::map<std::string, std::uint64_t> counts = host_.stats().rejected;
    net::add_refusals(tls(), counts);
    net::add_refusals(web(), counts);
    return counts;
}

void Network::start() {
    host_.set_unix_time(unix_seconds(), steady_seconds());
    unix_time_set_s_ = steady_seconds();
    udp_.start();
    tls_.start();
    if (web_) {
        web_->start();
    }
    arm_timer();
}

void Network::arm_timer() {
    timer_.expires_after(kTimerPeriod);
    timer_.async_wait([this](const asio::error_code& error) {
        if (error || closing_) {
            return;
        }
        const double now = steady_seconds();
        if (now - unix_time_set_s_ > kUnixTimePeriod) {
            host_.set_unix_time(unix_seconds(), now);
            unix_time_set_s_ = now;
        }
        if (now - sessions_seen_s_ > kSessionsEvery_s) {
            look_at_sessions();  // the loop stands still, or is slow
        }
        arm_timer();
    });
}

void Network::deliver(TickResult result) {
    if (closing_) {
        return;
    }
    look_at_load(result.load);
    const TimeSum sum(load_.io_s);
    tick_ = result.tick;
    clock_origin_s_ = result.clock_origin_s;
    for (const mailbox::OutboxItem& item : result.items) {
        held_.take(item, result.tick, result.store, [this](const auto& one) { send(one); });
    }
    look_at_sessions();
    arm_pacing();
    next_tick_s_ = result.next_due_s;
    gathering_.begin_tick(udp_.stats().received, steady_seconds());
    gather();
}

void Network::look_at_sessions() {
    sessions_seen_s_ = steady_seconds();
    host_.tick(sessions_seen_s_, tick_);
    udp_.flush();
}

void Network::on_datagrams(std::span<const net::Datagram> datagrams) {
    const TimeSum sum(load_.io_s);
    const double now = steady_seconds();
    // The newest first: where this thread is behind, the oldest are worth nothing.
    host_.begin_datagrams(gathered_s_);
    for (auto datagram = datagrams.rbegin(); datagram != datagrams.rend(); ++datagram) {
        host_.on_datagram(datagram->from, datagram->bytes, now, std::min(now, datagram->arrived_s));
    }
    udp_.flush();
    if (gathered_s_ == 0.0 && tick_begun_ && tick_begun_() > tick_ &&
        gathering_.are_many(tick_period_s_)) {
        await_output();
    }
}

void Network::gather() {
    const double now = steady_seconds();
    const double until = gathering_.hold_until(now, next_tick_s_);
    if (until > now) {
        udp_.hold();
        read_at(until, [this] { gather(); });
        return;
    }
    udp_.watch();
}

void Network::await_output() {
    udp_.hold();
    read_at(steady_seconds() + tick_period_s_, [this] { udp_.watch(); });  // a slow tick
}

void Network::read_at(double time_s, std::function<void()> then) {
    const double since_s = steady_seconds();
    reading_.expires_at(steady_moment(time_s));
    reading_.async_wait([this, since_s, time_s, then = std::move(then)](const auto& error) {
        if (error || closing_) {
            return;
        }
        gathered_s_ = time_s - since_s;
        udp_.read();
        gathered_s_ = 0.0;
        gathering_.note_reading(time_s, steady_seconds());
        then();
    });
}

/// TLS handshakes do not count: that many come at once is no reason to refuse those who come.
void Network::look_at_load(double loop_load) {
    const double now = steady_seconds();
    LoadSums& sums = load_;
    sums.loop_load += loop_load;
    ++sums.ticks;
    const double since_s = now - sums.begin_s;
    if (sums.begin_s >= 0.0 && since_s < kLoadEvery_s) {
        return;
    }
    if (sums.begin_s >= 0.0) {
        host_.measured(std::max(sums.io_s / since_s, sums.loop_load / sums.ticks), now);
    }
    const session::HostStats& stats = host_.stats();
    const bool narrowed = std::isfinite(stats.ceiling_bytes_per_s);
    if (stats.refusing != sums.refusing) {
        log_of(LogArea::kNetwork)
            .warn("overload{}: logins are {} (load {:.2f}, {} sessions; network.max_load)",
                  stats.refusing ? "" : " over",
                  stats.refusing ? "refused" : "taken again",
                  stats.load,
                  stats.sessions);
    }
    if (narrowed != sums.narrowed) {
        log_of(LogArea::kNetwork)
            .warn("overload{}: clients get {} (load {:.2f}, {} sessions)",
                  narrowed ? "" : " over",
                  narrowed ? "fewer bytes than they ask for" : "all the bytes that they may",
                  stats.load,
                  stats.sessions);
    }
    sums = {now, 0.0, 0, 0.0, stats.refusing, narrowed};
}

void Network::send(const mailbox::OutboxItem& item) {
    if (const auto* done = std::get_if<mailbox::OrderDone>(&item)) {
        if (order_done_) {
            order_done_(*done);
        }
        return;
    }
    const double now = steady_seconds();
    host_.on_outbox(item, now, now - clock_origin_s_);
}

void Network::on_durable(std::uint64_t number) {
    held_.stored(number, [this](const auto& item) { send(item); });
}

void Network::on_journaled(Tick tick) {
    held_.journaled(tick, [this](const auto& item) { send(item); });
}

void Network::arm_pacing() {
    const double wait_s = host_.next_release_s() - steady_seconds();
    if (!std::isfinite(wait_s)) {
        return;
    }
    pacing_.expires_after(std::chrono::duration_cast<std::chrono::steady_clock::duration>(
        std::chrono::duration<double>(std::max(0.0, wait_s))));
    pacing_.async_wait([this](const asio::error_code& error) {
        if (error || closing_) {
            return;
        }
        const TimeSum sum(load_.io_s);
        const double now = steady_seconds();
        host_.release(now, now - clock_origin_s_);
        udp_.flush();
        arm_pacing();
    });
}

void Network::shutdown(const std::string& text) {
    tls_.stop_accepting();
    if (web_) {
        web_->stop_accepting();
    }
    host_.shutdown(text);
    udp_.flush();
}

void Network::close() {
    closing_ = true;
    timer_.cancel();
    pacing_.cancel();
    reading_.cancel();
    tls_.abort_all();
    if (web_) {
        web_->abort_all();
    }
    udp_.close();
}

}  // namespace zoned::app
