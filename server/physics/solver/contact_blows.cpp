// Blows: the part of the contact solver that makes surfaces which meet bounce.
#include "server/physics/simd/lane_body.h"
#include "server/physics/solver/contact_lane.h"
#include "server/physics/solver/contact_solver.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

/// Passes over the points of a contact that an impact takes.
constexpr int kImpactSweeps = 8;
/// Where joints leave less than this of a blow's effect they hold the two as one (a motor that
/// drives a leg into the body that it belongs to): no blow could part them.
constexpr float kLeastImpactGive = 5.0e-4F;
/// A blow may make this share of twice the energy of its change of motion: motors work meanwhile.
/// One that is all rounding makes half of it.
constexpr float kMostMade = 0.1F;
/// A smaller share than this is rounding.
constexpr float kLeastMade = 1.0e-4F;
/// A blow may part a contact faster than it should by this factor.
constexpr float kMostOver = 1.001F;

}  // namespace

/// Impulses times the speeds of the points that they act at, W s.
float ContactSolver::Blow::power(const ContactSolver& solver,
                                 const SolverWatch& w,
                                 const Single& at,
                                 const Motions& m,
                                 bool friction) const {
    const ContactBatch& batch = solver.batches_[w.batch];
    float sum = 0.0F;
    for (std::size_t k = 0; k < batch.count; ++k) {
        if (push[k] > 0.0F) {
            sum += push[k] * at.speed(m, solver.points_[batch.points + k].arm.get(w.lane));
        }
    }
    if (friction) {
        const Vec3 slip = at.slip(m, batch.grip.get(w.lane));
        sum += shear1 * at.tangent1.dot(slip) + shear2 * at.tangent2.dot(slip) + twist * at.rate(m);
    }
    return sum;
}

/// Newton's restitution at one contact, `time` into the substep, with friction within the cone of
/// all that the impact pushes. First as if there were no joints. With joints the two bodies are
/// heavier than that: the blow grows until the contact parts as fast as it should, and never gives
/// back more energy than it takes.
void ContactSolver::strike(const Bodies& bodies, SolverWatch& w, float time) {
    const ContactBatch& batch = batches_[w.batch];
    const Single at(batch, w.lane, moving_, time);
    const float before = kept_ - time / h_;
    hit_.clear();
    moving_.turn_freely(bodies, at.a, time);
    moving_.turn_freely(bodies, at.b, time);
    const Motions m = motions_at(at, time);
    Blow blow;
    if (!aim(w, at, m, blow)) {
        moving_.turn_freely(bodies, at.a, -time);
        moving_.turn_freely(bodies, at.b, -time);
        return;
    }
    note_hit(bodies, at, at.a, time);
    note_hit(bodies, at, at.b, time);
    joints_.begin_blow(at.a, at.b);
    apply(w, at, blow, 1.0F);
    float size = size_of(w, at, m, blow);
    float kept = size > 0.0F ? 1.0F : 0.0F;
    if (size > 0.0F) {
        delay_pulls(at, time);
        kept = share_kept(before, work_of_movers(w, at, blow, size));
    }
    if (kept < 1.0F) {
        take_back(at, kept);
    }
    size *= kept;
    const bool given = size > 0.0F;
    joints_.end_blow(at.a, at.b);
    for (std::size_t k = 0; given && k < batch.count; ++k) {
        points_[batch.points + k].total[w.lane] += size * blow.push[k];
    }
    for (const auto& [slot, motion] : hit_) {
        if (!given) {
            moving_.turn_freely(bodies, slot, -time);
            continue;
        }
        if (moving_.shift_change(bodies, slot, moving_.motion[slot] - motion, time)) {
            follow_turns(slot);
        }
        struck_.push_back(slot);
    }
}

/// The masses of a body's contacts follow its turns from now on.
void ContactSolver::follow_turns(std::uint32_t slot) {
    for (std::uint32_t k = first_watch_[slot]; k < first_watch_[slot + 1]; ++k) {
        ContactBatch& batch = batches_[watches_[watch_of_[k]].batch];
        batch.turns = true;
        batch.strays = true;
    }
}

/// Joints pulled at points of bodies where they stand now, but bodies get the change of motion
/// later: by then the points are apart, and two pulls that cancel each other would turn the whole.
/// The first body's moment makes up for it.
void ContactSolver::delay_pulls(const Single& at, float time) {
    if (time == 0.0F) {
        return;
    }
    bool any = false;
    joints_.for_each_pull(at.a, at.b, [&](std::uint32_t a, std::uint32_t b, const Vec3& pull) {
        const Vec3 apart = time * SolverBodies::linear(before_of(b) - before_of(a));
        moving_.apply(a, Vec3::Zero(), -apart.cross(pull));
        any = true;
    });
    if (any) {
        joints_.solve_around(moving_, at.a, at.b);
    }
}

/// Work of bodies that impulses do not move in `size` times the blow, J: they go on as fast as
/// before. None where nothing bounces: a mover that only carries things along leaves it to the
/// solver, which is soft where two movers squeeze.
float ContactSolver::work_of_movers(const SolverWatch& w,
                                    const Single& at,
                                    const Blow& blow,
                                    float size) const {
    if (w.restitution == 0.0F) {
        return 0.0F;
    }
    Motions movers;
    movers.a = moving_.moved_by_impulses(at.a) ? Row8() : moving_.motion[at.a];
    movers.b = moving_.moved_by_impulses(at.b) ? Row8() : moving_.motion[at.b];
    return joints_.work_of_movers(moving_, at.a, at.b) -
           size * blow.power(*this, w, at, movers, true);
}

/// How many times the blow may be given so that it leaves the bodies with no more energy than they
/// had and `helped`, which movers gave, J; `before`: the share of this substep's change of velocity
/// that had not come yet. Its energy is a parabola of that number. Zero where joints contradict
/// each other: their pulls are all rounding.
float ContactSolver::share_kept(float before, float helped) const {
    float made = -helped;
    float moved = 0.0F;
    for (const auto& [slot, motion] : hit_) {
        const Row8 change = moving_.motion[slot] - motion;
        const Row8 gain = motion - moving_.start(slot);
        const Row8 mean = motion + 0.5F * change - before * gain;
        const Row8 push = moving_.momentum(slot, change);
        made += sum_of(push.at * mean.at);
        moved += sum_of(push.at * change.at);
    }
    if (!(made <= kMostMade * moved)) {
        return 0.0F;
    }
    return made > kLeastMade * moved ? 1.0F - 2.0F * made / moved : 1.0F;
}

/// Leaves a share of the blow.
void ContactSolver::take_back(const Single& at, float left) {
    for (const auto& [slot, motion] : hit_) {
        const Row8 change = moving_.motion[slot] - motion;
        moving_.motion[slot] = left > 0.0F ? motion + left * change : motion;
    }
    joints_.restore_impulses(at.a, at.b, left);
}

/// How many times the blow is given, which was given once; the rest is given here.
float ContactSolver::size_of(const SolverWatch& w,
                             const Single& at,
                             const Motions& m,
                             const Blow& blow) {
    const auto change = [&] {
        return Motions{moving_.motion[at.a] - before_of(at.a),
                       moving_.motion[at.b] - before_of(at.b)};
    };
    float wanted = -blow.power(*this, w, at, m, false);
    for (std::size_t k = 0; k < batches_[w.batch].count; ++k) {
        wanted += blow.push[k] * blow.wanted[k];
    }
    const float parted = blow.power(*this, w, at, change(), false);
    if (!(parted > kLeastImpactGive * wanted)) {
        return 0.0F;
    }
    const float taken = blow.power(*this, w, at, m, true);
    const float given = blow.power(*this, w, at, change(), true);
    const float most = given > 0.0F ? std::max(-2.0F * taken / given, 0.0F) : 1.0F;
    const float size = std::clamp(wanted / parted, 0.0F, most);
    apply(w, at, blow, size - 1.0F);
    const float reached = blow.power(*this, w, at, change(), false);
    if (size <= 1.0F || reached <= kMostOver * wanted) {
        return size;
    }
    // Motors and limits gave way: the more a blow grows, the less they add to the bodies' weight.
    const float less = 1.0F + (size - 1.0F) * (wanted - parted) / (reached - parted);
    apply(w, at, blow, less - size);
    return less;
}

/// Remembers how a body moves at the time of the blow, and the bodies that joints tie to it.
void ContactSolver::note_hit(const Bodies& bodies,
                             const Single& at,
                             std::uint32_t slot,
                             float time) {
    const auto note = [&](std::uint32_t s) {
        const bool known =
            std::any_of(hit_.begin(), hit_.end(), [s](const auto& hit) { return hit.first == s; });
        if (!known && moving_.moved_by_impulses(s)) {
            if (s != at.a && s != at.b) {
                moving_.turn_freely(bodies, s, time);
            }
            hit_.emplace_back(s, moving_.motion[s]);
        }
    };
    note(slot);
    joints_.for_each_tied(slot, note);
}

Row8 ContactSolver::before_of(std::uint32_t slot) const {
    for (const auto& [s, motion] : hit_) {
        if (s == slot) {
            return motion;
        }
    }
    return moving_.motion[slot];
}

void ContactSolver::apply(const SolverWatch& w, const Single& at, const Blow& blow, float share) {
    if (share == 0.0F) {
        return;
    }
    shove(batches_[w.batch], w.lane, at, blow, share);
    // The second solve takes out what rounding leaves of a blow that joints hold off almost whole.
    joints_.solve_around(moving_, at.a, at.b);
    joints_.solve_around(moving_, at.a, at.b);
}

/// Gives a share of the blow to the two bodies.
void ContactSolver::shove(const ContactBatch& batch,
                          std::size_t lane,
                          const Single& at,
                          const Blow& blow,
                          float share) {
    Vec3 impulse = blow.shear1 * at.tangent1 + blow.shear2 * at.tangent2;
    Vec3 moment = batch.grip.get(lane).cross(impulse) + blow.twist * at.normal;
    for (std::size_t k = 0; k < batch.count; ++k) {
        const Vec3 push = blow.push[k] * at.normal;
        impulse += push;
        moment += points_[batch.points + k].arm.get(lane).cross(push);
    }
    impulse *= share;
    moment *= share;
    moving_.apply(at.a, -impulse, -(moment + at.shift_a.cross(impulse)));
    moving_.apply(at.b, impulse, moment + at.shift_b.cross(impulse));
}

/// The blow that two bodies without joints would want; false: nothing meets.
bool ContactSolver::aim(const SolverWatch& w, const Single& at, Motions m, Blow& blow) const {
    const ContactBatch& batch = batches_[w.batch];
    const std::uint32_t lane = w.lane;
    bool any = false;
    for (std::size_t k = 0; k < batch.count; ++k) {
        const PointLanes& p = points_[batch.points + k];
        const Vec3 arm = p.arm.get(lane);
        if (p.mass[lane] > 0.0F && at.gap(p.separation[lane], arm) <= kMeets) {
            blow.meets[k] = true;
            const float speed = at.speed(m, arm);
            blow.wanted[k] = std::max(-w.restitution * speed, 0.0F);
            any |= speed < 0.0F;
        }
    }
    const auto push = [&](const Vec3& impulse, const Vec3& moment) {
        const auto change = [&](Row8& motion, std::uint32_t slot, float sign, const Vec3& shift) {
            const Vec3 turn = moving_.inverse_times(slot, sign * (moment + shift.cross(impulse)));
            const Vec3 shove = sign * motion.at[3] * impulse;
            motion.at +=
                Lanes{shove.x(), shove.y(), shove.z(), 0.0F, turn.x(), turn.y(), turn.z(), 0.0F};
        };
        change(m.a, at.a, -1.0F, at.shift_a);
        change(m.b, at.b, 1.0F, at.shift_b);
    };
    const Vec3 grip = batch.grip.get(lane);
    const float friction = batch.friction[lane];
    for (int sweep = 0; any && sweep < kImpactSweeps; ++sweep) {
        float pushed = 0.0F;
        float leverage = 0.0F;
        for (std::size_t k = 0; k < batch.count; ++k) {
            if (!blow.meets[k]) {
                continue;
            }
            const PointLanes& p = points_[batch.points + k];
            const Vec3 arm = p.arm.get(lane);
            const float change = p.mass[lane] * (blow.wanted[k] - at.speed(m, arm));
            const float after = std::max(blow.push[k] + change, 0.0F);
            const Vec3 impulse = (after - blow.push[k]) * at.normal;
            push(impulse, arm.cross(impulse));
            blow.push[k] = after;
            pushed += after;
            leverage += after * p.lever[lane];
        }
        const float twist = std::clamp(blow.twist - batch.twist_mass[lane] * at.rate(m),
                                       -friction * leverage,
                                       friction * leverage);
        push(Vec3::Zero(), (twist - blow.twist) * at.normal);
        blow.twist = twist;
        const Vec3 slip = at.slip(m, grip);
        const float v1 = at.tangent1.dot(slip);
        const float v2 = at.tangent2.dot(slip);
        float f1 = blow.shear1 - (batch.inv11[lane] * v1 + batch.inv12[lane] * v2);
        float f2 = blow.shear2 - (batch.inv12[lane] * v1 + batch.inv22[lane] * v2);
        const float limit = friction * pushed;
        const float size = std::sqrt(f1 * f1 + f2 * f2);
        if (size > limit) {
            f1 *= limit / size;
            f2 *= limit / size;
        }
        const Vec3 shear = (f1 - blow.shear1) * at.tangent1 + (f2 - blow.shear2) * at.tangent2;
        push(shear, grip.cross(shear));
        blow.shear1 = f1;
        blow.shear2 = f2;
    }
    return any;
}

}  // namespace zoned::physics
