// Spectator layers: messages about what viewers may ask for beside the entities.
#pragma once

#include "server/admin/spectator/spectator_hub.h"

#include <unordered_map>

namespace zoned::admin {

/// Messages, little-endian, each with the head u32 kind, u32 tick, u32 count, u32 0:
/// 3 joints: `count` times three points (f32 x, y, z): a body, where the joint holds, a body.
/// 4 soft bodies: `count` times u32 entity, u32 vertices, u32 faces, then f32 x, y, z and three u32
///   for each; 0 faces: those told before still hold.
/// 5 particles: `count` points.
/// 6 ghosts: `count` times f32 x, y, z, u32 (type, and 65536 times the zone that holds the copy).
class SpectatorLayers {
  public:
    struct Message {
        SpectatorLayer layer = kLayerJoints;
        SpectatorMessage bytes;
    };

    /// One message for each layer of the sample. With `whole` all faces are told anew.
    [[nodiscard]] std::vector<Message> update(const SpectatorSample& sample, bool whole);

  private:
    [[nodiscard]] SpectatorMessage softs(const SpectatorSample& sample, bool whole);

    std::unordered_map<EntityId, std::vector<std::array<std::uint32_t, 3>>> faces_;
};

}  // namespace zoned::admin
