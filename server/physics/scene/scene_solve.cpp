// The solve of a step: assigns contacts and joints to their solvers.
#include "server/physics/scene/scene_impl.h"
#include "server/physics/solver_variants/variant_stepper.h"

namespace zoned::physics {

Scene::Impl::~Impl() = default;

void Scene::Impl::solve(float dt) {
    bodies.compact_lists();  // bodies that were touched have joined
    broken.clear();
    note_starts();
    mark_held();
    if (settings.method != SolverVariant::kSoftStep) {
        solve_by_variant(dt);
    } else if (settings.substeps > 0) {
        solve_batch({settings.substeps, false, solve_list, active_joints}, dt);
    } else {
        solve_by_substep_policy(dt);
    }
    for (const std::uint32_t row : bodies.awake_list) {
        if (in_contact[row] == 0) {
            fly_free(bodies,
                     row,
                     settings.gravity,
                     dt,
                     settings.body_integrator,
                     settings.body_flight_pieces,
                     broken);
        }
    }
    for (const std::uint32_t row : bodies.mover_list) {
        fly_free(bodies, row, settings.gravity, dt, IntegratorKind::kDefault, 1, broken);
    }
    for (const std::uint32_t row : broken) {
        quarantine(row);
    }
    if (!broken.empty()) {
        bodies.compact_lists();
    }
}

/// Notes which bodies contacts and joints hold; the others fly freely.
void Scene::Impl::mark_held() {
    // Nobody asks about the others: a world may have a million of them.
    in_contact.resize(bodies.rows());
    for (const std::uint32_t row : bodies.awake_list) {
        in_contact[row] = 0;
    }
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
}

/// Each island as its loads ask for.
void Scene::Impl::solve_by_substep_policy(float dt) {
    substep_policy.plan(
        bodies,
        graph,
        solve_list,
        joints,
        active_joints,
        {settings.error_budget_m, SubstepPolicy::kLongestSubstep, dt, settings.gravity.norm()},
        *team);
    substep_limited = substep_policy.substep_limited();
    torn.begin_step(substep_policy.jointed_visits(),
                    {settings.error_budget_m, dt, settings.gravity});
    for (std::size_t i = 0; i < SubstepPolicy::kBatches; ++i) {
        const SubstepPolicy::SubstepBatch batch = substep_policy.batch(i);
        if (!batch.joints.empty()) {
            solve_jointed(batch, dt);
        } else if (!batch.contacts.empty()) {
            solve_batch(batch, dt);
        }
    }
    substep_limited += torn.given_up();
    for (std::size_t i = 0; i < substep_policy.exact_count(); ++i) {
        const SubstepPolicy::SubstepBatch island = substep_policy.exact(i);
        if (!solve_exactly(island.contacts, dt)) {
            ++substep_limited;
            solve_batch(island, dt);
        }
    }
}

void Scene::Impl::solve_batch(const SubstepPolicy::SubstepBatch& batch, float dt) {
    ContactSolver::Parameters parameters;
    parameters.gravity = settings.gravity;
    parameters.dt = dt;
    parameters.substeps = batch.substeps;
    parameters.iterations =
        std::max(batch.young ? SubstepPolicy::kYoungIterations : settings.velocity_iterations,
                 batch.least_passes);
    parameters.relax_iterations = std::max(settings.relax_iterations, batch.least_passes);
    parameters.restitution_speed = settings.restitution_speed_mps;
    substeps = std::max(substeps, static_cast<std::uint32_t>(batch.substeps));
    count_sweeps(batch.contacts,
                 batch.joints.size(),
                 static_cast<std::uint64_t>(batch.substeps) *
                     static_cast<std::uint64_t>(parameters.iterations));
    solver.solve(bodies, graph, batch.contacts, joints, batch.joints, parameters, *team, broken);
}

void Scene::Impl::count_sweeps(std::span<const std::uint32_t> contacts,
                               std::size_t joints_here,
                               std::uint64_t passes) {
    for (const std::uint32_t index : contacts) {
        contact_sweeps += passes * graph.pair(index).count;
    }
    joint_sweeps += passes * joints_here;
}

void Scene::Impl::solve_jointed(const SubstepPolicy::SubstepBatch& batch, float dt) {
    const TornIslands::StepView view{bodies, graph, joints, substep_policy, starts};
    torn.note(view, batch);
    solve_guarded(batch, dt);
    for (int more = 2 * batch.substeps; torn.take_back(view, more, passed, broken); more *= 2) {
        const int most = std::min(more, SubstepPolicy::kMostSubsteps);
        solve_guarded({most, batch.young, torn.contacts(), torn.joints(), more / most}, dt);
    }
    if (torn.take_back_hopeless(view, broken)) {
        solve_guarded({batch.substeps, batch.young, torn.contacts(), torn.joints()}, dt);
    }
    torn.take_out_gain(view);
    drop_guards();
}

bool Scene::Impl::solve_exactly(std::span<const std::uint32_t> contacts, float dt) {
    count_sweeps(contacts, 0, 1);
    return exact->solve_exactly({bodies, graph, contacts, joints, {}, exact_settings, dt}, broken);
}

void Scene::Impl::solve_by_variant(float dt) {
    stepper->solve({bodies, graph, solve_list, joints, active_joints, settings, dt, team}, broken);
    substeps = static_cast<std::uint32_t>(stepper->substeps());
    count_sweeps(solve_list, active_joints.size(), substeps);
}

const RowSystem* Scene::problem() const {
    return impl_->stepper && impl_->settings.methods.keep_problem ? &impl_->stepper->problem()
                                                                  : nullptr;
}

}  // namespace zoned::physics
