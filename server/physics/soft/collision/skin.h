// SoftSkin: the outer faces of a soft body, where other soft bodies meet it.
#pragma once

#include "server/physics/soft/soft_def.h"
#include "server/spatial/aabb_tree.h"

#include <span>

namespace zoned::physics::soft {

struct SoftBody;

/// Follows from the definition and the tears, so that no snapshot holds it.
struct SoftSkin {
    std::vector<SoftFace> faces;  ///< a rope's segment is a face whose last two corners are one
    std::vector<std::uint32_t> nodes;  ///< of the faces, ascending
    bool closed = false;               ///< the faces turn outward and bound an inside
    bool segments = false;             ///< a rope

    // Work of the steps in which the body is near another one.
    std::vector<Vec3> normals;  ///< of each node, unit; of closed skins only
    std::vector<Aabb> boxes;    ///< of each face
    spatial::AabbTree tree;     ///< of the boxes
    std::vector<std::uint32_t> rows;
};

/// Whether every edge belongs to two faces that run through it in opposite senses.
bool is_closed(std::span<const SoftFace> faces);

/// A body's skin: its faces where they are closed, else the boundary of its tetrahedra, else its
/// faces, which are met from both sides, else its structural springs as segments.
void find_skin(SoftBody& body);

/// Moves boxes, tree and normals to where the nodes are now.
void fit_skin(SoftBody& body);

}  // namespace zoned::physics::soft
