// Bursts: cosmetic particles of burst events, computed from those events alone.
#pragma once

#include "client-sim/view/world_info.h"
#include "shared/wire/session/session_messages.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::view {

/// Holds the bursts that have particles left. Bounded: a hostile server costs no more than kMost
/// entries and kMostAlive particles.
class Bursts {
  public:
    static constexpr std::size_t kMost = 1024;
    static constexpr std::uint64_t kMostAlive = 65'536;  ///< particles, in all bursts together

    /// The outcome of an event.
    enum class BurstOutcome : std::uint8_t {
        kTaken,
        kMalformed,  ///< no such system, numbers that no server sends
        kNoRoom,     ///< too many particles at a time: not displayed
    };

    explicit Bursts(const WorldInfo& world) : world_(&world) {}

    /// An event of the kind kEventParticleBurst. Forgets bursts that are over at `now` where
    /// it needs the room.
    BurstOutcome apply(const wire::EventMessage& event, Tick now);

    /// All particles of bursts that are alive at `tick`, in the order of the events, appended to
    /// `out`. World coordinates.
    void replay(Tick tick, std::vector<motion::CosmeticParticle>& out) const;

    [[nodiscard]] std::size_t size() const { return live_.size(); }

    void clear();

  private:
    void forget_over(Tick now);

    const WorldInfo* world_;
    std::vector<motion::CosmeticEmitter> live_;
    std::uint64_t particles_ = 0;
};

}  // namespace zoned::view
