// FaultyZone: a zone that does wrong on purpose, so that those who check clients can be checked.
#pragma once

#include "server/zone/zone.h"
#include "shared/core/rng.h"

#include <memory>

namespace zoned::zone {

/// A fault that hits a fixed share of the entities or clients, chosen by a hash of their id.
struct ShareFault {
    double share = 0.0;  ///< [0, 1]; 0 = off
    Tick from_tick = 0;

    [[nodiscard]] bool operator==(const ShareFault&) const = default;

    [[nodiscard]] bool hits(std::uint32_t id, Tick now) const {
        return share > 0.0 && now >= from_tick &&
               static_cast<double>(core::mix(id) >> 11U) * 0x1.0p-53 < share;
    }
};

/// Faults on purpose, to check the checkers. All off by default.
struct FaultSettings {
    ShareFault corrupt;             ///< these entities' replicated positions are off ...
    float corrupt_offset_m = 0.0F;  ///< ... by this much
    ShareFault hide;                ///< these entities are kept from everybody
    ShareFault leak;                ///< these viewers hear of one entity beyond their radii
    ShareFault leak_filtered;       ///< these viewers hear of what is concealed from them
    ShareFault drop_decision;       ///< these clients do not hear what they are to confirm
    Tick stall_from = 0;            ///< this zone does not simulate nor publish from this tick ...
    Tick stall_ticks = 0;           ///< ... for this many
    bool silent_bound = false;      ///< clients are not told of wider bounds

    [[nodiscard]] bool operator==(const FaultSettings&) const = default;
};

/// Decorates the step of a zone: what it publishes is altered on its way out, and nothing that it
/// simulates. Only worlds whose config has `testing` settings are made of such zones.
class FaultyZone final : public Zone {
  public:
    FaultyZone(ZoneSettings settings,
               const FaultSettings& faults,
               std::unique_ptr<Rules> rules,
               Stopwatch stopwatch = nullptr);

    void simulate(Tick now, std::span<const mailbox::InboxItem> inbox) override;
    void publish() override;

  protected:
    std::uint32_t replicate(const world::Visibility& sets) override;

  private:
    /// True while the zone neither simulates nor publishes.
    [[nodiscard]] bool stalled(Tick now) const;
    void drop_decisions();
    void alter_sets(const world::Visibility& sets);
    void shift_positions(float sign);
    void hide_wider_bounds();

    FaultSettings faults_;
    world::Visibility altered_;
};

}  // namespace zoned::zone
