// Network: sockets and sessions on one thread; it exchanges only messages with the tick loop.
#pragma once

#include "server/app/runtime/host_settings.h"
#include "server/app/runtime/tick_loop.h"
#include "server/config/settings.h"
#include "server/net/gather_schedule.h"
#include "server/net/tls_listener.h"
#include "server/net/udp_endpoint.h"
#include "server/session/host/session_host.h"

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::app {

/// The sums that a load is measured from.
struct LoadSums {
    double begin_s = -1.0;   ///< below 0: nothing is measured yet
    double loop_load = 0.0;  ///< of ticks
    unsigned ticks = 0;
    double io_s = 0.0;      ///< time with datagrams, from clients and to them
    bool refusing = false;  ///< as it was told
    bool narrowed = false;  ///< the same
};

class Network {
  public:
    /// Binds; throws std::system_error or std::runtime_error with a text for the operator.
    /// `to_zones` is called on the network thread.
    Network(asio::io_context& io,
            const config::Settings& settings,
            std::function<void(mailbox::InboxItem)> to_zones,
            std::function<void(const session::LoginToStore&)> store_login = {},
            std::function<std::optional<proto::Redirect>(const std::string&)> find_world = {});

    void start();
    /// Called on the network thread with the output of a tick.
    void deliver(TickResult result);
    /// The store has come to this number: durable events that waited for it leave.
    void on_durable(std::uint64_t number);

    /// The newest tick that has taken its inputs; called on the network thread. Those that come
    /// while it runs may wait for its output.
    void set_tick_begun(std::function<Tick()> tick_begun) { tick_begun_ = std::move(tick_begun); }

    /// From here on what is told once waits for the journal, which holds inputs up to this tick.
    void await_journal(Tick kept) { held_.await_journal(kept); }

    /// The journal holds the inputs up to this tick: what waited for them leaves.
    void on_journaled(Tick tick);

    /// The sessions, for what an operator asks; on the network thread only.
    [[nodiscard]] session::SessionHost& host() { return host_; }

    /// Called on the network thread with the answers of the zones to an operator's orders.
    void set_order_done(std::function<void(const mailbox::OrderDone&)> done) {
        order_done_ = std::move(done);
    }

    /// Tells all clients why the server closes.
    void shutdown(const std::string& text);
    /// Closes the sockets.
    void close();

    [[nodiscard]] std::uint16_t tcp_port() const { return tls_.port(); }

    [[nodiscard]] std::uint16_t udp_port() const { return udp_.port(); }

    /// 0: no WebSockets are taken.
    [[nodiscard]] std::uint16_t websocket_port() const { return web_ ? web_->port() : 0; }

    /// Pages of these sites may open WebSockets besides those of network.websocket_origin. On the
    /// network thread, or before start().
    void allow_origins(std::vector<std::string> origins);

    [[nodiscard]] const std::string& fingerprint() const { return tls_.fingerprint(); }

    [[nodiscard]] std::size_t connections() const { return tls_.connections() + websockets(); }

    [[nodiscard]] std::size_t websockets() const { return web_ ? web_->connections() : 0; }

    [[nodiscard]] const session::HostStats& sessions() const { return host_.stats(); }

    /// Refusals by reason: of sessions, and of connections before they are one.
    [[nodiscard]] std::map<std::string, std::uint64_t> rejected() const;

    [[nodiscard]] session::RttPercentiles rtt() const { return host_.rtt_percentiles(); }

    /// The output that waits for the store or the journal, and durable events that were not sent
    /// because the store refused what they tell.
    [[nodiscard]] const HeldOutput& held_output() const { return held_; }

    [[nodiscard]] const net::UdpStats& udp() const { return udp_.stats(); }

    [[nodiscard]] const net::TlsStats& tls() const { return tls_.stats(); }

    /// Of the WebSockets; empty where none are taken.
    [[nodiscard]] net::TlsStats web() const { return web_ ? web_->stats() : net::TlsStats{}; }

  private:
    void arm_timer();
    /// Times of sessions that are due.
    void look_at_sessions();
    /// Measures the load a few times a second, and tells when it begins or ends to matter.
    void look_at_load(double loop_load);
    void send(const mailbox::OutboxItem& item);
    /// Sends the packets that are spread over a tick, when they are due.
    void arm_pacing();
    void on_datagrams(std::span<const net::Datagram> datagrams);
    /// Lets datagrams wait until they have to be read, again and again until the tick is due.
    void gather();
    /// Datagrams that come while a tick runs are for the next one, and wait for its output.
    void await_output();
    void read_at(double time_s, std::function<void()> then);
    session::SessionOutput output(
        std::function<void(const session::LoginToStore&)> store_login,
        std::function<std::optional<proto::Redirect>(const std::string&)> find_world);
    net::TlsCallbacks callbacks();

    /// The listener whose stream it is.
    [[nodiscard]] net::TlsListener& listener_of(session::StreamId stream) {
        return web_ && stream.value > kWebSocketStreams ? *web_ : tls_;
    }

    std::function<void(mailbox::InboxItem)> to_zones_;
    std::function<void(const mailbox::OrderDone&)> order_done_;
    std::function<Tick()> tick_begun_;
    net::UdpEndpoint udp_;
    net::TlsListener tls_;
    std::unique_ptr<net::TlsListener> web_;  ///< nullptr: no WebSockets
    std::vector<std::string> origins_;       ///< of network.websocket_origin
    session::SessionHost host_;
    asio::steady_timer timer_;
    asio::steady_timer pacing_;
    asio::steady_timer reading_;
    net::GatherSchedule gathering_;
    Tick tick_ = 0;
    LoadSums load_;
    HeldOutput held_;
    double clock_origin_s_ = 0.0;  ///< steady clock minus this = server time
    double unix_time_set_s_ = 0.0;
    double sessions_seen_s_ = 0.0;
    double next_tick_s_ = 0.0;  // steady clock: when it is due
    double tick_period_s_ = 0.0;
    double gathered_s_ = 0.0;  // for which the datagrams being read waited on purpose
    bool closing_ = false;
};

}  // namespace zoned::app
