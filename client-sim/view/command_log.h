// CommandLog: the packet that carried each command, and the time at which the server had it.
#pragma once

#include "client-sim/link/datagram_channel.h"
#include "shared/core/ids.h"

#include <array>
#include <cstdint>
#include <optional>

namespace zoned::view {

/// Log of the newest kKept packets and commands of one client. The server reports the arrival of a
/// datagram only for the newest at the time. Nothing is known of the commands of other datagrams,
/// with one exception. Commands whose own packets had not come by then (lost, or overtaken) came
/// with that newest one.
class CommandLog {
  public:
    static constexpr std::size_t kKept = 256;

    /// A packet with the `count` commands up to tick `newest` left, so long after the newest was
    /// due: a client makes commands when it is polled. Sequence 0: it was not sent.
    void on_sent(std::uint64_t sequence, Tick newest, std::size_t count, double made_late_s);

    /// True when `news` is new and reports a packet of commands. `late` is then the number of
    /// commands that came first with this packet although earlier packets had carried them, and
    /// `made_late_s` what on_sent() was told of it.
    bool on_update(const link::UplinkUpdate& update, std::size_t& late, double& made_late_s);

    /// When the server had the command for a tick, by its clock; none when that is not known.
    [[nodiscard]] std::optional<double> arrival_s(Tick tick) const;

    void clear() { *this = {}; }

  private:
    struct CommandPacket {
        std::uint64_t sequence = 0;
        Tick newest = -1;
        std::size_t count = 0;
        double made_late_s = 0.0;
    };

    struct CommandArrival {
        Tick tick = -1;
        double server_s = 0.0;
    };

    std::array<CommandPacket, kKept> packets_{};
    std::array<CommandArrival, kKept> arrivals_{};
    std::uint64_t heard_ = 0;
};

}  // namespace zoned::view
