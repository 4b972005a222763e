#include "server/zone/zone_hash.h"

#include "server/zone/assemblies/entity_joints.h"
#include "server/zone/groups/group_changes.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "shared/core/block_hash.h"

#include <utility>

namespace zoned::zone {

namespace {

void hash_row(const world::Entities& e, world::Row row, core::StateHash& hash) {
    core::BlockHash block;
    const auto add = [&](const auto& vector) {
        for (Eigen::Index i = 0; i < vector.size(); ++i) {
            block.pack(vector[i]);
        }
    };
    block.pack(e.id[row].value);
    block.pack(e.flags[row]);
    add(e.position[row]);
    // A dozing agent is only put at another position. Otherwise it is as it was when it began to
    // doze: it stands, and faces where its yaw says.
    if (!e.has(row, world::kDozing)) {
        add(e.orientation[row].coeffs());
        add(e.velocity[row]);
        add(e.angular_velocity[row]);
    }
    block.pack(e.yaw[row]);
    block.pack(e.appearance[row]);
    for (const std::uint32_t word : e.field_values(row)) {
        block.pack(word);
    }
    hash.add(block.value());
}

void prefetch(const world::Entities& e, world::Row row) {
    __builtin_prefetch(&e.position[row]);
    if (!e.has(row, world::kDozing)) {
        __builtin_prefetch(&e.orientation[row]);
        __builtin_prefetch(&e.velocity[row]);
        __builtin_prefetch(&e.angular_velocity[row]);
    }
    __builtin_prefetch(&e.yaw[row]);
    __builtin_prefetch(&e.appearance[row]);
}

std::uint32_t hash_rows(ZoneState& state, bool all) {
    world::Entities& e = state.entities;
    std::vector<world::Row>& rows = state.changed_rows;
    rows.clear();
    if (all) {
        for (world::Row row = 0; row < e.size(); ++row) {
            rows.push_back(row);
        }
    } else {
        const auto add = [&](world::Row row) {
            rows.push_back(row);
        };
        world::for_each_row(e.moving(), e.touched(world::Reader::kHash), add);
    }
    e.forget_touched(world::Reader::kHash);
    // Few among many are anywhere in memory.
    constexpr std::size_t kAhead = 8;
    const bool few = rows.size() < e.size() / kAhead;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (few && i + kAhead < rows.size()) {
            prefetch(e, rows[i + kAhead]);
        }
        hash_row(e, rows[i], state.hash);
    }
    state.hash.add(e.size());
    return static_cast<std::uint32_t>(rows.size());
}

}  // namespace

std::uint32_t hash_tick(ZoneState& state) {
    const bool first = !std::exchange(state.hashed, true);
    const std::uint32_t hashed = hash_rows(state, first);
    if (first || state.report.plan.has(Pass::kSoft)) {
        hash_soft(state, state.hash);
    }
    hash_assemblies(state, state.hash);
    if (state.report.plan.has(Pass::kAgents)) {
        state.ai_update.hash(state.agents, state.hash);
        state.points_of_interest.hash(state.hash);
    }
    if (!state.settings.ai.difficulty.levels.empty()) {
        ai::visit_fields(state.ai_update.difficulty(),
                         [&state](const auto& number) { state.hash.add(number); });
    }
    if (state.report.plan.has(Pass::kParticles)) {
        state.particles.simulated.hash(state.hash);
    }
    if (state.report.plan.has(Pass::kRules)) {
        state.rules->hash(state.hash);
    }
    state.timers.hash_changes(state.hash);
    for (const DoorChange& change : state.out.doors) {
        state.hash.add(change.door);
        state.hash.add(change.course.from);
        state.hash.add(change.course.open);
    }
    for (const PlatformChange& change : state.out.platforms) {
        state.hash.add(change.platform);
        state.hash.add(change.from);
        state.hash.add(change.to);
    }
    hash_groups(state);
    if (state.next_store_request != 0) {
        state.hash.add(state.next_store_request);
    }
    return hashed;
}

}  // namespace zoned::zone
