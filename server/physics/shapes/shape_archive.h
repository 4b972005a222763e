// Shape archive: shapes as they are saved. Geometries that a zone's settings hold are saved by
// their number, hulls that were made while the zone ran by value.
#pragma once

#include "server/physics/shapes/convex/hull.h"
#include "server/physics/shapes/shape.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

namespace zoned::physics {

/// The geometries of a zone's settings, in an order that follows from the settings alone. Archives
/// lend it to the shapes that they save.
struct GeometryTable {
    std::vector<std::shared_ptr<const Geometry>> known;

    void add(const Shape& shape) {
        if (shape.geometry) {
            known.push_back(shape.geometry);
        }
    }
};

enum class SavedGeometry : std::uint8_t {
    kNone,
    kKnown,
    kHull,
};

/// Whether the faces and edges of a hull name corners that it has.
[[nodiscard]] bool is_sound(const ConvexHull::HullTables& tables);

template <class Archive>
void serialize(Archive& archive, Shape& shape) {
    archive(shape.kind, shape.half_extents, shape.radius, shape.half_segment);
    const auto& known = archive.template lent<GeometryTable>().known;
    SavedGeometry how = SavedGeometry::kNone;
    std::uint32_t number = 0;
    if constexpr (!Archive::kReads) {
        const auto it = std::find(known.begin(), known.end(), shape.geometry);
        if (shape.geometry) {
            how = it != known.end() ? SavedGeometry::kKnown : SavedGeometry::kHull;
            number = static_cast<std::uint32_t>(it - known.begin());
        }
        if (how == SavedGeometry::kHull && shape.kind != ShapeKind::kHull) {
            archive.fail("a shape that was made while the zone ran has no saved form");
            return;
        }
    }
    archive(how);
    switch (how) {
        case SavedGeometry::kNone:
            break;
        case SavedGeometry::kKnown:
            archive(number);
            if constexpr (Archive::kReads) {
                if (number >= known.size() || known[number]->kind != shape.kind) {
                    archive.fail("a shape is of a geometry that there is not");
                    break;
                }
                shape.geometry = known[number];
            }
            break;
        case SavedGeometry::kHull:
            if constexpr (Archive::kReads) {
                ConvexHull::HullTables tables;
                archive(tables);
                if (!archive.good() || !is_sound(tables)) {
                    archive.fail("a hull names corners that it has not");
                    break;
                }
                shape.geometry = std::make_shared<const ConvexHull>(std::move(tables));
            } else {
                archive(hull_of(shape).tables());
            }
            break;
    }
    if constexpr (Archive::kReads) {
        const bool needs = shape.kind == ShapeKind::kHull || shape.kind == ShapeKind::kMesh ||
                           shape.kind == ShapeKind::kHeightfield ||
                           shape.kind == ShapeKind::kCompound;
        if (shape.kind > ShapeKind::kCompound || needs != (shape.geometry != nullptr)) {
            archive.fail("a shape is of no kind, or lacks its geometry");
            shape = Shape();
        }
    }
}

}  // namespace zoned::physics
