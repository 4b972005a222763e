// CommandLog: which packet carried a command, and when the server had it.
#pragma once

#include "client-sim/link/datagram_channel.h"
#include "shared/core/ids.h"

#include <array>
#include <cstdint>
#include <optional>

namespace zoned::bot {

/// Of the newest kKept packets and commands of one client. The server says when a datagram came
/// only of the newest at the time: of the commands of others nothing is known, but for those whose
/// own packets had not come by then (lost, or overtaken): they came with that one.
class CommandLog {
  public:
    static constexpr std::size_t kKept = 256;

    /// A packet with the `count` commands up to tick `newest` left. Sequence 0: it did not.
    void on_sent(std::uint64_t sequence, Tick newest, std::size_t count);

    /// True when `news` is of a packet of commands and had not been heard before; `late` is then
    /// how many commands came first with this packet although they had been sent before it.
    bool on_update(const link::UplinkUpdate& update, std::size_t& late);

    /// When the server had the command for a tick, by its clock; none when that is not known.
    [[nodiscard]] std::optional<double> arrival_s(Tick tick) const;

    void clear() { *this = {}; }

  private:
    struct CommandPacket {
        std::uint64_t sequence = 0;
        Tick newest = -1;
        std::size_t count = 0;
    };

    struct CommandArrival {
        Tick tick = -1;
        double server_s = 0.0;
    };

    std::array<CommandPacket, kKept> packets_{};
    std::array<CommandArrival, kKept> arrivals_{};
    std::uint64_t heard_ = 0;
};

}  // namespace zoned::bot
