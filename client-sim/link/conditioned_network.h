// ConditionedNetwork: a SocketNetwork whose paths are made bad on purpose.
#pragma once

#include "client-sim/link/conditioner.h"
#include "client-sim/link/socket_transport.h"

#include <memory>
#include <string>
#include <vector>

namespace zoned::link {

class ConditionedTransport;

/// Drive it as a SocketNetwork. Every message passes a conditioner of its transport, where the
/// settings change anything.
class ConditionedNetwork {
  public:
    ConditionedNetwork(NetworkSettings settings, const ConditionerSettings& conditioner);

    /// Must end before the network.
    [[nodiscard]] std::unique_ptr<Transport> make_transport();

    void poll(double now_s);
    void flush();

    [[nodiscard]] const SocketNetwork& sockets() const { return sockets_; }

    /// Traffic of the bottlenecks of all connected clients in one direction, until the last poll.
    [[nodiscard]] std::vector<BottleneckMeter> bottlenecks(Direction direction) const;

  private:
    friend class ConditionedTransport;

    SocketNetwork sockets_;
    ConditionerSettings settings_;
    std::vector<ConditionedTransport*> transports_;
    std::uint64_t made_ = 0;
    double now_s_ = 0.0;
};

}  // namespace zoned::link
