#include "tests/bench/bullet_cloth.h"

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>

namespace zoned::bench {

struct BulletCloth::World {
    World(const scenario::Cloth& c, int passes) : cloth(c) {
        const btVector3 gravity(0.0F, static_cast<btScalar>(-c.gravity), 0.0F);
        world.setGravity(gravity);
        world.getWorldInfo().m_gravity = gravity;
        std::vector<btVector3> points;
        const double cell = c.size / (c.nodes - 1);
        for (int i = 0; i < c.count(); ++i) {
            points.emplace_back(static_cast<btScalar>(cell * (i % c.nodes)),
                                0.0F,
                                static_cast<btScalar>(cell * (i / c.nodes)));
        }
        body = new btSoftBody(&world.getWorldInfo(), c.count(), points.data(), nullptr);
        for (int i = 0; i < c.count(); ++i) {
            body->setMass(i, static_cast<btScalar>(c.node_mass()));
        }
        body->setMass(0, 0.0F);
        body->setMass(c.nodes - 1, 0.0F);
        for (const scenario::ClothSprings& s : scenario::cloth_springs(c)) {
            add_links(s);
        }
        for (int j = 0; j + 1 < c.nodes; ++j) {
            for (int i = 0; i + 1 < c.nodes; ++i) {
                const int a = j * c.nodes + i;
                body->appendFace(a, a + c.nodes, a + 1);
                body->appendFace(a + 1, a + c.nodes, a + c.nodes + 1);
            }
        }
        body->m_cfg.kDP = static_cast<btScalar>(-std::expm1(-c.drag * c.dt));
        body->m_cfg.piterations = passes;
        world.addSoftBody(body);
    }

    ~World() {
        world.removeSoftBody(body);
        delete body;
    }

    World(const World&) = delete;
    World& operator=(const World&) = delete;

    void add_links(const scenario::ClothSprings& s) {
        btSoftBody::Material* material = body->appendMaterial();
        const double w = 2.0 / cloth.node_mass();
        material->m_kLST =
            static_cast<btScalar>(w / (w + 1.0 / (s.stiffness * cloth.dt * cloth.dt)));
        for (int j = 0; j + s.dj < cloth.nodes; ++j) {
            for (int i = std::max(0, -s.di); i < cloth.nodes - std::max(0, s.di); ++i) {
                const int a = j * cloth.nodes + i;
                body->appendLink(a, a + s.dj * cloth.nodes + s.di, material);
            }
        }
    }

    scenario::Cloth cloth;
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    btSoftBody* body = nullptr;
};

BulletCloth::BulletCloth(const scenario::Cloth& cloth, int passes)
    : world_(std::make_unique<World>(cloth, passes)) {
}

BulletCloth::~BulletCloth() = default;

void BulletCloth::step() {
    const auto dt = static_cast<btScalar>(world_->cloth.dt);
    world_->world.stepSimulation(dt, 1, dt);
}

std::vector<Vec3d> BulletCloth::nodes() const {
    std::vector<Vec3d> out;
    for (int i = 0; i < world_->body->m_nodes.size(); ++i) {
        const btVector3& x = world_->body->m_nodes[i].m_x;
        out.emplace_back(
            static_cast<double>(x.x()), static_cast<double>(x.y()), static_cast<double>(x.z()));
    }
    return out;
}

double BulletCloth::links() const {
    return world_->body->m_links.size();
}

}  // namespace zoned::bench
