// The step of a scene, as a table of contents.
#include "server/physics/methods/method_stepper.h"
#include "server/physics/scene_impl.h"
#include "server/physics/strain.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::physics {

namespace {

/// Substeps are no longer than this, s: friction and rolling are first order in it.
constexpr float kLongestSubstep = 1.0F / 240.0F;
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

void Scene::Impl::solve(float dt) {
    bodies.compact_lists();  // bodies that were touched have joined
    ContactSolver::Parameters parameters;
    parameters.gravity = settings.gravity;
    parameters.dt = dt;
    parameters.iterations = settings.velocity_iterations;
    parameters.relax_iterations = settings.relax_iterations;
    parameters.restitution_speed = settings.restitution_speed_mps;
    broken.clear();
    in_contact.assign(bodies.rows(), 0);
    for (const std::uint32_t index : solve_list) {
        in_contact[graph.pair(index).a] = 1;
        in_contact[graph.pair(index).b] = 1;
    }
    for (const std::uint32_t index : active_joints) {
        if (joints[index].a != kNoIndex) {
            in_contact[joints[index].a] = 1;
        }
        in_contact[joints[index].b] = 1;
    }
    if (settings.method != Method::kSoftStep) {
        solve_by_method(dt);
    } else if (settings.substeps > 0) {
        parameters.substeps = settings.substeps;
        substeps = static_cast<std::uint32_t>(settings.substeps);
        solver.solve(bodies, graph, solve_list, joints, active_joints, parameters, *team, broken);
    } else {
        effort.plan(bodies,
                    graph,
                    solve_list,
                    joints,
                    active_joints,
                    {settings.error_budget_m, kLongestSubstep, dt, settings.gravity.norm()},
                    *team);
        strained = effort.strained();
        for (std::size_t i = 0; i < Effort::kBatches; ++i) {
            const Effort::Batch batch = effort.batch(i);
            if (!batch.contacts.empty() || !batch.joints.empty()) {
                parameters.substeps = batch.substeps;
                parameters.iterations =
                    batch.young ? Effort::kYoungIterations : settings.velocity_iterations;
                substeps = static_cast<std::uint32_t>(batch.substeps);
                solver.solve(
                    bodies, graph, batch.contacts, joints, batch.joints, parameters, *team, broken);
            }
        }
    }
    for (const std::uint32_t row : bodies.awake_list) {
        if (in_contact[row] == 0) {
            fly_free(bodies, row, settings.gravity, dt, broken);
        }
    }
    for (const std::uint32_t row : bodies.mover_list) {
        fly_free(bodies, row, settings.gravity, dt, broken);
    }
    for (const std::uint32_t row : broken) {
        quarantine(row);
    }
    if (!broken.empty()) {
        bodies.compact_lists();
    }
}

void Scene::Impl::list_moved() {
    const float far_m = farthest_for(settings.error_budget_m);
    for (const auto* list : {&bodies.awake_list, &bodies.mover_list, &bodies.particle_list}) {
        for (const std::uint32_t row : *list) {
            moved.push_back(bodies.id_of(row));
            far_bodies += bodies.position[row].cwiseAbs().maxCoeff() > far_m ? 1 : 0;
        }
    }
    if (!std::is_sorted(moved.begin(), moved.end())) {
        std::sort(moved.begin(), moved.end());
    }
}

StepStats Scene::Impl::stats_of(bool skipped, std::uint32_t island_count) {
    StepStats stats;
    stats.bodies = bodies.count;
    stats.awake = bodies.awake_dynamic;
    stats.quarantined = std::exchange(quarantined, 0);
    stats.substeps = std::exchange(substeps, 0);
    stats.skipped = skipped;
    stats.unpaired = unpaired;
    if (stepper) {
        stats.method = stepper->stats();
        stepper->reset_stats();
    }
    stats.particles = bodies.awake_particles;
    stats.strained = std::exchange(strained, 0);
    stats.far_bodies = std::exchange(far_bodies, 0);
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
