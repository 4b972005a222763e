// Problems: small systems of rows, as scenes produce them.
#pragma once

#include "server/physics/solver_variants/row_solvers/row_solvers.h"
#include "server/physics/solver_variants/rows/residual.h"
#include "tests/unit/solver_variants/variant_scene.h"

#include <numbers>

namespace zoned::physics {

inline PhysicsSettings problem_settings(FrictionModel friction, ManifoldMode manifold) {
    PhysicsSettings settings = settings_of(SolverVariant::kGaussSeidel);
    settings.methods.keep_problem = true;
    settings.methods.warm_start = false;
    settings.methods.friction = friction;
    settings.methods.manifold = manifold;
    return settings;
}

/// The rows of the scene's next step.
inline RowSystem problem_of(VariantScene& s) {
    s.scene.step(kFrame);
    return *s.scene.problem();
}

/// Three boxes that rest, slide and slide askew. None turns: the four points of a box share its
/// weight in no unique manner. So the friction moment of a turning box would be ambiguous too.
inline RowSystem boxes_on_ground(FrictionModel friction, ManifoldMode manifold) {
    VariantScene s(problem_settings(friction, manifold));
    s.ground();
    s.box(Vec3(0.0F, 0.5F, 0.0F));
    s.scene.set_velocity(s.box(Vec3(3.0F, 0.5F, 0.0F)), Vec3(1.0F, 0.0F, 0.4F), Vec3::Zero());
    s.scene.set_velocity(
        s.box(Vec3(6.0F, 0.5F, 0.0F), 5.0F), Vec3(0.0F, 0.0F, -2.0F), Vec3::Zero());
    return problem_of(s);
}

/// A sphere that falls into a groove of 90 degrees, turning.
inline RowSystem wedge(FrictionModel friction, ManifoldMode manifold) {
    VariantScene s(problem_settings(friction, manifold));
    for (const float side : {-1.0F, 1.0F}) {
        BodyDef def;
        def.kind = BodyKind::kStatic;
        def.shape = Shape::box(Vec3(5.0F, 0.5F, 5.0F));
        def.orientation =
            Quat(Eigen::AngleAxisf(side * 0.25F * std::numbers::pi_v<float>, Vec3::UnitZ()));
        const Vec3 up = def.orientation * Vec3::UnitY();
        def.position = -0.5F * up;
        EXPECT_TRUE(s.scene.add(def).ok());
    }
    BodyDef def;
    def.shape = Shape::sphere(0.5F);
    def.position = Vec3(0.0F, 0.5F * std::numbers::sqrt2_v<float>, 0.0F);
    def.velocity = Vec3(0.1F, -1.0F, 0.3F);
    def.angular_velocity = Vec3(0.0F, 0.0F, 3.0F);
    s.add(def);
    return problem_of(s);
}

/// Five boxes, the top one pushed sideways.
inline RowSystem stack_of_five(FrictionModel friction, ManifoldMode manifold) {
    VariantScene s(problem_settings(friction, manifold));
    s.ground();
    for (int i = 0; i < 5; ++i) {
        s.box(Vec3(0.0F, 0.5F + static_cast<float>(i), 0.0F));
    }
    s.scene.set_velocity(s.bodies[4], Vec3(0.3F, 0.0F, 0.1F), Vec3::Zero());
    return problem_of(s);
}

/// A square pyramid of boxes: 4 x 4, 3 x 3, 2 x 2 and one.
inline RowSystem heap(FrictionModel friction, ManifoldMode manifold) {
    VariantScene s(problem_settings(friction, manifold));
    s.ground();
    for (int level = 0; level < 4; ++level) {
        const int side = 4 - level;
        for (int i = 0; i < side * side; ++i) {
            const float x = static_cast<float>(i % side) - 0.5F * static_cast<float>(side - 1);
            const float z = static_cast<float>(i / side) - 0.5F * static_cast<float>(side - 1);
            s.box(Vec3(1.1F * x, 0.5F + static_cast<float>(level), 1.1F * z));
        }
    }
    return problem_of(s);
}

/// Largest difference of a velocity, m/s or rad/s.
inline double difference(const RowSystem& a, const RowSystem& b) {
    double largest = 0.0;
    for (std::size_t i = 0; i < a.bodies.size(); ++i) {
        const RowBody& p = a.bodies[i];
        const RowBody& q = b.bodies[i];
        largest = std::max({largest,
                            (p.velocity - q.velocity).cwiseAbs().maxCoeff(),
                            (p.spin - q.spin).cwiseAbs().maxCoeff()});
    }
    return largest;
}

}  // namespace zoned::physics
