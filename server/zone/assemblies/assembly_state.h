// AssemblyState: the joints between the entities of a zone, the parts of assemblies, and riders.
#pragma once

#include "server/physics/shapes/shape.h"
#include "server/zone/assemblies/assembly_def.h"
#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace zoned::zone {

/// A joint of the world, never reused. Zones hand them out as entity ids.
using EntityJointId = StrongId<struct EntityJointTag>;

/// A joint between two entities that one zone owns, or between one of them and the world.
struct EntityJoint {
    EntityJointId id;
    EntityId a;  ///< none: the world
    EntityId b;
    EntityId root;             ///< of the assembly that it belongs to; none: of no assembly
    std::uint16_t number = 0;  ///< among the joints of the assembly, or of those placed
    std::shared_ptr<const JointPlan> plan;
    /// The poses at which the joint was made: of `a` in the axes of `b`; with the world of `b`
    /// itself, zone-local. A joint that is made anew in another zone has the same anchors and the
    /// same zero.
    physics::Frame made_at;
    JointId joint;  ///< in this zone's scene

    // Its motor, where the plan has one or rules gave it one.
    bool motor = false;
    bool by_hand = false;  ///< rules or a driver set the target: the plan's no longer counts
    bool holds_position = false;
    float target = 0.0F;
    float most = 0.0F;
    float max_speed = 0.0F;
    float speed = 0.0F;  ///< as the scene was told last
};

/// A character that something carries.
struct Rider {
    EntityId rider;
    EntityId carrier;
    Vec3 place = Vec3::Zero();  ///< of its centre, from the carrier's, along its axes, m
    EntityId drives;  ///< the root of the assembly whose controls its stick moves, or none
};

struct AssemblyState {
    std::vector<EntityJoint> joints;                            ///< ascending by id
    std::vector<std::pair<EntityId, EntityJointId>> joints_of;  ///< by each end, ascending
    std::vector<Rider> riders;                                  ///< ascending by rider
    std::vector<EntityJointId> motors;                          ///< joints with a motor, ascending
    std::uint32_t next_joint = 0;                               ///< counter of ids handed out
    std::vector<EntityJointId> changed;  ///< since the last hash: made, gone, another target
};

}  // namespace zoned::zone
