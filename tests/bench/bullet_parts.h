// BulletParts: solids and joints of described scenes as Bullet's shapes and constraints.
#pragma once

#include "tests/scenario/physics_scenes.h"

#include <btBulletDynamicsCommon.h>

#include <deque>
#include <memory>
#include <vector>

namespace zoned::bench {

btVector3 to_bullet(const Vec3d& v);
btTransform to_bullet(const scenario::Pose& pose);

/// Equal solids share one shape, as Bullet's manual advises.
class BulletShapes {
  public:
    /// Valid as long as this object.
    btCollisionShape* of(const scenario::Solid& solid);

  private:
    struct Known {
        scenario::Solid solid;
        /// Of a mesh, which its shape refers to.
        std::vector<int> indices;
        std::vector<btScalar> points;
        std::unique_ptr<btTriangleIndexVertexArray> triangles;
        std::unique_ptr<btCollisionShape> shape;
    };

    void build(Known& known);
    void build_mesh(Known& known);

    std::deque<Known> known_;
};

/// The constraint at the bodies' present poses, for steps of `dt` seconds.
std::unique_ptr<btTypedConstraint> bullet_joint(const scenario::LinkedPair& joint,
                                                btRigidBody& a,
                                                btRigidBody& b,
                                                double dt);

}  // namespace zoned::bench
