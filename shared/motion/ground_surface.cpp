#include "shared/motion/ground_surface.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::motion {

namespace {

/// A large triangle stands in many cells: cells are widened until there are no more entries than
/// this for each triangle.
constexpr std::size_t kEntriesPerTriangle = 8;
constexpr float kTall_m = 1e7F;

FacedTriangle faced(const Vec3& a, const Vec3& b, const Vec3& c) {
    const Vec3 cross = (b - a).cross(c - a);
    const float twice_area = cross.norm();
    FacedTriangle t;
    t.corner = {a, b, c};
    // Without an area (rounding may leave none of a tiny one) it faces upwards.
    t.normal = twice_area > 0.0F ? Vec3(cross / twice_area) : Vec3::UnitY();
    return t;
}

float half_of(std::uint32_t samples) {
    return 0.5F * static_cast<float>(samples - 1);
}

/// Height of the triangle's plane over (x, z); none where it does not lie over or under it. Shared
/// edges belong to both sides, so that there is no gap between two triangles.
std::optional<float> height_over(const FacedTriangle& t, float x, float z) {
    const auto side = [&](std::size_t i) {
        const Vec3& a = t.corner[i];
        const Vec3& b = t.corner[(i + 1) % 3];
        return (b.z() - a.z()) * (x - a.x()) - (b.x() - a.x()) * (z - a.z());
    };
    const float s0 = side(0);
    const float s1 = side(1);
    const float s2 = side(2);
    const bool within =
        (s0 >= 0.0F && s1 >= 0.0F && s2 >= 0.0F) || (s0 <= 0.0F && s1 <= 0.0F && s2 <= 0.0F);
    if (!within || std::abs(t.normal.y()) < 1e-5F) {
        return std::nullopt;
    }
    const Vec3& a = t.corner[0];
    return a.y() - (t.normal.x() * (x - a.x()) + t.normal.z() * (z - a.z())) / t.normal.y();
}

}  // namespace

Surface::Surface(const HeightGrid& grid, std::shared_ptr<const void> owner)
    : owner_(std::move(owner)),
      grid_(grid),
      cell_(grid.spacing_x, 1.0F, grid.spacing_z),
      cells_x_(static_cast<int>(grid.columns) - 1),
      cells_z_(static_cast<int>(grid.rows) - 1) {
    ZONED_ASSERT(grid.columns >= 2 && grid.rows >= 2 &&
                     grid.heights.size() == static_cast<std::size_t>(grid.columns) * grid.rows,
                 "a height grid has its samples");
    const auto [low, high] = std::minmax_element(grid.heights.begin(), grid.heights.end());
    const float x = half_of(grid.columns) * grid.spacing_x;
    const float z = half_of(grid.rows) * grid.spacing_z;
    box_ = {Vec3(-x, *low, -z), Vec3(x, *high, z)};
}

Surface::Surface(const TriangleList& mesh, std::shared_ptr<const void> owner)
    : owner_(std::move(owner)),
      mesh_(mesh) {
    ZONED_ASSERT(!mesh.corners.empty(), "a surface has triangles");
    const Vec3& first = mesh.vertices[mesh.corners[0][0]];
    box_ = {first, first};
    for (const auto& corners : mesh.corners) {
        for (const std::uint32_t v : corners) {
            box_.lower = box_.lower.cwiseMin(mesh.vertices[v]);
            box_.upper = box_.upper.cwiseMax(mesh.vertices[v]);
        }
    }
    index_mesh();
}

void Surface::index_mesh() {
    const Vec3 size = (box_.upper - box_.lower).cwiseMax(1e-3F);
    const auto triangles = static_cast<float>(mesh_.corners.size());
    float edge = std::sqrt(size.x() * size.z() / triangles);
    const auto cells_of = [&](std::uint32_t i) {
        const FacedTriangle t = mesh_triangle(i);
        return cells_over({t.corner[0].cwiseMin(t.corner[1]).cwiseMin(t.corner[2]),
                           t.corner[0].cwiseMax(t.corner[1]).cwiseMax(t.corner[2])});
    };
    const auto count_entries = [&] {
        std::size_t entries = 0;
        for (std::uint32_t i = 0; i < mesh_.corners.size(); ++i) {
            const CellRange own = cells_of(i);
            entries += static_cast<std::size_t>(own.x1 - own.x0 + 1) *
                       static_cast<std::size_t>(own.z1 - own.z0 + 1);
        }
        return entries;
    };
    const auto along = [](float length, float cell) {
        return static_cast<int>(std::clamp(length / cell, 0.0F, 65535.0F)) + 1;
    };
    const std::size_t most = kEntriesPerTriangle * mesh_.corners.size() + 64;
    for (;; edge *= 2.0F) {
        cells_x_ = along(size.x(), edge);
        cells_z_ = along(size.z(), edge);
        cell_ = Vec3(
            size.x() / static_cast<float>(cells_x_), 1.0F, size.z() / static_cast<float>(cells_z_));
        const auto cells = static_cast<std::size_t>(cells_x_) * static_cast<std::size_t>(cells_z_);
        if (cells > most) {
            continue;
        }
        const std::size_t entries = count_entries();
        if (entries <= most || cells == 1) {
            cell_start_.assign(cells + 1, 0);
            cell_items_.resize(entries);
            break;
        }
    }
    const auto visit_cells = [&](auto&& visit) {
        for (std::uint32_t i = 0; i < mesh_.corners.size(); ++i) {
            const CellRange own = cells_of(i);
            for (int z = own.z0; z <= own.z1; ++z) {
                for (int x = own.x0; x <= own.x1; ++x) {
                    visit(static_cast<std::size_t>(z) * static_cast<std::size_t>(cells_x_) +
                              static_cast<std::size_t>(x),
                          i);
                }
            }
        }
    };
    visit_cells([&](std::size_t cell, std::uint32_t) { ++cell_start_[cell + 1]; });
    for (std::size_t c = 1; c < cell_start_.size(); ++c) {
        cell_start_[c] += cell_start_[c - 1];
    }
    std::vector<std::uint32_t> fill(cell_start_.begin(), cell_start_.end() - 1);
    visit_cells([&](std::size_t cell, std::uint32_t i) { cell_items_[fill[cell]++] = i; });
}

CellRange Surface::cells_over(const Aabb& area) const {
    // Clamped before the conversion, which is undefined for what an int cannot hold.
    const auto cell_of = [](float offset, float size, int cells) {
        return static_cast<int>(std::clamp(offset / size, 0.0F, static_cast<float>(cells - 1)));
    };
    return {cell_of(area.lower.x() - box_.lower.x(), cell_.x(), cells_x_),
            cell_of(area.upper.x() - box_.lower.x(), cell_.x(), cells_x_),
            cell_of(area.lower.z() - box_.lower.z(), cell_.z(), cells_z_),
            cell_of(area.upper.z() - box_.lower.z(), cell_.z(), cells_z_)};
}

FacedTriangle Surface::grid_triangle(int i, int k, int half) const {
    const auto sample = [this](int column, int row) {
        const auto at =
            static_cast<std::size_t>(row) * grid_.columns + static_cast<std::size_t>(column);
        return Vec3((static_cast<float>(column) - half_of(grid_.columns)) * grid_.spacing_x,
                    grid_.heights[at],
                    (static_cast<float>(row) - half_of(grid_.rows)) * grid_.spacing_z);
    };
    return half == 0 ? faced(sample(i, k), sample(i + 1, k + 1), sample(i + 1, k))
                     : faced(sample(i, k), sample(i, k + 1), sample(i + 1, k + 1));
}

FacedTriangle Surface::mesh_triangle(std::uint32_t index) const {
    const auto& corners = mesh_.corners[index];
    return faced(
        mesh_.vertices[corners[0]], mesh_.vertices[corners[1]], mesh_.vertices[corners[2]]);
}

std::optional<float> Surface::top_at(float x, float z) const {
    std::optional<float> top;
    for_each_near({Vec3(x, -kTall_m, z), Vec3(x, kTall_m, z)}, [&](const FacedTriangle& t) {
        const auto height = height_over(t, x, z);
        if (height && t.normal.y() > 0.0F && (!top || *height > *top)) {
            top = height;
        }
    });
    return top;
}

bool Surface::behind(const Vec3& p) const {
    if (is_grid() && p.y() < box_.lower.y() - grid_.thickness) {
        return false;
    }
    float nearest = kTall_m;
    bool back = false;
    for_each_near({p, Vec3(p.x(), kTall_m, p.z())}, [&](const FacedTriangle& t) {
        const auto height = height_over(t, p.x(), p.z());
        if (height && *height >= p.y() && *height < nearest) {
            nearest = *height;
            back = t.normal.y() > 0.0F;
        }
    });
    return back;
}

}  // namespace zoned::motion
