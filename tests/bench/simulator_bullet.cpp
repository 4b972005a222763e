#include "tests/bench/bullet_parts.h"
#include "tests/bench/simulator.h"

#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>

namespace zoned::bench {

namespace {

Vec3d from_bullet(const btVector3& v) {
    return {v.x(), v.y(), v.z()};
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
        for (const scenario::LinkedPair& joint : description.joints) {
            add(joint, description.dt / settings.substeps);
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
        m.asleep = !b.isActive();
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
        btCollisionShape* shape = shapes_.of(body.solid);
        btVector3 inertia(0, 0, 0);
        const auto mass = static_cast<btScalar>(body.mass);
        if (mass > 0 && body.solid.geometry != nullptr) {
            inertia = to_bullet(body.mass * body.solid.inertia_per_mass());
        } else if (mass > 0) {
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

    void add(const scenario::LinkedPair& joint, double dt) {
        btRigidBody& b = *bodies_[static_cast<std::size_t>(joint.b)];
        btRigidBody& a = joint.a == scenario::kWorld ? btTypedConstraint::getFixedBody()
                                                     : *bodies_[static_cast<std::size_t>(joint.a)];
        joints_.push_back(bullet_joint(joint, a, b, dt));
        world_.addConstraint(joints_.back().get(), true);
    }

    btDefaultCollisionConfiguration configuration_;
    btCollisionDispatcher dispatcher_;
    btDbvtBroadphase broadphase_;
    btSequentialImpulseConstraintSolver solver_;
    btDiscreteDynamicsWorld world_;
    BulletShapes shapes_;
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
