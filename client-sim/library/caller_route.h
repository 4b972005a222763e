// CallerRoute: the way to a server by a WebSocket that the caller owns, such as a browser's.
#pragma once

#include "client-sim/library/game_route.h"

#include <cstdint>
#include <list>
#include <span>
#include <string>

namespace zoned::library {

/// A wish of the session to the caller's WebSocket.
enum class StreamWish : std::uint8_t {
    kNothing,
    kOpen,   ///< a new one; what is left of an old one is closed
    kClose,  ///< after the frames that wait
};

/// Both ends in one: the session's transport, and what the caller passes on.
class CallerRoute final : public GameRoute, public link::Transport {
  public:
    /// More frames than these wait for a caller who fetches none: the stream ends.
    static constexpr std::size_t kMostFrames = 4096;

    [[nodiscard]] link::Transport& transport() override { return *this; }

    [[nodiscard]] const std::string& trouble() const override { return trouble_; }

    void poll(double /*now_s*/) override {}

    void flush() override {}

    // ---- the caller's end
    /// Each wish is told once.
    StreamWish take_wish();
    void opened();
    void receive(std::span<const std::uint8_t> frame);
    void closed(const std::string& reason);

    /// The oldest frame to send; nullptr: none.
    [[nodiscard]] const link::Bytes* frame() const {
        return out_.empty() ? nullptr : &out_.front();
    }

    void drop_frame() { out_.pop_front(); }

    // ---- the session's end
    void set_events(link::TransportEvents events) override;
    void open() override;
    void send_frame(link::Bytes frame) override;

    void set_udp(std::uint16_t /*udp_port*/, std::uint32_t /*connection_id*/) override {}

    void send_datagram(link::Bytes /*datagram*/) override {}

    void close() override;

  private:
    std::string trouble_;
    link::TransportEvents events_;
    StreamWish wish_ = StreamWish::kNothing;
    bool wanted_ = false;  // the session has opened the stream and not closed it
    bool open_ = false;
    std::list<link::Bytes> out_;
};

}  // namespace zoned::library
