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

core::SharedColumn<Platform> column_of(std::vector<Platform> platforms) {
    for (Platform& platform : platforms) {
        ZONED_ASSERT(platform.path.stops.size() > 1, "a platform has stops to travel between");
        for (float& coordinate : platform.box.centre) {
            coordinate = on_platform_step(static_cast<double>(coordinate));
        }
    }
    return platforms.empty() ? core::SharedColumn<Platform>()
                             : core::SharedColumn<Platform>(std::move(platforms));
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
                               std::vector<Door> doors,
                               std::vector<Platform> platforms)
    : fixed_(boxes.size()),
      doors_(std::move(doors)),
      platforms_(column_of(std::move(platforms))),
      surfaces_(std::vector<PlacedSurface>(surfaces.begin(), surfaces.end())),
      ground_height_(ground_height),
      cell_m_(cell_m) {
    ZONED_ASSERT(cell_m > 0.0F, "a cell has a size");
    for (const Door& door : doors_) {
        ZONED_ASSERT(door.times.period > 0, "the timetable of a door has a period");
        boxes.push_back(door.box);
    }
    for (const Platform& platform : platforms_) {
        boxes.push_back(platform.box);
    }
    boxes_ = core::SharedColumn(std::move(boxes));
    index_boxes();
}

bool StaticGeometry::open_at(std::uint32_t door, Tick tick) const {
    const Door& it = doors_[door];
    if (it.by_rules && courses_ && tick != kAllDoorsOpen) {
        if (const std::optional<bool> open = courses_->open_at(*it.by_rules, tick)) {
            return *open;
        }
    }
    return it.times.open_at(tick);
}

Tick StaticGeometry::next_turn(Tick tick) const {
    Tick next = Timetable::kNever;
    for (const Door& door : doors_) {
        next = std::min(next, door.by_rules ? tick + 1 : door.times.next_change(tick));
    }
    return next;
}

StaticGeometry StaticGeometry::with_courses(
    std::shared_ptr<const DoorCourses> doors,
    std::shared_ptr<const PlatformCourses> platforms) const {
    StaticGeometry out = *this;
    out.courses_ = std::move(doors);
    out.platform_courses_ = std::move(platforms);
    return out;
}

Tick StaticGeometry::along_at(std::uint32_t platform, Tick tick) const {
    const PlatformPath& path = platforms_[platform].path;
    if (!path.by_rules) {
        return path.along_at(tick);
    }
    const PlatformCourse* course =
        platform_courses_ ? platform_courses_->at(*path.by_rules, tick) : nullptr;
    return course == nullptr ? path.start : course->along_at(tick);
}

StaticBox StaticGeometry::platform_box(std::uint32_t platform, Tick tick) const {
    StaticBox box = platforms_[platform].box;
    box.centre += platform_offset(platform, tick);
    return box;
}

StaticGeometry StaticGeometry::without_platforms() const {
    StaticGeometry out = *this;
    out.platforms_ = {};
    out.platform_courses_ = nullptr;
    return out;
}

StaticGeometry StaticGeometry::around(const Aabb& area) const {
    std::vector<StaticBox> boxes;
    std::vector<Aabb> bounds;
    std::vector<Mat3> axes;
    std::vector<std::uint32_t> numbers;
    for_each_near(area, [&](std::uint32_t box) {
        numbers.push_back(static_cast<std::uint32_t>(boxes.size()));
        boxes.push_back(boxes_[box]);
        bounds.push_back(bounds_[box]);
        axes.push_back(axes_[box]);
    });
    std::vector<PlacedSurface> surfaces;
    for (const PlacedSurface& surface : surfaces_) {
        if (surface.bounds().overlaps(area)) {
            surfaces.push_back(surface);
        }
    }
    StaticGeometry out;
    out.ground_height_ = ground_height_;
    out.surfaces_ = core::SharedColumn(std::move(surfaces));
    if (boxes.empty()) {
        return out;
    }
    // All of it is one cell.
    out.fixed_ = boxes.size();
    out.cell_start_ =
        core::SharedColumn(std::vector<std::uint32_t>{0, static_cast<std::uint32_t>(boxes.size())});
    out.cell_items_ = core::SharedColumn(std::move(numbers));
    out.cells_x_ = out.cells_z_ = 1;
    out.boxes_ = core::SharedColumn(std::move(boxes));
    out.bounds_ = core::SharedColumn(std::move(bounds));
    out.axes_ = core::SharedColumn(std::move(axes));
    return out;
}

void StaticGeometry::index_boxes() {
    std::vector<Mat3> axes;
    std::vector<Aabb> bounds;
    axes.reserve(boxes_.size());
    bounds.reserve(boxes_.size());
    for (const StaticBox& box : boxes_) {
        axes.emplace_back(box.orientation.toRotationMatrix());
        bounds.push_back(bounds_of(box, axes.back()));
    }
    for (std::uint32_t p = 0; p < platforms_.size(); ++p) {
        Aabb& all = bounds[first_platform() + p];
        const Aabb first = all;
        for (const PlatformStop& stop : platforms_[p].path.stops) {
            all.lower = all.lower.cwiseMin(first.lower + stop.offset);
            all.upper = all.upper.cwiseMax(first.upper + stop.offset);
        }
    }
    axes_ = core::SharedColumn(std::move(axes));
    bounds_ = core::SharedColumn(std::move(bounds));
    if (!bounds_.empty()) {
        index_cells();
    }
}

void StaticGeometry::index_cells() {
    Vec3 lower = bounds_[0].lower;
    Vec3 upper = bounds_[0].upper;
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
    cells_x_ = cells_z_ = kMaxCells;  // until they are counted
    const CellRange all = cells_over({lower, upper});
    cells_x_ = all.x1 + 1;
    cells_z_ = all.z1 + 1;

    const auto visit_cells = [&](auto&& visit) {
        for (std::uint32_t i = 0; i < bounds_.size(); ++i) {
            const CellRange over = cells_over(bounds_[i]);
            for (int z = over.z0; z <= over.z1; ++z) {
                for (int x = over.x0; x <= over.x1; ++x) {
                    visit(static_cast<std::size_t>(z * cells_x_ + x), i);
                }
            }
        }
    };
    std::vector<std::uint32_t> start(
        static_cast<std::size_t>(cells_x_) * static_cast<std::size_t>(cells_z_) + 1, 0);
    visit_cells([&](std::size_t cell, std::uint32_t) { ++start[cell + 1]; });
    for (std::size_t c = 1; c < start.size(); ++c) {
        start[c] += start[c - 1];
    }
    std::vector<std::uint32_t> items(start.back());
    std::vector<std::uint32_t> fill(start.begin(), start.end() - 1);
    visit_cells([&](std::size_t cell, std::uint32_t i) { items[fill[cell]++] = i; });
    cell_start_ = core::SharedColumn(std::move(start));
    cell_items_ = core::SharedColumn(std::move(items));
}

StaticGeometry StaticGeometry::with_shut(std::span<const std::uint32_t> shut) const {
    StaticGeometry out = *this;
    out.doors_ = {};
    out.platforms_ = {};
    std::vector<StaticBox> boxes(boxes_.begin(), boxes_.begin() + fixed_);
    for (const std::uint32_t number : shut) {
        boxes.push_back(doors_[number].box);
    }
    out.fixed_ = boxes.size();
    out.boxes_ = core::SharedColumn(std::move(boxes));
    out.cell_start_ = {};
    out.cell_items_ = {};
    out.index_boxes();
    return out;
}

float StaticGeometry::floor_at(float x, float z) const {
    float floor = ground_height_;
    for (const PlacedSurface& placed : surfaces_) {
        floor = std::max(floor, placed.top_at(x, z).value_or(floor));
    }
    return floor;
}

CellRange StaticGeometry::cells_over(const Aabb& area) const {
    // Clamped before the conversion, which is undefined for what an int cannot hold.
    const auto cell_of = [this](float offset, int cells) {
        const float cell = offset / cell_m_;
        return cell > 0.0F ? static_cast<int>(std::min(cell, static_cast<float>(cells - 1))) : 0;
    };
    return {cell_of(area.lower.x() - origin_x_, cells_x_),
            cell_of(area.upper.x() - origin_x_, cells_x_),
            cell_of(area.lower.z() - origin_z_, cells_z_),
            cell_of(area.upper.z() - origin_z_, cells_z_)};
}

std::uint32_t StaticGeometry::next_in(const CellRange& cells,
                                      std::uint32_t first,
                                      std::uint32_t end) const {
    // Merges the few sorted lists: no memory, ascending, no doubles.
    std::uint32_t best = end;
    for (int z = cells.z0; z <= cells.z1; ++z) {
        for (int x = cells.x0; x <= cells.x1; ++x) {
            const auto cell = static_cast<std::size_t>(z * cells_x_ + x);
            const auto stop = cell_items_.begin() + cell_start_[cell + 1];
            const auto it = std::lower_bound(cell_items_.begin() + cell_start_[cell], stop, first);
            if (it != stop && *it < best) {
                best = *it;
            }
        }
    }
    return best;
}

}  // namespace zoned::motion
