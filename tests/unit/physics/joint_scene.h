// JointScene: short helpers for tests of joints, with bodies, joints and sums over them.
#pragma once

#include "server/physics/shapes/compound/inertia.h"
#include "tests/unit/physics/physics_test.h"

#include <gtest/gtest.h>

#include <vector>

namespace zoned::physics {

/// A scene whose bodies never sleep, and the bodies in it.
class JointScene {
  public:
    explicit JointScene(const Vec3& gravity = Vec3::Zero(), bool sleeping = false)
        : scene(settings(gravity, sleeping)),
          gravity_(gravity.cast<double>()) {}

    static PhysicsSettings settings(const Vec3& gravity, bool sleeping) {
        PhysicsSettings s;
        s.gravity = gravity;
        s.sleep_after_s = sleeping ? s.sleep_after_s : 0.0F;
        return s;
    }

    BodyId add(const BodyDef& def) {
        const auto id = scene.add(def);
        EXPECT_TRUE(id.ok());
        bodies.push_back({*id, def});
        return *id;
    }

    BodyId add(const Shape& shape,
               float mass,
               const Vec3& x,
               const Vec3& v = Vec3::Zero(),
               const Vec3& w = Vec3::Zero()) {
        BodyDef def;
        def.shape = shape;
        def.mass = mass;
        def.position = x;
        def.velocity = v;
        def.angular_velocity = w;
        return add(def);
    }

    JointId join(const JointDef& def) {
        const auto id = scene.add_joint(def);
        EXPECT_TRUE(id.ok()) << (id.ok() ? "" : id.error());
        return *id;
    }

    void run(float seconds) {
        for (int i = 0; i < static_cast<int>(std::lround(seconds / kFrame)); ++i) {
            scene.step(kFrame);
        }
    }

    /// Sums over the dynamic bodies, in doubles.
    struct Sums {
        Vec3d linear = Vec3d::Zero();   ///< N s
        Vec3d angular = Vec3d::Zero();  ///< N m s, about the origin
        double kinetic = 0.0;           ///< J
        double energy = 0.0;            ///< kinetic and that of height, J
        double size = 0.0;              ///< of the terms of the momenta, for their rounding
        bool finite = true;
    };

    [[nodiscard]] Sums sums() const {
        Sums out;
        for (const Known& body : bodies) {
            if (body.def.kind != BodyKind::kDynamic || !scene.contains(body.id)) {
                continue;
            }
            const BodyState s = scene.state(body.id);
            const double mass = static_cast<double>(body.def.mass);
            const Eigen::Matrix3d r = s.orientation.cast<double>().toRotationMatrix();
            const Vec3d moments = principal_inertia(body.def.shape, body.def.mass).cast<double>();
            const Vec3d x = s.position.cast<double>();
            const Vec3d v = s.velocity.cast<double>();
            const Vec3d w = s.angular_velocity.cast<double>();
            const Vec3d spin = r * moments.cwiseProduct(r.transpose() * w);
            out.linear += mass * v;
            out.angular += x.cross(mass * v) + spin;
            out.kinetic += 0.5 * mass * v.squaredNorm() + 0.5 * w.dot(spin);
            out.energy -= mass * gravity_.dot(x);
            out.size += mass * v.norm() * (1.0 + x.norm()) + spin.norm();
            out.finite &= x.allFinite() && v.allFinite() && w.allFinite();
        }
        out.energy += out.kinetic;
        return out;
    }

    Scene scene;

    struct Known {
        BodyId id;
        BodyDef def;
    };

    std::vector<Known> bodies;

  private:
    Vec3d gravity_;
};

inline JointDef joint_of(JointKind kind, BodyId a, BodyId b, const Vec3& anchor) {
    JointDef def;
    def.kind = kind;
    def.a = a;
    def.b = b;
    def.anchor = anchor;
    return def;
}

}  // namespace zoned::physics
