// build: hot loops
// Holds a node of one soft body off a face of another, with equal and opposite impulses.
#include "server/physics/soft/collision/soft_pairs.h"
#include "shared/math/segment_triangle.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {

namespace {

constexpr float kPartingSpeed = 0.3F;     // m/s: at which an overlap from before ends
constexpr float kTouching = 1.0e-6F;      // m: nearer than this a distance has no direction
constexpr float kSameDistance = 1.0e-5F;  // share by which equal distances differ in rounding

/// The node's distance from a face, and where on it.
struct SkinTouch {
    float distance = INFINITY;   ///< m; negative: the node is on the wrong side
    Vec3 normal = Vec3::Zero();  ///< unit: moving the node along it parts the two
    const SoftFace* face = nullptr;
    std::array<float, 3> weight{};  ///< of its corners, sum 1
};

std::array<float, 3> weights_at(const std::array<Vec3, 3>& c, const TrianglePoint& p) {
    std::array<float, 3> w{};
    if (p.corner >= 0) {
        w[static_cast<std::size_t>(p.corner)] = 1.0F;
        return w;
    }
    if (p.edge >= 0) {
        const auto from = static_cast<std::size_t>(p.edge);
        const std::size_t to = (from + 1) % 3;
        const Vec3 along = c[to] - c[from];
        w[to] = (p.point - c[from]).dot(along) / along.squaredNorm();
        w[from] = 1.0F - w[to];
        return w;
    }
    const Vec3 ab = c[1] - c[0];
    const Vec3 ac = c[2] - c[0];
    const Vec3 n = ab.cross(ac);
    const Vec3 to = p.point - c[0];
    const float twice = 1.0F / n.squaredNorm();
    w[1] = to.cross(ac).dot(n) * twice;
    w[2] = ab.cross(to).dot(n) * twice;
    w[0] = 1.0F - w[1] - w[2];
    return w;
}

/// Where a node was when the substep began.
Vec3 place_before(const SoftBody& body, std::uint32_t node) {
    return (body.asleep ? body.x : body.start)[node].head<3>();
}

/// Height of the node over the face when the substep began.
float height_before(const SoftBody& body,
                    const SoftBody& other,
                    std::uint32_t node,
                    const SoftFace& f) {
    const Vec3 a = place_before(other, f[0]);
    const Vec3 n = (place_before(other, f[1]) - a).cross(place_before(other, f[2]) - a);
    return n.normalized().dot(place_before(body, node) - a);
}

/// The nearest of the faces that the node may not pass says how far off it is, and on which side.
/// Left out are faces that it lay behind when the substep began, farther than a contact errs: it
/// came to them through others. Of faces that share the nearest point the one that looks
/// straightest at the node decides on the side.
SkinTouch nearest_touch(const SoftBody& body,
                        const SoftBody& other,
                        const SkinNode& at,
                        std::span<const NearFace> faces,
                        float thickness) {
    SkinTouch best;
    float nearest = INFINITY;
    float straight = 0.0F;
    const Vec3 x = body.position(at.node);
    for (const NearFace& near : faces) {
        const SoftFace& f = other.skin.faces[near.face];
        const std::array<Vec3, 3> c{
            other.position(f[0]), other.position(f[1]), other.position(f[2])};
        const TrianglePoint p = nearest_on_triangle(c, x);
        const Vec3 d = x - p.point;
        const float length = d.norm();
        const float same = kTouching + kSameDistance * length;
        if (!(length <= nearest + same)) {
            continue;  // nor is it a number where a face has no area
        }
        Vec3 normal = Vec3::Zero();
        float height = length;
        if (near.side != 0.0F) {
            normal = near.side * (c[1] - c[0]).cross(c[2] - c[0]).normalized();
            height = normal.dot(d);
        }
        if (length >= nearest - same && std::abs(height) <= straight) {
            continue;
        }
        if (near.side != 0.0F && !at.inside &&
            near.side * height_before(body, other, at.node, f) < -thickness) {
            continue;
        }
        nearest = std::min(nearest, length);
        straight = std::abs(height);
        const float sign = height < 0.0F ? -1.0F : 1.0F;
        best.distance = sign * length;
        best.normal = length > kTouching ? Vec3(sign / length * d) : normal;
        best.face = &f;
        best.weight = weights_at(c, p);
    }
    return best;
}

float yielding(const SoftBody& body, std::uint32_t node) {
    return body.asleep ? 0.0F : body.x[node].w();
}

}  // namespace

bool hold_off(std::span<SoftBody> bodies,
              const SkinNode& at,
              std::span<const NearFace> faces,
              float h) {
    SoftBody& body = bodies[at.body];
    SoftBody& other = bodies[at.other];
    const float thickness = body.material.thickness + other.material.thickness;
    const SkinTouch touch = nearest_touch(body, other, at, faces, thickness);
    const float gap = touch.distance - thickness;
    if (touch.face == nullptr || gap >= 0.0F) {
        return false;
    }
    const float node_w = yielding(body, at.node);
    std::array<float, 3> face_w{};
    float sum = node_w;
    Vec3 way = body.position(at.node) - place_before(body, at.node);
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t corner = (*touch.face)[k];
        face_w[k] = touch.weight[k] * yielding(other, corner);
        sum += touch.weight[k] * face_w[k];
        way -= touch.weight[k] * (other.position(corner) - place_before(other, corner));
    }
    if (!(sum > 0.0F)) {
        return false;
    }
    // The part that ends the approach changes velocities. The part that ends an overlap from before
    // moves nodes slowly, as it presses springs, and leaves their velocities.
    const float approach = touch.normal.dot(way);
    const float stop = std::min(-gap, std::max(0.0F, -approach));
    const float part = std::min(-gap - stop, h * kPartingSpeed);
    const float push = stop / sum;
    Vec3 impulse = push * touch.normal;
    const Vec3 slide = way - approach * touch.normal;
    const float slid = slide.norm();
    if (slid > 0.0F) {
        const float friction = std::sqrt(body.material.friction * other.material.friction);
        impulse -= std::min(slid / sum, friction * push) / slid * slide;
    }
    const Vec3 shift = part / sum * touch.normal;
    const auto move = [&](SoftBody& which, std::uint32_t node, float by) {
        if (by != 0.0F) {
            which.x[node].head<3>() += by * (impulse + shift);
            which.predicted[node].head<3>() += by * shift;
        }
    };
    move(body, at.node, node_w);
    for (std::size_t k = 0; k < 3; ++k) {
        move(other, (*touch.face)[k], -face_w[k]);
    }
    return true;
}

}  // namespace zoned::physics::soft
