#include "tests/harness/virtual_transport.h"

#include "tests/harness/virtual_server.h"

namespace zoned::harness {

VirtualTransport::VirtualTransport(VirtualServer& server, std::uint32_t number)
    : server_(&server),
      frames_up_(server.settings_.network, link::Conditioner::Mode::kFrames, 4ULL * number),
      frames_down_(server.settings_.network, link::Conditioner::Mode::kFrames, 4ULL * number + 1),
      datagrams_up_(server.settings_.network,
                    link::Conditioner::Mode::kDatagrams,
                    4ULL * number + 2),
      datagrams_down_(server.settings_.network,
                      link::Conditioner::Mode::kDatagrams,
                      4ULL * number + 3,
                      link::Direction::kDown) {
    address_.ip[15] = 1;
    address_.ip[11] = static_cast<std::uint8_t>(number >> 16U);
    address_.ip[12] = static_cast<std::uint8_t>(number >> 8U);
    address_.ip[13] = static_cast<std::uint8_t>(number);
    address_.port = 40000;
    server.transports_.push_back(this);
    server.addresses_[address_] = this;
}

VirtualTransport::~VirtualTransport() {
    std::erase(server_->transports_, this);
    server_->addresses_.erase(address_);
    server_->streams_.erase(stream_.value);
}

void VirtualTransport::open() {
    opening_ = true;
}

void VirtualTransport::send_frame(link::Bytes frame) {
    if (opened_) {
        frames_up_.push(server_->now_s(), std::move(frame));
    }
}

void VirtualTransport::set_udp(std::uint16_t, std::uint32_t) {
}

void VirtualTransport::send_datagram(link::Bytes datagram) {
    datagrams_up_.push(server_->now_s(), std::move(datagram));
}

void VirtualTransport::close() {
    if (stream_) {
        // Frames sent before the end still arrive: the server sees the end only after them.
        link::Bytes frame;
        while (frames_up_.pop_due(1e300, frame)) {
            server_->host_->on_frame(stream_, frame, server_->now_s());
        }
        const session::StreamId ended = stream_;
        server_->streams_.erase(stream_.value);
        stream_ = {};
        opened_ = false;
        server_->host_->on_stream_closed(ended, server_->now_s());
    }
}

void VirtualTransport::cut() {
    if (!stream_) {
        return;
    }
    const session::StreamId ended = stream_;
    server_->streams_.erase(stream_.value);
    stream_ = {};
    opened_ = false;
    cut_ = true;
    frames_up_.clear();
    frames_down_.clear();
    server_->host_->on_stream_closed(ended, server_->now_s());
}

void VirtualTransport::deliver_up(double now_s) {
    if (opening_) {
        opening_ = false;
        stream_ = session::StreamId(++server_->next_stream_);
        server_->streams_[stream_.value] = this;
        ending_ = false;
        opened_ = true;
        server_->host_->on_stream_open(stream_, true, now_s);
        if (events_.opened) {
            events_.opened(false);
        }
    }
    link::Bytes bytes;
    while (stream_ && frames_up_.pop_due(now_s, bytes)) {
        server_->host_->on_frame(stream_, bytes, now_s);
    }
    while (datagrams_up_.pop_due(now_s, bytes)) {
        server_->host_->on_datagram(address_, bytes, now_s);
    }
}

void VirtualTransport::deliver_down(double now_s) {
    link::Bytes bytes;
    while (frames_down_.pop_due(now_s, bytes)) {
        events_.frame(std::move(bytes));
    }
    while (datagrams_down_.pop_due(now_s, bytes)) {
        events_.datagram(std::move(bytes));
    }
    if (cut_) {
        cut_ = false;
        events_.closed("the stream was cut");
    }
    if (ending_ && frames_down_.next_due_s() > 1e299) {
        ending_ = false;
        if (stream_) {
            const session::StreamId ended = stream_;
            server_->streams_.erase(stream_.value);
            stream_ = {};
            opened_ = false;
            server_->host_->on_stream_closed(ended, now_s);
        }
        events_.closed("");
    }
}

}  // namespace zoned::harness
