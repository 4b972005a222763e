// TriangleMesh: a static surface of triangles, with a tree over them and its inner edges known.
#pragma once

#include "server/physics/shapes/box_tree.h"
#include "server/physics/shapes/shape.h"
#include "server/physics/shapes/surface.h"
#include "shared/core/result.h"

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace zoned::physics {

inline constexpr std::size_t kMaxMeshTriangles = 1U << 22;
inline constexpr std::size_t kMaxEdgeTriangles = 64;  ///< all of them look at each other

/// Immutable. One-sided: solid behind, so a body touches it only with its centre in front of a
/// triangle's plane. A body that got behind is not pulled through: it is not held at all.
class TriangleMesh final : public Geometry {
  public:
    struct MeshTables {
        std::vector<Vec3> vertices;
        std::vector<std::array<std::uint32_t, 3>> corners;
        std::vector<Vec3> normals;
        std::vector<std::array<EdgeBend, 3>> bends;
        BoxTree tree;
    };

    explicit TriangleMesh(MeshTables tables) : Geometry(ShapeKind::kMesh), t_(std::move(tables)) {}

    [[nodiscard]] std::uint32_t triangle_count() const {
        return static_cast<std::uint32_t>(t_.corners.size());
    }

    [[nodiscard]] Triangle triangle(std::uint32_t i) const;

    [[nodiscard]] const BoxTree& tree() const { return t_.tree; }

    [[nodiscard]] const Aabb& box() const { return t_.tree.box(); }

    [[nodiscard]] const MeshTables& tables() const { return t_; }

  private:
    MeshTables t_;
};

/// The mesh of a shape of kind kMesh.
inline const TriangleMesh& mesh_of(const Shape& shape) {
    return static_cast<const TriangleMesh&>(*shape.geometry);
}

struct MeshOptions {
    /// Vertices no farther apart are one, m: files repeat vertices where normals or textures
    /// differ. 0: only those at the very same place;
    /// otherwise at least 1e-6.
    float weld = 0.0F;
};

struct BuiltMesh {
    std::shared_ptr<const TriangleMesh> mesh;
    // Findings of the build; none of them stops the mesh from being used.
    std::uint32_t degenerate = 0;    ///< triangles without area, left out
    std::uint32_t repeated = 0;      ///< triangles that are there already, left out
    std::uint32_t open_edges = 0;    ///< edges of one triangle only: the rim of the surface
    std::uint32_t shared_edges = 0;  ///< edges of more than two triangles
    std::uint32_t turned_edges = 0;  ///< edges of two triangles that face in opposite directions
    std::uint32_t merged = 0;        ///< vertices that another one stands for
    std::uint32_t unused = 0;        ///< vertices that no triangle names; left out like the merged
    // Where the first of each was, as numbers of the triangles and vertices that were given. Only
    // valid where the count is not zero.
    std::uint32_t first_degenerate = 0;
    std::uint32_t first_repeated = 0;
    std::array<std::uint32_t, 2> first_open{};
    std::array<std::uint32_t, 2> first_shared{};
    std::array<std::uint32_t, 2> first_turned{};
};

/// Three indices for each triangle, counter-clockwise seen from the front. Fails with the reason
/// when a vertex is not finite or out of range, an index names no vertex, there are more than
/// kMaxMeshTriangles, or kMaxEdgeTriangles at an edge, or no triangle has an area.
core::Result<BuiltMesh> build_mesh(std::span<const Vec3> vertices,
                                   std::span<const std::uint32_t> indices,
                                   const MeshOptions& options = {});

/// The parts of a mesh that take long to find: files keep them.
struct MeshParts {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> corners;
    std::vector<std::array<EdgeBend, 3>> bends;
    BoxTree::Layout tree;
};

/// The mesh of these parts: the very same as the one whose tables they are. Any bytes may be given:
/// fails with the reason where build_mesh would, and when a triangle has no area, a bend is out of
/// range, or the tree is none. Bends are not compared with the triangles.
core::Result<std::shared_ptr<const TriangleMesh>> restore_mesh(MeshParts parts);

}  // namespace zoned::physics
