#include "shared/motion/static_geometry.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <utility>

namespace zoned::motion {

namespace {

/// A world may be wide and hold little: never more cells than this.
constexpr int kMaxCells = 1'000'000;

Aabb bounds_of(const StaticBox& box, const Mat3& axes) {
    // Half extents of a rotated box along the axes: |R| h (Ericson, Real-Time Collision
    // Detection, 4.2.6).
    const Vec3 half = axes.cwiseAbs() * box.half_extents;
    return {box.centre - half, box.centre + half};
}

}  // namespace

PlacedSurface::PlacedSurface(const StaticSurface& from)
    : surface_(from.surface),
      position_(from.position),
      axes_(from.orientation.toRotationMatrix()) {
    const Aabb& box = surface_->box();
    const Vec3 half = 0.5F * (box.upper - box.lower);
    const Vec3 centre = to_world(0.5F * (box.upper + box.lower));
    const Vec3 reach = axes_.cwiseAbs() * half;
    bounds_ = {centre - reach, centre + reach};
}

std::optional<float> PlacedSurface::top_at(float x, float z) const {
    if (x < bounds_.lower.x() || x > bounds_.upper.x() || z < bounds_.lower.z() ||
        z > bounds_.upper.z()) {
        return std::nullopt;
    }
    const Vec3 at = to_local(Vec3(x, 0.0F, z));
    std::optional<float> top = surface_->top_at(at.x(), at.z());
    if (top) {
        *top += position_.y();
    }
    return top;
}

StaticGeometry::StaticGeometry(std::vector<StaticBox> boxes,
                               float ground_height,
                               float cell_m,
                               const std::vector<StaticSurface>& surfaces,
                               std::vector<Door> doors)
    : boxes_(std::move(boxes)),
      fixed_(boxes_.size()),
      doors_(std::move(doors)),
      surfaces_(surfaces.begin(), surfaces.end()),
      ground_height_(ground_height),
      cell_m_(cell_m) {
    ZONED_ASSERT(cell_m > 0.0F, "a cell has a size");
    for (const Door& door : doors_) {
        ZONED_ASSERT(door.times.period > 0, "the timetable of a door has a period");
        boxes_.push_back(door.box);
    }
    if (!boxes_.empty()) {
        index_boxes();
    }
}

void StaticGeometry::index_boxes() {
    bounds_.reserve(boxes_.size());
    axes_.reserve(boxes_.size());
    for (const StaticBox& box : boxes_) {
        axes_.emplace_back(box.orientation.toRotationMatrix());
        bounds_.push_back(bounds_of(box, axes_.back()));
    }
    Vec3 lower = bounds_.front().lower;
    Vec3 upper = bounds_.front().upper;
    for (const Aabb& b : bounds_) {
        lower = lower.cwiseMin(b.lower);
        upper = upper.cwiseMax(b.upper);
    }
    while ((upper.x() - lower.x()) / cell_m_ * ((upper.z() - lower.z()) / cell_m_) >
           static_cast<float>(kMaxCells)) {
        cell_m_ *= 2.0F;
    }
    origin_x_ = lower.x();
    origin_z_ = lower.z();
    cells_x_ = cell_of(upper.x(), origin_x_, kMaxCells) + 1;
    cells_z_ = cell_of(upper.z(), origin_z_, kMaxCells) + 1;

    const auto visit_cells = [&](auto&& visit) {
        for (std::uint32_t i = 0; i < bounds_.size(); ++i) {
            for (int z = cell_of(bounds_[i].lower.z(), origin_z_, cells_z_);
                 z <= cell_of(bounds_[i].upper.z(), origin_z_, cells_z_);
                 ++z) {
                for (int x = cell_of(bounds_[i].lower.x(), origin_x_, cells_x_);
                     x <= cell_of(bounds_[i].upper.x(), origin_x_, cells_x_);
                     ++x) {
                    visit(static_cast<std::size_t>(z * cells_x_ + x), i);
                }
            }
        }
    };
    cell_start_.assign(static_cast<std::size_t>(cells_x_) * static_cast<std::size_t>(cells_z_) + 1,
                       0);
    visit_cells([&](std::size_t cell, std::uint32_t) { ++cell_start_[cell + 1]; });
    for (std::size_t c = 1; c < cell_start_.size(); ++c) {
        cell_start_[c] += cell_start_[c - 1];
    }
    cell_items_.resize(cell_start_.back());
    std::vector<std::uint32_t> fill(cell_start_.begin(), cell_start_.end() - 1);
    visit_cells([&](std::size_t cell, std::uint32_t i) { cell_items_[fill[cell]++] = i; });
}

StaticGeometry StaticGeometry::with_shut(std::span<const std::uint32_t> shut) const {
    StaticGeometry out = *this;
    out.doors_.clear();
    out.boxes_.resize(fixed_);
    for (const std::uint32_t number : shut) {
        out.boxes_.push_back(doors_[number].box);
    }
    out.fixed_ = out.boxes_.size();
    out.bounds_.clear();
    out.axes_.clear();
    out.cell_start_.clear();
    out.cell_items_.clear();
    if (!out.boxes_.empty()) {
        out.index_boxes();
    }
    return out;
}

float StaticGeometry::floor_at(float x, float z) const {
    float floor = ground_height_;
    for (const PlacedSurface& placed : surfaces_) {
        floor = std::max(floor, placed.top_at(x, z).value_or(floor));
    }
    return floor;
}

int StaticGeometry::cell_of(float coordinate, float origin, int cells) const {
    // Clamped before the conversion, which is undefined for what an int cannot hold.
    const float cell = (coordinate - origin) / cell_m_;
    return cell > 0.0F ? static_cast<int>(std::min(cell, static_cast<float>(cells - 1))) : 0;
}

}  // namespace zoned::motion
