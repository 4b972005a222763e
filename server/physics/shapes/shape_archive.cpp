#include "server/physics/shapes/shape_archive.h"

namespace zoned::physics {

bool is_sound(const ConvexHull::HullTables& tables) {
    const std::size_t padded = tables.x.size();
    const auto vertices = static_cast<std::size_t>(tables.vertices);
    bool sound = tables.vertices > 0 && vertices <= padded && tables.y.size() == padded &&
                 tables.z.size() == padded && tables.half_cosines.size() >= tables.edges.size();
    for (const HullFace& face : tables.faces) {
        sound = sound && face.corners >= 3 &&
                std::size_t{face.first} + face.corners <= tables.loops.size();
    }
    for (const std::uint8_t corner : tables.loops) {
        sound = sound && corner < vertices;
    }
    for (const HullEdge& edge : tables.edges) {
        sound = sound && edge.from < vertices && edge.to < vertices &&
                edge.left < tables.faces.size() && edge.right < tables.faces.size();
    }
    return sound;
}

}  // namespace zoned::physics
