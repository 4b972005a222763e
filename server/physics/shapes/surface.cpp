#include "server/physics/shapes/surface.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// Radians that rounding may turn a normal by.
constexpr float kNormalSlack = 1.0e-3F;

}  // namespace

bool Triangle::allows(std::size_t i, const Vec3& unit) const {
    const float up = unit.dot(normal);
    const float out = unit.dot(outward(i));
    if (out <= kNormalSlack) {
        return up > 0.0F;
    }
    return out * bend[i].cosine - up * bend[i].sine <= kNormalSlack;
}

Vec3 triangle_normal(const Vec3& a, const Vec3& b, const Vec3& c, float& twice_area) {
    const Vec3d n =
        (b.cast<double>() - a.cast<double>()).cross(c.cast<double>() - a.cast<double>());
    const double length = n.norm();
    twice_area = static_cast<float>(length);
    return length > 0.0 ? Vec3((n / length).cast<float>()) : Vec3(Vec3::Zero());
}

EdgeBend bend_towards(const Triangle& t, std::size_t i, const Vec3& normal, const Vec3& apex) {
    const float out = normal.dot(t.outward(i));
    const float up = normal.dot(t.normal);
    // A sheet folded onto itself has no bend to read off the normals: the apex tells the side.
    if (out <= kNormalSlack * 0.1F && (up > 0.0F || t.height(apex) > 0.0F)) {
        return EdgeBend::flat();
    }
    const float length = std::sqrt(out * out + up * up);
    return {up / length, std::max(out, 0.0F) / length};
}

}  // namespace zoned::physics
