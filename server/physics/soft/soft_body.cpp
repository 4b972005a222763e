#include "server/physics/soft/soft_body.h"

#include "server/physics/soft/soft_impl.h"
#include "server/physics/soft/volume.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

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
    body.drawn_faces = def.drawn_faces;
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

int SoftBody::substeps(float dt) const {
    if (solver.method == SoftMethod::kSemiImplicitEuler) {
        // A cut leaves lighter nodes than the definition had: then it takes more than were asked
        // for.
        const double least = std::ceil(static_cast<double>(dt) / limit.longest_step_s);
        return std::max(solver.substeps,
                        static_cast<int>(std::clamp(least, 1.0, double{kMostSubsteps})));
    }
    if (solver.substeps > 0) {
        return solver.substeps;
    }
    return solver.method == SoftMethod::kImplicitEuler ? 1 : relaxed_substeps();
}

int SoftBody::relaxed_substeps() const {
    const float root = std::sqrt(static_cast<float>(x.size()));
    return static_cast<int>(std::clamp(std::ceil(root), 4.0F, 64.0F));
}

void predict(SoftBody& body, const Vec3& gravity, float h) {
    // With c h small, (1 - e^-ch) / c loses its digits in floats: doubles keep them.
    const double c = static_cast<double>(body.material.drag);
    const double hd = static_cast<double>(h);
    const double kept = elementary::exp(-c * hd);
    const double reach = c > 0.0 ? -elementary::expm1(-c * hd) / c : hd;
    const double fall = c > 1.0e-6 ? (hd - reach) / c : 0.5 * hd * hd;
    Row4 g = Row4::Zero();
    g.head<3>() = gravity;
    const Row4 dv = static_cast<float>(reach) * g;
    const Row4 dx = static_cast<float>(fall) * g;
    for (std::size_t i = 0; i < body.x.size(); ++i) {
        Row4& x = body.x[i];
        body.start[i] = x;
        if (x.w() > 0.0F) {
            x += static_cast<float>(reach) * body.v[i] + dx;
            body.v[i] = static_cast<float>(kept) * body.v[i] + dv;
        } else {
            x += h * body.v[i];
        }
        body.predicted[i] = x;
    }
}

void finish(SoftBody& body, float h) {
    const float rate = 1.0F / h;
    for (std::size_t i = 0; i < body.x.size(); ++i) {
        body.v[i] += rate * (body.x[i] - body.predicted[i]);
    }
}

double enclosed_volume(const SoftBody& body, std::vector<Vec3d>* gradient) {
    if (gradient != nullptr) {
        gradient->assign(body.x.size(), Vec3d::Zero());
    }
    if (body.faces.empty()) {
        return 0.0;
    }
    // About a point nearby the terms stay small.
    const Vec3d middle = body.position(body.faces.front()[0]).cast<double>();
    double volume = 0.0;
    for (const SoftFace& f : body.faces) {
        const Vec3d a = body.position(f[0]).cast<double>() - middle;
        const Vec3d b = body.position(f[1]).cast<double>() - middle;
        const Vec3d c = body.position(f[2]).cast<double>() - middle;
        const Vec3d bc = b.cross(c);
        volume += a.dot(bc) / 6.0;
        if (gradient != nullptr) {
            (*gradient)[f[0]] += bc / 6.0;
            (*gradient)[f[1]] += c.cross(a) / 6.0;
            (*gradient)[f[2]] += a.cross(b) / 6.0;
        }
    }
    return volume;
}

double energy_of(const SoftBody& body, const Vec3& gravity) {
    double sum = 0.0;
    for (std::size_t i = 0; i < body.x.size(); ++i) {
        const auto m = static_cast<double>(body.mass[i]);
        sum += 0.5 * m * body.v[i].head<3>().cast<double>().squaredNorm() -
               m * gravity.cast<double>().dot(body.position(i).cast<double>());
    }
    for (const Spring& s : body.springs) {
        const double wrong = (body.position(s.b) - body.position(s.a)).cast<double>().norm() -
                             static_cast<double>(s.rest);
        sum += 0.5 * static_cast<double>(s.stiffness) * wrong * wrong;
    }
    for (std::size_t i = 0; i < body.tetrahedra.size(); ++i) {
        const SoftTetrahedron& t = body.tetrahedra[i];
        const auto rest = static_cast<double>(body.rest_volume[i]);
        const double wrong = static_cast<double>(tetrahedron_volume(body.position(t[0]),
                                                                    body.position(t[1]),
                                                                    body.position(t[2]),
                                                                    body.position(t[3]))) -
                             rest;
        sum += 0.5 * static_cast<double>(body.material.bulk_modulus) / rest * wrong * wrong;
    }
    if (body.gas > 0.0) {
        // Isothermal: the work from the first volume on is -pV ln(V / V0), against the outside
        // ambient (V - V0).
        const double first = body.gas / static_cast<double>(body.material.gas_pressure);
        const double volume = enclosed_volume(body, nullptr);
        sum += static_cast<double>(body.material.ambient_pressure) * (volume - first) -
               body.gas * elementary::log(volume / first);
    }
    return sum;
}

}  // namespace zoned::physics::soft
