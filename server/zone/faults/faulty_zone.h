// FaultyZone: a zone that commits errors on purpose, to test the checkers of clients.
#pragma once

#include "server/zone/faults/fault_settings.h"
#include "server/zone/zone.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace zoned::zone {

/// Decorates the step of a zone: it alters the zone's output, and nothing that the zone simulates.
/// Only worlds whose config has `testing` settings are made of such zones.
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
    void shift_fields(bool there);
    void hide_wider_bounds();

    FaultSettings faults_;
    world::Visibility altered_;
    std::vector<std::vector<std::uint32_t>> true_fields_;  // while shifted, by row
};

}  // namespace zoned::zone
