// Permanent set and tearing. Springs of a mesh tear it at a node: the faces on both sides of the
// plane across the spring part, each side keeps a node (O'Brien and Hodgins, "Graphical modeling
// and animation of brittle fracture", 1999, section 5, with the spring's direction for the
// separation plane's). Mass and momentum stay. Without faces the spring just goes.
#include "server/physics/soft/soft_body.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {

namespace {

constexpr std::uint32_t kMostTears = 64;  // per step: a crack runs on in the next ones

bool has_corner(const SoftFace& f, std::uint32_t node) {
    return f[0] == node || f[1] == node || f[2] == node;
}

/// Whether the face lies beyond the plane through node `v` across `way`.
bool beyond(const SoftBody& body, const SoftFace& f, std::uint32_t v, const Vec3& way) {
    const Vec3 middle = (body.position(f[0]) + body.position(f[1]) + body.position(f[2])) / 3.0F;
    return way.dot(middle - body.position(v)) > 0.0F;
}

bool share_a_face(const SoftBody& body, std::uint32_t a, std::uint32_t b) {
    return std::any_of(body.faces.begin(), body.faces.end(), [&](const SoftFace& f) {
        return has_corner(f, a) && has_corner(f, b);
    });
}

/// Whether some face at `a` and some face at `b` share a corner.
bool held_together(const SoftBody& body, std::uint32_t a, std::uint32_t b) {
    for (const SoftFace& f : body.faces) {
        if (!has_corner(f, a)) {
            continue;
        }
        for (const std::uint32_t corner : f) {
            if (share_a_face(body, corner, b)) {
                return true;
            }
        }
    }
    return false;
}

std::uint32_t duplicate(SoftBody& body, std::uint32_t v, float share) {
    const auto copy = static_cast<std::uint32_t>(body.x.size());
    body.x.push_back(body.x[v]);
    body.v.push_back(body.v[v]);
    body.start.push_back(body.start[v]);
    body.predicted.push_back(body.predicted[v]);
    body.kept.push_back(body.kept[v]);
    body.mass.push_back(share * body.mass[v]);
    body.mass[v] -= body.mass[copy];
    for (const std::uint32_t i : {v, copy}) {
        if (body.x[i].w() > 0.0F) {
            body.x[i].w() = 1.0F / body.mass[i];
        }
    }
    return copy;
}

/// Springs at `v` go to the side on which they lie; one along the cut is shared by both.
void share_springs(SoftBody& body, std::uint32_t v, std::uint32_t copy, const Vec3& way) {
    const std::size_t count = body.springs.size();
    for (std::size_t i = 0; i < count; ++i) {
        Spring& s = body.springs[i];
        if (!s.alive || (s.a != v && s.b != v)) {
            continue;
        }
        const std::uint32_t other = s.a == v ? s.b : s.a;
        std::uint32_t& end = s.a == v ? s.a : s.b;
        const bool here = share_a_face(body, v, other);
        const bool there = share_a_face(body, copy, other);
        if (here && there) {
            s.stiffness *= 0.5F;
            s.damping *= 0.5F;
            Spring twin = s;
            (twin.a == v ? twin.a : twin.b) = copy;
            body.springs.push_back(twin);
        } else if (there || (!here && way.dot(body.position(other) - body.position(v)) > 0.0F)) {
            end = copy;
        }
    }
}

/// Springs near the cut whose ends no longer hang together through the mesh.
void drop_bridges(SoftBody& body, std::uint32_t v, std::uint32_t copy, float reach) {
    for (Spring& s : body.springs) {
        if (s.alive && (body.position(s.a) - body.position(v)).norm() < reach &&
            (s.a == v || s.b == v || s.a == copy || s.b == copy || s.kind == SpringKind::kBend) &&
            !held_together(body, s.a, s.b)) {
            s.alive = false;
        }
    }
}

/// Parts the faces at node `v`; false where all lie on one side.
bool split(SoftBody& body, std::uint32_t v, const Vec3& way) {
    std::size_t there = 0;
    std::size_t all = 0;
    for (const SoftFace& f : body.faces) {
        if (has_corner(f, v)) {
            ++all;
            there += beyond(body, f, v, way) ? 1 : 0;
        }
    }
    if (there == 0 || there == all) {
        return false;
    }
    const std::uint32_t copy =
        duplicate(body, v, static_cast<float>(there) / static_cast<float>(all));
    for (SoftFace& f : body.faces) {
        if (has_corner(f, v) && beyond(body, f, v, way)) {
            std::replace(f.begin(), f.end(), v, copy);
        }
    }
    share_springs(body, v, copy, way);
    drop_bridges(body, v, copy, 4.0F * way.norm());
    return true;
}

bool overstretched(const SoftBody& body, const Spring& s) {
    const float longer = (body.position(s.b) - body.position(s.a)).norm() - s.rest;
    const SoftMaterial& m = body.material;
    return (m.tear_strain > 0.0F && longer > m.tear_strain * s.rest) ||
           (m.tear_force > 0.0F && s.stiffness * longer > m.tear_force);
}

}  // namespace

bool creep(SoftBody& body, float dt) {
    const SoftMaterial& m = body.material;
    if (m.yield_strain <= 0.0F) {
        return false;
    }
    bool changed = false;
    const float share = -elementary::expm1(-m.creep_rate * dt);
    for (Spring& s : body.springs) {
        const float strain = (body.position(s.b) - body.position(s.a)).norm() / s.rest - 1.0F;
        const float over = std::abs(strain) - m.yield_strain;
        if (s.alive && over > 0.0F) {
            const float rest = s.rest * (1.0F + std::copysign(share * over, strain));
            s.rest = std::clamp(
                rest, (1.0F - m.most_set) * s.first_rest, (1.0F + m.most_set) * s.first_rest);
            changed = true;
        }
    }
    return changed;
}

std::uint32_t tear(SoftBody& body) {
    const SoftMaterial& m = body.material;
    if (m.tear_strain <= 0.0F && m.tear_force <= 0.0F) {
        return 0;
    }
    std::uint32_t torn = 0;
    const std::size_t count = body.springs.size();
    for (std::size_t i = 0; i < count && torn < kMostTears; ++i) {
        if (!body.springs[i].alive || !overstretched(body, body.springs[i])) {
            continue;
        }
        ++torn;
        // By value: splitting adds springs.
        const Spring s = body.springs[i];
        const Vec3 way = body.position(s.b) - body.position(s.a);
        // The cut relieves the spring: it passes to the far side of its end a, or of b. A surface
        // that holds gas stays closed.
        const bool mesh = !body.faces.empty() && body.gas <= 0.0;
        if (!mesh || !(split(body, s.a, way) || split(body, s.b, -way))) {
            body.springs[i].alive = false;
        }
    }
    if (torn > 0) {
        std::erase_if(body.springs, [](const Spring& s) { return !s.alive; });
        relink(body);
    }
    body.torn += torn;
    return torn;
}

void relink(SoftBody& body) {
    body.batches.build(body.springs, body.x.size());
    body.linked.clear();
    find_skin(body);
    limit_step(body);
}

}  // namespace zoned::physics::soft
