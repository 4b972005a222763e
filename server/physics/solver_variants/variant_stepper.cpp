#include "server/physics/solver_variants/variant_stepper.h"

#include "server/physics/solver_variants/collision_response.h"
#include "server/physics/solver_variants/rows/residual.h"
#include "server/physics/solver_variants/rows/stabilise.h"

#include <algorithm>

namespace zoned::physics {

namespace {

IterationLimits limits_of(const VariantStep& step) {
    const VariantSettings& settings = step.settings.methods;
    IterationLimits limits;
    limits.team = step.team;
    limits.iterations = settings.iterations;
    limits.tolerance_mps = static_cast<double>(settings.tolerance_mps);
    limits.omega = static_cast<double>(settings.omega);
    limits.direct_rows = static_cast<std::uint32_t>(settings.direct_rows);
    limits.measure = settings.measure;
    return limits;
}

void count(const SolveReport& report, VariantStats& stats) {
    stats.iterations += static_cast<std::uint32_t>(report.iterations);
    stats.direct += report.direct;
    stats.too_large += report.too_large;
    stats.unsolved += report.unsolved;
    stats.residual_mps = report.residual_mps;
}

bool solves_rows(SolverVariant method) {
    return method != SolverVariant::kImpulse && method != SolverVariant::kProjection &&
           method != SolverVariant::kPenalty;
}

}  // namespace

int VariantStepper::substeps_of(const PhysicsSettings& settings) {
    if (settings.substeps > 0) {
        return settings.substeps;
    }
    switch (settings.method) {
        case SolverVariant::kProjection:
            return 4;
        case SolverVariant::kPenalty:
            return 16;
        default:
            return 1;
    }
}

void VariantStepper::reserve(std::size_t bodies, std::size_t contacts) {
    moving_.reserve(bodies);
    contacts_.reserve(contacts);
    contact_list_.reserve(contacts);
    sets_.reserve(bodies + 1);
}

void VariantStepper::take_bodies(const VariantStep& step) {
    moving_.begin(step.settings.gravity, system_);
    for (const std::uint32_t index : step.contacts) {
        moving_.slot_of(step.bodies, step.graph.pair(index).a, system_);
        moving_.slot_of(step.bodies, step.graph.pair(index).b, system_);
    }
    for (const std::uint32_t index : step.active_joints) {
        moving_.slot_of(step.bodies, step.joints[index].a, system_);
        moving_.slot_of(step.bodies, step.joints[index].b, system_);
    }
    contact_list_.assign(step.contacts.begin(), step.contacts.end());
    joint_list_.assign(step.active_joints.begin(), step.active_joints.end());
    if (step.settings.method == SolverVariant::kDirect) {
        sort_by_island(step);
    }
}

/// Contacts and joints by the island that they belong to, joints first, otherwise in their order.
void VariantStepper::sort_by_island(const VariantStep& step) {
    sets_.reset(moving_.size());
    const auto slot = [&](std::uint32_t row) {
        return row != kNoIndex && step.bodies.simulated(row) ? step.bodies.solver_slot[row] : 0U;
    };
    const auto join = [&](std::uint32_t a, std::uint32_t b) {
        if (slot(a) != 0 && slot(b) != 0) {
            sets_.join(slot(a), slot(b));
        }
    };
    for (const std::uint32_t index : contact_list_) {
        join(step.graph.pair(index).a, step.graph.pair(index).b);
    }
    for (const std::uint32_t index : joint_list_) {
        join(step.joints[index].a, step.joints[index].b);
    }
    const auto island = [&](std::uint32_t a, std::uint32_t b) {
        return static_cast<std::uint64_t>(sets_.root(slot(a) != 0 ? slot(a) : slot(b))) << 32;
    };
    const auto joints = static_cast<std::uint32_t>(joint_list_.size());
    keys_.clear();
    for (std::uint32_t i = 0; i < joints; ++i) {
        const JointEntry& entry = step.joints[joint_list_[i]];
        keys_.push_back(island(entry.a, entry.b) | i);
    }
    for (std::uint32_t i = 0; i < contact_list_.size(); ++i) {
        const Pair& pair = step.graph.pair(contact_list_[i]);
        keys_.push_back(island(pair.a, pair.b) | (joints + i));
    }
    std::sort(keys_.begin(), keys_.end());
}

void VariantStepper::write_rows(const VariantStep& step, double h) {
    system_.clear_rows();
    contacts_.clear();
    joints_.clear();
    RowParameters parameters;
    parameters.settings = &step.settings.methods;
    parameters.h = h;
    parameters.gravity = static_cast<double>(step.settings.gravity.norm());
    parameters.restitution_speed = static_cast<double>(step.settings.restitution_speed_mps);
    const SolverVariant method = step.settings.method;
    parameters.bounces = solves_rows(method);
    parameters.guess = method == SolverVariant::kPenalty ||
                       (solves_rows(method) && step.settings.methods.warm_start);
    const auto write_joint = [&](std::uint32_t index) {
        joints_.write(step.bodies, step.joints, index, moving_, parameters, system_);
    };
    const auto write_contact = [&](std::uint32_t index) {
        contacts_.write(step.bodies, step.graph, index, moving_, parameters, system_);
    };
    if (method == SolverVariant::kDirect) {
        for (std::size_t i = 0; i < keys_.size(); ++i) {
            const auto place = static_cast<std::uint32_t>(keys_[i]);
            const auto at = static_cast<std::uint32_t>(system_.size());
            if (i == 0 || keys_[i] >> 32 != keys_[i - 1] >> 32) {
                system_.groups.push_back({at, at});
            }
            if (place < joint_list_.size()) {
                write_joint(joint_list_[place]);
            } else {
                write_contact(contact_list_[place - joint_list_.size()]);
            }
            system_.groups.back().end = static_cast<std::uint32_t>(system_.size());
        }
    } else {
        std::for_each(joint_list_.begin(), joint_list_.end(), write_joint);
        std::for_each(contact_list_.begin(), contact_list_.end(), write_contact);
    }
    system_.finish(step.settings.methods.shuffle);
    stats_.rows = std::max(stats_.rows, static_cast<std::uint32_t>(system_.size()));
}

void VariantStepper::note_speeds() {
    before_.resize(system_.size());
    for (std::size_t i = 0; i < system_.size(); ++i) {
        before_[i] = system_.speed(i);
    }
}

void VariantStepper::solve_velocities(const VariantStep& step, double h) {
    const VariantSettings& settings = step.settings.methods;
    if (settings.measure) {
        note_speeds();
    }
    if (step.settings.method == SolverVariant::kImpulse) {
        stats_.iterations += static_cast<std::uint32_t>(
            respond_by_impulses(system_,
                                h,
                                static_cast<double>(step.settings.restitution_speed_mps),
                                settings.iterations));
        stats_.residual_mps = settings.measure ? residual(system_) : 0.0;
    } else {
        system_.apply_guess();
        if (settings.keep_problem && problem_.size() == 0) {
            problem_ = system_;
        }
        count(solve_rows(step.settings.method, system_, limits_of(step)), stats_);
    }
    if (settings.measure) {
        const BiasEnergy energy = bias_energy(system_, before_);
        stats_.bias_in_j += energy.in;
        stats_.bias_out_j += energy.out;
    }
}

/// Velocities that exist for this solve alone carry the bodies out of their overlaps. Impulses have
/// no solve of their own: Gauss-Seidel's stands in.
void VariantStepper::split_positions(const VariantStep& step, double h) {
    kept_ = system_.bodies;
    for (RowBody& body : system_.bodies) {
        body.velocity.setZero();
        body.spin.setZero();
    }
    ask_for_positions(step.settings.methods, h, system_);
    IterationLimits limits = limits_of(step);
    limits.measure = false;
    const double residual_before = stats_.residual_mps;
    const bool rows = solves_rows(step.settings.method);
    count(solve_rows(rows ? step.settings.method : SolverVariant::kGaussSeidel, system_, limits),
          stats_);
    stats_.residual_mps = residual_before;
    moving_.displace(h, system_.bodies);
    system_.bodies = kept_;
}

void VariantStepper::store(const VariantStep& step, double h, int index) {
    contacts_.store(system_, h, index > 0, step.graph);
    joints_.store(system_, h, index + 1, step.joints);
}

void VariantStepper::substep(const VariantStep& step, double h, int index) {
    moving_.gain(step.bodies, h, system_);
    write_rows(step, h);
    if (step.settings.method == SolverVariant::kProjection) {
        projection_.solve({step.bodies, step.graph, step.joints, step.settings, joint_list_, h},
                          contacts_.spans(),
                          moving_,
                          system_);
        stats_.iterations += static_cast<std::uint32_t>(step.settings.methods.iterations);
        store(step, h, index);
        return;
    }
    solve_velocities(step, h);
    store(step, h, index);
    if (step.settings.methods.stabilisation == Stabilisation::kSplit) {
        split_positions(step, h);
    }
    moving_.move(step.bodies, h, true, system_);
}

/// Semi-implicit Euler gives all of the push, then moves; velocity Verlet half, moves, and then the
/// other half from where the bodies came to.
void VariantStepper::penalty_substep(const VariantStep& step, double h, int index) {
    const VariantSettings& settings = step.settings.methods;
    const bool verlet = settings.penalty_integrator == PenaltyIntegrator::kVelocityVerlet;
    const double part = verlet ? 0.5 * h : h;
    const auto push = [&](int place) {
        moving_.gain(step.bodies, part, system_);
        write_rows(step, part);
        respond_by_penalties(settings, h, part, system_);
        ++stats_.iterations;
        store(step, part, place);
    };
    push(verlet ? 2 * index : index);
    moving_.move(step.bodies, h, !verlet, system_);
    if (verlet) {
        push(2 * index + 1);
    }
}

void VariantStepper::solve(const VariantStep& step, std::vector<std::uint32_t>& broken) {
    stats_ = VariantStats();
    problem_.clear();
    take_bodies(step);
    substeps_ = substeps_of(step.settings);
    const double h = static_cast<double>(step.dt) / substeps_;
    for (int i = 0; i < substeps_; ++i) {
        if (step.settings.method == SolverVariant::kPenalty) {
            penalty_substep(step, h, i);
        } else {
            substep(step, h, i);
        }
    }
    moving_.store(step.bodies, system_, broken);
}

namespace {

/// Impulses may give this share of all the energy that they take and give.
constexpr double kMostGiven = 0.01;

/// Whether impulses left the bodies with more energy than they had, not counting what takes
/// overlaps apart. Bounces that shall all happen at once do that where they follow from each other:
/// a ball between the ground and a falling weight (D. Stewart, "Rigid-body dynamics with friction
/// and impact", SIAM Review 42, 2000, section 1). Movers give what they like.
bool makes_energy(const RowSystem& system, std::span<const double> before) {
    double made = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < system.size(); ++i) {
        for (const std::uint32_t slot : {system.a[i], system.b[i]}) {
            const RowBody& body = system.bodies[slot];
            if (body.inv_mass == 0.0 && !(body.velocity.isZero(0.0) && body.spin.isZero(0.0))) {
                return false;
            }
        }
        const double work = 0.5 * system.lambda[i] * (before[i] + system.speed(i));
        made += system.undoes[i] == 0 ? work : 0.0;
        size += std::abs(work);
    }
    return made > kMostGiven * size;
}

}  // namespace

bool VariantStepper::solve_exactly(const VariantStep& step, std::vector<std::uint32_t>& broken) {
    stats_ = VariantStats();
    take_bodies(step);
    const auto h = static_cast<double>(step.dt);
    moving_.gain(step.bodies, h, system_);
    write_rows(step, h);
    note_speeds();
    solve_velocities(step, h);
    if (stats_.direct == 0 || makes_energy(system_, before_)) {
        moving_.release(step.bodies);
        return false;
    }
    store(step, h, 0);
    moving_.move(step.bodies, h, true, system_);
    moving_.store(step.bodies, system_, broken);
    return true;
}

}  // namespace zoned::physics
