#include "server/physics/shapes/compound/outer_hull.h"

#include "server/physics/shapes/convex/hull.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace zoned::physics {

namespace {

/// Directions in which a ball is touched: the 26 to the faces, edges and corners of a cube.
template <class Visit>
void for_each_direction(Visit&& visit) {
    for (int i = 0; i < 27; ++i) {
        const Vec3 v(static_cast<float>(i % 3 - 1),
                     static_cast<float>(i / 3 % 3 - 1),
                     static_cast<float>(i / 9 - 1));
        if (!v.isZero(0.0F)) {
            visit(Vec3(v.normalized()));
        }
    }
}

/// No point of a ball is farther off one of these directions than a face's middle ring: the angle
/// between (1, 1, 0) and the triangle that it forms with (1, 1, 1) and (1, 0, 0), about 24 degrees.
constexpr float kBallCut = 0.09F;

struct Outline {
    std::vector<Vec3> points;
    float cut_off = 0.0F;

    void add_ball(const Frame& frame, const Vec3& centre, float radius) {
        for_each_direction([&](const Vec3& way) {
            points.push_back(frame.position + frame.rotation * Vec3(centre + radius * way));
        });
        cut_off = std::max(cut_off, kBallCut * radius);
    }

    void add(const CompoundPart& part) {
        const Shape& shape = part.shape;
        switch (shape.kind) {
            case ShapeKind::kSphere:
                add_ball(part.frame, Vec3::Zero(), shape.radius);
                return;
            case ShapeKind::kCapsule:
                for (const float end : {-shape.half_segment, shape.half_segment}) {
                    add_ball(part.frame, Vec3(0.0F, end, 0.0F), shape.radius);
                }
                return;
            case ShapeKind::kBox:
                for (int i = 0; i < 8; ++i) {
                    const Vec3 sign((i & 1) != 0 ? 1.0F : -1.0F,
                                    (i & 2) != 0 ? 1.0F : -1.0F,
                                    (i & 4) != 0 ? 1.0F : -1.0F);
                    points.push_back(part.frame.position +
                                     part.frame.rotation * sign.cwiseProduct(shape.half_extents));
                }
                return;
            case ShapeKind::kHull: {
                const HullView view = hull_of(shape).view();
                for (int i = 0; i < view.points.count; ++i) {
                    points.push_back(part.frame.position + part.frame.rotation * view.points[i]);
                }
                return;
            }
            default:
                return;
        }
    }
};

}  // namespace

core::Result<OuterHull> outer_hull_of(const Compound& compound) {
    using Made = core::Result<OuterHull>;
    Outline outline;
    CompoundPart part;
    bool first = true;
    for (const Compound::CompoundChild& p : compound.parts()) {
        if (p.part.sensor) {
            continue;
        }
        outline.add(p.part);
        if (first) {
            part.material = p.part.material;
            part.filter = p.part.filter;
            first = false;
        }
    }
    const auto hull = build_hull(outline.points);
    if (!hull) {
        return Made::failure(hull.error());
    }
    part.shape = Shape::hull(hull->hull);
    part.frame = hull->frame;
    // The mass properties stay: about the same centre, along the same axes.
    const Vec3 moments = compound.mass() * compound.moments_per_kg();
    const auto built =
        build_compound({&part, 1}, compound.mass(), Vec3::Zero(), Mat3(moments.asDiagonal()));
    return built ? Made({built->compound, std::max(outline.cut_off, hull->cut_off)})
                 : Made::failure(built.error());
}

}  // namespace zoned::physics
