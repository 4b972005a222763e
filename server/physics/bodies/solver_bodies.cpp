// build: hot loops
#include "server/physics/bodies/solver_bodies.h"

#include "server/physics/integrator/free_flight.h"
#include "server/physics/integrator/integrate.h"
#include "server/physics/shapes/compound/inertia.h"
#include "server/physics/shapes/ranges.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// A body that turns farther than this within a step has its inertia followed in each substep, rad.
constexpr float kFastTurn = 0.2F;
/// Below this turn within a step the inertia of a body that others hold is as good as still, rad.
constexpr float kNoTurn = 1.0e-4F;
/// Bodies that one thread stores at a time.
constexpr std::size_t kStoreGrain = 64;
/// Bodies that one thread integrates at a time.
constexpr std::size_t kSlotGrain = 512;

Row8 row_of(const Vec3& first, float w, const Vec3& second) {
    return {Lanes{first.x(), first.y(), first.z(), w, second.x(), second.y(), second.z(), 0.0F}};
}

/// The spin with the same angular momentum after the body's axes went from `from` to `to`.
Vec3 spin_after(const Mat3& from, const Mat3& to, const Vec3& moments, const Vec3& spin) {
    const Vec3 momentum = from * moments.cwiseProduct(from.transpose() * spin);
    return to * (to.transpose() * momentum).cwiseQuotient(moments);
}

bool fit(const Vec3& position, const Vec3& velocity, const Vec3& spin, const Quat& orientation) {
    return fit_position(position) && fit_velocity(velocity, spin) && fit_orientation(orientation);
}

/// Cuts a vector longer than `most`, up to `excess` times as long; true if it did.
bool cut(Vec3& v, float most, float excess) {
    const float size = v.norm();
    const bool over = size > most && size < excess * most;
    v *= over ? 0.9999F * most / size : 1.0F;
    return over;
}

/// Impacts may ask for more than bodies can have. An elastic one asks for twice the speed, and one
/// off the centre of a small body for a hundred times the spin. Up to that they get the most there
/// is; a larger demand is an error. True if something was cut.
bool slow_down(Vec3& velocity, Vec3& spin) {
    const bool slower = cut(velocity, kMaxSpeed, 2.0F);
    return cut(spin, kMaxSpin, 100.0F) || slower;
}

void stop_broken(Bodies& bodies, std::uint32_t row, std::vector<std::uint32_t>& broken) {
    broken.push_back(row);
    bodies.set_pose(row, bodies.position[row], bodies.orientation[row]);
    bodies.velocity[row].setZero();
    bodies.angular_velocity[row].setZero();
}

}  // namespace

Vec3 rotate_body(const Bodies& bodies,
                 std::uint32_t row,
                 float seconds,
                 Quat& orientation,
                 Vec3& spin) {
    if (!bodies.tilted(row)) {
        return rotate_freely(bodies.inertia[row], seconds, orientation, spin);
    }
    Quat principal = orientation * bodies.tilt[row];
    const Vec3 went = rotate_freely(bodies.inertia[row], seconds, principal, spin);
    orientation = (principal * bodies.tilt[row].conjugate()).normalized();
    return went;
}

void SolverBodies::reserve(std::size_t bodies) {
    for (auto* table : {&motion, &drift, &tensor, &gain_, &damp_, &start_}) {
        table->reserve(bodies + 1);
    }
    row_.reserve(bodies + 1);
    outcome_.reserve(bodies + 1);
    spinners_.reserve(bodies + 1);
    spinner_of_.reserve(bodies + 1);
}

void SolverBodies::begin(const Vec3& gravity, float dt, float h) {
    gravity_ = gravity;
    dt_ = dt;
    h_ = h;
    for (auto* table : {&motion, &drift, &tensor, &gain_, &damp_, &start_}) {
        table->assign(1, Row8());
    }
    row_.assign(1, kNoIndex);
    spinner_of_.assign(1, kNoIndex);
    spinners_.clear();
}

std::uint32_t SolverBodies::slot_of(Bodies& bodies, std::uint32_t row) {
    std::uint32_t& slot = bodies.solver_slot[row];
    if (slot != 0) {
        return slot;
    }
    slot = static_cast<std::uint32_t>(row_.size());
    row_.push_back(row);
    const float inv_mass = bodies.inv_mass_scale[row] * bodies.inv_mass[row];
    motion.push_back(row_of(bodies.velocity[row], inv_mass, bodies.angular_velocity[row]));
    drift.emplace_back();
    tensor.emplace_back();
    gain_.emplace_back();
    damp_.push_back({lanes(1.0F)});
    start_.emplace_back();
    spinner_of_.push_back(kNoIndex);
    take_spin(bodies, row, slot);
    if (inv_mass > 0.0F) {
        take_forces(bodies, row, slot);
    }
    return slot;
}

/// The change by gravity, forces and damping in a substep. Damping is implicit, v / (1 + c h):
/// stable however strong.
void SolverBodies::take_forces(const Bodies& bodies, std::uint32_t row, std::uint32_t slot) {
    const Vec3 pull = gravity_ + bodies.inv_mass[row] * bodies.force[row];
    const Vec3 twist = inverse_times(slot, bodies.torque[row]) / bodies.inv_mass_scale[row];
    gain_[slot] = row_of(h_ * pull, 0.0F, h_ * twist);
    const Damping& damping = bodies.damping[row];
    const float v = 1.0F / (1.0F + h_ * damping.linear);
    const float w = 1.0F / (1.0F + h_ * damping.angular);
    damp_[slot].at = Lanes{v, v, v, 1.0F, w, w, w, 1.0F};
}

/// Inertia is taken halfway through the step, and the spin that goes with it: the free rotation
/// between the impulses is then the implicit midpoint rule's explicit half, second order in the
/// turn, and keeps the angular momentum to rounding.
void SolverBodies::take_spin(const Bodies& bodies, std::uint32_t row, std::uint32_t slot) {
    if (bodies.inv_mass[row] == 0.0F) {
        return;
    }
    const Vec3& spin = bodies.angular_velocity[row];
    const Vec3 turn = (0.5F * dt_) * spin;
    const float turn2 = turn.squaredNorm();
    Mat3 axes = bodies.inertia_axes(row, bodies.rotation[row]);
    if (bodies.round[row] == 0) {
        if (turn2 > 0.25F * kFastTurn * kFastTurn) {
            spinner_of_[slot] = static_cast<std::uint32_t>(spinners_.size());
            spinners_.push_back({slot, bodies.orientation[row], true});
        } else if (turn2 > 0.25F * kNoTurn * kNoTurn) {
            const Mat3 before = axes;
            axes = middle_axes(bodies, row);
            const Vec3 mid = spin_after(before, axes, bodies.inertia[row], spin);
            for (std::size_t i = 0; i < 3; ++i) {
                motion[slot].at[4 + i] = mid[static_cast<Eigen::Index>(i)];
            }
        }
    }
    take_tensor(bodies, row, slot, axes);
}

/// Axes of inertia as `take_spin` has them.
Mat3 SolverBodies::middle_axes(const Bodies& bodies, std::uint32_t row) const {
    const Vec3 half = (0.5F * dt_) * bodies.angular_velocity[row];
    return bodies.inertia_axes(row,
                               half.squaredNorm() > 0.25F * kNoTurn * kNoTurn
                                   ? Mat3(turned(bodies.orientation[row], half).toRotationMatrix())
                                   : bodies.rotation[row]);
}

void SolverBodies::take_tensor(const Bodies& bodies,
                               std::uint32_t row,
                               std::size_t slot,
                               const Mat3& axes) {
    const Mat3 m = rotated_tensor(axes, bodies.inv_mass_scale[row] * bodies.inv_inertia[row]);
    auto& at = tensor[slot].at;
    at[0] = m(0, 0);
    at[1] = m(0, 1);
    at[2] = m(0, 2);
    at[3] = m(1, 1);
    at[4] = m(1, 2);
    at[5] = m(2, 2);
}

template <class Visit>
void SolverBodies::for_each_slot(compute::Team& team, Visit&& visit) {
    team.run(row_.size() - 1, kSlotGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin + 1; i <= end; ++i) {
            visit(i);
        }
    });
}

void SolverBodies::integrate_velocities(compute::Team& team) {
    for_each_slot(team, [this](std::size_t i) {
        start_[i] = motion[i];
        motion[i].at = (motion[i].at + gain_[i].at) * damp_[i].at;
    });
}

void SolverBodies::integrate_positions(const Bodies& bodies, float seconds, compute::Team& team) {
    for_each_slot(team, [&](std::size_t i) { drift[i].at += seconds * motion[i].at; });
    for (Spinner& s : spinners_) {
        turn(bodies, seconds, s);
    }
}

void SolverBodies::turn(const Bodies& bodies, float seconds, Spinner& s) {
    Lanes& m = motion[s.slot].at;
    Lanes& d = drift[s.slot].at;
    const std::uint32_t row = row_[s.slot];
    Vec3 spin(m[4], m[5], m[6]);
    const Vec3 plain = seconds * spin;
    Vec3 went = plain;
    const bool round = bodies.round[row] != 0;
    if (s.fast) {
        went = rotate_body(bodies, row, seconds, s.orientation, spin);
    } else {
        const Mat3 before = bodies.inertia_axes(row, s.orientation.toRotationMatrix());
        s.orientation = turned(s.orientation, plain);
        if (!round) {
            const Mat3 after = bodies.inertia_axes(row, s.orientation.toRotationMatrix());
            spin = spin_after(before, after, bodies.inertia[row], spin);
        }
    }
    if (!round) {
        const Mat3 axes = bodies.inertia_axes(row, s.orientation.toRotationMatrix());
        take_tensor(bodies, row, s.slot, axes);
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const auto axis = static_cast<Eigen::Index>(k);
        d[4 + k] += went[axis] - plain[axis];
        start_[s.slot].at[4 + k] += spin[axis] - m[4 + k];  // nobody's impulse
        m[4 + k] = spin[axis];
    }
}

void SolverBodies::turn_freely(const Bodies& bodies, std::uint32_t slot, float time) {
    const std::uint32_t row = row_[slot];
    if (time == 0.0F || !turns_fast(slot)) {
        return;
    }
    Quat& orientation = spinners_[spinner_of_[slot]].orientation;
    Vec3 spin = angular(motion[slot]);
    rotate_body(bodies, row, time, orientation, spin);
    set_spin(slot, spin);
    take_tensor(bodies, row, slot, bodies.inertia_axes(row, orientation.toRotationMatrix()));
}

/// Whether the body turns far by now, and did not before; `way`: its turn since the substep began,
/// rad. From now on its free rotation is computed with care.
bool SolverBodies::begin_to_spin(const Bodies& bodies, std::uint32_t slot, const Vec3& way) {
    const std::uint32_t row = row_[slot];
    if (!moved_by_impulses(slot) || bodies.round[row] != 0) {
        return false;
    }
    const float rate = angular(motion[slot]).norm();
    if (spinner_of_[slot] != kNoIndex) {
        Spinner& spinner = spinners_[spinner_of_[slot]];
        if (spinner.fast || h_ * rate <= kFastTurn) {
            return false;
        }
        spinner.fast = true;
        spinner.orientation = turned(spinner.orientation, way);
        return true;
    }
    if (dt_ * rate <= kFastTurn) {
        return false;
    }
    const Quat orientation = turned(bodies.orientation[row], Vec3(angular(drift[slot]) + way));
    spinner_of_[slot] = static_cast<std::uint32_t>(spinners_.size());
    spinners_.push_back({slot, orientation, true});
    const Mat3 axes = bodies.inertia_axes(row, orientation.toRotationMatrix());
    const Vec3 spin = angular(motion[slot]);
    set_spin(slot, spin_after(middle_axes(bodies, row), axes, bodies.inertia[row], spin));
    take_tensor(bodies, row, slot, axes);
    return true;
}

/// Not by anybody's impulse.
void SolverBodies::set_spin(std::uint32_t slot, const Vec3& spin) {
    for (std::size_t k = 0; k < 3; ++k) {
        const float more = spin[static_cast<Eigen::Index>(k)] - motion[slot].at[4 + k];
        motion[slot].at[4 + k] += more;
        start_[slot].at[4 + k] += more;
    }
}

void SolverBodies::track(const Bodies& bodies, std::uint32_t slot) {
    if (spinner_of_[slot] != kNoIndex || !moved_by_impulses(slot)) {
        return;
    }
    // Inertia starts from where the body is, not from halfway through the step.
    const std::uint32_t row = row_[slot];
    const Vec3& spin = bodies.angular_velocity[row];
    motion[slot] = row_of(bodies.velocity[row], motion[slot].at[3], spin);
    const Mat3 axes = bodies.inertia_axes(row, bodies.rotation[row]);
    take_tensor(bodies, row, slot, axes);
    spinner_of_[slot] = static_cast<std::uint32_t>(spinners_.size());
    spinners_.push_back({slot, bodies.orientation[row], false});
}

Quat SolverBodies::orientation(std::uint32_t slot, const Quat& start) const {
    const std::uint32_t spinner = spinner_of_[slot];
    return spinner != kNoIndex ? spinners_[spinner].orientation
                               : turned(start, Vec3(angular(drift[slot])));
}

/// Positions moved with the velocity at the substep's end. Where the velocity changed by forces,
/// the mean of both ends is exact to second order (x += v h + a h^2 / 2), and with it the path of a
/// thrown or sliding body. Where it changed by an impact there is no such mean: a change of more
/// than twice gravity's is left alone.
void SolverBodies::follow_mean_velocity(compute::Team& team) {
    const float gravity2 = h_ * h_ * gravity_.squaredNorm();
    for_each_slot(team, [&](std::size_t i) {
        const Lanes change = motion[i].at - start_[i].at;
        const float forces2 = std::max(gravity2, linear(gain_[i]).squaredNorm());
        if (change[0] * change[0] + change[1] * change[1] + change[2] * change[2] <=
            4.0F * forces2) {
            const Lanes back = (0.5F * h_) * change;
            drift[i].at -= Lanes{back[0], back[1], back[2], 0.0F, 0.0F, 0.0F, 0.0F, 0.0F};
        }
    });
}

void SolverBodies::apply(std::uint32_t slot, const Vec3& impulse, const Vec3& moment) {
    change(slot, impulse, inverse_times(slot, moment));
}

Row8 SolverBodies::momentum(std::uint32_t slot, const Row8& of) const {
    if (!moved_by_impulses(slot)) {
        return {};
    }
    const Lanes& t = tensor[slot].at;
    Mat3 inverse;
    inverse << t[0], t[1], t[2], t[1], t[3], t[4], t[2], t[4], t[5];
    return row_of(linear(of) / motion[slot].at[3], 0.0F, inverse.inverse() * angular(of));
}

void SolverBodies::change(std::uint32_t slot, const Vec3& impulse, const Vec3& spin) {
    if (!moved_by_impulses(slot)) {
        return;
    }
    Lanes& m = motion[slot].at;
    m += Lanes{m[3] * impulse.x(),
               m[3] * impulse.y(),
               m[3] * impulse.z(),
               0.0F,
               spin.x(),
               spin.y(),
               spin.z(),
               0.0F};
}

bool SolverBodies::shift_change(const Bodies& bodies,
                                std::uint32_t slot,
                                const Row8& change,
                                float time) {
    start_[slot].at += change.at;
    const Vec3 before = angular(motion[slot]) - angular(change);
    const bool begins = begin_to_spin(bodies, slot, time * before);
    drift[slot].at -= time * change.at;
    if (turns_fast(slot)) {
        turn_freely(bodies, slot, -time);
        return begins;
    }
    if (spinner_of_[slot] == kNoIndex) {
        return begins;
    }
    const std::uint32_t row = row_[slot];
    Quat& orientation = spinners_[spinner_of_[slot]].orientation;
    const Mat3 axes = bodies.inertia_axes(row, orientation.toRotationMatrix());
    orientation = turned(orientation, Vec3(-time * angular(change)));
    if (bodies.round[row] == 0) {
        const Mat3 after = bodies.inertia_axes(row, orientation.toRotationMatrix());
        const Vec3 spin = angular(motion[slot]);
        set_spin(slot, spin_after(axes, after, bodies.inertia[row], spin));
        take_tensor(bodies, row, slot, after);
    }
    return begins;
}

void SolverBodies::store(Bodies& bodies, compute::Team& team, std::vector<std::uint32_t>& broken) {
    outcome_.resize(row_.size());
    team.run(row_.size() - 1, kStoreGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin + 1; i <= end; ++i) {
            outcome_[i] = store_body(bodies, i);
        }
    });
    for (std::size_t i = 1; i < row_.size(); ++i) {
        if (outcome_[i] == StoreOutcome::kUnfit) {
            stop_broken(bodies, row_[i], broken);
        }
        bodies.slowed += outcome_[i] == StoreOutcome::kSlowed ? 1 : 0;
    }
}

/// An impulse that is not finite leaves NaN in the inverse mass too. NaN is not above zero, so that
/// the solvers take the body for one that nothing moves: it would stand still and nobody would
/// know.
bool SolverBodies::sound(std::size_t slot) const {
    const Lanes zero = tensor[slot].at - tensor[slot].at;
    return within(motion[slot].at[3], 0.0F, 1.0F / kMinMass) && sum_of(zero) == 0.0F;
}

/// Where the result is of no use the body is as it was.
SolverBodies::StoreOutcome SolverBodies::store_body(Bodies& bodies, std::size_t slot) const {
    const std::uint32_t row = row_[slot];
    bodies.solver_slot[row] = 0;
    if (motion[slot].at[3] == 0.0F) {
        return StoreOutcome::kStored;
    }
    if (!sound(slot)) {
        return StoreOutcome::kUnfit;
    }
    Quat orientation = bodies.orientation[row];
    Vec3 spin = angular(motion[slot]);
    const Vec3 turn = angular(drift[slot]);
    if (spinner_of_[slot] != kNoIndex) {
        orientation = spinners_[spinner_of_[slot]].orientation;
    } else {
        orientation = turned(orientation, turn);
        const float turn2 = turn.squaredNorm();
        if (bodies.round[row] == 0 && turn2 > kNoTurn * kNoTurn) {
            spin = spin_after(middle_axes(bodies, row),
                              bodies.inertia_axes(row, orientation.toRotationMatrix()),
                              bodies.inertia[row],
                              spin);
        }
    }
    const Vec3 position = bodies.position[row] + linear(drift[slot]);
    Vec3 velocity = linear(motion[slot]);
    const bool slowed = slow_down(velocity, spin);
    if (!fit(position, velocity, spin, orientation)) {
        return StoreOutcome::kUnfit;
    }
    bodies.set_pose(row, position, orientation);
    bodies.velocity[row] = velocity;
    bodies.angular_velocity[row] = spin;
    return slowed ? StoreOutcome::kSlowed : StoreOutcome::kStored;
}

void fly_free(Bodies& bodies,
              std::uint32_t row,
              const Vec3& gravity,
              float dt,
              IntegratorKind integrator,
              int pieces,
              std::vector<std::uint32_t>& broken) {
    const bool dynamic = bodies.inv_mass[row] > 0.0F;
    const Vec3 pull =
        dynamic ? Vec3(gravity + bodies.inv_mass[row] * bodies.force[row]) : Vec3(Vec3::Zero());
    Vec3 position = bodies.position[row];
    Vec3 velocity = bodies.velocity[row];
    const bool arrived = free_flight_in(
        pieces, integrator, {pull, bodies.damping[row].linear}, dt, position, velocity);
    Quat orientation = bodies.orientation[row];
    const Mat3 r = bodies.inertia_axes(row, bodies.rotation[row]);
    const Vec3 twist = r * bodies.inv_inertia[row].cwiseProduct(r.transpose() * bodies.torque[row]);
    Vec3 spin =
        (bodies.angular_velocity[row] + dt * twist) / (1.0F + dt * bodies.damping[row].angular);
    if (!spin.isZero(0.0F)) {
        if (dynamic && bodies.round[row] == 0) {
            rotate_body(bodies, row, dt, orientation, spin);
            bodies.slowed += cut(spin, kMaxSpin, 100.0F) ? 1 : 0;  // tumbling is faster at times
        } else {
            orientation = turned(orientation, Vec3(dt * spin));
        }
    }
    if (!arrived || !fit(position, velocity, spin, orientation)) {
        stop_broken(bodies, row, broken);
        return;
    }
    bodies.set_pose(row, position, orientation);
    bodies.velocity[row] = velocity;
    bodies.angular_velocity[row] = spin;
}

}  // namespace zoned::physics
