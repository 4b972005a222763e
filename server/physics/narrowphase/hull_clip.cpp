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
            break;
    }
    const HullEdge& ea = a.edges[axis.i];
    const HullEdge& eb = b.edges[axis.j];
    const Vec3 pa = a.points[ea.from];
    const Vec3 pb = b.points[eb.from];
    const SegmentPoints p = nearest_on_edges(pa, a.points[ea.to] - pa, pb, b.points[eb.to] - pb);
    out.add(0.5F * (p.on_a + p.on_b),
            axis.separation,
            kEdgeContact | static_cast<std::uint32_t>(axis.i) << 8 |
                static_cast<std::uint32_t>(axis.j));
}

}  // namespace zoned::physics
