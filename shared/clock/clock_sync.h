// ClockSync: estimates the server's clock from round trips; the caller passes the time.
#pragma once

#include <array>
#include <cstddef>

namespace zoned::clock {

/// Filters offset samples as NTP's clock filter does (RFC 5905, section 10): of the last samples
/// those with the smallest round trip are the most truthful. The offset is slewed, never stepped,
/// once it has settled.
class ClockSync {
  public:
    /// One exchange, all in seconds: request left at `sent_local`, server received it at
    /// `server_receive` and answered at `server_send` (server clock), the answer came at
    /// `received_local`. Nonsense (negative round trip) is ignored.
    void add_sample(double sent_local,
                    double server_receive,
                    double server_send,
                    double received_local);

    /// The server's time at local time `local`; meaningless before ready().
    [[nodiscard]] double server_time(double local) const;

    /// True from the first sample on.
    [[nodiscard]] bool ready() const { return count_ > 0; }

    [[nodiscard]] double offset_s() const { return offset_; }

    [[nodiscard]] double rtt_s() const {
        return rtt_;
    }  ///< smoothed round trip without server time

    [[nodiscard]] double min_rtt_s() const;  ///< smallest of the window

    /// Half the smallest round trip: the offset cannot be wrong by more, whatever the asymmetry of
    /// the path.
    [[nodiscard]] double error_bound_s() const { return 0.5 * min_rtt_s(); }

  private:
    struct Sample {
        double offset = 0.0;
        double rtt = 0.0;
        double local = 0.0;
    };

    static constexpr std::size_t kWindow = 32;
    std::array<Sample, kWindow> samples_{};
    std::size_t count_ = 0;
    double offset_ = 0.0;
    double rtt_ = 0.0;
    double last_local_ = 0.0;
};

}  // namespace zoned::clock
