#include "shared/math/segment_triangle.h"

#include <algorithm>
#include <cmath>

namespace zoned {

namespace {

/// From the closest point of the second segment to that of the first.
Vec3 between_segments(const Vec3& p, const Vec3& d1, const Vec3& q, const Vec3& d2) {
    const Vec3 r = p - q;
    const float a = d1.squaredNorm();
    const float e = d2.squaredNorm();  // an edge of a triangle with an area: not zero
    const float f = d2.dot(r);
    float s = 0.0F;
    if (a > 0.0F) {
        const float b = d1.dot(d2);
        const float c = d1.dot(r);
        const float denominator = a * e - b * b;
        if (denominator > 0.0F) {
            s = std::clamp((b * f - c * e) / denominator, 0.0F, 1.0F);
        }
        const float t = (b * s + f) / e;
        if (t < 0.0F) {
            s = std::clamp(-c / a, 0.0F, 1.0F);
        } else if (t > 1.0F) {
            s = std::clamp((b - c) / a, 0.0F, 1.0F);
        }
    }
    const Vec3 on_first = p + d1 * s;
    const float t = std::clamp(d2.dot(on_first - q) / e, 0.0F, 1.0F);
    return on_first - (q + d2 * t);
}

/// Whether a point of the plane lies in the triangle.
bool inside(const FacedTriangle& t, const Vec3& p) {
    for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 edge = t.corner[(i + 1) % 3] - t.corner[i];
        if (edge.cross(p - t.corner[i]).dot(t.normal) < 0.0F) {
            return false;
        }
    }
    return true;
}

}  // namespace

TrianglePoint nearest_on_triangle(const std::array<Vec3, 3>& corner, const Vec3& p) {
    const Vec3& a = corner[0];
    const Vec3& b = corner[1];
    const Vec3& c = corner[2];
    const Vec3 ab = b - a;
    const Vec3 ac = c - a;
    const Vec3 bc = c - b;
    const float d1 = ab.dot(p - a);
    const float d2 = ac.dot(p - a);
    if (d1 <= 0.0F && d2 <= 0.0F) {
        return {a, -1, 0};
    }
    const float d3 = ab.dot(p - b);
    const float d4 = ac.dot(p - b);
    if (d3 >= 0.0F && d4 <= d3) {
        return {b, -1, 1};
    }
    const float vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0F && d1 >= 0.0F && d3 <= 0.0F) {
        return {a + d1 / (d1 - d3) * ab, 0, -1};
    }
    const float d5 = ab.dot(p - c);
    const float d6 = ac.dot(p - c);
    if (d6 >= 0.0F && d5 <= d6) {
        return {c, -1, 2};
    }
    const float vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0F && d2 >= 0.0F && d6 <= 0.0F) {
        return {a + d2 / (d2 - d6) * ac, 2, -1};
    }
    const float va = d3 * d6 - d5 * d4;
    if (va <= 0.0F && d4 >= d3 && d5 >= d6) {
        return {b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * bc, 1, -1};
    }
    const float denominator = 1.0F / (va + vb + vc);
    return {a + vb * denominator * ab + vc * denominator * ac, -1, -1};
}

SegmentTriangleDistance segment_triangle_distance(const Vec3& middle,
                                                  const Vec3& half,
                                                  const FacedTriangle& t) {
    const Vec3 first = middle - half;
    const Vec3 second = middle + half;
    const float h1 = t.height(first);
    const float h2 = t.height(second);
    const bool crosses = (h1 <= 0.0F) != (h2 <= 0.0F);
    if (crosses && inside(t, first + (second - first) * (h1 / (h1 - h2)))) {
        return {t.normal, std::min(h1, h2)};
    }
    Vec3 best = first - nearest_on_triangle(t.corner, first).point;
    float least = best.squaredNorm();
    const auto consider = [&](const Vec3& apart) {
        const float squared = apart.squaredNorm();
        if (squared < least) {
            least = squared;
            best = apart;
        }
    };
    consider(second - nearest_on_triangle(t.corner, second).point);
    for (std::size_t i = 0; i < 3; ++i) {
        consider(between_segments(
            first, second - first, t.corner[i], t.corner[(i + 1) % 3] - t.corner[i]));
    }
    const float distance = std::sqrt(least);
    if (distance < 1e-6F) {
        return {t.normal, std::min({0.0F, h1, h2})};  // touches: no direction of its own
    }
    return {best / distance, distance};
}

bool box_triangle_overlap(const Vec3& centre, const Vec3& half_extents, const FacedTriangle& t) {
    const std::array<Vec3, 3> corner{
        t.corner[0] - centre, t.corner[1] - centre, t.corner[2] - centre};
    const auto separates = [&](const Vec3& axis) {
        if (axis.squaredNorm() < 1e-12F) {
            return false;  // an edge along that axis: others decide
        }
        const float a = axis.dot(corner[0]);
        const float b = axis.dot(corner[1]);
        const float c = axis.dot(corner[2]);
        const float reach = half_extents.dot(axis.cwiseAbs());
        return std::min({a, b, c}) >= reach || std::max({a, b, c}) <= -reach;
    };
    for (int i = 0; i < 3; ++i) {
        if (separates(Vec3::Unit(i))) {
            return false;
        }
    }
    if (separates(t.normal)) {
        return false;
    }
    for (std::size_t e = 0; e < 3; ++e) {
        const Vec3 edge = corner[(e + 1) % 3] - corner[e];
        for (int i = 0; i < 3; ++i) {
            if (separates(Vec3::Unit(i).cross(edge))) {
                return false;
            }
        }
    }
    return true;
}

}  // namespace zoned
