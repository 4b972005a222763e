#include "server/physics/narrowphase/axis_choice.h"
#include "server/physics/narrowphase/collide.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace zoned::physics {

namespace {

/// Two boxes, with the shared data of the 15 tests: b's axes and centre in a's frame.
struct BoxPair {
    const Placed& a;
    const Placed& b;
    Mat3 turn;      // b's axes as columns, in a's frame
    Mat3 abs_turn;  // their absolute values
    Vec3 offset_a;  // b's centre in a's frame
    Vec3 offset_b;  // the same vector in b's frame
};

enum class Feature {
    kFaceA,
    kFaceB,
    kEdges
};

struct BestAxis {
    float separation = -INFINITY;
    Feature feature = Feature::kFaceA;
    int i = 0;
    int j = 0;
    Vec3 normal = Vec3::UnitY();  // world, from a to b
};

/// Four edges of the face and four of the planes.
constexpr int kEdgeBits = 4;
/// In the names of an edge contact's points: a's edge runs along b's face.
constexpr std::uint32_t kFlippedRun = 0x40000000U;

void test_faces(const BoxPair& p, BestAxis& best) {
    const Vec3& ha = p.a.shape.half_extents;
    const Vec3& hb = p.b.shape.half_extents;
    const Vec3 gap_a = p.offset_a.cwiseAbs() - ha - p.abs_turn * hb;
    const Vec3 gap_b = p.offset_b.cwiseAbs() - hb - p.abs_turn.transpose() * ha;
    for (int i = 0; i < 3; ++i) {
        if (gap_a[i] > best.separation) {
            best.separation = gap_a[i];
            best.i = i;
        }
    }
    best.normal = p.a.rotation.col(best.i) * (p.offset_a[best.i] >= 0.0F ? 1.0F : -1.0F);
    for (int j = 0; j < 3; ++j) {
        const float bias = best.feature == Feature::kFaceA ? kFaceBias : 0.0F;
        if (gap_b[j] > best.separation + bias) {
            best.separation = gap_b[j];
            best.feature = Feature::kFaceB;
            best.j = j;
            best.normal = p.b.rotation.col(j) * (p.offset_b[j] >= 0.0F ? 1.0F : -1.0F);
        }
    }
}

/// The nine cross products of edges (Gottschalk, Lin, Manocha, "OBBTree", SIGGRAPH 1996), written
/// out: with w = e_i x c_j, component i is zero and the others are -+ entries of the turn.
void test_edges(const BoxPair& p, BestAxis& best) {
    const Vec3& ha = p.a.shape.half_extents;
    const Vec3& hb = p.b.shape.half_extents;
    for (int i = 0; i < 3; ++i) {
        const int i1 = (i + 1) % 3;
        const int i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            // Not 1 - cosine^2, of which nothing is left where edges are nearly parallel.
            const float sine2 = p.turn(i1, j) * p.turn(i1, j) + p.turn(i2, j) * p.turn(i2, j);
            if (sine2 < kParallel * kParallel) {
                continue;
            }
            const int j1 = (j + 1) % 3;
            const int j2 = (j + 2) % 3;
            // e_i x c_j in a's frame: components (i1, i2) = (-c[i2], c[i1]).
            const float distance = p.offset_a[i2] * p.turn(i1, j) - p.offset_a[i1] * p.turn(i2, j);
            const float reach = ha[i1] * p.abs_turn(i2, j) + ha[i2] * p.abs_turn(i1, j) +
                                hb[j1] * p.abs_turn(i, j2) + hb[j2] * p.abs_turn(i, j1);
            const float gap = std::abs(distance) - reach;
            const float bias = best.feature == Feature::kEdges ? 0.0F : kEdgeBias;
            const float length = std::sqrt(sine2);
            if (gap > (best.separation + bias) * length) {
                Vec3 axis = Vec3::Zero();
                axis[i1] = -p.turn(i2, j);
                axis[i2] = p.turn(i1, j);
                axis *= (distance >= 0.0F ? 1.0F : -1.0F) / length;
                best = {gap / length, Feature::kEdges, i, j, p.a.rotation * axis};
            }
        }
    }
}

/// A segment, and the face that it may run along: of `box`, beside its edge along `edge`, whichever
/// looks more along `towards` (unit, from the box to the segment).
struct BoxRun {
    const Placed& box;
    int edge;
    Vec3 towards;
    Vec3 from, along;
};

/// Adds the ends of the segment's part over the face that are near it and not at the crossing of
/// the two edges, which is near[0]. The shapes overlap by no more along the axis than there.
void add_run_ends(const BoxRun& run,
                  float margin,
                  std::uint32_t name,
                  std::array<ManifoldPoint, 5>& near,
                  std::size_t& count) {
    const Vec3 outward = run.box.rotation.transpose() * run.towards;
    const Vec3 p = run.box.to_local(run.from);
    const Vec3 d = run.box.rotation.transpose() * run.along;
    const Vec3& half = run.box.shape.half_extents;
    int face = (run.edge + 1) % 3;
    int other = (run.edge + 2) % 3;
    if (std::abs(outward[other]) > std::abs(outward[face])) {
        std::swap(face, other);
    }
    const float steep = std::abs(outward[face]);
    if (steep < kAlongFace) {
        return;
    }
    float lower = 0.0F;
    float upper = 1.0F;
    for (const int k : {run.edge, other}) {
        if (d[k] == 0.0F) {
            if (std::abs(p[k]) > half[k]) {
                return;
            }
            continue;
        }
        const float s = (-half[k] - p[k]) / d[k];
        const float t = (half[k] - p[k]) / d[k];
        lower = std::max(lower, std::min(s, t));
        upper = std::min(upper, std::max(s, t));
    }
    if (lower >= upper) {
        return;
    }
    const float sign = outward[face] > 0.0F ? 1.0F : -1.0F;
    for (const float s : {lower, upper}) {
        const float gap = (sign * (p[face] + s * d[face]) - half[face]) / steep;
        const Vec3 middle = run.from + s * run.along - 0.5F * gap * run.towards;
        const bool over = gap >= near[0].separation - kNotOver;
        if (over && gap <= margin && (middle - near[0].point).squaredNorm() > kSameEnd * kSameEnd) {
            near[count++] = {middle, gap, name | (s == lower ? 1U : 2U) << kRunBits};
        }
    }
}

/// Where the two edges cross, and where each of them leaves the face of the other box that it runs
/// along: held at the crossing alone, a thin plate on a ridge would turn about it, and through the
/// ridge.
void add_edge_contact(const BoxPair& p, const BestAxis& best, float margin, Manifold& out) {
    if (best.separation > margin) {
        return;
    }
    const Vec3 local_a = p.a.rotation.transpose() * best.normal;
    const Vec3 local_b = p.b.rotation.transpose() * best.normal;
    Vec3 corner_a = p.a.shape.half_extents;
    Vec3 corner_b = p.b.shape.half_extents;
    std::uint32_t feature = 0x80000000U | static_cast<std::uint32_t>(best.i * 3 + best.j) << 8;
    for (int k = 0; k < 3; ++k) {
        const bool minus_a = local_a[k] < 0.0F;
        const bool minus_b = local_b[k] > 0.0F;
        corner_a[k] = k == best.i ? 0.0F : (minus_a ? -corner_a[k] : corner_a[k]);
        corner_b[k] = k == best.j ? 0.0F : (minus_b ? -corner_b[k] : corner_b[k]);
        feature |= (k != best.i && minus_a ? 1U : 0U) << k;
        feature |= (k != best.j && minus_b ? 1U : 0U) << (k + 3);
    }
    const Vec3 pa = p.a.to_world(corner_a);
    const Vec3 pb = p.b.to_world(corner_b);
    const Vec3 da = p.a.rotation.col(best.i);
    const Vec3 db = p.b.rotation.col(best.j);
    const Vec3 d = pb - pa;
    const Vec3 across = da.cross(db);
    const float sine2 = across.squaredNorm();
    const float limit_a = p.a.shape.half_extents[best.i];
    const float limit_b = p.b.shape.half_extents[best.j];
    const float s = d.cross(db).dot(across) / sine2;
    const float t = d.cross(da).dot(across) / sine2;
    const Vec3 on_a = pa + std::clamp(s, -limit_a, limit_a) * da;
    const Vec3 on_b = pb + std::clamp(t, -limit_b, limit_b) * db;
    std::array<ManifoldPoint, 5> near;
    near[0] = {0.5F * (on_a + on_b), best.separation, feature};
    std::size_t count = 1;
    const BoxRun a_on_b{p.b, best.j, -best.normal, pa - limit_a * da, 2.0F * limit_a * da};
    const BoxRun b_on_a{p.a, best.i, best.normal, pb - limit_b * db, 2.0F * limit_b * db};
    add_run_ends(a_on_b, margin, feature | kFlippedRun, near, count);
    add_run_ends(b_on_a, margin, feature, near, count);
    keep_four({near.data(), count}, out);
}

/// The face of `box` that looks most along `direction`, as a polygon.
Polygon face_towards(const Placed& box, const Vec3& direction) {
    const Vec3 local = box.rotation.transpose() * direction;
    int axis = 0;
    local.cwiseAbs().maxCoeff(&axis);
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const Vec3& half = box.shape.half_extents;
    Polygon face;
    constexpr float kSigns[4][2] = {{1, 1}, {-1, 1}, {-1, -1}, {1, -1}};
    const std::uint32_t name = static_cast<std::uint32_t>(axis) * 2 + (local[axis] > 0.0F ? 1 : 0);
    for (std::uint32_t k = 0; k < 4; ++k) {
        Vec3 corner = Vec3::Zero();
        corner[axis] = local[axis] > 0.0F ? half[axis] : -half[axis];
        corner[u] = kSigns[k][0] * half[u];
        corner[v] = kSigns[k][1] * half[v];
        face.add({box.to_world(corner), (name << 12) | k, k});
    }
    return face;
}

/// Clips the incident face by the sides of the reference face and keeps the corners that are near
/// it.
void add_face_contact(const Placed& reference,
                      const Placed& incident,
                      int axis,
                      bool b_is_reference,
                      float margin,
                      Manifold& out) {
    const Vec3 outward = b_is_reference ? Vec3(-out.normal) : out.normal;
    Polygon face = face_towards(incident, -outward);
    const std::uint32_t incident_name = face.corners[0].feature & 0xF000U;
    const Vec3& half = reference.shape.half_extents;
    std::uint32_t plane = 4;
    Polygon other;
    for (const int side : {(axis + 1) % 3, (axis + 2) % 3}) {
        const Vec3 normal = reference.rotation.col(side);
        const float centre = normal.dot(reference.position);
        clip(face, normal, centre + half[side], plane++, kEdgeBits, other);
        clip(other, -normal, half[side] - centre, plane++, kEdgeBits, face);
    }
    const float surface = outward.dot(reference.position) + half[axis];
    const bool positive = outward.dot(reference.rotation.col(axis)) > 0.0F;
    const std::uint32_t name = (b_is_reference ? 0x40000000U : 0U) | incident_name |
                               static_cast<std::uint32_t>(axis * 2 + (positive ? 1 : 0)) << 16;
    std::array<ManifoldPoint, 12> near;
    std::size_t count = 0;
    for (int k = 0; k < face.count; ++k) {
        const Corner& corner = face[k];
        const float gap = outward.dot(corner.position) - surface;
        if (gap <= margin) {
            near[count++] = {
                corner.position - 0.5F * gap * outward, gap, name | (corner.feature & 0xFFFU)};
        }
    }
    keep_four({near.data(), count}, out);
}

}  // namespace

void collide_box_box(const Placed& a, const Placed& b, float margin, Manifold& out) {
    const Mat3 turn = a.rotation.transpose() * b.rotation;
    const Vec3 between = b.position - a.position;
    const BoxPair pair{a,
                       b,
                       turn,
                       turn.cwiseAbs(),
                       a.rotation.transpose() * between,
                       b.rotation.transpose() * between};
    BestAxis best;
    test_faces(pair, best);
    if (best.separation <= margin) {
        test_edges(pair, best);
    }
    out.normal = best.normal;
    out.separation = best.separation;
    if (best.separation > margin) {
        return;
    }
    switch (best.feature) {
        case Feature::kFaceA:
            add_face_contact(a, b, best.i, false, margin, out);
            break;
        case Feature::kFaceB:
            add_face_contact(b, a, best.j, true, margin, out);
            break;
        case Feature::kEdges:
            add_edge_contact(pair, best, margin, out);
            break;
    }
}

}  // namespace zoned::physics
