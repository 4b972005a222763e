#include "server/physics/narrowphase/hull_axis.h"

#include "server/physics/simd/lanes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace zoned::physics {

namespace {

/// The bound that keeps most axes from being tried. A ball lies in each hull. Along an axis n the
/// hulls are therefore apart by at most n . (b's centre - a's) less both radii.
struct AxisBound {
    Vec3 between;  ///< from a's centre to b's, m
    float radii;   ///< both, less the rounding of what is compared with it, m

    AxisBound(const HullView& a, const HullView& b)
        : between(b.centre - a.centre),
          radii(a.inner + b.inner) {
        radii -= 1.0e-4F * (radii + between.norm());
    }

    /// An axis with at least this gap leans as far along `between` as the value, m.
    [[nodiscard]] float least_lean(float gap) const { return radii + gap; }
};

/// How far the normals of faces lean towards the other hull, m.
struct FaceLeans {
    std::array<float, kMaxHullFaces> lean;

    FaceLeans(const HullView& hull, const Vec3& towards) {
        for (int f = 0; f < hull.face_count; ++f) {
            lean[static_cast<std::size_t>(f)] = hull.faces[f].normal.dot(towards);
        }
    }

    [[nodiscard]] float operator[](int f) const { return lean[static_cast<std::size_t>(f)]; }
};

/// The faces of `hull` against the corners of the other; returns the best face, the first of
/// equals. Faces that cannot have a gap of `least` are left out: where no face has one,
/// `separation` may be too small.
int best_face(const HullView& hull,
              const PointsView& other,
              const FaceLeans& leans,
              const AxisBound& bound,
              float least,
              float& separation) {
    const auto gap_of = [&](int f) {
        return lowest(other, hull.faces[f].normal) - hull.faces[f].offset;
    };
    // The face that looks most towards the other hull is good enough to leave out most others.
    const auto first = leans.lean.begin();
    const int guess = static_cast<int>(std::max_element(first, first + hull.face_count) - first);
    const float lean = bound.least_lean(std::max(gap_of(guess), least));
    int best = 0;
    separation = -INFINITY;
    for (int f = 0; f < hull.face_count; ++f) {
        if (leans[f] < lean) {
            continue;
        }
        const float gap = gap_of(f);
        if (gap > separation) {
            separation = gap;
            best = f;
        }
    }
    return best;
}

constexpr int kPaddedEdges = padded(kMaxHullEdges);

/// The edges of a hull that may be part of an axis with at least that gap, by number.
struct NearEdges {
    std::array<std::uint8_t, kPaddedEdges> edges;
    int count = 0;

    /// A unit vector n on the arc between normals l and r is (s l + t r) / |s l + t r|, and the
    /// length is at least (s + t) cos(half the angle between them). It leans by max(l, r) over that
    /// cosine at most.
    NearEdges(const HullView& hull, const FaceLeans& leans, float lean) {
        for (int e = 0; e < hull.edge_count; ++e) {
            const float most = std::max(leans[hull.edges[e].left], leans[hull.edges[e].right]);
            // Without a branch, which would be guessed wrong half of the time.
            edges[static_cast<std::size_t>(count)] = static_cast<std::uint8_t>(e);
            count += lean <= 0.0F || most >= lean * hull.half_cosines[e] ? 1 : 0;
        }
    }

    [[nodiscard]] int operator[](int k) const { return edges[static_cast<std::size_t>(k)]; }
};

/// Directions of edges and the normals on both sides of them, as columns.
struct EdgeColumns {
    std::array<float, kPaddedEdges> dx, dy, dz, lx, ly, lz, rx, ry, rz;
    int count = 0;

    EdgeColumns(const HullView& hull, const NearEdges& near) : count(padded(near.count)) {
        for (int e = 0; e < count; ++e) {
            const auto k = static_cast<std::size_t>(e);
            if (e >= near.count) {
                // No direction: it crosses nothing.
                dx[k] = dy[k] = dz[k] = lx[k] = ly[k] = lz[k] = rx[k] = ry[k] = rz[k] = 0.0F;
                continue;
            }
            const HullEdge& edge = hull.edges[near[e]];
            const Vec3 d = hull.points[edge.to] - hull.points[edge.from];
            const Vec3& l = hull.faces[edge.left].normal;
            const Vec3& r = hull.faces[edge.right].normal;
            dx[k] = d.x();
            dy[k] = d.y();
            dz[k] = d.z();
            lx[k] = l.x();
            ly[k] = l.y();
            lz[k] = l.z();
            rx[k] = r.x();
            ry[k] = r.y();
            rz[k] = r.z();
        }
    }
};

Lanes dot(const float* x, const float* y, const float* z, const Vec3& v) {
    return load(x) * lanes(v.x()) + load(y) * lanes(v.y()) + load(z) * lanes(v.z());
}

/// Compares the axis of one pair of edges with the best so far.
void try_edges(const HullView& a, const HullView& b, int i, int j, HullAxis& best) {
    const HullEdge& ea = a.edges[i];
    const HullEdge& eb = b.edges[j];
    const Vec3 pa = a.points[ea.from];
    const Vec3 pb = b.points[eb.from];
    const Vec3 da = a.points[ea.to] - pa;
    const Vec3 db = b.points[eb.to] - pb;
    Vec3 axis = da.cross(db);
    const float length2 = axis.squaredNorm();
    if (length2 < kParallel * kParallel * da.squaredNorm() * db.squaredNorm()) {
        return;
    }
    // The axis lies on the arc between the normals on both sides of a's edge.
    const Vec3 outward = a.faces[ea.left].normal + a.faces[ea.right].normal;
    axis *= (axis.dot(outward) >= 0.0F ? 1.0F : -1.0F) / std::sqrt(length2);
    const float gap = axis.dot(pb - pa);
    if (gap > best.separation) {
        best = {gap, AxisKind::kEdges, i, j, axis};
    }
}

/// Edge pairs whose arcs cross: each arc, b's mirrored, has its ends on both sides of the other's
/// great circle, on the same half of the sphere. An edge's direction is normal to its circle.
void test_edges(const HullView& a,
                const HullView& b,
                const NearEdges& near_a,
                const NearEdges& near_b,
                HullAxis& best) {
    const EdgeColumns columns(b, near_b);
    for (int i = 0; i < near_a.count; ++i) {
        const HullEdge& edge = a.edges[near_a[i]];
        const Vec3 direction = a.points[edge.to] - a.points[edge.from];
        const Vec3& left = a.faces[edge.left].normal;
        const Vec3& right = a.faces[edge.right].normal;
        for (int j = 0; j < columns.count; j += kGroup) {
            const auto k = static_cast<std::size_t>(j);
            const Lanes cba = dot(&columns.lx[k], &columns.ly[k], &columns.lz[k], direction);
            const Lanes dba = dot(&columns.rx[k], &columns.ry[k], &columns.rz[k], direction);
            const Lanes adc = dot(&columns.dx[k], &columns.dy[k], &columns.dz[k], left);
            const Lanes bdc = dot(&columns.dx[k], &columns.dy[k], &columns.dz[k], right);
            const Lanes zero = lanes(0.0F);
            const auto crosses = (cba * dba < zero) & (adc * bdc < zero) & (cba * bdc < zero);
            if (!any(crosses)) {
                continue;
            }
            for (int lane = 0; lane < kGroup; ++lane) {
                if (crosses[lane] != 0) {
                    try_edges(a, b, near_a[i], near_b[j + lane], best);
                }
            }
        }
    }
}

}  // namespace

MovedHull::MovedHull(const HullView& hull, const Mat3& rotation, const Vec3& position)
    : from_(hull) {
    from_.centre = rotation * hull.centre + position;
    for (int i = 0; i < hull.points.count; i += kGroup) {
        const auto k = static_cast<std::size_t>(i);
        const Lanes x = load(hull.points.x + i);
        const Lanes y = load(hull.points.y + i);
        const Lanes z = load(hull.points.z + i);
        const auto move = [&](int row, float* to) {
            const Lanes moved = lanes(rotation(row, 0)) * x + lanes(rotation(row, 1)) * y +
                                lanes(rotation(row, 2)) * z + lanes(position[row]);
            std::memcpy(to, &moved, sizeof(moved));
        };
        move(0, &x_[k]);
        move(1, &y_[k]);
        move(2, &z_[k]);
    }
    for (int f = 0; f < hull.face_count; ++f) {
        const HullFace& face = hull.faces[f];
        const Vec3 normal = rotation * face.normal;
        faces_[static_cast<std::size_t>(f)] = {
            normal, face.offset + normal.dot(position), face.first, face.corners};
    }
}

HullView MovedHull::view() const {
    HullView view = from_;
    view.points = {x_.data(), y_.data(), z_.data(), from_.points.count};
    view.faces = faces_.data();
    return view;
}

HullAxes find_axes(const HullView& a, const HullView& b, float margin, float scale) {
    HullAxes out;
    HullAxis& best = out.face;
    const AxisBound bound(a, b);
    const FaceLeans leans_a(a, bound.between);
    best.i = best_face(a, b.points, leans_a, bound, -INFINITY, best.separation);
    best.normal = a.faces[best.i].normal;
    if (best.separation > margin) {
        return out;
    }
    float separation = 0.0F;
    const FaceLeans leans_b(b, -bound.between);
    const int face = best_face(b, a.points, leans_b, bound, best.separation, separation);
    if (separation > best.separation + kFaceBias * scale) {
        best = {separation, AxisKind::kFaceB, best.i, face, -b.faces[face].normal};
    }
    if (best.separation <= margin) {
        const float lean = bound.least_lean(best.separation);
        const NearEdges near_a(a, leans_a, lean);
        const NearEdges near_b(b, leans_b, lean);
        test_edges(a, b, near_a, near_b, out.edges);
    }
    return out;
}

}  // namespace zoned::physics
