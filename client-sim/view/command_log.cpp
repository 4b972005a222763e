#include "client-sim/view/command_log.h"

#include <algorithm>

namespace zoned::view {

void CommandLog::on_sent(std::uint64_t sequence,
                         Tick newest,
                         std::size_t count,
                         double made_late_s) {
    if (sequence != 0) {
        packets_[sequence % kKept] = {sequence, newest, count, made_late_s};
    }
}

bool CommandLog::on_update(const link::UplinkUpdate& update,
                           std::size_t& late,
                           double& made_late_s) {
    if (update.sequence <= heard_) {
        return false;
    }
    heard_ = update.sequence;
    const CommandPacket& packet = packets_[update.sequence % kKept];
    if (packet.sequence != update.sequence || packet.count == 0) {
        return false;
    }
    // Packets are sent one a tick; where that was not so, a few arrivals more stay unknown.
    made_late_s = packet.made_late_s;
    late = std::min(update.missed_before, packet.count - 1);
    for (std::size_t i = 0; i <= late; ++i) {
        const Tick tick = packet.newest - static_cast<Tick>(i);
        if (tick < 0) {
            break;
        }
        CommandArrival& arrival = arrivals_[static_cast<std::size_t>(tick) % kKept];
        if (arrival.tick != tick) {
            arrival = {tick, update.server_receive_s};
        }
    }
    return true;
}

std::optional<double> CommandLog::arrival_s(Tick tick) const {
    if (tick < 0) {
        return std::nullopt;
    }
    const CommandArrival& arrival = arrivals_[static_cast<std::size_t>(tick) % kKept];
    return arrival.tick == tick ? std::optional<double>(arrival.server_s) : std::nullopt;
}

}  // namespace zoned::view
