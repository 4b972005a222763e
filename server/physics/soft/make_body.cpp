// From a definition to the columns of a body.
#include "server/physics/soft/soft_impl.h"
#include "server/physics/soft/volume.h"

#include <algorithm>

namespace zoned::physics::soft {

SoftBody make_body(const SoftDef& def) {
    SoftBody body;
    for (const SoftNode& n : def.nodes) {
        Row4 x = Row4::Zero();
        Row4 v = Row4::Zero();
        x << n.position, (n.pinned ? 0.0F : 1.0F / n.mass);
        v.head<3>() = n.velocity;
        body.x.push_back(x);
        body.v.push_back(v);
        body.mass.push_back(n.mass);
    }
    body.start = body.kept = body.predicted = body.x;
    for (const SoftSpring& s : def.springs) {
        body.springs.push_back({s.a, s.b, s.rest, s.rest, s.stiffness, s.damping, s.kind, true});
    }
    body.faces = def.faces;
    body.tetrahedra = def.tetrahedra;
    for (const SoftTetrahedron& t : def.tetrahedra) {
        body.rest_volume.push_back(tetrahedron_volume(def.nodes[t[0]].position,
                                                      def.nodes[t[1]].position,
                                                      def.nodes[t[2]].position,
                                                      def.nodes[t[3]].position));
    }
    body.vertices = def.vertices;
    body.material = def.material;
    body.solver = def.solver;
    body.user = def.user;
    if (def.material.gas_pressure > 0.0F) {
        body.gas = static_cast<double>(def.material.gas_pressure) * enclosed_volume(body, nullptr);
        for (const SoftFace& f : def.faces) {
            body.surface.insert(body.surface.end(), f.begin(), f.end());
        }
        std::sort(body.surface.begin(), body.surface.end());
        body.surface.erase(std::unique(body.surface.begin(), body.surface.end()),
                           body.surface.end());
    }
    body.there = true;
    relink(body);
    fit_box(body);
    return body;
}

void fit_box(SoftBody& body) {
    Eigen::Array4f lower = body.x.front().array();
    Eigen::Array4f upper = lower;
    for (const Row4& x : body.x) {
        lower = lower.min(x.array());
        upper = upper.max(x.array());
    }
    body.box =
        Aabb{lower.matrix().head<3>(), upper.matrix().head<3>()}.grown(body.material.thickness);
}

}  // namespace zoned::physics::soft
