// Visibility: who listens and what each of them hears; written by interest, read by replication.
#pragma once

#include "server/world/entities.h"

#include <cstdint>
#include <vector>

namespace zoned::world {

/// A client whose avatar lives in this zone.
struct Viewer {
    ClientId client;
    EntityId avatar;
};

/// One entity that a viewer hears of.
struct Visible {
    EntityId entity;
    std::uint8_t lod = 0;  ///< 0 is the nearest level of detail
};

/// What one viewer hears of, ascending by entity id, and how that differs from the tick before.
struct VisibleSet {
    ClientId client;
    std::vector<Visible> visible;      ///< never holds the viewer's own avatar
    std::vector<Visible> entered;      ///< new this tick
    std::vector<EntityId> left;        ///< gone this tick (also when the entity ceased to be)
    std::vector<Visible> lod_changed;  ///< visible before and now, at another level of detail
    bool changed = true;               ///< `visible` is not as it was a tick ago, or is new
    /// Of the matcher that keeps the set. Who writes `visible` himself sets it to 0, so that the
    /// matcher looks at everything anew.
    std::uint64_t stamp = 0;
};

/// One set per viewer, in the order of the viewers (ascending by client id).
using Visibility = std::vector<VisibleSet>;

}  // namespace zoned::world
