#include "server/physics/manifold.h"

namespace zoned::physics {

void clip(Polygon& polygon, const Vec3& normal, float offset, std::uint32_t plane_edge) {
    Polygon out;
    for (int i = 0; i < polygon.count; ++i) {
        const Polygon::Corner& u = polygon.corners[static_cast<std::size_t>(i)];
        const Polygon::Corner& v =
            polygon.corners[static_cast<std::size_t>((i + 1) % polygon.count)];
        const float du = normal.dot(u.position) - offset;
        const float dv = normal.dot(v.position) - offset;
        if (du <= 0.0F) {
            out.add(u);
        }
        if ((du < 0.0F && dv > 0.0F) || (du > 0.0F && dv < 0.0F)) {
            const Vec3 cut = u.position + (v.position - u.position) * (du / (du - dv));
            const std::uint32_t feature = 0x100U | (u.edge << 4) | plane_edge;
            // Leaving the half-space the outline goes on along the plane, entering it goes on along
            // the edge that was cut.
            out.add({cut, feature, du < 0.0F ? plane_edge : u.edge});
        }
    }
    polygon = out;
}

void keep_four(const std::array<ManifoldPoint, 12>& candidates, int count, Manifold& out) {
    const auto at = [&](int i) -> const ManifoldPoint& {
        return candidates[static_cast<std::size_t>(i)];
    };
    if (count <= kMaxManifoldPoints) {
        for (int i = 0; i < count; ++i) {
            out.add(at(i).point, at(i).separation, at(i).feature);
        }
        return;
    }
    int first = 0;
    for (int i = 1; i < count; ++i) {
        first = at(i).separation < at(first).separation ? i : first;
    }
    int second = -1;
    float farthest = -1.0F;
    for (int i = 0; i < count; ++i) {
        const float d = (at(i).point - at(first).point).squaredNorm();
        if (i != first && d > farthest) {
            farthest = d;
            second = i;
        }
    }
    // Twice the signed area of the triangle over an edge, seen along the normal.
    const auto area = [&](int p, int q, int r) {
        return (at(q).point - at(p).point).cross(at(r).point - at(p).point).dot(out.normal);
    };
    int third = -1;
    float largest = -1.0F;
    for (int i = 0; i < count; ++i) {
        const float a = std::abs(area(first, second, i));
        if (i != first && i != second && a > largest) {
            largest = a;
            third = i;
        }
    }
    const float side = area(first, second, third) >= 0.0F ? 1.0F : -1.0F;
    int fourth = -1;
    float gain = 0.0F;
    for (int i = 0; i < count; ++i) {
        if (i == first || i == second || i == third) {
            continue;
        }
        // Outside an edge of the triangle the area counts negative.
        const float outside = std::min({side * area(first, second, i),
                                        side * area(second, third, i),
                                        side * area(third, first, i)});
        if (-outside > gain) {
            gain = -outside;
            fourth = i;
        }
    }
    for (const int i : {first, second, third, fourth}) {
        if (i >= 0) {
            out.add(at(i).point, at(i).separation, at(i).feature);
        }
    }
}

}  // namespace zoned::physics
