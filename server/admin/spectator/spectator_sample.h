// SpectatorSample: a copy of the columns of all zones, from which messages for viewers are made.
#pragma once

#include "server/physics/soft/soft_def.h"
#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace zoned::admin {

enum SpectatorFlag : std::uint8_t {
    kSpectatorAtRest = 1u << 0,
    kSpectatorAvatar = 1u << 1,     ///< a client's
    kSpectatorOffScreen = 1u << 2,  ///< its agent is suspended: it goes from event to event
};

/// A viewer may ask for these beside the entities; bits of SpectatorWish::layers.
enum SpectatorLayer : std::uint32_t {
    kLayerJoints = 1u << 0,
    kLayerSofts = 1u << 1,
    kLayerParticles = 1u << 2,
    kLayerGhosts = 1u << 3,
    kLayerMoved = 1u << 4,  ///< doors and platforms that rules move
};

/// Columns of one zone, by row; positions are from `origin`. Copied whole, so that the thread of
/// the simulation looks at no single row.
struct SpectatorZone {
    std::uint16_t number = 0;
    Vec3d origin = Vec3d::Zero();  ///< m
    std::vector<EntityId> id;
    std::vector<TypeIndex> type;
    std::vector<std::uint8_t> flags;  ///< world::EntityFlag bits
    std::vector<ClientId> client;
    std::vector<Vec3> position;  ///< m
    std::vector<Quat> orientation;
    std::vector<Vec3> velocity;  ///< m/s
};

/// Where an entity is whose agent goes from event to event: its columns are those of the last
/// event.
struct SpectatorWalker {
    std::uint16_t zone = 0;  ///< index into SpectatorSample::zones
    std::uint32_t row = 0;
    Vec2 position = Vec2::Zero();  ///< x, z from the zone's origin, m
    Vec2 velocity = Vec2::Zero();  ///< m/s
};

/// A soft body as it is deformed.
struct SpectatorSoft {
    EntityId entity;
    Vec3d origin = Vec3d::Zero();                ///< of its zone, m
    std::vector<Vec3> nodes;                     ///< from the origin, m
    std::vector<physics::soft::SoftFace> faces;  ///< of the drawn vertices
    /// How drawn vertices hang on the nodes; empty: the nodes are drawn.
    std::vector<physics::soft::SoftVertex> hung;
};

/// A joint: from one body by the point where it holds to the other.
using SpectatorJoint = std::array<Vec3d, 3>;

/// Kept and filled again, so that filling it allocates nothing once it is large enough.
struct SpectatorSample {
    std::int64_t tick = 0;
    float tick_s = 1.0F / 30.0F;
    std::vector<SpectatorZone> zones;
    std::vector<SpectatorWalker> walkers;
    std::uint32_t layers = 0;  ///< SpectatorLayer bits: those below that were asked for
    std::vector<SpectatorJoint> joints;
    std::vector<SpectatorSoft> softs;
    std::vector<std::array<float, 3>> particles;  ///< world coordinates, m
    std::vector<std::uint32_t> moved_doors;       ///< in the order of the scene: 1 open, 0 shut
    std::vector<Tick> moved_platforms;            ///< in the order of the scene: ticks of travel
    std::uint32_t next_walker = 0;                ///< of the filler: where it goes on next time
};

/// A viewer asked for this last.
struct SpectatorWish {
    std::uint32_t layers = 0;
    std::array<float, 3> eye{};  ///< world coordinates, m
};

/// Where viewers get the world from.
struct SpectatorSource {
    double rate_hz = 30.0;  ///< of samples, at most
    /// The part of the world that never changes, as JSON; called on the server's thread.
    std::function<std::string()> scene;
    /// Asks for the state after one of the next ticks, with the layers that the sample names;
    /// `taken` may be called from any thread. False when that is impossible just now.
    std::function<bool(std::shared_ptr<SpectatorSample> into, std::function<void()> taken)> sample;
};

}  // namespace zoned::admin
