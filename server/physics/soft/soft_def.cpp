#include "server/physics/soft/soft_def.h"

#include "server/physics/shapes/compound/body_checks.h"
#include "server/physics/shapes/ranges.h"
#include "server/physics/soft/collision/skin.h"
#include "server/physics/soft/volume.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace zoned::physics::soft {

namespace {

constexpr float kMostStiffness = 1.0e12F;  // N/m
constexpr float kMostPressure = 1.0e12F;   // Pa
constexpr std::size_t kMostNodes = 1U << 24U;

/// Written so that NaN fails.
bool in_range(float value, float lower, float upper) {
    return value >= lower && value <= upper;
}

std::string at(const char* what, std::size_t index, const char* reason) {
    return std::string(what) + " " + std::to_string(index) + ": " + reason;
}

template <class Indices>
bool distinct_below(const Indices& indices, std::size_t count) {
    for (std::size_t i = 0; i < indices.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (indices[i] == indices[j]) {
                return false;
            }
        }
        if (indices[i] >= count) {
            return false;
        }
    }
    return true;
}

std::string why_unfit_nodes(const SoftDef& def) {
    if (def.nodes.empty()) {
        return "nodes: none";
    }
    if (def.nodes.size() > kMostNodes) {
        return "nodes: too many";
    }
    for (std::size_t i = 0; i < def.nodes.size(); ++i) {
        const SoftNode& n = def.nodes[i];
        if (!fit_position(n.position)) {
            return at("node", i, "position not finite or out of range");
        }
        if (!fit_velocity(n.velocity, Vec3::Zero())) {
            return at("node", i, "velocity not finite or out of range");
        }
        if (!in_range(n.mass, 1.0e-9F, kMaxMass)) {
            return at("node", i, "mass not positive or out of range");
        }
    }
    return {};
}

std::string why_unfit_springs(const SoftDef& def) {
    for (std::size_t i = 0; i < def.springs.size(); ++i) {
        const SoftSpring& s = def.springs[i];
        if (!distinct_below(std::array{s.a, s.b}, def.nodes.size())) {
            return at("spring", i, "ends are not two different nodes");
        }
        if (!in_range(s.rest, 1.0e-6F, kMaxSize)) {
            return at("spring", i, "rest length not positive or out of range");
        }
        if ((def.nodes[s.a].position - def.nodes[s.b].position).norm() < 1.0e-6F) {
            return at("spring", i, "its ends lie in one point");
        }
        if (!in_range(s.stiffness, 1.0e-6F, kMostStiffness)) {
            return at("spring", i, "stiffness not positive or out of range");
        }
        if (!in_range(s.damping, 0.0F, kMostStiffness)) {
            return at("spring", i, "damping negative or out of range");
        }
        if (s.kind > SpringKind::kBend) {
            return at("spring", i, "unknown kind");
        }
    }
    return {};
}

std::string why_unfit_mesh(const SoftDef& def) {
    for (std::size_t i = 0; i < def.faces.size(); ++i) {
        if (!distinct_below(def.faces[i], def.nodes.size())) {
            return at("face", i, "corners are not three different nodes");
        }
    }
    for (std::size_t i = 0; i < def.tetrahedra.size(); ++i) {
        const SoftTetrahedron& t = def.tetrahedra[i];
        if (!distinct_below(t, def.nodes.size())) {
            return at("tetrahedron", i, "corners are not four different nodes");
        }
        if (!(tetrahedron_volume(def.nodes[t[0]].position,
                                 def.nodes[t[1]].position,
                                 def.nodes[t[2]].position,
                                 def.nodes[t[3]].position) > 1.0e-15F)) {
            return at("tetrahedron", i, "volume not positive");
        }
    }
    for (std::size_t i = 0; i < def.vertices.size(); ++i) {
        float sum = 0.0F;
        for (std::size_t c = 0; c < 4; ++c) {
            if (def.vertices[i].node[c] >= def.nodes.size()) {
                return at("vertex", i, "node out of range");
            }
            sum += def.vertices[i].weight[c];
        }
        if (!in_range(std::abs(def.vertices[i].offset), 0.0F, kMaxSize)) {
            return at("vertex", i, "offset not finite or out of range");
        }
        if (!in_range(sum, 0.999F, 1.001F)) {
            return at("vertex", i, "weights do not sum to one");
        }
    }
    for (std::size_t i = 0; i < def.drawn_faces.size(); ++i) {
        if (!distinct_below(def.drawn_faces[i], def.vertices.size())) {
            return at("drawn face", i, "corners are not three different vertices");
        }
    }
    return {};
}

std::string why_unfit_material(const SoftDef& def) {
    const SoftMaterial& m = def.material;
    if ((m.tear_strain > 0.0F || m.tear_force > 0.0F) && !def.vertices.empty()) {
        return "vertices: none may hang on a body that tears";
    }
    if (!in_range(m.drag, 0.0F, 1.0e4F)) {
        return "drag negative or out of range";
    }
    if (!in_range(m.bulk_modulus, 0.0F, kMostPressure)) {
        return "bulk modulus negative or out of range";
    }
    if (!in_range(m.gas_pressure, 0.0F, kMostPressure) ||
        !in_range(m.ambient_pressure, 0.0F, kMostPressure)) {
        return "pressure negative or out of range";
    }
    if (!in_range(m.tear_strain, 0.0F, 1.0e6F) || !in_range(m.tear_force, 0.0F, kMaxForce)) {
        return "limit of tearing negative or out of range";
    }
    if (!in_range(m.yield_strain, 0.0F, 1.0e6F) || !in_range(m.creep_rate, 0.0F, 1.0e6F) ||
        !in_range(m.most_set, 0.0F, 0.99F)) {
        return "permanent set out of range";
    }
    if (!in_range(m.thickness, 1.0e-5F, 10.0F)) {
        return "thickness not positive or out of range";
    }
    return in_range(m.friction, 0.0F, 100.0F) ? "" : "friction out of range";
}

std::string why_unfit_gas(const SoftDef& def) {
    if (!(def.material.gas_pressure > 0.0F)) {
        return {};
    }
    if (!is_closed(def.faces)) {
        return "faces: gas needs a closed surface whose faces all turn outward";
    }
    double volume = 0.0;
    for (const SoftFace& f : def.faces) {
        const Vec3d a = def.nodes[f[0]].position.cast<double>();
        const Vec3d b = def.nodes[f[1]].position.cast<double>();
        volume += a.dot(b.cross(def.nodes[f[2]].position.cast<double>())) / 6.0;
    }
    return volume > 1.0e-12 ? "" : "faces: gas needs a positive volume";
}

std::string why_unfit_solver(const SoftSolver& s) {
    if (s.method > SoftMethod::kSemiImplicitEuler) {
        return "unknown method";
    }
    if (s.substeps < 0 || s.substeps > kMostSubsteps) {
        return "substeps out of range";
    }
    if (s.newton_iterations < 1 || s.newton_iterations > 100 || s.gradient_iterations < 1 ||
        s.gradient_iterations > 100'000) {
        return "iterations out of range";
    }
    return in_range(s.gradient_accuracy, 1.0e-12F, 1.0F) ? "" : "accuracy out of range";
}

}  // namespace

std::string why_unfit(const SoftDef& def) {
    for (const auto check :
         {why_unfit_nodes, why_unfit_springs, why_unfit_mesh, why_unfit_material, why_unfit_gas}) {
        if (std::string reason = check(def); !reason.empty()) {
            return reason;
        }
    }
    return why_unfit_solver(def.solver);
}

}  // namespace zoned::physics::soft
