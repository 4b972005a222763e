// Physics test: step lengths, settings and constants that tests of scenes share.
#pragma once

#include "server/physics/scene/scene.h"

#include <limits>

namespace zoned::physics {

inline constexpr float kFrame = 1.0F / 60.0F;  ///< s
inline constexpr float kTick = 1.0F / 30.0F;   ///< s, of a server
inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
inline const Vec3 kDown(0.0F, -kGravity, 0.0F);
inline constexpr QueryFilter kAll{};

/// Nothing falls and nothing sleeps.
inline PhysicsSettings weightless() {
    PhysicsSettings settings;
    settings.gravity = Vec3::Zero();
    settings.sleep_after_s = 0.0F;
    return settings;
}

inline void run_steps(Scene& scene, int n, float dt = kFrame) {
    for (int i = 0; i < n; ++i) {
        scene.step(dt);
    }
}

}  // namespace zoned::physics
