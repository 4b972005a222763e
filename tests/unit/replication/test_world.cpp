#include "tests/unit/replication/test_world.h"

#include <algorithm>
#include <cmath>

namespace zoned::replication {

world::TypeTable test_types() {
    world::TypeTable types(3);
    types[kWalker].kind = world::EntityKind::kCharacter;
    types[kWalker].max_acceleration_mps2 = 20.0F;
    types[kWalker].max_velocity_jump_mps = 6.0F;
    types[kBody].kind = world::EntityKind::kProp;
    types[kBody].max_acceleration_mps2 = 20.0F;
    types[kBody].max_velocity_jump_mps = 12.0F;
    types[kDasher] = types[kWalker];
    types[kDasher].max_acceleration_mps2 = 5.0F;
    types[kDasher].max_velocity_jump_mps = 1.0F;
    return types;
}

ReplicationSettings test_settings() {
    ReplicationSettings settings;
    settings.lods = {{0.05F, 0.1F}, {0.5F, 0.3F}};
    settings.quantization.lod_shift[1] = wire::lod_shift(0.05F, 0.1F, 0.5F, 0.3F);
    settings.budget_bytes_per_s = 200000;
    settings.tick_s = kTickS;
    return settings;
}

EntityId TestWorld::spawn(TypeIndex type) {
    const EntityId entity(next_id_++);
    const world::Row row = entities.add(entity, type);
    entities.position[row] = {rng.range(-extent_, extent_), 1.0F, rng.range(-extent_, extent_)};
    entities.discontinuity_tick[row] = now;
    if (type == kBody) {
        entities.position[row].y() = rng.range(1.0F, 4.0F);
        entities.velocity[row] = {rng.range(-3, 3), 0.0F, rng.range(-3, 3)};
        entities.angular_velocity[row] = {rng.range(-2, 2), rng.range(-2, 2), rng.range(-2, 2)};
        entities.orientation[row] =
            Quat(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1), 0.5F).normalized();
    }
    return entity;
}

void TestWorld::step() {
    ++now;
    for (world::Row row = 0; row < entities.size() && !frozen; ++row) {
        const Vec3 before = entities.velocity[row];
        if (entities.type[row] == kBody) {
            fly(row);
        } else {
            walk(row);
        }
        entities.acceleration[row] = (entities.velocity[row] - before) / kTickS;
        entities.position[row] += entities.velocity[row] * kTickS;
    }
}

void TestWorld::walk(world::Row row) {
    Vec3& wanted = wanted_.try_emplace(entities.id[row], Vec3::Zero()).first->second;
    if (rng.below(60) == 0 || now == 1) {
        const float heading = rng.range(0.0F, 6.2831853F);
        const float speed = rng.below(5) == 0 ? 0.0F : 5.0F;
        wanted = Vec3(std::sin(heading), 0.0F, std::cos(heading)) * speed;
    }
    const Vec3& p = entities.position[row];
    if (p.cwiseAbs().maxCoeff() > extent_ && p.dot(wanted) > 0.0F) {
        wanted = -wanted;
    }
    const Vec3 change = wanted - entities.velocity[row];
    const float most = 20.0F * kTickS;
    entities.velocity[row] += change.norm() <= most ? change : change.normalized() * most;
    const Vec3& v = entities.velocity[row];
    const bool rests = v.squaredNorm() == 0.0F;
    entities.set(row, world::kAtRest, rests);
    if (!rests) {
        const float yaw = std::atan2(v.x(), v.z());
        entities.yaw[row] = static_cast<std::uint16_t>(
            static_cast<std::int32_t>(yaw / 6.2831853F * 65536.0F) & 0xFFFF);
        entities.orientation[row] = motion::orientation_from_yaw(entities.yaw[row]);
    }
}

void TestWorld::fly(world::Row row) {
    Vec3& v = entities.velocity[row];
    v.y() -= kGravity * kTickS;
    if (entities.position[row].y() < 0.5F && v.y() < 0.0F) {
        v.y() = std::min(-v.y(), 5.0F);
        entities.angular_velocity[row] = {rng.range(-2, 2), rng.range(-2, 2), rng.range(-2, 2)};
    }
    for (int axis = 0; axis < 3; axis += 2) {
        if (std::abs(entities.position[row][axis]) > extent_ &&
            v[axis] * entities.position[row][axis] > 0.0F) {
            v[axis] = -v[axis];
        }
    }
    motion::KinematicState spin = entities.kinematic(row);
    entities.orientation[row] =
        motion::predict_orientation(spin, motion::PredictorOrder::kLinear, kTickS).normalized();
}

void TestWorld::freeze() {
    frozen = true;
    for (world::Row row = 0; row < entities.size(); ++row) {
        entities.velocity[row].setZero();
        entities.acceleration[row].setZero();
        entities.angular_velocity[row].setZero();
        entities.set(row, world::kAtRest, true);
    }
}

world::Visibility TestWorld::visibility(const std::vector<world::Viewer>& viewers,
                                        float radius_m,
                                        float near_m) const {
    world::Visibility sets;
    for (const world::Viewer& viewer : viewers) {
        world::VisibleSet& set = sets.emplace_back();
        set.client = viewer.client;
        const world::Row own = entities.find(viewer.avatar);
        for (world::Row row = 0; row < entities.size(); ++row) {
            const Vec3 offset = entities.position[row] - entities.position[own];
            const float distance = std::hypot(offset.x(), offset.z());
            if (row != own && distance <= radius_m) {
                set.visible.push_back(
                    {entities.id[row], static_cast<std::uint8_t>(distance <= near_m ? 0 : 1)});
            }
        }
        std::sort(
            set.visible.begin(),
            set.visible.end(),
            [](const world::Visible& a, const world::Visible& b) { return a.entity < b.entity; });
    }
    return sets;
}

}  // namespace zoned::replication
