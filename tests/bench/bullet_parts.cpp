#include "tests/bench/bullet_parts.h"

#include "tests/scenario/solid_geometry.h"

#include <stdexcept>

namespace zoned::bench {

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

btCollisionShape* BulletShapes::of(const scenario::Solid& solid) {
    for (const Known& known : known_) {
        if (known.solid == solid) {
            return known.shape.get();
        }
    }
    Known known;
    known.solid = solid;
    build(known);
    known_.push_back(std::move(known));
    return known_.back().shape.get();
}

void BulletShapes::build(Known& known) {
    const scenario::Solid& solid = known.solid;
    switch (solid.form) {
        case scenario::Form::kSphere:
            known.shape = std::make_unique<btSphereShape>(static_cast<btScalar>(solid.radius));
            return;
        case scenario::Form::kBox:
            known.shape = std::make_unique<btBoxShape>(to_bullet(solid.half_extents));
            return;
        case scenario::Form::kCapsule:
            known.shape = std::make_unique<btCapsuleShape>(
                static_cast<btScalar>(solid.radius), static_cast<btScalar>(2 * solid.half_segment));
            return;
        case scenario::Form::kHull: {
            auto hull = std::make_unique<btConvexHullShape>();
            for (const Vec3d& p : solid.geometry->points) {
                hull->addPoint(to_bullet(p), false);
            }
            hull->recalcLocalAabb();
            known.shape = std::move(hull);
            return;
        }
        case scenario::Form::kCompound: {
            auto compound = std::make_unique<btCompoundShape>();
            for (const scenario::SolidPart& part : solid.geometry->parts) {
                compound->addChildShape(to_bullet(part.pose), of(part.solid));
            }
            known.shape = std::move(compound);
            return;
        }
        case scenario::Form::kMesh:
            build_mesh(known);
            return;
    }
    throw std::logic_error("a solid of no form");
}

void BulletShapes::build_mesh(Known& known) {
    const scenario::SolidGeometry& geometry = *known.solid.geometry;
    for (const Vec3d& p : geometry.points) {
        for (const double x : {p.x(), p.y(), p.z()}) {
            known.points.push_back(static_cast<btScalar>(x));
        }
    }
    for (const scenario::SolidFace& face : geometry.faces) {
        for (const std::uint32_t corner : face.ring) {
            known.indices.push_back(static_cast<int>(corner));
        }
    }
    // The arrays keep their place when `known` moves.
    known.triangles =
        std::make_unique<btTriangleIndexVertexArray>(static_cast<int>(geometry.faces.size()),
                                                     known.indices.data(),
                                                     static_cast<int>(3 * sizeof(int)),
                                                     static_cast<int>(geometry.points.size()),
                                                     known.points.data(),
                                                     static_cast<int>(3 * sizeof(btScalar)));
    known.shape = std::make_unique<btBvhTriangleMeshShape>(known.triangles.get(), true);
}

namespace {

/// A frame at the anchor whose z is the axis.
btTransform joint_frame(const scenario::LinkedPair& joint, const btRigidBody& body) {
    scenario::Pose pose;
    pose.position = joint.anchor;
    pose.orientation = scenario::Quatd::FromTwoVectors(Vec3d::UnitZ(), joint.axis);
    return body.getWorldTransform().inverse() * to_bullet(pose);
}

}  // namespace

std::unique_ptr<btTypedConstraint> bullet_joint(const scenario::LinkedPair& joint,
                                                btRigidBody& a,
                                                btRigidBody& b,
                                                double dt) {
    const btTransform in_a = joint_frame(joint, a);
    const btTransform in_b = joint_frame(joint, b);
    switch (joint.link) {
        case scenario::Link::kBall:
            return joint.a == scenario::kWorld
                       ? std::make_unique<btPoint2PointConstraint>(b, in_b.getOrigin())
                       : std::make_unique<btPoint2PointConstraint>(
                             a, b, in_a.getOrigin(), in_b.getOrigin());
        case scenario::Link::kHinge: {
            auto hinge = std::make_unique<btHingeConstraint>(a, b, in_a, in_b);
            // Its angle and its motor turn a against b.
            if (joint.limited) {
                hinge->setLimit(static_cast<btScalar>(-joint.upper),
                                static_cast<btScalar>(-joint.lower));
            }
            if (joint.motor_torque > 0.0) {
                hinge->enableAngularMotor(true,
                                          static_cast<btScalar>(-joint.motor_speed),
                                          static_cast<btScalar>(joint.motor_torque * dt));
            }
            return hinge;
        }
        case scenario::Link::kFixed:
            return std::make_unique<btFixedConstraint>(a, b, in_a, in_b);
    }
    throw std::logic_error("a joint of no kind");
}

}  // namespace zoned::bench
