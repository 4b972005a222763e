// The step of a scene, as a table of contents.
#include "server/physics/scene/scene_impl.h"
#include "server/physics/scene/stability_warnings.h"
#include "server/physics/solver_variants/variant_stepper.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::physics {

namespace {

/// With fewer pairs than this, one thread is done before others would have come.
constexpr std::size_t kMuch = 512;

}  // namespace

StepStats Scene::Impl::step(float dt) {
    ZONED_ASSERT(dt > 0.0F && std::isfinite(dt), "a step needs a positive length of time");
    events.clear();
    events.swap(left_contacts);
    breaks.clear();
    sensor_events.clear();
    sensor_events.swap(left_sensors);
    moved.clear();
    wake_joined_to_movers();
    bodies.compact_lists();
    if (bodies.awake_list.empty() && bodies.mover_list.empty() && bodies.particle_list.empty()) {
        return stats_of(true, 0);
    }
    refresh_bounds(dt);
    find_pairs(dt);
    {
        const compute::Team::Shift shift(graph.active().size() < kMuch ? alone : *team);
        update_contacts(dt);
        list_joints();
        step_particles(dt);
        solve(dt);
        limit_squeezed(dt);
        hold_back(dt);
        settle_contacts();
    }
    report_contacts();
    break_joints();
    follow_bounds();
    bodies.clear_forces();
    list_moved();
    const std::uint32_t island_count = islands.update(
        bodies,
        graph,
        joints,
        active_joints,
        {settings.sleep_speed_mps, settings.sleep_spin_rps, settings.sleep_after_s, dt});
    return stats_of(false, island_count);
}

void Scene::Impl::list_moved() {
    const float far_m = farthest_for(settings.error_budget_m);
    for (const auto* list : {&bodies.awake_list, &bodies.mover_list, &bodies.particle_list}) {
        for (const std::uint32_t row : *list) {
            moved.push_back(bodies.id_of(row));
            far_bodies += bodies.position[row].cwiseAbs().maxCoeff() > far_m ? 1 : 0;
        }
    }
    for (const std::uint32_t row : stopped) {
        if (bodies.alive[row] != 0 && bodies.listed[row] == 0) {
            moved.push_back(bodies.id_of(row));
        }
    }
    stopped.clear();
    if (!std::is_sorted(moved.begin(), moved.end())) {
        std::sort(moved.begin(), moved.end());
        moved.erase(std::unique(moved.begin(), moved.end()), moved.end());
    }
}

StepStats Scene::Impl::stats_of(bool skipped, std::uint32_t island_count) {
    StepStats stats;
    stats.bodies = bodies.count;
    stats.awake = bodies.awake_dynamic;
    stats.quarantined = std::exchange(quarantined, 0);
    stats.substeps = std::exchange(substeps, 0);
    stats.contact_sweeps = std::exchange(contact_sweeps, 0);
    stats.joint_sweeps = std::exchange(joint_sweeps, 0);
    stats.skipped = skipped;
    stats.unpaired = unpaired;
    if (stepper) {
        stats.method = stepper->stats();
        stepper->reset_stats();
    }
    stats.particles = bodies.awake_particles;
    stats.substep_limited = std::exchange(substep_limited, 0);
    stats.far_bodies = std::exchange(far_bodies, 0);
    stats.held_back = std::exchange(held_back, 0);
    stats.slowed = std::exchange(bodies.slowed, 0);
    if (!skipped) {
        stats.pairs = graph.size();
        stats.islands = island_count;
        for (const std::uint32_t index : solve_list) {
            stats.contacts += graph.pair(index).count;
        }
    }
    return stats;
}

}  // namespace zoned::physics
