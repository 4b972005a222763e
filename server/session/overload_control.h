// OverloadControl: decides by measured load whether one more client is let in, and how many bytes a
// client may cost while the server has more to do than it can.
#pragma once

#include <cstddef>
#include <limits>

namespace zoned::session {

/// Loads are shares of the time there is: 1 is a thread that never rests. Waiting for a core counts
/// as work: a machine that others use is as full as one that is too small.
///
/// *Admission.* Measured load, and the number of sessions that it was measured with, are smoothed
/// by one second, so what new sessions will cost does not show at once: it is added by the cost of
/// a session so far (the load above that of the server without sessions, divided by the sessions,
/// of which there are taken to be sixteen at least).
/// Logins are refused from `max_load` on, until the load is a tenth below.
///
/// *Bytes.* Halfway between `max_load` and 1 the server has more to do than it may admit. Once a
/// second the ceiling of each client is then cut to four fifths of what clients cost on average,
/// and grows by a quarter where the load is a tenth below `max_load`. Replication gives up what is
/// far first, and announces the wider bounds. A load that follows its cause late is held by cuts in
/// proportion (Chiu and Jain 1989, section 3); since one ceiling holds for all, growth may be in
/// proportion too.
class OverloadControl {
  public:
    static constexpr double kNoCeiling = std::numeric_limits<double>::infinity();

    /// `load` since the last call, with so many sessions; `bytes_per_s` goes to all of them.
    /// `now_s` ascends. `floor`: bytes per second that a client costs at least.
    void measured(double load,
                  std::size_t sessions,
                  double bytes_per_s,
                  double floor,
                  double max_load,
                  double now_s);

    /// Whether one more session is let in beside so many.
    bool admits(std::size_t sessions, double max_load);

    /// The load to expect of so many sessions.
    [[nodiscard]] double expected(std::size_t sessions) const;

    /// Measured, of the last second.
    [[nodiscard]] double load() const { return load_; }

    [[nodiscard]] bool refusing() const { return refusing_; }

    /// Bytes per second and client; kNoCeiling where nothing is given up.
    [[nodiscard]] double ceiling() const { return ceiling_; }

  private:
    void move_ceiling(std::size_t sessions, double floor, double max_load);

    double load_ = 0.0;
    double sessions_ = 0.0;     ///< that load_ was measured with
    double bytes_per_s_ = 0.0;  ///< to all clients
    double idle_load_ = 0.0;    ///< without sessions; 0: not seen yet
    double measured_s_ = -1.0;  ///< last call; below 0: none
    double moved_s_ = 0.0;      ///< the ceiling
    double ceiling_ = kNoCeiling;
    double usual_ = 0.0;  ///< bytes per second and client when the first cut was made
    bool refusing_ = false;
};

}  // namespace zoned::session
