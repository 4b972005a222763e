// VirtualTransport: one client's stream and UDP path through a conditioned virtual network.
#pragma once

#include "client-sim/link/conditioner.h"
#include "client-sim/link/link.h"
#include "server/session/host/session_host.h"

namespace zoned::harness {

class VirtualServer;

class VirtualTransport final : public link::Transport {
  public:
    VirtualTransport(VirtualServer& server, std::uint32_t number);
    ~VirtualTransport() override;

    void set_events(link::TransportEvents events) override { events_ = std::move(events); }

    void open() override;
    void send_frame(link::Bytes frame) override;
    void set_udp(std::uint16_t udp_port, std::uint32_t connection_id) override;
    void send_datagram(link::Bytes datagram) override;
    void close() override;

    // The server's side of the path.
    void push_frame(double now_s, link::Bytes frame) { frames_down_.push(now_s, std::move(frame)); }

    void push_datagram(double now_s, link::Bytes datagram) {
        datagrams_down_.push(now_s, std::move(datagram));
    }

    /// Everything passes at once from now on, in both directions.
    void heal() {
        for (link::Conditioner* path :
             {&frames_up_, &frames_down_, &datagrams_up_, &datagrams_down_}) {
            path->heal();
        }
    }

    /// The path of datagrams from the server to this client.
    [[nodiscard]] link::Conditioner& down() { return datagrams_down_; }

    /// The server ends the stream after the frames before.
    void end_stream() { ending_ = true; }

    void cut();
    void deliver_up(double now_s);
    void deliver_down(double now_s);

    [[nodiscard]] session::StreamId stream() const { return stream_; }

    [[nodiscard]] const mailbox::Address& address() const { return address_; }

  private:
    VirtualServer* server_;
    link::TransportEvents events_;
    mailbox::Address address_;
    session::StreamId stream_;
    bool opening_ = false;
    bool opened_ = false;
    bool ending_ = false;
    bool cut_ = false;
    link::Conditioner frames_up_;
    link::Conditioner frames_down_;
    link::Conditioner datagrams_up_;
    link::Conditioner datagrams_down_;
};

}  // namespace zoned::harness
