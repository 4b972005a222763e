#include "client-sim/view/input_stream.h"

#include "shared/wire/packet.h"

#include <algorithm>
#include <cmath>

namespace zoned::view {

namespace {

/// Rounding of seconds counted in ticks.
constexpr double kSameTick = 1e-6;

}  // namespace

void InputStream::restart(double tick_s) {
    tick_s_ = tick_s;
    lead_.reset();
    log_.clear();
    notified_tick_ = -1;
    next_ = -1;
}

/// In ticks: the command for the tick that this has reached is due.
double InputStream::position(const link::Client& client, double now_s) const {
    return (client.clock().server_time(now_s) + lead_s()) / tick_s_;
}

double InputStream::due_in_s(const link::Client& client, double now_s) const {
    return (static_cast<double>(next_) - position(client, now_s)) * tick_s_;
}

double InputStream::fraction(const link::Client& client, double now_s) const {
    return std::clamp(position(client, now_s) - static_cast<double>(next_ - 1), 0.0, 1.0);
}

void InputStream::advance(link::Client& client,
                          OwnAvatar& own,
                          double now_s,
                          const Decide& decide) {
    if (!lead_) {
        lead_.emplace(tick_s_);
        lead_->begin(client.clock().rtt_s(), now_s);
    }
    lead_->set_loss(client.uplink().loss);
    lead_->advance(now_s);
    const auto target = static_cast<Tick>(std::floor(position(client, now_s) + kSameTick));
    if (next_ < 0 || target - next_ > clock::InputLead::kMostTicks) {
        next_ = target;  // the beginning, or a stall of this process: the past is over
    }
    if (next_ > target) {
        return;
    }
    for (; next_ <= target; ++next_) {
        motion::InputCommand command = decide(next_);
        command.tick = next_;
        own.push(command);
    }
    body_.clear();
    const auto newest = own.newest_commands(kCommandsPerPacket);
    wire::write_commands(newest, body_);
    const double late_ticks = position(client, now_s) - static_cast<double>(own.newest_tick());
    log_.on_sent(client.send_input(body_, now_s),
                 own.newest_tick(),
                 newest.size(),
                 std::max(0.0, late_ticks) * tick_s_);
}

void InputStream::on_report(const wire::OwnState& own, double rtt_s) {
    if (!lead_) {
        return;
    }
    if (notified_tick_ >= 0 && own.input_tick > notified_tick_) {
        // The server reports only some ticks, but always the first missed one. Between two missed
        // ticks, all were missed.
        const auto ticks = static_cast<std::uint64_t>(own.input_tick - notified_tick_);
        stats_.ticks += ticks;
        stats_.missing += own.input_missing ? (notified_missing_ ? ticks : 1) : 0;
        lead_->on_feedback(own.input_missing, rtt_s);
    }
    if (notified_tick_ >= 0 || !own.input_missing) {
        notified_tick_ = std::max(notified_tick_, own.input_tick);
        notified_missing_ = own.input_missing;
    }
}

void InputStream::on_path_answers(const link::Client& client) {
    const link::UplinkUpdate& update = client.uplink();
    std::size_t late = 0;
    double made_late_s = 0.0;
    if (log_.on_update(update, late, made_late_s) && lead_) {
        // A page that draws 60 pictures a second makes its commands up to 17 ms late.
        lead_->add_path(
            update.server_receive_s - client.clock().server_time(update.sent_s) + made_late_s,
            static_cast<int>(late));
    }
}

}  // namespace zoned::view
