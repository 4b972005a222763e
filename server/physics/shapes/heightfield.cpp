#include "server/physics/shapes/heightfield.h"

#include "server/physics/shapes/ranges.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::physics {

namespace {

float half_of(std::uint32_t samples) {
    return 0.5F * static_cast<float>(samples - 1);
}

/// Index of the cell that holds a coordinate, which may lie outside.
std::uint32_t cell_of(float coordinate, float spacing, std::uint32_t samples) {
    const float at = std::floor(coordinate / spacing + half_of(samples));
    return static_cast<std::uint32_t>(std::clamp(at, 0.0F, static_cast<float>(samples - 2)));
}

}  // namespace

Aabb Heightfield::box() const {
    const Vec3 half(half_of(t_.columns) * t_.spacing_x, 0.0F, half_of(t_.rows) * t_.spacing_z);
    return {Vec3(-half.x(), t_.lowest - t_.thickness, -half.z()),
            Vec3(half.x(), t_.highest, half.z())};
}

Heightfield::HeightfieldCells Heightfield::cells_over(const Aabb& area) const {
    const Aabb whole = box();
    if (!(area.lower.x() <= whole.upper.x() && area.upper.x() >= whole.lower.x() &&
          area.lower.z() <= whole.upper.z() && area.upper.z() >= whole.lower.z())) {
        return {};
    }
    return {cell_of(area.lower.x(), t_.spacing_x, t_.columns),
            cell_of(area.upper.x(), t_.spacing_x, t_.columns) + 1,
            cell_of(area.lower.z(), t_.spacing_z, t_.rows),
            cell_of(area.upper.z(), t_.spacing_z, t_.rows) + 1};
}

Vec3 Heightfield::sample(std::uint32_t i, std::uint32_t k) const {
    return {(static_cast<float>(i) - half_of(t_.columns)) * t_.spacing_x,
            height(i, k),
            (static_cast<float>(k) - half_of(t_.rows)) * t_.spacing_z};
}

/// Half 0: (i, k), (i+1, k+1), (i+1, k); half 1: (i, k), (i, k+1), (i+1, k+1).
Triangle Heightfield::bare_triangle(std::uint32_t i, std::uint32_t k, std::uint32_t half) const {
    Triangle t;
    t.corner[0] = sample(i, k);
    t.corner[1] = half == 0 ? sample(i + 1, k + 1) : sample(i, k + 1);
    t.corner[2] = half == 0 ? sample(i + 1, k) : sample(i + 1, k + 1);
    float area = 0.0F;
    t.normal = triangle_normal(t.corner[0], t.corner[1], t.corner[2], area);
    t.id = 2 * (k * (t_.columns - 1) + i) + half;
    return t;
}

Triangle Heightfield::triangle(std::uint32_t i, std::uint32_t k, std::uint32_t half) const {
    Triangle t = bare_triangle(i, k, half);
    // The triangle across an edge, and which of its corners is not on the edge.
    const auto beyond = [&](std::size_t edge,
                            bool there,
                            std::uint32_t ni,
                            std::uint32_t nk,
                            std::uint32_t nhalf,
                            std::size_t apex) {
        if (!there) {
            t.bend[edge] = EdgeBend::open();
            return;
        }
        const Triangle other = bare_triangle(ni, nk, nhalf);
        t.bend[edge] = bend_towards(t, edge, other.normal, other.corner[apex]);
    };
    if (half == 0) {
        beyond(0, true, i, k, 1, 1);                    // the diagonal
        beyond(1, i + 2 < t_.columns, i + 1, k, 1, 2);  // towards +x
        beyond(2, k > 0, i, k - 1, 1, 0);               // towards -z
    } else {
        beyond(0, i > 0, i - 1, k, 0, 0);            // towards -x
        beyond(1, k + 2 < t_.rows, i, k + 1, 0, 1);  // towards +z
        beyond(2, true, i, k, 0, 2);                 // the diagonal
    }
    return t;
}

bool Heightfield::triangle_at(const Vec3& p, Triangle& out) const {
    const Aabb whole = box();
    if (!(p.x() >= whole.lower.x() && p.x() <= whole.upper.x() && p.z() >= whole.lower.z() &&
          p.z() <= whole.upper.z())) {
        return false;
    }
    const std::uint32_t i = cell_of(p.x(), t_.spacing_x, t_.columns);
    const std::uint32_t k = cell_of(p.z(), t_.spacing_z, t_.rows);
    const Vec3 corner = sample(i, k);
    const float x = (p.x() - corner.x()) / t_.spacing_x;
    const float z = (p.z() - corner.z()) / t_.spacing_z;
    out = triangle(i, k, x >= z ? 0 : 1);
    return true;
}

core::Result<std::shared_ptr<const Heightfield>> build_heightfield(std::span<const float> samples,
                                                                   const FieldOptions& options) {
    using Built = core::Result<std::shared_ptr<const Heightfield>>;
    const auto fits = [](std::uint32_t n) {
        return n >= 2 && n <= kMaxFieldSamples;
    };
    if (!fits(options.columns) || !fits(options.rows)) {
        return Built::failure("heightfield: columns and rows must be 2.." +
                              std::to_string(kMaxFieldSamples));
    }
    if (samples.size() != static_cast<std::size_t>(options.columns) * options.rows) {
        return Built::failure("heightfield: has " + std::to_string(samples.size()) +
                              " samples instead of columns times rows");
    }
    for (const float spacing : {options.spacing_x, options.spacing_z}) {
        if (!(spacing >= kMinSize && spacing <= kMaxSize)) {
            return Built::failure("heightfield: spacing out of range");
        }
    }
    if (!(options.thickness >= 0.0F && options.thickness <= kMaxSize)) {
        return Built::failure("heightfield: thickness out of range");
    }
    Heightfield::HeightfieldTables t;
    t.thickness = options.thickness;
    t.columns = options.columns;
    t.rows = options.rows;
    t.spacing_x = options.spacing_x;
    t.spacing_z = options.spacing_z;
    t.lowest = INFINITY;
    t.highest = -INFINITY;
    t.heights.resize(samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const float height = samples[i] * options.scale + options.offset;
        if (!(std::abs(height) <= kMaxSize)) {
            return Built::failure("heightfield: sample " + std::to_string(i % options.columns) +
                                  " of row " + std::to_string(i / options.columns) +
                                  " is not finite or out of range");
        }
        t.heights[i] = height;
        t.lowest = std::min(t.lowest, height);
        t.highest = std::max(t.highest, height);
    }
    const float width = static_cast<float>(std::max(t.columns - 1, t.rows - 1)) *
                        std::max(t.spacing_x, t.spacing_z);
    if (width > kMaxCoordinate) {
        return Built::failure("heightfield: larger than " + std::to_string(kMaxCoordinate) + " m");
    }
    return std::shared_ptr<const Heightfield>(std::make_shared<const Heightfield>(std::move(t)));
}

Shape Shape::heightfield(std::shared_ptr<const Heightfield> field) {
    Shape shape;
    shape.kind = ShapeKind::kHeightfield;
    shape.geometry = std::move(field);
    return shape;
}

}  // namespace zoned::physics
