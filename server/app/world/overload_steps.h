// OverloadSteps: notices when an overload begins to give something up, and when it ends.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace zoned::app {

/// Steps of an overload, each of which gives something up, in this order.
enum class OverloadStep : std::uint8_t {
    kCopies,  ///< copies ahead of losses: acknowledgements are late
    kBounds,  ///< updates of what is far: bounds are wider than promised
};

inline constexpr std::size_t kOverloadSteps = 2;

/// A step has begun when it concerned more than a tenth of all clients over the last second, and
/// has ended when it concerned less than a fiftieth: in between nothing is said.
class OverloadSteps {
  public:
    /// Clients of one tick.
    struct Load {
        std::uint64_t clients = 0;
        std::uint64_t late = 0;     ///< whose acknowledgements are late
        std::uint64_t widened = 0;  ///< with bounds wider than promised
    };

    /// The next tick. True where the state of some step changed; `changed` says of which.
    bool tick(const Load& load) {
        const double clients = static_cast<double>(load.clients);
        const std::array<std::uint64_t, kOverloadSteps> concerned = {load.late, load.widened};
        bool any = false;
        for (std::size_t i = 0; i < kOverloadSteps; ++i) {
            const double share =
                load.clients == 0 ? 0.0 : static_cast<double>(concerned[i]) / clients;
            shares_[i] += (share - shares_[i]) / kMemory;
            changed_[i] = shares_[i] > kBegins ? !on_[i] : shares_[i] < kEnds && on_[i];
            on_[i] = on_[i] != changed_[i];
            any = any || changed_[i];
        }
        return any;
    }

    [[nodiscard]] bool changed(OverloadStep step) const {
        return changed_[static_cast<std::size_t>(step)];
    }

    [[nodiscard]] bool on(OverloadStep step) const { return on_[static_cast<std::size_t>(step)]; }

    /// Of the clients, over the last second.
    [[nodiscard]] double share(OverloadStep step) const {
        return shares_[static_cast<std::size_t>(step)];
    }

  private:
    static constexpr double kMemory = 30.0;  // ticks
    static constexpr double kBegins = 0.1;
    static constexpr double kEnds = 0.02;

    std::array<double, kOverloadSteps> shares_{};
    std::array<bool, kOverloadSteps> on_{};
    std::array<bool, kOverloadSteps> changed_{};
};

}  // namespace zoned::app
