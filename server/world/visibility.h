// Visibility: the viewers and the visible set of each; written by interest, read by replication.
#pragma once

#include "server/world/entities.h"

#include <algorithm>
#include <cstdint>
#include <utility>
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

/// The visible set of one viewer, ascending by entity id, and its changes since the last tick.
struct VisibleSet {
    ClientId client;
    std::vector<Visible> visible;      ///< never holds the viewer's own avatar
    std::vector<Visible> entered;      ///< new this tick
    std::vector<EntityId> left;        ///< gone this tick (also when the entity ceased to be)
    std::vector<Visible> lod_changed;  ///< visible before and now, at another level of detail
    bool changed = true;               ///< `visible` is not as it was a tick ago, or is new
    /// Of the matcher that keeps the set. Code that writes `visible` itself sets it to 0, so that
    /// the matcher looks at everything anew.
    std::uint64_t stamp = 0;
};

/// One set per viewer, in the order of the viewers (ascending by client id).
using Visibility = std::vector<VisibleSet>;

/// Makes `items` hold one per element of `wanted`; both ascend by client, which `client_of` gives
/// for either. Items that stay keep their content; the others are `fresh(wanted one)`. True when
/// any item came or went. `spare` is working memory.
template <class Item, class Wanted, class ClientOf, class Fresh>
bool align(std::vector<Item>& items,
           std::vector<Item>& spare,
           const Wanted& wanted,
           ClientOf client_of,
           Fresh fresh) {
    const bool aligned = std::equal(
        items.begin(),
        items.end(),
        wanted.begin(),
        wanted.end(),
        [&](const auto& item, const auto& one) { return client_of(item) == client_of(one); });
    if (aligned) {
        return false;
    }
    spare.clear();
    spare.reserve(wanted.size());
    auto old = items.begin();
    for (const auto& one : wanted) {
        while (old != items.end() && client_of(*old) < client_of(one)) {
            ++old;
        }
        if (old != items.end() && client_of(*old) == client_of(one)) {
            spare.push_back(std::move(*old++));
        } else {
            spare.push_back(fresh(one));
        }
    }
    items.swap(spare);
    spare.clear();
    return true;
}

}  // namespace zoned::world
