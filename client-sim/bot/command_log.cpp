#include "client-sim/bot/command_log.h"

namespace zoned::bot {

void CommandLog::on_sent(std::uint64_t sequence, Tick newest, std::size_t count) {
    if (sequence != 0) {
        packets_[sequence % kKept] = {sequence, newest, count};
    }
}

bool CommandLog::on_news(const link::UplinkNews& news) {
    if (news.sequence <= heard_) {
        return false;
    }
    heard_ = news.sequence;
    const Packet& packet = packets_[news.sequence % kKept];
    if (packet.sequence != news.sequence || packet.count == 0) {
        return false;
    }
    for (std::size_t i = 0; i < packet.count; ++i) {
        const Tick tick = packet.newest - static_cast<Tick>(i);
        if (tick < 0) {
            break;
        }
        Arrival& arrival = arrivals_[static_cast<std::size_t>(tick) % kKept];
        // News ascends by sequence, so the first is the earliest that is known.
        if (arrival.tick != tick) {
            arrival = {tick, news.server_receive_s};
        }
    }
    return true;
}

std::optional<double> CommandLog::arrival_s(Tick tick) const {
    if (tick < 0) {
        return std::nullopt;
    }
    const Arrival& arrival = arrivals_[static_cast<std::size_t>(tick) % kKept];
    return arrival.tick == tick ? std::optional<double>(arrival.server_s) : std::nullopt;
}

}  // namespace zoned::bot
