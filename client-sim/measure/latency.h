// Latency: the budget of an action, from the decision on one client to the display on another, by
// stage.
#pragma once

#include "client-sim/bot/bot.h"
#include "shared/core/histogram.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace zoned::measure {

/// In the order in which an action passes them; all in server time, as each client estimates it. So
/// their sum is the whole latency, except for clock errors.
enum class Stage : std::uint8_t {
    kWireUp,    ///< from the decision until the server has the command
    kTickWait,  ///< until the command's tick: the excess of the input lead
    kPublish,   ///< until the truth leaves the bound of others' predictions, and is published
    kSend,      ///< the step itself, replication, budget, pacing: until the packet leaves
    kWireDown,
    kDisplay,  ///< until a tick that shows it is displayed: a tick, or the jitter buffer
};

inline constexpr std::size_t kStages = 6;

/// Name of a stage as reports have it: wire_up, ...
[[nodiscard]] const char* stage_name(Stage stage);

class Latency {
  public:
    using Histograms = std::array<core::Histogram, kStages>;

    /// The command for `tick`, decided at `decided_s` by bot `decider`, shows on `observer` by a
    /// publication of `publication_tick`, from view tick `from_tick` on. `decided_s` is the
    /// decider's estimate of the server's time. Call from within the observer's packet.
    void add(std::size_t decider,
             Tick tick,
             double decided_s,
             const bot::Bot& observer,
             Tick publication_tick,
             Tick from_tick);

    /// Settles waiting actions: the decider learns a round trip later when its command came.
    /// Actions for which that stays unknown (the packet was lost, or overtaken) are left out of all
    /// stages.
    void settle(std::span<const std::unique_ptr<bot::Bot>> bots);

    /// In ms, by stage.
    [[nodiscard]] const Histograms& stages() const { return stages_ms_; }

    /// Number of actions whose stages are not all known.
    [[nodiscard]] std::uint64_t unknown() const { return unknown_; }

  private:
    struct PendingAction {
        std::size_t decider = 0;
        Tick tick = 0;
        double decided_s = 0.0;
        double due_s = 0.0;  // of the command's tick
        double shown_s = 0.0;
        std::array<double, kStages> ms{};  // without the first two
    };

    std::vector<PendingAction> waiting_;
    Histograms stages_ms_;
    std::uint64_t unknown_ = 0;
};

}  // namespace zoned::measure
