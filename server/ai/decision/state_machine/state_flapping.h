// FlappingDetector: finds agents that switch to and fro between two states, and reports the pair.
#pragma once

#include "server/ai/decision/state_machine/active_state.h"

#include <span>

namespace zoned::ai::state_machine {

struct FlappingSettings {
    Tick window = 60;           ///< ticks; a later change back does not count
    std::uint16_t changes = 6;  ///< number of changes to and fro, each within the window, that are
                                ///< reported
};

/// Two states, and how often agents were found switching to and fro between them.
struct FlappingPair {
    std::uint16_t a = 0;  ///< the smaller one
    std::uint16_t b = 0;
    std::uint16_t a_to_b = 0;  ///< the transitions, numbered through the state machine
    std::uint16_t b_to_a = 0;
    std::uint64_t count = 0;  ///< number of times that an agent was found
    std::uint32_t agent = 0;  ///< the last agent found
    Tick at = 0;              ///< the tick when it was found
};

/// Watches the changes of all agents of one state machine; states that do not change cost nothing.
/// Its memory is for reports and decides nothing.
class FlappingDetector {
  public:
    explicit FlappingDetector(FlappingSettings settings = {}) : settings_(settings) {}

    /// Trace: the detector's memory of one agent.
    struct Trace {
        std::uint16_t from = kNone;
        std::uint16_t to = kNone;
        std::uint16_t transition = kNone;
        std::uint16_t streak = 0;
        Tick at = 0;
    };

    /// Watches one change of an agent whose trace the caller keeps; `change.agent` is only for
    /// reports. An agent that keeps switching is reported once for each `changes` changes. An agent
    /// that goes on to a third state has stopped. At most 64 pairs are kept apart.
    void watch(Trace& trace, const StateChange& change, Tick now);

    /// The pairs found, ordered by states. Pairs beyond the 64th are only counted, in lost().
    [[nodiscard]] std::span<const FlappingPair> found() const { return found_; }

    [[nodiscard]] std::uint64_t lost() const { return lost_; }

  private:
    void report(const Trace& last, const StateChange& change, Tick now);

    FlappingSettings settings_;
    std::vector<FlappingPair> found_;
    std::uint64_t lost_ = 0;
};

}  // namespace zoned::ai::state_machine
