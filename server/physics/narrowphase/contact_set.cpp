#include "server/physics/narrowphase/contact_set.h"

#include "server/physics/narrowphase/narrowphase.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace zoned::physics {

namespace {

/// Normals within 1.8 degrees are one.
constexpr float kSameNormal = 0.9995F;
/// Points nearer than this are one, m: both triangles at an edge report it.
constexpr float kSharedPoint = 1.0e-3F;
/// Of the boxes of parts, m.
constexpr float kRounding = 1.0e-3F;

bool is_surface(ShapeKind kind) {
    return kind == ShapeKind::kMesh || kind == ShapeKind::kHeightfield;
}

/// A shape in the frame of another one.
struct Local {
    Mat3 rotation;
    Placed placed;

    Local(const Placed& shape, const Placed& frame)
        : rotation(frame.rotation.transpose() * shape.rotation),
          placed{shape.shape, frame.to_local(shape.position), rotation} {}

    Local(const Local&) = delete;
    Local& operator=(const Local&) = delete;

    /// Its box swept along `travel` (world axes).
    [[nodiscard]] Aabb reach(const Placed& frame, const Vec3& travel, float margin) const {
        const Aabb box = shape_bounds(placed.shape, placed.position, rotation);
        return swept(box.grown(margin), frame.rotation.transpose() * travel);
    }
};

bool buried(const Heightfield& field, const Placed& shape, Triangle& over) {
    return field.triangle_at(shape.position, over) && over.height(shape.position) < 0.0F;
}

bool buried(const TriangleMesh&, const Placed&, Triangle&) {
    return false;
}

/// Calls visit(part of a, part of b) for the parts that may meet.
template <class Visit>
void for_part_pairs(const Placed& a, const Placed& b, const Probe& probe, Visit&& visit) {
    const Vec3 travel = probe.time * probe.approach;
    for_parts_near(b, a, -travel, probe.margin, [&](const PartPlaced& of_b) {
        for_parts_near(a, of_b.placed, travel, probe.margin, [&](const PartPlaced& of_a) {
            const bool meets = of_a.part == nullptr || of_b.part == nullptr ||
                               of_a.part->part.filter.meets(of_b.part->part.filter);
            if (meets) {
                visit(of_a, of_b);
            }
        });
    });
}

/// How long until a gap along a normal (from a to b) has shrunk to half of `least`, so that it is
/// safely below it then; 0 when it is below it now.
float time_to_close(float gap, const Vec3& normal, const Probe& probe, float least) {
    if (gap <= least) {
        return 0.0F;
    }
    const float closing = -normal.dot(probe.approach);
    return closing > 0.0F ? (gap - 0.5F * least) / closing : INFINITY;
}

template <class Surface>
float impact_on(const Surface& surface,
                const Placed& frame,
                const Placed& shape,
                const Probe& probe,
                float gap) {
    const Local local(shape, frame);
    const SurfaceVisitor visitor(local.placed);
    Triangle over;
    if (buried(surface, local.placed, over)) {
        return 0.0F;
    }
    // Seen from the surface, the shape approaches.
    float earliest = INFINITY;
    const Aabb area = local.reach(frame, probe.time * probe.approach, probe.margin);
    for_triangles(surface, area, [&](const Triangle& t) {
        if (t.height(local.placed.position) >= 0.0F) {
            Vec3 normal = t.normal;
            const float distance = visitor.distance(t, normal);
            earliest =
                std::min(earliest, time_to_close(distance, frame.rotation * normal, probe, gap));
        }
    });
    return earliest;
}

float impact_of(const Placed& a, const Placed& b, const Probe& probe, float gap) {
    if (b.shape.kind == ShapeKind::kMesh) {
        const Probe mirrored{probe.margin, -probe.approach, probe.time};
        return impact_on(mesh_of(b.shape), b, a, mirrored, gap);
    }
    if (b.shape.kind == ShapeKind::kHeightfield) {
        const Probe mirrored{probe.margin, -probe.approach, probe.time};
        return impact_on(field_of(b.shape), b, a, mirrored, gap);
    }
    if (is_surface(a.shape.kind)) {
        return a.shape.kind == ShapeKind::kMesh ? impact_on(mesh_of(a.shape), a, b, probe, gap)
                                                : impact_on(field_of(a.shape), a, b, probe, gap);
    }
    Manifold manifold;
    collide(a, b, 0.0F, manifold);
    return time_to_close(manifold.separation, manifold.normal, probe, gap);
}

}  // namespace

/// Two parts that meet, none of them a compound.
struct ContactSet::Pair {
    const PartPlaced& a;
    const PartPlaced& b;

    [[nodiscard]] bool senses() const {
        return (a.part != nullptr && a.part->part.sensor) ||
               (b.part != nullptr && b.part->part.sensor);
    }

    static const Material* material(const PartPlaced& p) {
        return p.part == nullptr ? nullptr : &p.part->part.material;
    }
};

ContactSet::ContactSet() {
    groups_.reserve(kMaxPairManifolds);
    manifolds_.reserve(kMaxPairManifolds);
}

void ContactSet::collide(const Placed& a, const Placed& b, const Probe& probe) {
    groups_.clear();
    manifolds_.clear();
    sensed_ = false;
    dropped_ = 0;
    gathered_ = false;
    const Vec3 travel = probe.time * probe.approach;
    if (a.shape.kind == ShapeKind::kMesh && b.shape.kind == ShapeKind::kCompound) {
        gather(a, b, travel, probe.margin);
    } else if (b.shape.kind == ShapeKind::kMesh && a.shape.kind == ShapeKind::kCompound) {
        gather(b, a, -travel, probe.margin);
    }
    for_part_pairs(a, b, probe, [&](const PartPlaced& of_a, const PartPlaced& of_b) {
        meet({of_a, of_b}, probe);
    });
    for (const ManifoldGroup& group : groups_) {
        PartManifold out{group.key, {}, group.material_a, group.material_b};
        out.manifold.normal = group.normal;
        out.manifold.separation = group.separation;
        keep_four({group.points.data(), group.count}, out.manifold);
        manifolds_.push_back(out);
    }
}

void ContactSet::gather(const Placed& mesh,
                        const Placed& compound,
                        const Vec3& travel,
                        float margin) {
    near_.clear();
    gathered_ = true;
    const Local local(compound, mesh);
    // The parts' boxes are not rounded like that of the whole.
    const Aabb area = local.reach(mesh, travel, margin).grown(kRounding);
    for_triangles(mesh_of(mesh.shape), area, [&](const Triangle& t) {
        gathered_ = near_.add(t) && gathered_;
    });
}

void ContactSet::meet(const Pair& pair, const Probe& probe) {
    for (const bool a_is : {true, false}) {
        const Shape& shape = (a_is ? pair.a : pair.b).placed.shape;
        if (shape.kind == ShapeKind::kMesh) {
            meet_surface(pair, probe, mesh_of(shape), a_is);
            return;
        }
        if (shape.kind == ShapeKind::kHeightfield) {
            meet_surface(pair, probe, field_of(shape), a_is);
            return;
        }
    }
    Manifold manifold;
    const float margin = probe.margin + probe.time * probe.approach.norm();
    physics::collide(pair.a.placed, pair.b.placed, margin, manifold);
    add(pair, 0, probe, manifold);
}

template <class Surface>
void ContactSet::meet_surface(const Pair& pair,
                              const Probe& probe,
                              const Surface& surface,
                              bool a_is) {
    const Placed& frame = (a_is ? pair.a : pair.b).placed;
    const Local local((a_is ? pair.b : pair.a).placed, frame);
    const float margin = probe.margin + probe.time * probe.approach.norm();
    const auto take = [&](const Triangle& t, Manifold& manifold) {
        if (manifold.count > 0) {
            to_world(frame, manifold);
            if (!a_is) {
                manifold.flip();
            }
            add(pair, t.id, probe, manifold);
        }
    };
    Triangle over;
    if (buried(surface, local.placed, over)) {
        Manifold manifold;
        SurfaceVisitor(local.placed).collide_half_space(over, margin, manifold);
        take(over, manifold);
        return;
    }
    const Vec3 travel = probe.time * (a_is ? probe.approach : Vec3(-probe.approach));
    std::optional<SurfaceVisitor> visitor;  // most parts of a compound are near no triangle
    const auto visit = [&](const Triangle& t) {
        if (!visitor) {
            visitor.emplace(local.placed);
        }
        Manifold manifold;
        visitor->collide(t, margin, manifold);
        take(t, manifold);
    };
    const Aabb reach = local.reach(frame, travel, probe.margin);
    if (!gathered_) {
        for_triangles(surface, reach, visit);
        return;
    }
    near_.query(reach, visit);
}

/// Takes the points that are near or will be, into the group of their normal.
void ContactSet::add(const Pair& pair,
                     std::uint32_t triangle,
                     const Probe& probe,
                     Manifold& manifold) {
    const float closing = std::max(0.0F, -manifold.normal.dot(probe.approach));
    const float margin = probe.margin + closing * probe.time;
    if (pair.senses()) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(manifold.count); ++i) {
            sensed_ |= manifold.points[i].separation <= 0.0F;
        }
        return;
    }
    const auto of_a = static_cast<PartKey>(pair.a.part != nullptr ? pair.a.index : triangle);
    const auto of_b = static_cast<PartKey>(pair.b.part != nullptr ? pair.b.index : triangle);
    const PartKey key = (of_a << 32) | of_b;
    ManifoldGroup* group = nullptr;
    for (std::size_t i = 0; i < static_cast<std::size_t>(manifold.count); ++i) {
        ManifoldPoint point = manifold.points[i];
        if (point.separation > margin) {
            continue;
        }
        if (group == nullptr) {
            group = group_for(pair, key, manifold);
            if (group == nullptr) {
                ++dropped_;
                return;
            }
        }
        const auto known = group->points.begin() + static_cast<std::ptrdiff_t>(group->count);
        if (std::any_of(group->points.begin(), known, [&](const ManifoldPoint& p) {
                return (p.point - point.point).squaredNorm() < kSharedPoint * kSharedPoint;
            })) {
            continue;
        }
        if (group->count == kGroupPoints) {
            Manifold four;
            four.normal = group->normal;
            keep_four({group->points.data(), group->count}, four);
            std::copy_n(four.points.begin(), four.count, group->points.begin());
            group->count = static_cast<std::size_t>(four.count);
        }
        // Points of several parts get names of their own.
        point.feature ^= static_cast<std::uint32_t>(key * 0x9E3779B1U >> 3);
        group->points[group->count++] = point;
        group->separation = std::min(group->separation, point.separation);
    }
}

/// The group of the manifold's normal and materials, or a new one; when all are taken, that of the
/// shallowest one if the manifold is deeper.
ContactSet::ManifoldGroup* ContactSet::group_for(const Pair& pair,
                                                 PartKey key,
                                                 const Manifold& manifold) {
    const Material* material_a = Pair::material(pair.a);
    const Material* material_b = Pair::material(pair.b);
    for (ManifoldGroup& group : groups_) {
        if (group.normal.dot(manifold.normal) >= kSameNormal && group.material_a == material_a &&
            group.material_b == material_b) {
            return &group;
        }
    }
    ManifoldGroup* group = nullptr;
    if (groups_.size() < kMaxPairManifolds) {
        group = &groups_.emplace_back();
    } else {
        group = &*std::max_element(
            groups_.begin(), groups_.end(), [](const ManifoldGroup& a, const ManifoldGroup& b) {
                return a.separation < b.separation;
            });
        ++dropped_;
        if (group->separation <= manifold.separation) {
            return nullptr;
        }
    }
    group->key = key;
    group->normal = manifold.normal;
    group->separation = INFINITY;
    group->material_a = material_a;
    group->material_b = material_b;
    group->count = 0;
    return group;
}

float earliest_impact(const Placed& a, const Placed& b, const Probe& probe, float gap) {
    float earliest = INFINITY;
    for_part_pairs(a, b, probe, [&](const PartPlaced& of_a, const PartPlaced& of_b) {
        const bool senses = (of_a.part != nullptr && of_a.part->part.sensor) ||
                            (of_b.part != nullptr && of_b.part->part.sensor);
        if (!senses) {
            earliest = std::min(earliest, impact_of(of_a.placed, of_b.placed, probe, gap));
        }
    });
    return earliest <= probe.time ? earliest : INFINITY;
}

}  // namespace zoned::physics
