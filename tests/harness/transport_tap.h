// TransportTap: a transport that passes everything on; a subclass reads or changes the downlink.
#pragma once

#include "client-sim/link/link.h"

#include <memory>
#include <string>
#include <utility>

namespace zoned::harness {

class TransportTap : public link::Transport {
  public:
    explicit TransportTap(std::unique_ptr<link::Transport> inner) : inner_(std::move(inner)) {}

    void set_events(link::TransportEvents events) final {
        events_ = std::move(events);
        link::TransportEvents heard;
        heard.opened = events_.opened;
        heard.frame = [this](link::Bytes frame) {
            on_frame(frame);
            events_.frame(std::move(frame));
        };
        heard.datagram = [this](link::Bytes datagram) {
            on_datagram(datagram);
            events_.datagram(std::move(datagram));
        };
        heard.closed = [this](std::string reason) {
            events_.closed(std::move(reason));
        };
        inner_->set_events(std::move(heard));
    }

    void open() final { inner_->open(); }

    void send_frame(link::Bytes frame) final { inner_->send_frame(std::move(frame)); }

    void set_udp(std::uint16_t udp_port, std::uint32_t connection_id) final {
        inner_->set_udp(udp_port, connection_id);
    }

    void send_datagram(link::Bytes datagram) final { inner_->send_datagram(std::move(datagram)); }

    void close() final { inner_->close(); }

  protected:
    /// Before the client hears of it.
    virtual void on_frame(link::Bytes& /*frame*/) {}

    virtual void on_datagram(link::Bytes& /*datagram*/) {}

  private:
    std::unique_ptr<link::Transport> inner_;
    link::TransportEvents events_;
};

}  // namespace zoned::harness
