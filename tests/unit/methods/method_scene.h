// What tests of the methods share: names, and scenes of a few boxes on a level ground.
#pragma once

#include "server/physics/methods/row_system.h"
#include "server/physics/scene.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace zoned::physics {

inline constexpr float kFrame = 1.0F / 60.0F;

inline const std::vector<Method>& all_methods() {
    static const std::vector<Method> methods{Method::kJacobi,
                                             Method::kGaussSeidel,
                                             Method::kOverRelaxation,
                                             Method::kConjugateGradient,
                                             Method::kDirect,
                                             Method::kImpulse,
                                             Method::kProjection,
                                             Method::kPenalty};
    return methods;
}

/// Those that solve a RowSystem.
inline const std::vector<Method>& row_methods() {
    static const std::vector<Method> methods{Method::kJacobi,
                                             Method::kGaussSeidel,
                                             Method::kOverRelaxation,
                                             Method::kConjugateGradient,
                                             Method::kDirect};
    return methods;
}

inline std::string name_of(Method method) {
    switch (method) {
        case Method::kSoftStep:
            return "soft step";
        case Method::kJacobi:
            return "jacobi";
        case Method::kGaussSeidel:
            return "gauss-seidel";
        case Method::kOverRelaxation:
            return "over relaxation";
        case Method::kConjugateGradient:
            return "conjugate gradient";
        case Method::kDirect:
            return "direct";
        case Method::kImpulse:
            return "impulse";
        case Method::kProjection:
            return "projection";
        case Method::kPenalty:
            return "penalty";
    }
    return "?";
}

inline Settings settings_of(Method method, int iterations = 20) {
    Settings settings;
    settings.method = method;
    settings.methods.iterations = iterations;
    settings.sleep_after_s = 0.0F;
    return settings;
}

/// A scene and the bodies that were put into it.
class MethodScene {
  public:
    explicit MethodScene(const Settings& settings) : scene(settings) {}

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
