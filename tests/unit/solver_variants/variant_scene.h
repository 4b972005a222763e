// VariantScene: names of the methods, and scenes of a few boxes on level ground, for their tests.
#pragma once

#include "server/physics/scene/scene.h"
#include "server/physics/solver_variants/rows/row_system.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace zoned::physics {

inline constexpr float kFrame = 1.0F / 60.0F;

inline const std::vector<SolverVariant>& all_methods() {
    static const std::vector<SolverVariant> methods{SolverVariant::kJacobi,
                                                    SolverVariant::kGaussSeidel,
                                                    SolverVariant::kOverRelaxation,
                                                    SolverVariant::kConjugateGradient,
                                                    SolverVariant::kDirect,
                                                    SolverVariant::kImpulse,
                                                    SolverVariant::kProjection,
                                                    SolverVariant::kPenalty};
    return methods;
}

/// The methods that solve a RowSystem.
inline const std::vector<SolverVariant>& row_methods() {
    static const std::vector<SolverVariant> methods{SolverVariant::kJacobi,
                                                    SolverVariant::kGaussSeidel,
                                                    SolverVariant::kOverRelaxation,
                                                    SolverVariant::kConjugateGradient,
                                                    SolverVariant::kDirect};
    return methods;
}

inline std::string name_of(SolverVariant method) {
    switch (method) {
        case SolverVariant::kSoftStep:
            return "soft step";
        case SolverVariant::kJacobi:
            return "jacobi";
        case SolverVariant::kGaussSeidel:
            return "gauss-seidel";
        case SolverVariant::kOverRelaxation:
            return "over relaxation";
        case SolverVariant::kConjugateGradient:
            return "conjugate gradient";
        case SolverVariant::kDirect:
            return "direct";
        case SolverVariant::kImpulse:
            return "impulse";
        case SolverVariant::kProjection:
            return "projection";
        case SolverVariant::kPenalty:
            return "penalty";
    }
    return "?";
}

inline PhysicsSettings settings_of(SolverVariant method, int iterations = 20) {
    PhysicsSettings settings;
    settings.method = method;
    settings.methods.iterations = iterations;
    settings.sleep_after_s = 0.0F;
    return settings;
}

/// A scene and the bodies in it.
class VariantScene {
  public:
    explicit VariantScene(const PhysicsSettings& settings) : scene(settings) {}

    BodyId add(const BodyDef& def) {
        const auto id = scene.add(def);
        EXPECT_TRUE(id.ok());
        bodies.push_back(*id);
        return *id;
    }

    BodyId ground(float friction = 0.5F, float restitution = 0.0F) {
        BodyDef def;
        def.kind = BodyKind::kStatic;
        def.shape = Shape::box(Vec3(50.0F, 1.0F, 50.0F));
        def.position = Vec3(0.0F, -1.0F, 0.0F);
        def.material.friction = friction;
        def.material.restitution = restitution;
        const auto id = scene.add(def);
        EXPECT_TRUE(id.ok());
        return *id;
    }

    BodyId box(const Vec3& position, float mass = 1.0F, float friction = 0.5F) {
        BodyDef def;
        def.shape = Shape::box(Vec3::Constant(0.5F));
        def.mass = mass;
        def.position = position;
        def.material.friction = friction;
        return add(def);
    }

    BodyId sphere(const Vec3& position,
                  const Vec3& velocity,
                  float restitution,
                  float mass = 1.0F,
                  float friction = 0.0F) {
        BodyDef def;
        def.shape = Shape::sphere(0.5F);
        def.mass = mass;
        def.position = position;
        def.velocity = velocity;
        def.material.friction = friction;
        def.material.restitution = restitution;
        return add(def);
    }

    void run(float seconds) {
        for (int i = 0; i < static_cast<int>(std::lround(seconds / kFrame)); ++i) {
            stats = scene.step(kFrame);
        }
    }

    Scene scene;
    std::vector<BodyId> bodies;
    StepStats stats;
};

}  // namespace zoned::physics
