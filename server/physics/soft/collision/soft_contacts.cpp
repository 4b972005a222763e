// Contacts of nodes with rigid bodies, through the scene's public interface. Surfaces are looked
// for once per step; within it each is a plane that moves with its body. The impulse that pushes a
// node off goes to the body at once, at the node, equal and opposite, so that linear and angular
// momentum stay. Friction is Coulomb's, on the distance of the substep (Macklin et al., "Unified
// particle physics for real-time applications", 2014, section 6.1).
#include "server/physics/scene/scene.h"
#include "server/physics/soft/soft_body.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {

namespace {

constexpr float kPushOut = 1.0F;      // m/s: at which nodes leave an overlap from before
constexpr float kInsideReach = 2.0F;  // m: from where a surface is looked for that a node is behind

/// The surface that a node is behind: the nearest of the hits from above and from straight outside.
bool straight_exit(const Query& query,
                   const Scene& scene,
                   const Vec3& x,
                   BodyId body,
                   QueryHit& hit) {
    float depth = INFINITY;
    Vec3 outward = x - scene.state(body).position;
    outward = outward.norm() > 1.0e-6F ? outward.normalized() : Vec3(Vec3::UnitY());
    for (const Vec3& way : {Vec3(Vec3::UnitY()), outward}) {
        QueryHit found;
        const Ray ray{x + kInsideReach * way, -way, kInsideReach};
        if (query.ray(ray, {}, found) && found.body == body &&
            kInsideReach - found.distance < depth) {
            depth = kInsideReach - found.distance;
            hit = found;
        }
    }
    return std::isfinite(depth);
}

Vec3 surface_velocity(const BodyState& s, const Vec3& point) {
    return s.velocity + s.angular_velocity.cross(point - s.position);
}

struct Reach {
    float dt;
    float bodies;  // how far bodies may come in the step, m
};

void add_contacts(SoftBody& body,
                  std::uint32_t i,
                  const Query& query,
                  const Scene& scene,
                  Reach r) {
    const Vec3 x = body.position(i);
    const Vec3 way = r.dt * body.v[i].head<3>();
    const float reach = body.material.thickness + way.norm() + r.bodies;
    // A node may be held between two bodies: one that stands and one that moves.
    QueryFilter standing;
    standing.kinematics = standing.dynamics = false;
    QueryFilter moving;
    moving.statics = false;
    const std::size_t first = body.contacts.size();
    for (const QueryFilter& filter : {standing, moving}) {
        QueryHit hit;
        if (query.closest_to_point(x, reach, filter, hit) &&
            (hit.distance > 0.0F || straight_exit(query, scene, x, hit.body, hit))) {
            body.contacts.push_back({i, hit.body, hit.point, hit.normal, Vec3::Zero()});
        }
    }
    // The surface that a fast node would run into may be another surface than the nearest.
    QueryHit ahead;
    if (way.norm() > body.material.thickness && query.ray({x, way, way.norm()}, {}, ahead) &&
        std::none_of(body.contacts.begin() + static_cast<std::ptrdiff_t>(first),
                     body.contacts.end(),
                     [&](const NodeContact& c) {
                         return c.body == ahead.body && c.normal.dot(ahead.normal) > 0.99F;
                     })) {
        body.contacts.push_back({i, ahead.body, ahead.point, ahead.normal, Vec3::Zero()});
    }
}

}  // namespace

void find_contacts(SoftBody& body, const Scene& scene, float dt) {
    body.contacts.clear();
    body.touches_dynamic = false;
    if (!body.material.collides) {
        return;
    }
    float fastest = 0.0F;
    for (std::size_t i = 0; i < body.x.size(); ++i) {
        fastest = std::max(fastest, body.v[i].norm());
    }
    const float near = body.material.thickness + dt * (fastest + kFastBody);
    body.neighbours.clear();
    scene.overlap(body.box.grown(near), body.neighbours);
    if (body.neighbours.empty()) {
        return;
    }
    float reach = 0.0F;
    for (const BodyId id : body.neighbours) {
        const BodyState s = scene.state(id);
        // Spin sweeps by at most the speed of the farthest point of a body of a few metres.
        reach = std::max(reach, dt * (s.velocity.norm() + s.angular_velocity.norm()));
    }
    const Query query = scene.query();
    for (std::uint32_t i = 0; i < body.x.size(); ++i) {
        if (body.x[i].w() > 0.0F) {
            add_contacts(body, i, query, scene, {dt, reach + 0.5F * kGravity * dt * dt});
        }
    }
}

void solve_contacts(SoftBody& body, Scene& scene, float h) {
    for (NodeContact& c : body.contacts) {
        if (!scene.contains(c.body)) {
            continue;
        }
        const Vec3 x = body.position(c.node);
        const Vec3 surface = h * surface_velocity(scene.state(c.body), x);
        c.moved += surface;
        const float gap = c.normal.dot(x - c.point - c.moved) - body.material.thickness;
        if (gap >= 0.0F) {
            continue;
        }
        const Vec3 way = x - body.start[c.node].head<3>() - surface;
        const float approach = std::max(0.0F, -c.normal.dot(way));
        const float depth = std::min(-gap, approach + h * kPushOut);
        const float wn = body.x[c.node].w();
        const float wb = scene.response(c.body, x, c.normal);
        const float push = depth / (wn + wb);
        Vec3 lambda = push * c.normal;
        const Vec3 slide = way - c.normal.dot(way) * c.normal;
        const float slid = slide.norm();
        if (slid > 0.0F) {
            const Vec3 t = slide / slid;
            const float hold = slid / (wn + scene.response(c.body, x, t));
            lambda -= std::min(hold, body.material.friction * push) * t;
        }
        body.x[c.node].head<3>() += wn * lambda;
        if (wb > 0.0F) {
            c.moved -= wb * push * c.normal;
            scene.apply_impulse(c.body, -lambda / h, x);
            body.touches_dynamic = true;
        }
    }
}

}  // namespace zoned::physics::soft
