// Spectator layers: messages about what viewers may ask for beside the entities.
#pragma once

#include "server/admin/spectator/spectator_hub.h"

#include <unordered_map>

namespace zoned::admin {

/// Messages, little-endian, each with the head u32 kind, u32 tick, u32 count, u32 0:
/// 3 joints: `count` times three points (f32 x, y, z): a body, where the joint holds, a body.
/// 4 soft bodies: `count` times u32 entity, u32 nodes, u32 faces, u32 hung vertices; f32 x, y, z of
///   each node; three u32 of each face; four u32 nodes, four f32 weights and f32 offset of each
///   hung vertex (physics::soft::SoftVertex). Faces are of the hung vertices, or of the nodes where
///   none hang. 0 faces: those sent before still hold, and the vertices with them.
/// 5 particles: `count` points.
/// 6 ghosts: `count` times f32 x, y, z, u32 (type, and 65536 times the zone that holds the copy).
/// 7 doors and platforms that rules move, in the order of the scene: `count` times u32 (1: the door
///   is open), then i32 for each platform: ticks of travel from its first stop.
class SpectatorLayers {
  public:
    struct Message {
        SpectatorLayer layer = kLayerJoints;
        SpectatorMessage bytes;
    };

    /// One message for each layer of the sample. With `whole` all surfaces are sent anew.
    [[nodiscard]] std::vector<Message> update(const SpectatorSample& sample, bool whole);

  private:
    [[nodiscard]] SpectatorMessage softs(const SpectatorSample& sample, bool whole);

    /// A body's surface as it was sent to viewers.
    struct SentSurface {
        std::vector<physics::soft::SoftFace> faces;
        std::vector<physics::soft::SoftVertex> hung;
    };

    std::unordered_map<EntityId, SentSurface> surfaces_;
};

}  // namespace zoned::admin
