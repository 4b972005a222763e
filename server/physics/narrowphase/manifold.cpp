#include "server/physics/narrowphase/manifold.h"

namespace zoned::physics {

namespace {

/// Points as deep as the deepest but for this are as good, m.
constexpr float kLevel = 2.0e-4F;

}  // namespace

void keep_four(std::span<const ManifoldPoint> candidates, Manifold& out) {
    const auto count = static_cast<int>(candidates.size());
    const auto at = [&](int i) -> const ManifoldPoint& {
        return candidates[static_cast<std::size_t>(i)];
    };
    if (count <= kMaxManifoldPoints) {
        for (int i = 0; i < count; ++i) {
            out.add(at(i).point, at(i).separation, at(i).feature);
        }
        return;
    }
    // A point that is left out where the shapes overlap lets them sink; one that is still apart can
    // wait, the longer the farther.
    const auto weight = [&](int i) {
        const float s = at(i).separation;
        return s > kLevel ? kLevel * kLevel / s : kLevel;
    };
    float lowest = at(0).separation;
    Vec3 middle = at(0).point;
    for (int i = 1; i < count; ++i) {
        lowest = std::min(lowest, at(i).separation);
        middle += at(i).point;
    }
    middle /= static_cast<float>(count);
    int first = -1;
    float outermost = -1.0F;
    for (int i = 0; i < count; ++i) {
        const float d = (at(i).point - middle).squaredNorm();
        if (at(i).separation <= lowest + kLevel && d > outermost) {
            outermost = d;
            first = i;
        }
    }
    int second = -1;
    float farthest = -1.0F;
    for (int i = 0; i < count; ++i) {
        const float d = weight(i) * (at(i).point - at(first).point).norm();
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
        const float a = weight(i) * std::abs(area(first, second, i));
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
        const float outside = weight(i) * std::min({side * area(first, second, i),
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
