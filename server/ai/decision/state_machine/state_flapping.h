// FlappingDetector: finds agents that go to and fro between two states, and says between which.
#pragma once

#include "server/ai/decision/state_machine/active_states.h"

#include <span>

namespace zoned::ai::state_machine {

struct FlappingSettings {
    Tick window = 60;           ///< ticks; a change back that comes later than this is none
    std::uint16_t changes = 6;  ///< changes to and fro, each within the window, that make one
};

/// Two states, and how often agents went to and fro between them.
struct FlappingPair {
    std::uint16_t a = 0;  ///< the smaller one
    std::uint16_t b = 0;
    std::uint16_t a_to_b = 0;  ///< the transitions, numbered through the machine
    std::uint16_t b_to_a = 0;
    std::uint64_t count = 0;  ///< of times that an agent was found at it
    std::uint32_t agent = 0;  ///< the last one
    Tick at = 0;              ///< when it was
};

/// Watches the changes of all agents of one machine; states that do not change cost nothing. What
/// it remembers is for reports and decides nothing.
class FlappingDetector {
  public:
    explicit FlappingDetector(FlappingSettings settings = {}) : settings_(settings) {}

    /// What is remembered of one agent.
    struct Trace {
        std::uint16_t from = kNone;
        std::uint16_t to = kNone;
        std::uint16_t transition = kNone;
        std::uint16_t streak = 0;
        Tick at = 0;
    };

    /// For agents 0 to `count` - 1; forgets all.
    void reset(std::size_t count);

    /// The changes of one step. An agent is reported once for each `changes` changes that it keeps
    /// at it; one that goes on to a third state has stopped. At most 64 pairs are kept apart.
    void watch(std::span<const StateChange> changes, Tick now);
    /// One change, of an agent whose trace the caller keeps; `change.agent` is only for reports.
    void watch(Trace& trace, const StateChange& change, Tick now);

    /// By states; those of pairs beyond the 64th are counted in lost().
    [[nodiscard]] std::span<const FlappingPair> found() const { return found_; }

    [[nodiscard]] std::uint64_t lost() const { return lost_; }

  private:
    void report(const Trace& last, const StateChange& change, Tick now);

    FlappingSettings settings_;
    std::vector<Trace> last_;
    std::vector<FlappingPair> found_;
    std::uint64_t lost_ = 0;
};

}  // namespace zoned::ai::state_machine
