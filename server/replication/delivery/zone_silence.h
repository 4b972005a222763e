// ZoneSilence: the ticks in which next to none of a zone's many clients was heard.
#pragma once

#include "shared/core/ids.h"

#include <bit>
#include <cstdint>

namespace zoned::replication {

/// Paths do not fail all at once. Where acknowledgements of all clients stay out together, the
/// server itself is behind, or the machine that all of them run on, and nothing is lost. Such ticks
/// do not count as time in which an acknowledgement could have come. Deterministic.
class ZoneSilence {
  public:
    /// A client's acknowledgement of something new came.
    void on_acknowledged() { ++heard_; }

    void begin_tick() {
        const auto heard = static_cast<float>(heard_);
        silent_ = silent_ << 1U | (usual_ >= kLeast && heard < kShare * usual_ ? 1U : 0U);
        usual_ += (heard - usual_) / kMemory;
        heard_ = 0;
    }

    /// The silent ones among the last `ticks`, this one included.
    [[nodiscard]] Tick among(Tick ticks) const {
        const std::uint64_t last =
            ticks >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << ticks) - 1;
        return std::popcount(silent_ & last);
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(silent_, usual_, heard_);
    }

  private:
    static constexpr float kLeast = 4.0F;  ///< a tick: fewer clients may be silent by chance
    static constexpr float kShare = 0.25F;
    static constexpr float kMemory = 32.0F;

    std::uint64_t silent_ = 0;  // bit i: so it was i ticks ago
    float usual_ = 0.0F;        // acknowledgements a tick
    std::uint32_t heard_ = 0;   // since the last tick
};

}  // namespace zoned::replication
