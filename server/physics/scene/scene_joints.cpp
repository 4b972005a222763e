// Joints of a scene: how they come, are solved, break and go.
#include "server/physics/scene/scene_impl.h"
#include "server/physics/shapes/compound/body_checks.h"
#include "server/physics/shapes/ranges.h"
#include "shared/core/assert.h"
#include "shared/core/block_hash.h"

#include <algorithm>
#include <utility>

namespace zoned::physics {

JointPose Scene::Impl::pose_of(std::uint32_t row) const {
    return row == kNoIndex ? JointPose() : JointPose{bodies.position[row], bodies.rotation[row]};
}

void Scene::Impl::wake_joint(std::uint32_t index) {
    for (const std::uint32_t row : {joints[index].a, joints[index].b}) {
        if (row != kNoIndex) {
            wake(row);
        }
    }
}

void Scene::Impl::wake_joined(std::uint32_t row) {
    joints.for_each_of(bodies, row, [&](std::uint32_t, std::uint32_t other) {
        if (other != kNoIndex) {
            wake(other);
        }
    });
}

/// A body that hangs on a moving kinematic body goes with it.
void Scene::Impl::wake_joined_to_movers() {
    for (const std::uint32_t row : bodies.mover_list) {
        if (bodies.awake[row] != 0 && bodies.kind[row] == BodyKind::kKinematic) {
            wake_joined(row);
        }
    }
}

/// Takes a joint out; the bodies that it held apart may collide from now on.
void Scene::Impl::drop_joint(std::uint32_t index) {
    wake_joint(index);
    for (const std::uint32_t row : {joints[index].a, joints[index].b}) {
        if (row != kNoIndex && !bodies.is_plane(row)) {
            mark_pending(row);
        }
    }
    joints.remove(bodies, index);
}

void Scene::Impl::list_joints() {
    active_joints.clear();
    for (std::uint32_t i = 0; i < joints.rows(); ++i) {
        const JointEntry& entry = joints[i];
        if (entry.alive &&
            (bodies.simulated(entry.b) || (entry.a != kNoIndex && bodies.simulated(entry.a)))) {
            active_joints.push_back(i);
        }
    }
}

void Scene::Impl::break_joints() {
    for (const std::uint32_t index : active_joints) {
        const JointEntry& entry = joints[index];
        if (!(entry.force_n > entry.joint.def.break_force_n)) {  // no number breaks nothing
            continue;
        }
        breaks.push_back({joints.id_of(index),
                          entry.a == kNoIndex ? BodyId() : bodies.id_of(entry.a),
                          bodies.id_of(entry.b),
                          entry.joint.def.user,
                          entry.force_n});
        drop_joint(index);
    }
}

core::Result<JointId> Scene::Impl::add_joint(const JointDef& def,
                                             const JointPose& pose_a,
                                             const JointPose& pose_b) {
    using Refused = core::Result<JointId>;
    std::string reason = why_unfit(def);
    if (!reason.empty()) {
        return Refused::failure(std::move(reason));
    }
    const std::uint32_t a = def.a == BodyId() ? kNoIndex : bodies.row_of(def.a);
    const std::uint32_t b = bodies.row_of(def.b);
    if (b == kNoIndex || (a == kNoIndex && def.a != BodyId())) {
        return Refused::failure("joint: no such body");
    }
    if (a == b) {
        return Refused::failure("joint: a body cannot be joined to itself");
    }
    if (!bodies.is_dynamic(b) && (a == kNoIndex || !bodies.is_dynamic(a))) {
        return Refused::failure("joint: neither body is dynamic");
    }
    const JointId id = joints.add(bodies, make_joint(def, pose_a, pose_b), a, b);
    if (!def.collide && a != kNoIndex && graph.contains(a, b)) {
        graph.for_each_of(bodies, b, [&](std::uint32_t contact, std::uint32_t other) {
            if (other == a) {
                end_touch(contact, left_contacts);
                graph.destroy(bodies, contact);
            }
        });
    }
    solver.reserve_joints(joints.rows());
    active_joints.reserve(joints.rows());
    wake_joint(joints.index_of(id));
    return id;
}

core::Result<JointId> Scene::add_joint(const JointDef& def) {
    const auto pose_of = [this](BodyId body) {
        return impl_->pose_of(body == BodyId() ? kNoIndex : impl_->bodies.row_of(body));
    };
    return impl_->add_joint(def, pose_of(def.a), pose_of(def.b));
}

core::Result<JointId> Scene::add_joint(const JointDef& def, const Frame& a, const Frame& b) {
    return impl_->add_joint(def,
                            {a.position, a.rotation.toRotationMatrix()},
                            {b.position, b.rotation.toRotationMatrix()});
}

void Scene::remove_joint(JointId joint) {
    const std::uint32_t index = impl_->joints.index_of(joint);
    if (index != kNoIndex) {
        impl_->drop_joint(index);
    }
}

bool Scene::contains(JointId joint) const {
    return impl_->joints.index_of(joint) != kNoIndex;
}

float Scene::joint_position(JointId joint) const {
    const std::uint32_t index = impl_->joints.index_of(joint);
    ZONED_ASSERT(index != kNoIndex, "joint_position() of a joint that is not in the scene");
    const JointEntry& entry = impl_->joints[index];
    return physics::joint_position(entry.joint, impl_->pose_of(entry.a), impl_->pose_of(entry.b));
}

float Scene::joint_force(JointId joint) const {
    const std::uint32_t index = impl_->joints.index_of(joint);
    ZONED_ASSERT(index != kNoIndex, "joint_force() of a joint that is not in the scene");
    return impl_->joints[index].force_n;
}

bool Scene::set_motor(JointId joint, float speed, float most) {
    const std::uint32_t index = impl_->joints.index_of(joint);
    ZONED_ASSERT(index != kNoIndex, "set_motor() of a joint that is not in the scene");
    if (!fit_motor(speed, most)) {
        return false;
    }
    JointEntry& entry = impl_->joints[index];
    JointDef& def = entry.joint.def;
    if (!def.motor) {
        // Rows know their impulses by their places, and the motor's comes before the limits'.
        std::fill(entry.impulse.begin() + static_cast<std::ptrdiff_t>(hard_rows(def.kind)),
                  entry.impulse.end(),
                  0.0F);
    }
    def.motor = true;
    def.motor_speed = speed;
    def.motor_max = most;
    impl_->wake_joint(index);
    return true;
}

const JointState& Scene::joint_state(JointId joint) const {
    const std::uint32_t index = impl_->joints.index_of(joint);
    ZONED_ASSERT(index != kNoIndex, "joint_state() of a joint that is not in the scene");
    return impl_->joints[index];
}

void Scene::set_joint_state(JointId joint, const JointState& state) {
    const std::uint32_t index = impl_->joints.index_of(joint);
    ZONED_ASSERT(index != kNoIndex, "set_joint_state() of a joint that is not in the scene");
    static_cast<JointState&>(impl_->joints[index]) = state;
}

void Scene::hash_joints(core::StateHash& hash) const {
    for (const std::uint32_t index : impl_->active_joints) {
        const JointEntry& entry = impl_->joints[index];
        if (!entry.alive) {
            continue;  // went after the step
        }
        core::BlockHash block;
        for (std::size_t i = 0; i < entry.impulse.size(); ++i) {
            block.pack(entry.impulse[i]);
            block.pack(entry.straight_error[i]);
        }
        hash.add(block.value());
    }
}

std::span<const JointBreak> Scene::joint_breaks() const {
    return impl_->breaks;
}

}  // namespace zoned::physics
