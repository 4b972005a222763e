#include "server/physics/narrowphase/hull_clip.h"

namespace zoned::physics {

namespace {

/// Corners of a loop have six bits.
constexpr int kLoopBits = 7;
constexpr std::uint32_t kPlaneEdge = 0x40U;
constexpr std::uint32_t kEdgeContact = 0x80000000U;
constexpr std::uint32_t kFlipped = 0x40000000U;

/// Clips the incident face by the sides of the reference face and keeps the corners that are near
/// it.
void add_face_points(const HullView& reference,
                     int reference_face,
                     const HullView& incident,
                     const Vec3& outward,
                     std::uint32_t name,
                     float margin,
                     Manifold& out) {
    const int incident_face = facing(incident, -outward);
    const HullFace& from = incident.faces[incident_face];
    std::array<FacePolygon, 2> room;
    FacePolygon* polygon = &room[0];
    FacePolygon* clipped = &room[1];
    for (int i = 0; i < from.corners; ++i) {
        const std::uint32_t corner = incident.loops[from.first + i];
        polygon->add(
            {incident.points[static_cast<int>(corner)], corner, static_cast<std::uint32_t>(i)});
    }
    const HullFace& face = reference.faces[reference_face];
    Vec3 at = reference.corner(face, face.corners - 1);
    for (int i = 0; i < face.corners; ++i) {
        const Vec3 next = reference.corner(face, i);
        const Vec3 side = (next - at).cross(face.normal).normalized();
        clip(*polygon,
             side,
             side.dot(at),
             kPlaneEdge | static_cast<std::uint32_t>(i),
             kLoopBits,
             *clipped);
        std::swap(polygon, clipped);
        at = next;
    }
    name |= static_cast<std::uint32_t>(reference_face) << 22 |
            static_cast<std::uint32_t>(incident_face) << 15;
    std::array<ManifoldPoint, 2 * kMaxHullVertices + 16> near;
    std::size_t count = 0;
    for (int i = 0; i < polygon->count; ++i) {
        const Corner& corner = (*polygon)[i];
        const float gap = face.normal.dot(corner.position) - face.offset;
        if (gap <= margin) {
            near[count++] = {
                corner.position - 0.5F * gap * face.normal, gap, name | (corner.feature & 0x7FFFU)};
        }
    }
    keep_four({near.data(), count}, out);
}

/// A segment that runs along a face of a hull: both ends of the part over that face, which is the
/// one of the two beside `crossed` that looks more along `towards` (unit, from the hull to the
/// segment).
class EdgeRun {
  public:
    EdgeRun(const HullView& hull, const HullEdge& crossed, const Vec3& towards)
        : hull_(hull),
          face_(pick(hull, crossed, towards)),
          towards_(towards) {}

    /// Adds the ends that are near the face and not at the crossing; returns how many. The
    /// shapes overlap by no more along the axis than where the edges cross.
    std::size_t add_ends(const Vec3& from,
                         const Vec3& along,
                         const ManifoldPoint& crossing,
                         float margin,
                         std::uint32_t name,
                         ManifoldPoint* out) const {
        const float steep = face_.normal.dot(towards_);
        float lower = 0.0F;
        float upper = 1.0F;
        if (steep < kAlongFace || !clip_to_sides(from, along, lower, upper)) {
            return 0;
        }
        std::size_t count = 0;
        for (const float s : {lower, upper}) {
            const Vec3 end = from + s * along;
            const float gap = (face_.normal.dot(end) - face_.offset) / steep;
            const Vec3 middle = end - 0.5F * gap * towards_;
            const bool over = gap >= crossing.separation - kNotOver;
            if (over && gap <= margin &&
                (middle - crossing.point).squaredNorm() > kSameEnd * kSameEnd) {
                out[count++] = {middle, gap, name | (s == lower ? 1U : 2U) << kRunBits};
            }
        }
        return count;
    }

  private:
    static const HullFace& pick(const HullView& hull, const HullEdge& edge, const Vec3& towards) {
        const HullFace& left = hull.faces[edge.left];
        const HullFace& right = hull.faces[edge.right];
        return left.normal.dot(towards) >= right.normal.dot(towards) ? left : right;
    }

    bool clip_to_sides(const Vec3& from, const Vec3& along, float& lower, float& upper) const {
        Vec3 at = hull_.corner(face_, face_.corners - 1);
        for (int i = 0; i < face_.corners; ++i) {
            const Vec3 next = hull_.corner(face_, i);
            const Vec3 side = (next - at).cross(face_.normal);
            const float beyond = side.dot(from - at);
            const float rate = side.dot(along);
            if (rate > 0.0F) {
                upper = std::min(upper, -beyond / rate);
            } else if (rate < 0.0F) {
                lower = std::max(lower, -beyond / rate);
            } else if (beyond > 0.0F) {
                return false;
            }
            at = next;
        }
        return lower < upper;
    }

    const HullView& hull_;
    const HullFace& face_;
    Vec3 towards_;
};

/// Where the two edges cross, and where each of them leaves the face of the other hull that it runs
/// along: held at the crossing alone, a thin plate on a ridge would turn about it, and through the
/// ridge.
void add_edge_points(const HullView& a,
                     const HullView& b,
                     const HullAxis& axis,
                     float margin,
                     Manifold& out) {
    const HullEdge& ea = a.edges[axis.i];
    const HullEdge& eb = b.edges[axis.j];
    const Vec3 pa = a.points[ea.from];
    const Vec3 pb = b.points[eb.from];
    const Vec3 da = a.points[ea.to] - pa;
    const Vec3 db = b.points[eb.to] - pb;
    const SegmentPoints p = nearest_on_edges(pa, da, pb, db);
    const Vec3 crossing = 0.5F * (p.on_a + p.on_b);
    const std::uint32_t name =
        kEdgeContact | static_cast<std::uint32_t>(axis.i) << 8 | static_cast<std::uint32_t>(axis.j);
    std::array<ManifoldPoint, 5> near;
    near[0] = {crossing, axis.separation, name};
    std::size_t count = 1;
    const Vec3 back = -axis.normal;
    count += EdgeRun(b, eb, back).add_ends(pa, da, near[0], margin, name | kFlipped, &near[count]);
    count += EdgeRun(a, ea, axis.normal).add_ends(pb, db, near[0], margin, name, &near[count]);
    keep_four({near.data(), count}, out);
}

}  // namespace

int facing(const HullView& hull, const Vec3& direction) {
    const int corner = support(hull.points, direction);
    int best = 0;
    float most = -INFINITY;
    for (int e = 0; e < hull.edge_count; ++e) {
        const HullEdge& edge = hull.edges[e];
        if (edge.from != corner && edge.to != corner) {
            continue;
        }
        for (const int f : {int{edge.left}, int{edge.right}}) {
            const float d = hull.faces[f].normal.dot(direction);
            if (d > most) {
                most = d;
                best = f;
            }
        }
    }
    return best;
}

SegmentPoints nearest_on_edges(const Vec3& pa, const Vec3& da, const Vec3& pb, const Vec3& db) {
    const Vec3 r = pa - pb;
    const float aa = da.squaredNorm();
    const float bb = db.squaredNorm();
    const float ab = da.dot(db);
    const float ar = da.dot(r);
    const float br = db.dot(r);
    const float denominator = aa * bb - ab * ab;
    float s = denominator > 0.0F ? std::clamp((ab * br - ar * bb) / denominator, 0.0F, 1.0F) : 0.0F;
    const float t = std::clamp((ab * s + br) / bb, 0.0F, 1.0F);
    s = std::clamp((ab * t - ar) / aa, 0.0F, 1.0F);
    return {pa + s * da, pb + t * db};
}

void add_points(const HullView& a,
                const HullView& b,
                const HullAxis& axis,
                float margin,
                Manifold& out) {
    switch (axis.kind) {
        case AxisKind::kFaceA:
            add_face_points(a, axis.i, b, axis.normal, 0, margin, out);
            return;
        case AxisKind::kFaceB:
            add_face_points(b, axis.j, a, -axis.normal, kFlipped, margin, out);
            return;
        case AxisKind::kEdges:
            add_edge_points(a, b, axis, margin, out);
            return;
    }
}

}  // namespace zoned::physics
