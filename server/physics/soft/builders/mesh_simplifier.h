// Mesh simplifier: a surface with fewer of its vertices, joined in the same way.
#pragma once

#include "server/physics/soft/soft_def.h"

#include <span>
#include <vector>

namespace zoned::physics::soft {

struct SimplifiedMesh {
    std::vector<std::uint32_t> kept;  ///< vertices that are left, ascending
    std::vector<SoftFace> faces;      ///< of indices into `kept`
    std::vector<std::uint32_t> into;  ///< of each vertex: the index into `kept` that it went to
};

/// Draws edges together, one of their ends onto the other, until at most `most` vertices are left
/// or no edge may go: then more are left. Vertices stay where they are. Those with `stays` are
/// left, rims and holes remain, and a closed surface stays closed.
///
/// An edge may go that meets the link condition (T. Dey, H. Edelsbrunner, S. Guha, D. Nekhayev,
/// "Topology preserving edge contraction", 1999) and turns over no triangle. The first to go has
/// the least cost: the area for which its end stands by now, times the square of its length, plus
/// the squared distances from the planes that the end stood for (M. Garland, P. Heckbert, "Surface
/// simplification using quadric error metrics", 1997). The first term keeps what is left evenly
/// spread, the second the shape. Ties go by number: the same mesh gives the same result.
///
/// The mesh: edges of at most two faces, each of three different vertices and with an area.
SimplifiedMesh simplify_mesh(std::span<const Vec3> vertices,
                             std::span<const SoftFace> faces,
                             const std::vector<bool>& stays,
                             std::size_t most);

}  // namespace zoned::physics::soft
