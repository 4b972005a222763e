// World faults: the errors that `testing` settings make a world commit on purpose, to test the
// checkers of clients.
#pragma once

#include "server/config/settings.h"
#include "server/mailbox/messages.h"
#include "server/zone/faults/faulty_zone.h"

#include <cstddef>
#include <map>
#include <memory>
#include <span>

namespace zoned::app {

/// The faults of one zone; FaultSettings{}: none.
zone::FaultSettings zone_faults(const config::Settings& settings, ZoneId id);

/// Alters the output of a world to clients.
class WorldFaults {
  public:
    explicit WorldFaults(const config::TestingSettings& testing);

    /// `zone_of`: by client, of all present clients.
    void alter(Tick now,
               const std::map<ClientId, std::size_t>& zone_of,
               std::span<mailbox::OutboxItem> out) const;

  private:
    zone::ShareFault leak_topic_;  ///< these clients get the messages of all topics
    double wrong_clock_ = 0.0;     ///< share by which the rates of shared clocks are off
};

/// nullptr where no `testing` setting is about a world.
std::unique_ptr<const WorldFaults> make_world_faults(const config::Settings& settings);

}  // namespace zoned::app
