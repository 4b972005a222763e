// HandshakeQueue: accepted connections before their handshake: until the client's first message is
// there, and then until it is their turn.
#pragma once

#include "server/mailbox/network_key.h"
#include "server/net/socket_address.h"

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>

namespace zoned::net {

using mailbox::NetworkKey;

struct HandshakeQueueSettings {
    bool tls = true;          ///< the first message is a TLS record; else any byte counts as one
    double timeout_s = 10.0;  ///< for the first message
    double starts_per_s = 500.0;  ///< handshakes; one second's worth may come at once
};

/// Nothing but a socket waits here, a few hundred bytes each: whoever connects and sends nothing,
/// or a piece of a message, costs no handshake and nobody's turn. Those whose message is there
/// start at the allowed rate, network by network in turn, so that a flood from one delays the
/// others by one handshake. Not thread-safe: driven by the thread of its io_context.
class HandshakeQueue : public std::enable_shared_from_this<HandshakeQueue> {
  public:
    enum class Left : std::uint8_t {
        kClosed,  ///< by the client, before its message was there
        kTimeout,
        kNoTls,  ///< the first bytes begin no handshake
    };

    using Clock = std::chrono::steady_clock;

    struct Callbacks {
        /// `spent`: how long the client took for its first message; waiting for a turn is not its
        /// fault.
        std::function<void(asio::ip::tcp::socket, const Address&, Clock::duration spent)> start;
        std::function<void(const Address&, Left)> left;
    };

    HandshakeQueue(asio::io_context& io,
                   const HandshakeQueueSettings& settings,
                   Callbacks callbacks);

    void add(asio::ip::tcp::socket socket, const Address& peer);

    [[nodiscard]] std::size_t size() const { return waiting_.size() + ready_count_; }

    /// Closes all that wait, without callbacks. None will come any more.
    void clear();

  private:
    using Number = std::uint64_t;  ///< in the order of arrival

    struct Waiting {
        asio::ip::tcp::socket socket;
        Address peer;
        Clock::time_point since;
        Clock::duration spent{};
    };

    void wait_for_bytes(Number number);
    void look(Number number);
    void be_ready(Number number);
    void leave(Number number, Left why);
    [[nodiscard]] Clock::duration patience() const;
    void sweep();
    void arm_sweep();
    void start_those_due();
    [[nodiscard]] Clock::duration turn_wait();

    HandshakeQueueSettings settings_;
    Callbacks callbacks_;
    asio::steady_timer sweep_timer_;
    asio::steady_timer turn_timer_;
    Number last_ = 0;
    std::map<Number, Waiting> waiting_;                ///< for their message
    std::map<NetworkKey, std::deque<Waiting>> ready_;  ///< none is empty
    std::deque<NetworkKey> turns_;                     ///< keys of ready_
    std::size_t ready_count_ = 0;
    /// When the handshakes started so far would all be due at the allowed rate.
    Clock::time_point next_start_ = Clock::now();
};

}  // namespace zoned::net
