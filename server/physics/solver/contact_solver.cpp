// build: hot loops
#include "server/physics/solver/contact_solver.h"

#include "server/physics/simd/lane_body.h"

#include <algorithm>

namespace zoned::physics {

namespace {

/// Overlap is undone no faster than this, m/s.
constexpr float kPushSpeed = 3.0F;

/// How often the points of one contact are solved among themselves in one visit. With two, stacks
/// come to rest at half the substeps that they need with one; three gain nothing more.
constexpr int kSweeps = 2;
/// A soft contact yields to its load. A load carried for longer is taken out of the spring's
/// deflection at this rate, 1/s. Faster, and the loads of a pyramid wander.
constexpr float kSagRate = 0.3F;

/// Passes over contacts where joints are not solved all at once.
constexpr int kLeastTurns = 2;
/// The most of them while contacts open joints.
constexpr int kMostTurns = 8;

/// The work that one thread takes at a time: some microseconds.
constexpr std::size_t kBatchGrain = 8;

}  // namespace

/// How far the bodies have drifted apart from where they stand at the contact. Arms that started at
/// one point end at one point again: a's grows by `shift_a`, b's by `shift_b`.
struct ContactSolver::Arms {
    Lanes closing;  ///< of b relative to a, along the normal
    Lanes3 offset, shift_a, shift_b;

    [[gnu::always_inline]] Arms(const ContactBatch& batch, const LaneBody& a, const LaneBody& b) {
        offset = batch.lead + (b.shift - a.shift);
        closing = dot(batch.normal, offset);
        shift_a = batch.follow_b * offset;
        shift_b = shift_a - offset - batch.between;
    }
};

void ContactSolver::reserve(std::size_t bodies, std::size_t contacts) {
    moving_.reserve(bodies);
    coloring_.reserve(bodies, contacts);
    batches_.reserve(contacts);
    points_.reserve(contacts);
    couplings_.reserve(contacts);
    rolls_.reserve(contacts);
    watches_.reserve(contacts);
    meetings_.reserve(2 * contacts);
    watch_of_.reserve(2 * contacts);
    first_watch_.reserve(bodies + 2);
    struck_.reserve(bodies);
    hit_.reserve(bodies);
    joints_.reserve_bodies(bodies);
}

template <class Visit>
void ContactSolver::for_each_batch(Visit&& visit) {
    for (const ContactColoring::ColorGroup stage : coloring_.stages()) {
        team_->run(stage.end - stage.begin, kBatchGrain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                visit(batches_[stage.begin + i]);
            }
        });
    }
}

void ContactSolver::warm_start() {
    for_each_batch([this](ContactBatch& batch) {
        LaneBody a(moving_, batch.a);
        LaneBody b(moving_, batch.b);
        const Arms arms(batch, a, b);
        const Lanes3 strayed = arms.offset - batch.fitted;
        const Lanes3 ahead = strayed + lanes(h_) * (b.velocity - a.velocity);
        batch.strays =
            batch.turns || any(max(dot(strayed, strayed), dot(ahead, ahead)) > batch.same2);
        if (batch.strays) {
            fit_masses(batch, a, b, arms.offset);
        }
        const Lanes3 tangent2 = cross(batch.normal, batch.tangent);
        const Lanes3 shear = batch.impulse1 * batch.tangent + batch.impulse2 * tangent2;
        // The points' impulses are parallel: one force at their centre of pressure.
        Lanes push = lanes(0.0F);
        Lanes3 lever{push, push, push};
        for (std::size_t k = 0; k < batch.count; ++k) {
            const PointLanes& p = points_[batch.points + k];
            push += p.impulse;
            lever = lever + p.impulse * p.arm;
        }
        const Lanes3 thrust = push * batch.normal;
        const Lanes3 impulse = thrust + shear;
        Lanes3 moment =
            cross(lever, batch.normal) + cross(batch.grip, shear) + batch.twist * batch.normal;
        if (batch.rolls != 0) {
            const RollLanes& r = rolls_[batch.rolls - 1];
            moment = moment + r.roll1 * batch.tangent + r.roll2 * tangent2 + r.spin * batch.normal;
        }
        a.pull(impulse, moment + cross(arms.shift_a, impulse));
        b.push(impulse, moment + cross(arms.shift_b, impulse));
        a.store(moving_, batch.a);
        b.store(moving_, batch.b);
    });
}

[[gnu::always_inline]] inline void ContactSolver::solve_friction(ContactBatch& batch,
                                                                 LaneBody& a,
                                                                 LaneBody& b,
                                                                 const Arms& arms,
                                                                 const Lanes& push,
                                                                 const Lanes& leverage) const {
    const Lanes twist_limit = batch.friction * leverage;
    const Lanes rate = dot(batch.normal, b.spin - a.spin);
    const Lanes twist = max(min(batch.twist - batch.twist_mass * rate, twist_limit), -twist_limit);
    const Lanes3 turn = (twist - batch.twist) * batch.normal;
    batch.twist = twist;
    a.spin = a.spin - a.inverse * turn;
    b.spin = b.spin + b.inverse * turn;

    const Lanes3 tangent2 = cross(batch.normal, batch.tangent);
    const Lanes3 arm_a = batch.grip + arms.shift_a;
    const Lanes3 arm_b = batch.grip + arms.shift_b;
    const Lanes3 slip = (b.velocity - a.velocity) + (cross(b.spin, arm_b) - cross(a.spin, arm_a));
    const Lanes v1 = dot(batch.tangent, slip);
    const Lanes v2 = dot(tangent2, slip);
    Lanes f1 = batch.impulse1 - (batch.inv11 * v1 + batch.inv12 * v2);
    Lanes f2 = batch.impulse2 - (batch.inv12 * v1 + batch.inv22 * v2);
    // Scaled back onto the cone: limit / max(size, limit) is 1 inside of it. The smallest size
    // keeps 0 / 0 out.
    const Lanes limit = batch.friction * push;
    const Lanes size = sqrt(f1 * f1 + f2 * f2);
    const Lanes scale = limit / max(max(size, limit), lanes(1.0e-30F));
    f1 *= scale;
    f2 *= scale;
    const Lanes3 impulse = (f1 - batch.impulse1) * batch.tangent + (f2 - batch.impulse2) * tangent2;
    batch.impulse1 = f1;
    batch.impulse2 = f2;
    a.pull(impulse, cross(arm_a, impulse));
    b.push(impulse, cross(arm_b, impulse));
}

/// Normals first, then friction within the cone that they allow: after an impact the cone has to
/// shrink with the push in the same pass.
///
/// With springs, a gap s may close as far as the surface within the substep (bias s / h), an
/// overlap is pushed apart softly. Without them, overlap is left alone, and so is a gap that no
/// impulse holds open: positions were moved already, it is the next substep's affair.
///
/// The points of a contact share one normal: their speeds and gaps are linear in the arm, and an
/// impulse at one changes the speed at another by a number that is known beforehand. So the points
/// are solved among themselves, as often as wanted, before the bodies hear of it.
template <bool kSoft, std::size_t kCount>
[[gnu::always_inline]] inline void ContactSolver::solve_batch(ContactBatch& batch) {
    LaneBody a(moving_, batch.a);
    LaneBody b(moving_, batch.b);
    const Arms arms(batch, a, b);
    const Lanes zero = lanes(0.0F);
    const Lanes inv_h = lanes(1.0F / h_);
    const Lanes3 turn_a = cross(batch.normal, a.turn);
    const Lanes3 turn_b = cross(batch.normal, b.turn);
    const Lanes3 spin_a = cross(batch.normal, a.spin);
    const Lanes3 spin_b = cross(batch.normal, b.spin);
    const Lanes3 turn = turn_b - turn_a;
    const Lanes3 spin = spin_b - spin_a;
    const Lanes gap0 = arms.closing + dot(arms.shift_b, turn_b) - dot(arms.shift_a, turn_a);
    const Lanes speed0 = dot(batch.normal, b.velocity - a.velocity) + dot(arms.shift_b, spin_b) -
                         dot(arms.shift_a, spin_a);
    PointLanes* points = &points_[batch.points];
    const Lanes* coupling = &couplings_[batch.couplings];
    Lanes speed[kCount];
    Lanes bias[kCount];
    Lanes limit[kCount];
    Lanes before[kCount];
    ZONED_UNROLL
    for (std::size_t k = 0; k < kCount; ++k) {
        const PointLanes& p = points[k];
        const Lanes s = p.separation + gap0 + dot(p.arm, turn);
        speed[k] = speed0 + dot(p.arm, spin);
        bias[k] = max(s, zero) * inv_h;
        before[k] = p.impulse;
        if constexpr (kSoft) {
            bias[k] += max(softness_.bias_rate * min(s, zero), lanes(-kPushSpeed));
            // Lanes without such a point have no mass, and must not get the impulses of others.
            limit[k] = where_not_positive(s, p.mass > zero ? lanes(1.0F) : zero);
        } else {
            limit[k] = (p.impulse + max(-s, zero)) * lanes(1.0e30F);
        }
    }
    ZONED_UNROLL
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        ZONED_UNROLL
        for (std::size_t k = 0; k < kCount; ++k) {
            PointLanes& p = points[k];
            const Lanes stiff = p.mass * (speed[k] + bias[k]);
            Lanes impulse;
            if constexpr (kSoft) {
                const Lanes give = softness_.impulse_scale * max(p.impulse - batch.carried, zero) -
                                   (1.0F - softness_.mass_scale) * stiff;
                impulse = max(p.impulse - stiff - limit[k] * give, zero);
            } else {
                impulse = min(max(p.impulse - stiff, zero), limit[k]);
            }
            const Lanes change = impulse - p.impulse;
            p.impulse = impulse;
            ZONED_UNROLL
            for (std::size_t j = 0; j < kCount; ++j) {
                speed[j] += change * coupling[coupling_of(j, k)];
            }
        }
    }
    Lanes push = zero;
    Lanes leverage = zero;
    Lanes pressure = zero;
    Lanes3 at{zero, zero, zero};
    ZONED_UNROLL
    for (std::size_t k = 0; k < kCount; ++k) {
        PointLanes& p = points[k];
        const Lanes change = p.impulse - before[k];
        if constexpr (!kSoft) {
            p.total += tally_ * p.impulse;
        }
        pressure += change;
        at = at + change * p.arm;
        push += p.impulse;
        leverage += p.impulse * p.lever;
    }
    const Lanes3 impulse = pressure * batch.normal;
    const Lanes3 moment = cross(at, batch.normal);
    a.pull(impulse, moment + cross(arms.shift_a, impulse));
    b.push(impulse, moment + cross(arms.shift_b, impulse));
    solve_friction(batch, a, b, arms, push, leverage);
    a.store(moving_, batch.a);
    b.store(moving_, batch.b);
}

/// Turning against each other is resisted about the normal, and about lines across it, by a moment
/// of at most a length times the load. It is a constraint that wants no turning at all, within
/// those bounds: a ball comes to rest, and stays at rest on a slope that its load can hold.
void ContactSolver::solve_rolling(const ContactBatch& batch) {
    RollLanes& r = rolls_[batch.rolls - 1];
    LaneBody a(moving_, batch.a);
    LaneBody b(moving_, batch.b);
    const Lanes least = lanes(1.0e-30F);  // keeps 0 / 0 out
    Lanes push = lanes(0.0F);
    for (std::size_t k = 0; k < batch.count; ++k) {
        push += points_[batch.points + k].impulse;
    }
    const auto turn = [&](const Lanes3& moment) {
        a.spin = a.spin - a.inverse * moment;
        b.spin = b.spin + b.inverse * moment;
    };
    const auto give = [&](const Lanes3& along) {
        return a.inverse * along + b.inverse * along;
    };
    const Lanes3 give_n = give(batch.normal);
    const Lanes most_spin = r.spinning * push;
    const Lanes spun = dot(batch.normal, b.spin - a.spin) / max(dot(batch.normal, give_n), least);
    const Lanes spin = max(min(r.spin - spun, most_spin), -most_spin);
    turn((spin - r.spin) * batch.normal);
    r.spin = spin;

    const Lanes3 tangent2 = cross(batch.normal, batch.tangent);
    const Lanes3 give_1 = give(batch.tangent);
    const Lanes3 give_2 = give(tangent2);
    const Lanes k11 = dot(batch.tangent, give_1);
    const Lanes k12 = dot(tangent2, give_1);
    const Lanes k22 = dot(tangent2, give_2);
    // The floor is the rounding error of the difference.
    const Lanes inverse = lanes(1.0F) / max(max(k11 * k22 - k12 * k12, 1.0e-6F * k11 * k22), least);
    const Lanes3 rate = b.spin - a.spin;
    const Lanes w1 = dot(batch.tangent, rate);
    const Lanes w2 = dot(tangent2, rate);
    Lanes r1 = r.roll1 - inverse * (k22 * w1 - k12 * w2);
    Lanes r2 = r.roll2 - inverse * (k11 * w2 - k12 * w1);
    const Lanes limit = r.rolling * push;
    const Lanes scale = limit / max(max(sqrt(r1 * r1 + r2 * r2), limit), least);
    r1 *= scale;
    r2 *= scale;
    turn((r1 - r.roll1) * batch.tangent + (r2 - r.roll2) * tangent2);
    r.roll1 = r1;
    r.roll2 = r2;
    a.store(moving_, batch.a);
    b.store(moving_, batch.b);
}

void ContactSolver::take_back_rolling(const ContactBatch& batch, std::size_t lane) {
    RollLanes& r = rolls_[batch.rolls - 1];
    const Vec3 normal = batch.normal.get(lane);
    const Vec3 tangent = batch.tangent.get(lane);
    const Vec3 moment =
        r.roll1[lane] * tangent + r.roll2[lane] * normal.cross(tangent) + r.spin[lane] * normal;
    moving_.apply(batch.a[lane], Vec3::Zero(), moment);
    moving_.apply(batch.b[lane], Vec3::Zero(), -moment);
    r.roll1[lane] = r.roll2[lane] = r.spin[lane] = 0.0F;
}

template <bool kSoft>
void ContactSolver::solve_all() {
    for_each_batch([this](ContactBatch& batch) {
        if (!kSoft && batch.strays) {  // the bodies have moved on
            const LaneBody a(moving_, batch.a);
            const LaneBody b(moving_, batch.b);
            fit_masses(batch, a, b, Arms(batch, a, b).offset);
        }
        switch (batch.count) {
            case 1:
                solve_batch<kSoft, 1>(batch);
                break;
            case 2:
                solve_batch<kSoft, 2>(batch);
                break;
            case 3:
                solve_batch<kSoft, 3>(batch);
                break;
            default:
                solve_batch<kSoft, 4>(batch);
                break;
        }
        if (batch.rolls != 0) {
            solve_rolling(batch);
        }
    });
}

/// Notes the impulses carried in this substep, where no pass over the contacts has done so.
void ContactSolver::add_totals() {
    for (PointLanes& p : points_) {
        p.total += p.impulse;
    }
}

void ContactSolver::substep(const Bodies& bodies, const JointTable& table, bool last) {
    joints_.update(table, moving_);
    moving_.integrate_velocities(*team_);
    joints_.warm_start(moving_);
    // The joints' last impulses balance those of contacts: only together do they show who meets.
    if (leaps_) {
        warm_start();
    }
    watch_impacts();
    collide(bodies);
    if (!leaps_) {
        warm_start();
    }
    // Joints solved one after the other move again what a contact has stopped: both take turns.
    const int least = joints_.exact() ? 1 : kLeastTurns;
    const int iterations = batches_.empty() ? 1 : std::max(parameters_.iterations, least);
    for (int i = 0; i < iterations; ++i) {
        joints_.solve(moving_);
        solve_all<true>();
    }
    // Joints have the last word: a contact that yields is soft, a joint that opens is torn.
    for (int i = iterations; joints_.close(moving_) && i < kMostTurns; ++i) {
        solve_all<true>();
    }
    const float move = leaps_ && last ? 0.5F * h_ : h_;
    moving_.integrate_positions(bodies, move, *team_);
    const bool relax = joints_.relax() || !batches_.empty();
    const int relax_iterations = relax ? parameters_.relax_iterations : 0;
    if (relax_iterations > 0) {
        joints_.follow(moving_);
    }
    for (int i = 0; i < relax_iterations; ++i) {
        joints_.solve_relaxed(moving_);
        tally_ = i + 1 == relax_iterations ? 1.0F : 0.0F;
        solve_all<false>();
    }
    joints_.add_totals();
    if (relax_iterations == 0) {
        add_totals();
    }
    if (!leaps_) {
        moving_.follow_mean_velocity(*team_);
    }
}

void ContactSolver::store(Bodies& bodies, ContactGraph& graph, std::vector<std::uint32_t>& broken) {
    moving_.store(bodies, *team_, broken);
    team_->run(batches_.size(), kBatchGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            store_batch(batches_[i], graph);
        }
    });
}

void ContactSolver::store_batch(const ContactBatch& batch, ContactGraph& graph) const {
    const float follow = std::min(1.0F, kSagRate * parameters_.dt);
    const Lanes3 tangent2 = cross(batch.normal, batch.tangent);
    const Lanes3 shear = batch.impulse1 * batch.tangent + batch.impulse2 * tangent2;
    for (std::size_t lane = 0; lane < kLanes && batch.contact[lane] != kNoIndex; ++lane) {
        Contact& contact = graph[batch.contact[lane]];
        const std::size_t count = graph.pair(batch.contact[lane]).points();
        contact.friction = shear.get(lane);
        contact.twist = batch.twist[lane];
        if (batch.rolls != 0) {
            const RollLanes& r = rolls_[batch.rolls - 1];
            contact.rolling = r.roll1[lane] * batch.tangent.get(lane) +
                              r.roll2[lane] * tangent2.get(lane) +
                              r.spin[lane] * batch.normal.get(lane);
        }
        contact.step_impulse = 0.0F;
        const float scale = contact.substep_s > 0.0F ? h_ / contact.substep_s : 0.0F;
        contact.substep_s = h_;
        float mean = 0.0F;
        for (std::size_t k = 0; k < count; ++k) {
            const PointLanes& p = points_[batch.points + k];
            contact.points[k].impulse = p.impulse[lane];
            contact.step_impulse += p.total[lane];
            mean += p.impulse[lane];
        }
        const float carried = scale * contact.carried;
        contact.carried = carried + follow * (mean / static_cast<float>(count) - carried);
    }
}

void ContactSolver::solve(Bodies& bodies,
                          ContactGraph& graph,
                          std::span<const std::uint32_t> list,
                          JointTable& table,
                          std::span<const std::uint32_t> joints,
                          const Parameters& parameters,
                          compute::Team& team,
                          std::vector<std::uint32_t>& broken) {
    parameters_ = parameters;
    team_ = &team;
    h_ = parameters.dt / static_cast<float>(parameters.substeps);
    prepare(bodies, graph, list, table, joints);
    leaps_ = !joints_.empty();
    kept_ = leaps_ ? 0.5F : 1.0F;
    if (leaps_) {
        moving_.integrate_positions(bodies, 0.5F * h_, team);
    }
    for (int i = 0; i < parameters.substeps; ++i) {
        substep(bodies, table, i + 1 == parameters.substeps);
    }
    store(bodies, graph, broken);
    joints_.store(table, moving_);
}

}  // namespace zoned::physics
