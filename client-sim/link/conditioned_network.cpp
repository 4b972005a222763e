#include "client-sim/link/conditioned_network.h"

#include <utility>

namespace zoned::link {

class ConditionedTransport final : public Transport {
  public:
    ConditionedTransport(ConditionedNetwork& network, std::uint64_t index);
    ~ConditionedTransport() override;
    ConditionedTransport(const ConditionedTransport&) = delete;
    ConditionedTransport& operator=(const ConditionedTransport&) = delete;

    void set_events(TransportEvents events) override;
    void open() override;
    void send_frame(Bytes frame) override;
    void set_udp(std::uint16_t udp_port, std::uint32_t connection_id) override;
    void send_datagram(Bytes datagram) override;
    void close() override;

    void prepare(const std::string& host,
                 std::uint16_t port,
                 const std::string& certificate_sha256) override {
        inner_->prepare(host, port, certificate_sha256);
    }

    [[nodiscard]] bool prepared() const override { return inner_->prepared(); }

    bool redirect(const std::string& host,
                  std::uint16_t port,
                  const std::string& certificate_sha256) override;

    /// Delivers the messages that are due at `now_s`, both directions.
    void release(double now_s);

    [[nodiscard]] const Conditioner& path(Direction direction) const {
        return direction == Direction::kUp ? up_datagrams_ : down_datagrams_;
    }

    [[nodiscard]] bool has_peer() const { return has_peer_; }

  private:
    void deliver_frames(double now_s);
    void send_last_frames();

    ConditionedNetwork& network_;
    TransportEvents events_;
    bool has_peer_ = false;
    Conditioner up_datagrams_;
    Conditioner down_datagrams_;
    Conditioner up_frames_;
    Conditioner down_frames_;
    std::unique_ptr<Transport> inner_;  // ends first: it calls the others
};

ConditionedTransport::ConditionedTransport(ConditionedNetwork& network, std::uint64_t index)
    : network_(network),
      up_datagrams_(network.settings_, Conditioner::Mode::kDatagrams, 4 * index),
      down_datagrams_(network.settings_,
                      Conditioner::Mode::kDatagrams,
                      4 * index + 1,
                      Direction::kDown),
      up_frames_(network.settings_, Conditioner::Mode::kFrames, 4 * index + 2),
      down_frames_(network.settings_, Conditioner::Mode::kFrames, 4 * index + 3),
      inner_(network.sockets_.make_transport()) {
    network_.transports_.push_back(this);
}

ConditionedTransport::~ConditionedTransport() {
    std::erase(network_.transports_, this);
}

void ConditionedTransport::set_events(TransportEvents events) {
    events_ = std::move(events);
    TransportEvents inner;
    inner.opened = events_.opened;
    inner.frame = [this](Bytes frame) {
        down_frames_.push(network_.now_s_, std::move(frame));
    };
    inner.datagram = [this](Bytes datagram) {
        down_datagrams_.push(network_.now_s_, std::move(datagram));
    };
    inner.closed = [this](std::string reason) {
        // Messages that the server sent before it closed still count, the goodbye above all.
        deliver_frames(1e300);
        if (events_.closed) {
            events_.closed(std::move(reason));
        }
    };
    inner_->set_events(std::move(inner));
}

void ConditionedTransport::deliver_frames(double now_s) {
    Bytes frame;
    while (down_frames_.pop_due(now_s, frame)) {
        if (events_.frame) {
            events_.frame(std::move(frame));
        }
    }
}

void ConditionedTransport::open() {
    up_frames_.clear();
    down_frames_.clear();
    inner_->open();
}

void ConditionedTransport::send_frame(Bytes frame) {
    up_frames_.push(network_.now_s_, std::move(frame));
}

void ConditionedTransport::set_udp(std::uint16_t udp_port, std::uint32_t connection_id) {
    if (!std::exchange(has_peer_, true)) {
        up_datagrams_.restart_bottleneck_meter(network_.now_s_);
        down_datagrams_.restart_bottleneck_meter(network_.now_s_);
    }
    inner_->set_udp(udp_port, connection_id);
}

void ConditionedTransport::send_datagram(Bytes datagram) {
    up_datagrams_.push(network_.now_s_, std::move(datagram));
}

void ConditionedTransport::send_last_frames() {
    Bytes frame;
    while (up_frames_.pop_due(1e300, frame)) {
        inner_->send_frame(std::move(frame));
    }
    down_frames_.clear();
}

void ConditionedTransport::close() {
    send_last_frames();
    inner_->close();
}

bool ConditionedTransport::redirect(const std::string& host,
                                    std::uint16_t port,
                                    const std::string& certificate_sha256) {
    send_last_frames();
    return inner_->redirect(host, port, certificate_sha256);
}

void ConditionedTransport::release(double now_s) {
    Bytes bytes;
    while (up_datagrams_.pop_due(now_s, bytes)) {
        inner_->send_datagram(std::move(bytes));
    }
    while (up_frames_.pop_due(now_s, bytes)) {
        inner_->send_frame(std::move(bytes));
    }
    while (down_datagrams_.pop_due(now_s, bytes)) {
        if (events_.datagram) {
            events_.datagram(std::move(bytes));
        }
    }
    deliver_frames(now_s);
}

ConditionedNetwork::ConditionedNetwork(NetworkSettings settings,
                                       const ConditionerSettings& conditioner)
    : sockets_(std::move(settings)),
      settings_(conditioner) {
}

std::unique_ptr<Transport> ConditionedNetwork::make_transport() {
    if (settings_.active()) {
        return std::make_unique<ConditionedTransport>(*this, made_++);
    }
    return sockets_.make_transport();
}

void ConditionedNetwork::poll(double now_s) {
    now_s_ = now_s;
    sockets_.poll(now_s);
    for (ConditionedTransport* transport : transports_) {
        transport->release(now_s);
    }
}

void ConditionedNetwork::flush() {
    for (ConditionedTransport* transport : transports_) {
        transport->release(now_s_);
    }
    sockets_.flush();
}

std::vector<BottleneckMeter> ConditionedNetwork::bottlenecks(Direction direction) const {
    std::vector<BottleneckMeter> meters;
    for (const ConditionedTransport* transport : transports_) {
        if (transport->has_peer()) {
            meters.push_back(transport->path(direction).bottleneck(now_s_));
        }
    }
    return meters;
}

}  // namespace zoned::link
