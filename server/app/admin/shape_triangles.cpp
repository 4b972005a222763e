#include "server/app/admin/shape_triangles.h"

#include "server/physics/shapes/compound/compound.h"
#include "server/physics/shapes/convex/hull.h"

#include <cmath>
#include <numbers>

namespace zoned::app {

namespace {

constexpr int kAround = 12;
constexpr int kRings = 6;  ///< of half a turn; even, so that the middle one can be drawn out

void add_faces(const physics::HullView& hull, std::vector<Vec3>& out) {
    for (int f = 0; f < hull.face_count; ++f) {
        const physics::HullFace& face = hull.faces[f];
        for (int i = 1; i + 1 < face.corners; ++i) {
            out.insert(out.end(),
                       {hull.corner(face, 0), hull.corner(face, i), hull.corner(face, i + 1)});
        }
    }
}

/// A sphere whose upper and lower halves are `half_segment` from the middle.
void add_round(float radius, float half_segment, std::vector<Vec3>& out) {
    const auto corner = [&](int ring, int step, float shift) {
        const float up = std::numbers::pi_v<float> * (static_cast<float>(ring) / kRings - 0.5F);
        const float turn = 2.0F * std::numbers::pi_v<float> * static_cast<float>(step) / kAround;
        return Vec3(radius * std::cos(up) * std::sin(turn),
                    radius * std::sin(up) + shift,
                    radius * std::cos(up) * std::cos(turn));
    };
    const auto add_quad = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
        out.insert(out.end(), {a, b, c, a, c, d});
    };
    for (int step = 0; step < kAround; ++step) {
        for (int ring = 0; ring < kRings; ++ring) {
            const float shift = ring < kRings / 2 ? -half_segment : half_segment;
            add_quad(corner(ring, step, shift),
                     corner(ring, step + 1, shift),
                     corner(ring + 1, step + 1, shift),
                     corner(ring + 1, step, shift));
        }
        if (half_segment > 0.0F) {
            add_quad(corner(kRings / 2, step, -half_segment),
                     corner(kRings / 2, step + 1, -half_segment),
                     corner(kRings / 2, step + 1, half_segment),
                     corner(kRings / 2, step, half_segment));
        }
    }
}

}  // namespace

std::vector<Vec3> triangles_of(const physics::Shape& shape) {
    std::vector<Vec3> out;
    switch (shape.kind) {
        case physics::ShapeKind::kSphere:
            add_round(shape.radius, 0.0F, out);
            break;
        case physics::ShapeKind::kCapsule:
            add_round(shape.radius, shape.half_segment, out);
            break;
        case physics::ShapeKind::kBox:
            add_faces(physics::BoxHull(shape.half_extents).view(), out);
            break;
        case physics::ShapeKind::kHull:
            add_faces(physics::hull_of(shape).view(), out);
            break;
        case physics::ShapeKind::kCompound:
            for (const auto& child : physics::compound_of(shape).parts()) {
                for (const Vec3& corner : triangles_of(child.part.shape)) {
                    out.push_back(child.part.frame.position + child.rotation * corner);
                }
            }
            break;
        case physics::ShapeKind::kPlane:
        case physics::ShapeKind::kMesh:
        case physics::ShapeKind::kHeightfield:
            break;
    }
    return out;
}

}  // namespace zoned::app
