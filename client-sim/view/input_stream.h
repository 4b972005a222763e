// InputStream: makes the commands of the own avatar ahead of the server's clock, and sends them.
#pragma once

#include "client-sim/link/client.h"
#include "client-sim/view/command_log.h"
#include "client-sim/view/own_avatar.h"
#include "shared/clock/input_lead.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace zoned::view {

/// Commands in time and missed, by the server's reports.
struct InputStats {
    std::uint64_t ticks =
        0;  ///< ticks that the server has reported, since the first command in time
    std::uint64_t missing = 0;  ///< of these: the command came too late or not at all
};

/// Commands are made for ticks ahead of the server (clock::InputLead), on a clock of their own.
class InputStream {
  public:
    static constexpr std::size_t kCommandsPerPacket = 4;

    /// The intent for a tick; its tick is filled in.
    using Decide = std::function<motion::InputCommand(Tick)>;

    /// A new session: all is measured anew, the stats go on.
    void restart(double tick_s);

    /// The server's clock was set back: commands begin anew at its present.
    void set_back() { next_ = -1; }

    /// Makes the commands that are due, predicts their effect and sends the newest ones. Needs a
    /// client that knows the server's clock.
    void advance(link::Client& client, OwnAvatar& own, double now_s, const Decide& decide);

    /// Takes the server's last report on the way of our datagrams.
    void on_path_answers(const link::Client& client);
    /// Takes the server's report on the command of a tick.
    void on_report(const wire::OwnState& own, double rtt_s);

    /// Time until the next command is due, s; needs a command before it.
    [[nodiscard]] double due_in_s(const link::Client& client, double now_s) const;

    /// Time by which commands are made ahead of the server's clock; 0 before the first one.
    [[nodiscard]] double lead_s() const { return lead_ ? lead_->lead_s() : 0.0; }

    /// Progress from the newest command's tick towards the next, 0..1.
    [[nodiscard]] double fraction(const link::Client& client, double now_s) const;

    [[nodiscard]] const InputStats& stats() const { return stats_; }

    /// When the server had the command for a tick, by its own clock; none when not known.
    [[nodiscard]] std::optional<double> arrival_s(Tick tick) const { return log_.arrival_s(tick); }

  private:
    [[nodiscard]] double position(const link::Client& client, double now_s) const;

    double tick_s_ = 1.0 / 30.0;
    std::optional<clock::InputLead> lead_;
    CommandLog log_;
    InputStats stats_;
    Tick notified_tick_ =
        -1;  // newest tick with a report of the server on its command; -1: no command came in time
    bool notified_missing_ = false;
    Tick next_ = -1;
    std::vector<std::uint8_t> body_;
};

}  // namespace zoned::view
