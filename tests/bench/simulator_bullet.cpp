#include "tests/bench/simulator.h"

#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <stdexcept>

namespace zoned::bench {

namespace {

btVector3 to_bullet(const Vec3d& v) {
    return {
        static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

btTransform to_bullet(const scenario::Pose& pose) {
    const auto& q = pose.orientation;
    return btTransform(btQuaternion(static_cast<btScalar>(q.x()),
                                    static_cast<btScalar>(q.y()),
                                    static_cast<btScalar>(q.z()),
                                    static_cast<btScalar>(q.w())),
                       to_bullet(pose.position));
}

Vec3d from_bullet(const btVector3& v) {
    return {v.x(), v.y(), v.z()};
}

std::unique_ptr<btCollisionShape> shape_of(const scenario::Solid& solid) {
    switch (solid.form) {
        case scenario::Form::kSphere:
            return std::make_unique<btSphereShape>(static_cast<btScalar>(solid.radius));
        case scenario::Form::kBox:
            return std::make_unique<btBoxShape>(to_bullet(solid.half_extents));
        case scenario::Form::kCapsule:
            return std::make_unique<btCapsuleShape>(static_cast<btScalar>(solid.radius),
                                                    static_cast<btScalar>(2 * solid.half_segment));
    }
    throw std::logic_error("a solid of no form");
}

struct BulletSettings {
    bool continuous = false;  ///< continuous collision detection of moving bodies
    int substeps = 1;
    bool exact_rays = false;  ///< rays by GJK, else by its subsimplex cast
};

/// A world at Bullet's defaults: sequential impulses with 10 iterations, dynamic AABB trees.
class BulletSimulator : public Simulator {
  public:
    BulletSimulator(const scenario::Description& description, const BulletSettings& settings)
        : dispatcher_(&configuration_),
          world_(&dispatcher_, &broadphase_, &solver_, &configuration_),
          settings_(settings),
          dt_(static_cast<btScalar>(description.dt / settings.substeps)) {
        world_.setGravity(to_bullet(description.gravity));
        for (const scenario::Body& body : description.bodies) {
            add(body, description);
        }
        for (const scenario::BallJoint& joint : description.joints) {
            add(joint);
        }
    }

    ~BulletSimulator() override {
        for (const auto& joint : joints_) {
            world_.removeConstraint(joint.get());
        }
        for (const auto& body : bodies_) {
            world_.removeRigidBody(body.get());
        }
    }

    BulletSimulator(const BulletSimulator&) = delete;
    BulletSimulator& operator=(const BulletSimulator&) = delete;

    void step() override {
        for (int i = 0; i < settings_.substeps; ++i) {
            world_.stepSimulation(dt_, 0);
        }
    }

    [[nodiscard]] Motion motion(std::size_t body) const override {
        const btRigidBody& b = *bodies_[body];
        const btQuaternion q = b.getCenterOfMassTransform().getRotation();
        Motion m;
        m.pose.position = from_bullet(b.getCenterOfMassPosition());
        m.pose.orientation = scenario::Quatd(q.w(), q.x(), q.y(), q.z()).normalized();
        m.velocity = from_bullet(b.getLinearVelocity());
        m.spin = from_bullet(b.getAngularVelocity());
        return m;
    }

    void prepare_queries() override { broadphase_.optimize(); }

    bool cast(std::span<const scenario::Ray> rays, std::span<double> distances) const override {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const btVector3 from = to_bullet(rays[i].origin);
            const btVector3 to = from + to_bullet(rays[i].direction * rays[i].length);
            btCollisionWorld::ClosestRayResultCallback hit(from, to);
            if (settings_.exact_rays) {
                hit.m_flags |= btTriangleRaycastCallback::kF_UseGjkConvexCastRaytest;
            }
            world_.rayTest(from, to, hit);
            distances[i] = hit.hasHit()
                               ? static_cast<double>(hit.m_closestHitFraction) * rays[i].length
                               : INFINITY;
        }
        return true;
    }

  private:
    void add(const scenario::Body& body, const scenario::Description& description) {
        btCollisionShape* shape = shared_shape(body.solid);
        btVector3 inertia(0, 0, 0);
        const auto mass = static_cast<btScalar>(body.mass);
        if (mass > 0) {
            shape->calculateLocalInertia(mass, inertia);
        }
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
        info.m_startWorldTransform = to_bullet(body.pose);
        // Bullet multiplies the coefficients of a pair: their roots give the pair the scene's
        // coefficient.
        info.m_friction = static_cast<btScalar>(std::sqrt(body.friction));
        info.m_restitution = static_cast<btScalar>(std::sqrt(body.restitution));
        bodies_.push_back(std::make_unique<btRigidBody>(info));
        btRigidBody& b = *bodies_.back();
        b.setLinearVelocity(to_bullet(body.velocity));
        b.setAngularVelocity(to_bullet(body.spin));
        if (!description.sleeping && mass > 0) {
            b.setActivationState(DISABLE_DEACTIVATION);
        }
        if (settings_.continuous && mass > 0) {
            b.setCcdMotionThreshold(static_cast<btScalar>(body.solid.radius));
            b.setCcdSweptSphereRadius(static_cast<btScalar>(0.5 * body.solid.radius));
        }
        if (description.colliding) {
            world_.addRigidBody(&b);
        } else {
            world_.addRigidBody(&b, 1, 0);
        }
    }

    /// Equal bodies share one shape, as Bullet's manual advises.
    btCollisionShape* shared_shape(const scenario::Solid& solid) {
        for (std::size_t i = 0; i < solids_.size(); ++i) {
            if (solids_[i] == solid) {
                return shapes_[i].get();
            }
        }
        solids_.push_back(solid);
        shapes_.push_back(shape_of(solid));
        return shapes_.back().get();
    }

    void add(const scenario::BallJoint& joint) {
        btRigidBody& b = *bodies_[static_cast<std::size_t>(joint.b)];
        const btVector3 anchor = to_bullet(joint.anchor);
        const btVector3 in_b = b.getWorldTransform().inverse() * anchor;
        if (joint.a == scenario::kWorld) {
            joints_.push_back(std::make_unique<btPoint2PointConstraint>(b, in_b));
        } else {
            btRigidBody& a = *bodies_[static_cast<std::size_t>(joint.a)];
            const btVector3 in_a = a.getWorldTransform().inverse() * anchor;
            joints_.push_back(std::make_unique<btPoint2PointConstraint>(a, b, in_a, in_b));
        }
        world_.addConstraint(joints_.back().get(), true);
    }

    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btDbvtBroadphase broadphase_;
    btSequentialImpulseConstraintSolver solver_;
    btDiscreteDynamicsWorld world_;
    std::vector<scenario::Solid> solids_;
    std::vector<std::unique_ptr<btCollisionShape>> shapes_;  // by solid
    std::vector<std::unique_ptr<btRigidBody>> bodies_;
    std::vector<std::unique_ptr<btTypedConstraint>> joints_;
    BulletSettings settings_;
    btScalar dt_;  // of a substep
};

Engine bullet_engine(std::string method, const BulletSettings& settings) {
    return {std::move(method),
            "bullet",
            [settings](const scenario::Description& description) {
                return std::make_unique<BulletSimulator>(description, settings);
            },
            [settings](const std::string& scene, const scenario::Description& description) {
                if (settings.continuous && scene != "S9") {
                    return std::string("only for fast bodies");
                }
                const bool large = settings.substeps > 1 && description.bodies.size() > kSmallScene;
                return std::string(large ? "only for small scenes" : "");
            }};
}

}  // namespace

std::vector<Engine> bullet_engines() {
    BulletSettings continuous;
    continuous.continuous = true;
    BulletSettings fine;
    fine.substeps = 4;
    return {bullet_engine("default", {}),
            bullet_engine("ccd", continuous),
            bullet_engine("substeps_4", fine)};
}

std::vector<Engine> bullet_query_engines() {
    BulletSettings exact;
    exact.exact_rays = true;
    return {bullet_engine("default", {}), bullet_engine("gjk", exact)};
}

}  // namespace zoned::bench
