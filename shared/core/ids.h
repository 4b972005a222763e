// StrongId: identifiers that cannot be mixed up, and the tick number, for all stages.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>

namespace zoned {

/// A number that cannot be mixed up with another kind of number. Zero means "none".
template <class Tag, class Rep = std::uint32_t>
struct StrongId {
    Rep value = 0;

    constexpr StrongId() = default;

    constexpr explicit StrongId(Rep v) : value(v) {}

    constexpr explicit operator bool() const { return value != 0; }

    constexpr auto operator<=>(const StrongId&) const = default;
};

/// One entity of the world, the same on server and client, never reused while a world lives.
/// Zone z of n (counted from 0) hands out z + 1, z + 1 + n, z + 1 + 2n, ... so that ids stay small
/// on the wire.
using EntityId = StrongId<struct EntityTag>;
/// One session of a logged-in client; stays the same across reconnects.
using ClientId = StrongId<struct ClientTag>;
/// A zone, counted from 1 in the order of the config.
using ZoneId = StrongId<struct ZoneTag, std::uint16_t>;
/// Number of one reliable event, unique in the world: (counter << 16) | zone.
using EventId = StrongId<struct EventTag, std::uint64_t>;
/// A rigid body of one zone's physics scene: (generation << 20) | (index + 1).
using BodyId = StrongId<struct BodyTag>;
/// A joint of one physics scene: (generation << 20) | (index + 1).
using JointId = StrongId<struct JointTag>;
/// Index of an entity type in the world's type table (0 is a valid index, so no StrongId).
using TypeIndex = std::uint16_t;

/// Number of simulation steps since the world began; tick t has the nominal time t * dt.
using Tick = std::int64_t;

}  // namespace zoned

template <class Tag, class Rep>
struct std::hash<zoned::StrongId<Tag, Rep>> {
    std::size_t operator()(const zoned::StrongId<Tag, Rep>& id) const noexcept {
        // Fibonacci hashing (Knuth, TAOCP vol. 3, section 6.4) spreads consecutive ids.
        return static_cast<std::size_t>(id.value) * 0x9E3779B97F4A7C15ull;
    }
};
