#include "shared/motion/capsule_sweep.h"

#include <algorithm>

namespace zoned::motion {

namespace {

/// A move that nears an obstacle by less than this passes it, m: it absorbs the rounding of a move
/// that was made parallel to the obstacle.
constexpr float kGraze = 5e-5F;
/// The sweep ends this close before the first contact, m.
constexpr float kTolerance = 2e-5F;
constexpr int kNewtonSteps = 8;
constexpr int kPartingPasses = 8;

/// A capsule's segment in the axes of a box.
struct LocalSegment {
    Vec3 middle;
    Vec3 half;
};

LocalSegment local_segment(const StaticBox& box,
                           const Mat3& axes,
                           const Vec3& position,
                           float half_segment) {
    return {axes.transpose() * (position - box.centre), axes.row(1).transpose() * half_segment};
}

/// The vertical part of the most upward of the faces that `found` lies on.
float face_up(const Mat3& axes, const SegmentBoxDistance& found) {
    float up = -1.0F;
    for (int axis = 0; axis < 3; ++axis) {
        if (found.faces[axis] != 0.0F) {
            up = std::max(up, found.faces[axis] * axes(1, axis));
        }
    }
    return up;
}

/// Newton's iteration for the share of a move after which a capsule is `reach` away from an
/// obstacle. `distance_at(s)` gives its `normal` and `distance` after the share s, both as `way`
/// sees them. The last of these stay in `found`. Negative: it is not reached.
template <class Found, class DistanceAt>
float first_contact(const Vec3& way, float reach, DistanceAt&& distance_at, Found& found) {
    float s = 0.0F;
    for (int step = 0; step < kNewtonSteps; ++step) {
        found = distance_at(s);
        const float approach = -found.normal.dot(way);
        if (approach * (1.0F - s) <= kGraze) {
            return -1.0F;
        }
        const float gap = found.distance - reach;
        if (gap <= kTolerance) {
            break;
        }
        s += gap / approach;
        if (s >= 1.0F) {
            return -1.0F;
        }
    }
    return s;
}

}  // namespace

SegmentBoxDistance distance_to(const Capsule& capsule,
                               const Vec3& position,
                               const StaticBox& box,
                               const Mat3& axes) {
    const LocalSegment segment = local_segment(box, axes, position, capsule.half_segment);
    return segment_box_distance(segment.middle, segment.half, box.half_extents);
}

bool overlaps(const Capsule& capsule,
              const Vec3& position,
              const StaticBox& box,
              const Mat3& axes) {
    return distance_to(capsule, position, box, axes).distance < capsule.radius + kLeastAir;
}

CapsuleSweep::CapsuleSweep(const StaticGeometry& world,
                           const Capsule& capsule,
                           const Aabb& area,
                           Tick tick,
                           const PassedPlatforms* passed)
    : world_(world),
      tick_(tick),
      capsule_(capsule),
      reach_(Vec3(capsule.radius, capsule.radius + capsule.half_segment, capsule.radius) +
             Vec3::Constant(2.0F * kSkin)),
      floor_height_(world.ground_height() + capsule.half_segment + capsule.radius) {
    const Aabb reached{area.lower - reach_, area.upper + reach_};
    world.for_each_near(reached, tick, [this](std::uint32_t box) {
        if (near_count_ < near_.size()) {
            near_[near_count_] = box;
        }
        ++near_count_;
    });
    for (const PlacedSurface& placed : world.surfaces()) {
        // An obstacle above the area may have to push the capsule up and out.
        const Aabb& bounds = placed.bounds();
        near_surfaces_ =
            near_surfaces_ ||
            (bounds.lower.x() <= reached.upper.x() && bounds.upper.x() >= reached.lower.x() &&
             bounds.lower.z() <= reached.upper.z() && bounds.upper.z() >= reached.lower.z());
    }
    if (!world.platforms().empty() && tick != kAllDoorsOpen &&
        (passed == nullptr || !passed->all)) {
        passed_ = passed;
        world.for_each_platform_near(reached, [this](std::uint32_t) { near_platforms_ = true; });
    }
}

SweepHit CapsuleSweep::sweep_ground(const Vec3& from, const Vec3& move) const {
    SweepHit hit;
    const float gap = from.y() - floor_height_;
    if (move.y() < 0.0F && gap < -move.y()) {
        hit.hit = true;
        hit.ground_plane = true;
        hit.fraction = std::max(gap, 0.0F) / -move.y();
    }
    return hit;
}

SweepHit CapsuleSweep::sweep_box(const StaticBox& box,
                                 const Mat3& axes,
                                 const Vec3& from,
                                 const Vec3& move) const {
    const LocalSegment segment = local_segment(box, axes, from, capsule_.half_segment);
    const Vec3 way = axes.transpose() * move;
    const auto distance_at = [&](float s) {
        return segment_box_distance(segment.middle + s * way, segment.half, box.half_extents);
    };
    SegmentBoxDistance found;
    const float s = first_contact(way, capsule_.radius + kSkin, distance_at, found);
    if (s < 0.0F) {
        return {};
    }
    return {s, true, false, axes * found.normal, face_up(axes, found)};
}

SweepHit CapsuleSweep::sweep_triangle(const FacedTriangle& triangle,
                                      const Vec3& from,
                                      const Vec3& move) const {
    if (triangle.height(from) < 0.0F) {
        return {};
    }
    const Vec3 half(0.0F, capsule_.half_segment, 0.0F);
    const auto distance_at = [&](float s) {
        return segment_triangle_distance(from + s * move, half, triangle);
    };
    SegmentTriangleDistance found;
    const float s = first_contact(move, capsule_.radius + kSkin, distance_at, found);
    if (s < 0.0F) {
        return {};
    }
    return {s, true, false, found.normal, triangle.normal.y()};
}

SweepHit CapsuleSweep::sweep(const Vec3& from, const Vec3& move) const {
    SweepHit first = sweep_ground(from, move);
    for_each_on_path(from, move, [&](std::uint32_t box) {
        const SweepHit hit = sweep_box(box, from, move);
        if (hit.hit && (!first.hit || hit.fraction < first.fraction)) {
            first = hit;
        }
        return false;
    });
    if (near_surfaces_) {
        const SweepHit hit = sweep_surfaces(from, move, [](const SweepHit&) { return true; });
        if (hit.hit && (!first.hit || hit.fraction < first.fraction)) {
            first = hit;
        }
    }
    if (near_platforms_) {
        const SweepHit hit = sweep_platforms(from, move, [](const SweepHit&) { return true; });
        if (hit.hit && (!first.hit || hit.fraction < first.fraction)) {
            first = hit;
        }
    }
    return first;
}

bool CapsuleSweep::part_from_surfaces(Vec3& position) const {
    bool overlapped = false;
    for (const PlacedSurface& placed : world_.surfaces()) {
        // A capsule below a height grid comes up out of it, as bodies do.
        if (placed.surface().is_grid() && placed.surface().behind(placed.to_local(position))) {
            const auto top = placed.top_at(position.x(), position.z());
            if (top) {
                position.y() = *top + capsule_.half_segment + capsule_.radius + kSkin;
                overlapped = true;
            }
        }
    }
    const Vec3 half(0.0F, capsule_.half_segment, 0.0F);
    const Vec3 begin = position;
    for_each_triangle(
        begin, Vec3::Zero(), [&](const PlacedSurface& placed, const FacedTriangle& t) {
            const Vec3 local = placed.to_local(position);
            if (t.height(local) < 0.0F) {
                return;
            }
            const SegmentTriangleDistance found = segment_triangle_distance(local, half, t);
            if (found.distance < capsule_.radius + kLeastAir) {
                position += placed.turned_to_world(found.normal) *
                            (capsule_.radius + 0.5F * kSkin - found.distance);
                overlapped = true;
            }
        });
    return overlapped;
}

Vec3 CapsuleSweep::parted(Vec3 position, float most_of_doors) const {
    const std::size_t fixed = world_.boxes().size();
    for (int pass = 0; pass < kPartingPasses; ++pass) {
        bool overlapped = false;
        for_each_on_path(position, Vec3::Zero(), [&](std::uint32_t index) {
            const StaticBox& box = world_.box(index);
            const Mat3& axes = world_.box_axes(index);
            const SegmentBoxDistance found = distance_to(capsule_, position, box, axes);
            if (found.distance < capsule_.radius + kLeastAir) {
                float out = capsule_.radius + 0.5F * kSkin - found.distance;
                if (index >= fixed) {
                    out = std::min(out, most_of_doors);
                    most_of_doors -= out;
                }
                position += axes * found.normal * out;
                overlapped = true;
            }
            return false;
        });
        if (near_surfaces_ && part_from_surfaces(position)) {
            overlapped = true;
        }
        if (position.y() < floor_height_) {
            position.y() = floor_height_;
            overlapped = overlapped || pass == 0;
        }
        if (!overlapped) {
            break;
        }
    }
    return position;
}

}  // namespace zoned::motion
