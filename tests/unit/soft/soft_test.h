// Soft test: frames, weightless settings and momentum sums that tests of soft bodies share.
#pragma once

#include "server/physics/scene/scene.h"
#include "server/physics/soft/builders/builders.h"
#include "server/physics/soft/soft_bodies.h"

#include <gtest/gtest.h>

#include <limits>

namespace zoned::physics::soft {

inline constexpr float kFrame = 1.0F / 60.0F;  ///< s
inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

inline SoftSettings weightless_soft() {
    SoftSettings settings;
    settings.gravity.setZero();
    settings.sleep_after_s = 0.0F;
    return settings;
}

inline SoftSettings awake_soft() {
    SoftSettings settings;
    settings.sleep_after_s = 0.0F;
    return settings;
}

inline SoftId put(SoftBodies& bodies, const SoftDef& def) {
    const auto id = bodies.add(def);
    EXPECT_TRUE(id.ok()) << (id.ok() ? "" : id.error());
    return *id;
}

inline void run(SoftBodies& bodies, int steps, Scene* scene = nullptr, float dt = kFrame) {
    for (int i = 0; i < steps; ++i) {
        bodies.step(dt, scene);
        if (scene != nullptr) {
            scene->step(dt);
        }
    }
}

struct Momenta {
    Vec3d linear = Vec3d::Zero();
    Vec3d angular = Vec3d::Zero();  ///< about the origin
    double size = 0.0;              ///< sum of absolute terms: the scale of rounding
};

inline Momenta momenta(const SoftBodies& bodies, SoftId id) {
    Momenta m;
    for (std::size_t i = 0; i < bodies.node_count(id); ++i) {
        const Vec3d p =
            static_cast<double>(bodies.mass(id, i)) * bodies.velocity(id, i).cast<double>();
        const Vec3d x = bodies.position(id, i).cast<double>();
        m.linear += p;
        m.angular += x.cross(p);
        m.size += p.norm() * (1.0 + x.norm());
    }
    return m;
}

inline std::uint64_t hash_of(const SoftBodies& bodies) {
    core::StateHash hash;
    bodies.hash(hash);
    return hash.value();
}

inline SoftDef cloth(int n, float stiffness = 1.0e4F) {
    ClothDef def;
    def.nx = def.nz = n;
    def.size_x = def.size_z = 2.0F;
    def.stiffness = stiffness;
    def.shear_stiffness = 0.5F * stiffness;
    def.bend_stiffness = 0.1F * stiffness;
    def.pins = {{0, 0}, {n - 1, 0}};
    return *build_cloth(def);
}

inline SoftDef jelly() {
    JellyDef def;
    def.centre = Vec3(0, 2, 0);
    return *build_jelly(def);
}

}  // namespace zoned::physics::soft
