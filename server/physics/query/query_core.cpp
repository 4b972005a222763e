#include "server/physics/query/query_core.h"

#include "server/physics/narrowphase/gjk.h"
#include "server/physics/shapes/convex/hull.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// Surfaces closer than this touch, relative to one metre and the extent of the shapes.
constexpr double kSurfacesTouch = 1.0e-6;
/// Grazing contacts halve the remaining distance with each advance; all others take three or four.
constexpr int kMaxAdvances = 48;

}  // namespace

void ConvexCore::add(const Vec3& corner) {
    const auto i = static_cast<std::size_t>(count_++);
    x_[i] = corner.x();
    y_[i] = corner.y();
    z_[i] = corner.z();
    extent_ = std::max(extent_, corner.cwiseAbs().maxCoeff());
}

/// Fills the last group up with the last corner.
void ConvexCore::pad() {
    const Vec3 last = points()[count_ - 1];
    while (count_ % kGroup != 0) {
        add(last);
    }
}

ConvexCore::ConvexCore(const Placed& shape, float inset) : origin_(shape.position.cast<double>()) {
    const Shape& s = shape.shape;
    // No shape is turned inside out: at most half of it goes.
    const auto less = [inset](float size) {
        return size - std::min(inset, 0.5F * size);
    };
    switch (s.kind) {
        case ShapeKind::kBox: {
            const Vec3 half = s.half_extents.unaryExpr(less);
            for (int i = 0; i < 8; ++i) {
                const Vec3 sign((i & 1) != 0 ? 1.0F : -1.0F,
                                (i & 2) != 0 ? 1.0F : -1.0F,
                                (i & 4) != 0 ? 1.0F : -1.0F);
                add(shape.rotation * sign.cwiseProduct(half));
            }
            break;
        }
        case ShapeKind::kCapsule:
            add(shape.rotation.col(1) * s.half_segment);
            add(shape.rotation.col(1) * -s.half_segment);
            radius_ = less(s.radius);
            break;
        case ShapeKind::kHull: {
            const float scale = less(hull_of(s).radius()) / hull_of(s).radius();
            const PointsView corners = hull_of(s).view().points;
            for (int i = 0; i < hull_of(s).vertex_count(); ++i) {
                add(shape.rotation * (scale * corners[i]));
            }
            break;
        }
        default:
            add(Vec3::Zero());
            radius_ = less(s.radius);
            break;
    }
    pad();
}

ConvexCore::ConvexCore(const Triangle& triangle, const Placed& surface)
    : origin_(surface.position.cast<double>() +
              (surface.rotation * triangle.corner[0]).cast<double>()) {
    for (const Vec3& corner : triangle.corner) {
        add(surface.rotation * (corner - triangle.corner[0]));
    }
    pad();
}

ConvexCore::ConvexCore(const Vec3& point) : origin_(point.cast<double>()) {
    add(Vec3::Zero());
    pad();
}

ConvexCore ConvexCore::moved(const Vec3d& shift) const {
    ConvexCore core;
    core.count_ = count_;
    core.extent_ = extent_;
    core.radius_ = radius_;
    core.origin_ = origin_;
    for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) {
        core.x_[i] = static_cast<float>(x_[i] + shift.x());
        core.y_[i] = static_cast<float>(y_[i] + shift.y());
        core.z_[i] = static_cast<float>(z_[i] + shift.z());
    }
    return core;
}

Vec3d ConvexCore::farthest(const Vec3& direction) const {
    const PointsView corners = points();
    float most = -INFINITY;
    for (int i = 0; i < count_; ++i) {
        most = std::max(most, corners[i].dot(direction));
    }
    const float near = most - 1.0e-5F * (1.0F + extent_);
    Vec3d sum = Vec3d::Zero();
    int found = 0;
    for (int i = 0; i < count_; ++i) {
        if (corners[i].dot(direction) >= near) {
            sum += corners[i].cast<double>();
            ++found;
        }
    }
    return origin_ + sum / std::max(found, 1);
}

CoreGap gap_between(const ConvexCore& a, const Vec3d& shift, const ConvexCore& b) {
    // Everything about b's origin: near b's surface, where it counts, numbers are small.
    const ConvexCore at = a.moved(a.origin() + shift - b.origin());
    const Vec3 guess = (b.origin() - a.origin() - shift).cast<float>();
    const Closest nearest = closest_points(at.points(), b.points(), guess);
    CoreGap out;
    out.deep = nearest.overlap || !(nearest.distance > 0.0);
    if (out.deep) {
        out.gap = -(a.radius() + b.radius());
        return out;
    }
    out.gap = nearest.distance - a.radius() - b.radius();
    out.normal = -nearest.normal;
    out.point = b.origin() + nearest.on_b + b.radius() * out.normal;
    return out;
}

namespace {

/// The two touch or overlap at the start.
bool cast_from_touch(const ConvexCore& a,
                     const ConvexCore& inner,
                     const Vec3& direction,
                     const ConvexCore& b,
                     CastHit& hit) {
    const CoreGap clear = gap_between(inner, Vec3d::Zero(), b);
    if (clear.deep || clear.gap <= 0.0) {
        hit = {0.0F, a.origin().cast<float>(), -direction};
        return true;
    }
    hit = {0.0F, clear.point.cast<float>(), clear.normal.cast<float>()};
    return -direction.cast<double>().dot(clear.normal) > kSliding;
}

}  // namespace

bool cast_core(const ConvexCore& a,
               const ConvexCore& inner,
               const Vec3& direction,
               float limit,
               const ConvexCore& b,
               CastHit& hit) {
    const Vec3d along = direction.cast<double>();
    const double touching =
        kSurfacesTouch * (1.0 + static_cast<double>(a.extent()) + static_cast<double>(b.extent()));
    double way = 0.0;
    CoreGap gap = gap_between(a, Vec3d::Zero(), b);
    if (gap.deep || gap.gap <= touching) {
        return cast_from_touch(a, inner, direction, b, hit);
    }
    for (int i = 0; i < kMaxAdvances && gap.gap > touching; ++i) {
        const double closing = -along.dot(gap.normal);
        // To just short of the root, where the normal is still known.
        way += (gap.gap - 0.5 * touching) / closing;
        if (!(closing > 0.0) || !(way <= static_cast<double>(limit))) {
            return false;
        }
        const CoreGap next = gap_between(a, way * along, b);
        if (next.deep) {
            break;  // by rounding: the last normal is the one
        }
        gap = next;
    }
    hit = {static_cast<float>(way), gap.point.cast<float>(), gap.normal.cast<float>()};
    return true;
}

}  // namespace zoned::physics
