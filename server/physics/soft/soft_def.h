// SoftDef: the material and the method of a soft body, before it is added.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace zoned::physics::soft {

/// A soft body of one SoftBodies: index + 1 (never reused while a SoftBodies lives).
using SoftId = StrongId<struct SoftTag>;

/// How the springs and volumes of a body are solved; one file each.
enum class SoftMethod : std::uint8_t {
    kXpbd,           ///< solve_xpbd.cpp
    kImplicitEuler,  ///< solve_implicit.cpp
    /// solve_semi_implicit.cpp: explicit springs, the cheapest substep, for slack springs only; see
    /// why_unstable.
    kSemiImplicitEuler,
};

/// As messages name it.
constexpr const char* name_of(SoftMethod method) {
    constexpr std::array kNames{"xpbd", "implicit_euler", "semi_implicit_euler"};
    const auto i = static_cast<std::size_t>(method);
    return i < kNames.size() ? kNames[i] : "unknown";
}

inline constexpr int kMostSubsteps = 256;  ///< of a step

enum class SpringKind : std::uint8_t {
    kStructural,
    kShear,
    kBend,
};

struct SoftNode {
    Vec3 position = Vec3::Zero();  ///< m, zone coordinates
    Vec3 velocity = Vec3::Zero();  ///< m/s; of a pinned node: that with which it is led
    float mass = 1.0F;             ///< kg, > 0, also where it is pinned
    bool pinned = false;           ///< moves only as it is led
};

struct SoftSpring {
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    float rest = 0.0F;       ///< m, > 0
    float stiffness = 0.0F;  ///< N/m, > 0
    float damping = 0.0F;    ///< N s/m along the spring, >= 0
    SpringKind kind = SpringKind::kStructural;
};

using SoftFace = std::array<std::uint32_t, 3>;         ///< of a closed surface: outward normal
using SoftTetrahedron = std::array<std::uint32_t, 4>;  ///< of positive volume

/// A drawn vertex that hangs on up to four nodes: its place is the weighted sum of theirs, and
/// beyond it `offset` along the normal of the first three. Those may be one line or point only
/// where the offset is 0.
struct SoftVertex {
    std::array<std::uint32_t, 4> node{};
    std::array<float, 4> weight{};  ///< sum 1
    float offset = 0.0F;            ///< m

    bool operator==(const SoftVertex&) const = default;
};

struct SoftMaterial {
    float drag = 0.0F;          ///< share of its speed that a node loses per second, 1/s, >= 0
    float bulk_modulus = 0.0F;  ///< of the tetrahedra, Pa; 0: they keep no volume
    /// Absolute pressure of the gas within the faces at the volume that they enclose at first, Pa;
    /// 0: no gas. Isothermal: p V is constant.
    float gas_pressure = 0.0F;
    float ambient_pressure = 101325.0F;  ///< outside, Pa
    float tear_strain = 0.0F;            ///< springs break above it; 0: never
    float tear_force = 0.0F;             ///< N; 0: never
    float yield_strain = 0.0F;           ///< springs creep above it; 0: never
    float creep_rate = 1.0F;             ///< share of the strain above yield per second, 1/s
    float most_set = 0.5F;               ///< of the rest length, as a share of the first one, < 1
    float thickness = 0.01F;             ///< distance that nodes keep from surfaces, m, > 0;
                                         ///< two soft bodies keep the sum of theirs
    float friction = 0.5F;               ///< Coulomb's coefficient against rigid bodies, >= 0;
                                         ///< between soft ones the geometric mean counts
    bool collides = true;                ///< with rigid bodies and other soft ones
    bool self_collision = false;
};

struct SoftSolver {
    SoftMethod method = SoftMethod::kXpbd;
    /// Per step, 1..256. 0 for XPBD: the root of the number of nodes within 4..64 (a spring passes
    /// a load on by about one node per substep). 0 for implicit Euler: one. 0 for semi-implicit
    /// Euler: as many as its springs need.
    int substeps = 0;
    int newton_iterations = 2;        ///< implicit Euler, per substep, 1..100
    int gradient_iterations = 60;     ///< implicit Euler: conjugate gradients per Newton step, >= 1
    float gradient_accuracy = 1e-3F;  ///< ends them at this share of the first residual
};

struct SoftDef {
    std::vector<SoftNode> nodes;
    std::vector<SoftSpring> springs;
    std::vector<SoftFace> faces;
    std::vector<SoftTetrahedron> tetrahedra;
    std::vector<SoftVertex> vertices;   ///< empty: the nodes are drawn
    std::vector<SoftFace> drawn_faces;  ///< of the vertices; none without them: `faces` are drawn
    SoftMaterial material;
    SoftSolver solver;
    std::uint32_t user = 0;  ///< the caller's tag
};

/// Empty when the definition is fit, otherwise the place and the reason ("spring 17: rest length
/// out of range").
std::string why_unfit(const SoftDef& def);

/// Why the method of a definition that is fit cannot bear steps of `dt` > 0 s in so many substeps:
/// names the fastest spring, omega h and the limit (see spring_limit.h). Empty where it can; XPBD
/// and implicit Euler can always.
std::string why_unstable(const SoftDef& def, float dt);

}  // namespace zoned::physics::soft
