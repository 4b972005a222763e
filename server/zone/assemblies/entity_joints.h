// Entity joints: makes, finds, ends and carries the joints between entities.
#pragma once

#include "server/zone/zone_state.h"
#include "shared/core/result.h"

#include <memory>
#include <string_view>
#include <vector>

namespace zoned::zone {

/// The assembly that a joint belongs to.
struct JointOrigin {
    EntityId root;  ///< none: the joints that the config places
    std::uint16_t number = 0;
};

/// The number of a joint that rules made.
inline constexpr std::uint16_t kUnlisted = 0xFFFF;

/// Joins two owned entities with bodies, or `b` and the world (`a` none). The plan holds at
/// `made_at` (see EntityJoint). Fails with the reason.
core::Result<EntityJointId> join(ZoneState& state,
                                 EntityId a,
                                 EntityId b,
                                 const std::shared_ptr<const JointPlan>& plan,
                                 const physics::Frame& made_at,
                                 const JointOrigin& origin);
/// EntityJoint::made_at for a joint that is made at the present poses of the rows; kNoRow: the
/// world.
physics::Frame present_frame(const world::Entities& entities, world::Row a, world::Row b);

EntityJoint* find_joint(ZoneState& state, EntityJointId joint);
const EntityJoint* find_joint(const ZoneState& state, EntityJointId joint);
/// The joint with that number of an assembly of this zone, or of the placed ones; none: it broke,
/// was removed or is in another zone.
EntityJointId joint_numbered(const ZoneState& state, const JointOrigin& origin);

void end_joint(ZoneState& state, EntityJointId joint);
/// Ends all joints of an entity whose body goes.
void end_joints_of(ZoneState& state, EntityId entity);
[[nodiscard]] bool has_joints(const ZoneState& state, EntityId entity);

/// Takes the joints that broke in the last step out and hands them to the rules. Returns how many.
std::uint32_t report_breaks(ZoneState& state, RulesContext& context);

/// Adds to `rows` all rows of this zone that joints and riding hold to them, through any number of
/// entities. The rows stay, and come first.
void add_held(const ZoneState& state, std::vector<world::Row>& rows);
/// The same, with the props that touch what is added and what holds to those.
void add_held_and_touching(const ZoneState& state, std::vector<world::Row>& rows);

/// Takes out the joints whose ends are all among the entities (ascending), for another zone. Their
/// bodies must still be there.
std::vector<JointTransfer> take_joints(ZoneState& state, const std::vector<EntityId>& entities);
/// Takes over a joint whose entities are here; `shift` as of write_entity().
void give_joint(ZoneState& state, JointTransfer from, const Vec3& shift);

/// Changes since the last call, chained into the hash.
void hash_assemblies(ZoneState& state, core::StateHash& hash);

}  // namespace zoned::zone
