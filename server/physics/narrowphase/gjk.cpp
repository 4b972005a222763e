#include "server/physics/narrowphase/gjk.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

constexpr int kMaxRounds = 64;
/// A support point that is nearer by less than this share of the squared distance ends the search.
constexpr double kProgress = 1.0e-12;

struct Vertex {
    Vec3d w = Vec3d::Zero();  // a corner of a minus one of b
    int a = 0;
    int b = 0;
    double weight = 0.0;  // barycentric, of the point nearest to the origin
};

struct Simplex {
    std::array<Vertex, 4> v;
    int count = 0;

    [[nodiscard]] const Vec3d& w(int i) const { return v[static_cast<std::size_t>(i)].w; }

    [[nodiscard]] Vec3d nearest() const {
        Vec3d p = Vec3d::Zero();
        for (int i = 0; i < count; ++i) {
            p += v[static_cast<std::size_t>(i)].weight * w(i);
        }
        return p;
    }

    [[nodiscard]] bool holds(int a, int b) const {
        return std::any_of(
            v.begin(), v.begin() + count, [&](const Vertex& x) { return x.a == a && x.b == b; });
    }

    [[nodiscard]] Simplex only(std::initializer_list<std::pair<int, double>> parts) const {
        Simplex s;
        for (const auto& [i, weight] : parts) {
            s.v[static_cast<std::size_t>(s.count)] = v[static_cast<std::size_t>(i)];
            s.v[static_cast<std::size_t>(s.count++)].weight = weight;
        }
        return s;
    }
};

Simplex nearest_on_segment(const Simplex& s, int i, int k) {
    const Vec3d d = s.w(k) - s.w(i);
    const double length2 = d.squaredNorm();
    const double t = length2 > 0.0 ? -d.dot(s.w(i)) / length2 : 0.0;
    if (t <= 0.0) {
        return s.only({{i, 1.0}});
    }
    if (t >= 1.0) {
        return s.only({{k, 1.0}});
    }
    return s.only({{i, 1.0 - t}, {k, t}});
}

Simplex nearer(const Simplex& a, const Simplex& b) {
    return b.nearest().squaredNorm() < a.nearest().squaredNorm() ? b : a;
}

/// The face where the origin lies over the triangle, otherwise the nearest of the edges.
Simplex nearest_on_triangle(const Simplex& s, int i, int k, int l) {
    const Vec3d& a = s.w(i);
    const Vec3d& b = s.w(k);
    const Vec3d& c = s.w(l);
    const Vec3d n = (b - a).cross(c - a);
    const double n2 = n.squaredNorm();
    if (n2 > 0.0) {
        const double u = n.dot(b.cross(c)) / n2;
        const double v = n.dot(c.cross(a)) / n2;
        const double w = n.dot(a.cross(b)) / n2;
        if (u > 0.0 && v > 0.0 && w > 0.0) {
            return s.only({{i, u}, {k, v}, {l, w}});
        }
    }
    return nearer(nearer(nearest_on_segment(s, i, k), nearest_on_segment(s, k, l)),
                  nearest_on_segment(s, l, i));
}

/// Reduces the simplex to the part whose inside holds the point nearest to the origin; four corners
/// remain when the origin is within them.
Simplex reduce(const Simplex& s) {
    switch (s.count) {
        case 1:
            return s.only({{0, 1.0}});
        case 2:
            return nearest_on_segment(s, 0, 1);
        case 3:
            return nearest_on_triangle(s, 0, 1, 2);
        default:
            break;
    }
    constexpr int kFaces[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
    bool inside = true;
    Simplex best;
    for (const auto& f : kFaces) {
        const Vec3d n = (s.w(f[1]) - s.w(f[0])).cross(s.w(f[2]) - s.w(f[0]));
        const double apex = n.dot(s.w(f[3]) - s.w(f[0]));
        const double origin = -n.dot(s.w(f[0]));
        // On the other side than the fourth corner; a flat tetrahedron has no inside.
        if (origin * apex < 0.0 || apex == 0.0) {
            inside = false;
            const Simplex on_face = nearest_on_triangle(s, f[0], f[1], f[2]);
            best = best.count == 0 ? on_face : nearer(best, on_face);
        }
    }
    return inside ? s : best;
}

Vertex support_along(const PointsView& a, const PointsView& b, const Vec3d& direction) {
    const Vec3 d = direction.normalized().cast<float>();
    Vertex v;
    v.a = support(a, d);
    v.b = support(b, -d);
    v.w = a[v.a].cast<double>() - b[v.b].cast<double>();
    return v;
}

}  // namespace

Closest closest_points(const PointsView& a, const PointsView& b, const Vec3& guess) {
    Simplex simplex;
    const Vec3d start = guess.squaredNorm() > 0.0F ? guess.cast<double>() : Vec3d(Vec3d::UnitY());
    simplex.v[0] = support_along(a, b, start);
    simplex.v[0].weight = 1.0;
    simplex.count = 1;
    Vec3d p = simplex.w(0);
    Closest out;
    const double tiny = 1.0e-24 * (1.0 + p.squaredNorm());
    for (int round = 0; round < kMaxRounds; ++round) {
        const double d2 = p.squaredNorm();
        if (d2 <= tiny) {
            out.overlap = true;
            break;
        }
        const Vertex next = support_along(a, b, -p);
        if (d2 - p.dot(next.w) <= kProgress * d2 || simplex.holds(next.a, next.b)) {
            break;
        }
        Simplex grown = simplex;
        grown.v[static_cast<std::size_t>(grown.count++)] = next;
        grown = reduce(grown);
        if (grown.count == 4) {
            out.overlap = true;
            break;
        }
        const Vec3d q = grown.nearest();
        if (!(q.squaredNorm() < d2)) {
            break;  // rounding: no nearer than before
        }
        simplex = grown;
        p = q;
    }
    for (int i = 0; i < simplex.count; ++i) {
        const Vertex& v = simplex.v[static_cast<std::size_t>(i)];
        out.on_a += v.weight * a[v.a].cast<double>();
        out.on_b += v.weight * b[v.b].cast<double>();
    }
    if (!out.overlap) {
        out.distance = p.norm();
        out.normal = -p / out.distance;
    }
    return out;
}

}  // namespace zoned::physics
