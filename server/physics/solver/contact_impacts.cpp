// Impacts: the part of the contact solver that finds when surfaces meet within a substep, and makes
// them bounce one after the other.
#include "server/physics/simd/lane_body.h"
#include "server/physics/solver/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::physics {

namespace {

/// Passes over the points of a contact that an impact takes.
constexpr int kImpactSweeps = 8;
/// Impacts of one substep that follow from each other, at most: what is left is the solver's.
constexpr int kMostImpactRounds = 64;
/// Where joints leave less than this of a blow's effect they hold the two as one (a motor that
/// drives a leg into the body that it belongs to): no blow could part them.
constexpr float kLeastImpactGive = 5.0e-4F;
/// A blow may make this share of twice the energy of its change of motion: motors work meanwhile.
/// One that is all rounding makes half of it.
constexpr float kMostMade = 0.1F;
/// A blow may part a contact faster than it should by this factor.
constexpr float kMostOver = 1.001F;
/// Points this close take part in the impact of a contact, m.
constexpr float kMeets = 0.0005F;
/// Steps to the time of a meeting.
constexpr int kTimeSteps = 6;
/// A bounce that lasts for fewer steps than this is none, twice over: a contact under the pull g
/// bounces from kShortBounce g dt on.
constexpr float kShortBounce = 3.0F;
/// Slower impacts never bounce, m/s: rounding.
constexpr float kSlowestBounce = 0.01F;
/// Contacts that one thread watches at a time.
constexpr std::size_t kWatchGrain = 64;

constexpr float kNoImpact = std::numeric_limits<float>::infinity();

Row8 operator+(const Row8& a, const Row8& b) {
    return {a.at + b.at};
}

Row8 operator-(const Row8& a, const Row8& b) {
    return {a.at - b.at};
}

Row8 operator*(float s, const Row8& a) {
    return {s * a.at};
}

/// When two surfaces meet, s from now, and how fast, m/s.
struct Meeting {
    float time = kNoImpact;
    float speed = 0.0F;
};

/// Of a gap, m, that opens at `speed`, m/s, under the acceleration `pull`, m/s2.
Meeting meeting_of(float gap, float speed, float pull) {
    if (gap <= 0.0F) {
        return {speed < 0.0F ? 0.0F : kNoImpact, -speed};
    }
    const float square = speed * speed - 2.0F * pull * gap;
    const float root = std::sqrt(std::max(square, 0.0F));
    return {square > 0.0F && root > speed ? 2.0F * gap / (root - speed) : kNoImpact, root};
}

}  // namespace

/// One lane of a batch as plain vectors, `time` into the substep: impacts are few and branch a lot.
struct ContactSolver::Single {
    std::uint32_t a, b;
    Vec3 normal, tangent1, tangent2, shift_a, shift_b, turn_a, turn_b;
    float closing;

    Single(const ContactBatch& batch, std::size_t lane, const SolverBodies& bodies, float time)
        : a(batch.a[lane]),
          b(batch.b[lane]),
          normal(batch.normal.get(lane)),
          tangent1(batch.tangent.get(lane)),
          tangent2(normal.cross(tangent1)) {
        const Row8 drift_a = bodies.drift[a] + time * bodies.motion[a];
        const Row8 drift_b = bodies.drift[b] + time * bodies.motion[b];
        const Vec3 offset =
            batch.lead.get(lane) + SolverBodies::linear(drift_b) - SolverBodies::linear(drift_a);
        closing = normal.dot(offset);
        shift_a = batch.follow_b[lane] * offset;
        shift_b = shift_a - offset - batch.between.get(lane);
        turn_a = SolverBodies::angular(drift_a);
        turn_b = SolverBodies::angular(drift_b);
    }

    [[nodiscard]] Vec3 slip(const Motions& m, const Vec3& arm) const {
        return SolverBodies::linear(m.b) - SolverBodies::linear(m.a) +
               SolverBodies::angular(m.b).cross(arm + shift_b) -
               SolverBodies::angular(m.a).cross(arm + shift_a);
    }

    [[nodiscard]] float speed(const Motions& m, const Vec3& arm) const {
        return normal.dot(slip(m, arm));
    }

    [[nodiscard]] float rate(const Motions& m) const {
        return normal.dot(SolverBodies::angular(m.b) - SolverBodies::angular(m.a));
    }

    /// Of a point that was `separation` apart at the time of contact.
    [[nodiscard]] float gap(float separation, const Vec3& arm) const {
        return separation + closing + (arm + shift_b).cross(normal).dot(turn_b) -
               (arm + shift_a).cross(normal).dot(turn_a);
    }
};

/// What an impact gives to the points of a contact and to its patch, N s and N m s.
struct ContactSolver::Blow {
    std::array<float, kMaxManifoldPoints> push{};
    std::array<float, kMaxManifoldPoints> wanted{};  ///< speeds after it, m/s
    std::array<bool, kMaxManifoldPoints> meets{};
    float shear1 = 0.0F, shear2 = 0.0F, twist = 0.0F;

    [[nodiscard]] float power(const ContactSolver& solver,
                              const SolverWatch& w,
                              const Single& at,
                              const Motions& m,
                              bool friction) const;
};

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

/// Finds the contacts whose surfaces meet in this substep.
void ContactSolver::watch_impacts() {
    team_->run(watched_, kWatchGrain, [this](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            watches_[i].time = meeting_time(watches_[i]);
        }
    });
}

/// Velocities hold all that gravity and joints do in this substep already; `start` is without it.
/// So a gap goes as s + v t + a t^2 / 2, and in it v is the velocity where positions are now.
float ContactSolver::meeting_time(const SolverWatch& w) const {
    const ContactBatch& batch = batches_[w.batch];
    const Single at(batch, w.lane, moving_, 0.0F);
    const Motions m{moving_.motion[at.a], moving_.motion[at.b]};
    const Motions gain{m.a - moving_.start(at.a), m.b - moving_.start(at.b)};
    const float weight = std::abs(at.normal.dot(parameters_.gravity));
    float earliest = kNoImpact;
    for (std::size_t k = 0; k < batch.count; ++k) {
        const PointLanes& p = points_[batch.points + k];
        if (p.mass[w.lane] == 0.0F) {
            continue;
        }
        const Vec3 arm = p.arm.get(w.lane);
        const float gained = at.speed(gain, arm);
        const float gap = at.gap(p.separation[w.lane], arm);
        const Meeting meeting = meeting_of(gap, at.speed(m, arm) - kept_ * gained, gained / h_);
        if (meeting.speed > bounce_speed(std::max(weight, -gained / h_))) {
            earliest = std::min(earliest, meeting.time);
        }
    }
    return earliest < h_ ? earliest : kNoImpact;
}

/// The same where bodies turn and slide on the way, which a straight line to the meeting leaves
/// out: Newton's method from there.
float ContactSolver::arrival(const SolverWatch& w, float time) const {
    const ContactBatch& batch = batches_[w.batch];
    for (int i = 0; i < kTimeSteps && time < h_; ++i) {
        const Single at(batch, w.lane, moving_, time);
        const Motions m = motions_at(at, time);
        float wait = kNoImpact;
        for (std::size_t k = 0; k < batch.count; ++k) {
            const PointLanes& p = points_[batch.points + k];
            if (p.mass[w.lane] == 0.0F) {
                continue;
            }
            const Vec3 arm = p.arm.get(w.lane);
            const float gap = at.gap(p.separation[w.lane], arm);
            if (gap <= kMeets) {
                return time;
            }
            const float speed = -at.speed(m, arm);
            wait = speed > 0.0F ? std::min(wait, gap / speed) : wait;
        }
        time += wait;
    }
    return kNoImpact;
}

/// Velocities `time` into the substep.
ContactSolver::Motions ContactSolver::motions_at(const Single& at, float time) const {
    const float ahead = kept_ - time / h_;
    const auto then = [&](std::uint32_t slot) {
        return moving_.motion[slot] - ahead * (moving_.motion[slot] - moving_.start(slot));
    };
    return {then(at.a), then(at.b)};
}

/// The slowest impact that bounces under this pull, m/s2.
float ContactSolver::bounce_speed(float pull) const {
    const float least = std::max(kShortBounce * pull * parameters_.dt, kSlowestBounce);
    return std::min(least, parameters_.restitution_speed);
}

/// One impact after the other in the order of their times, each as if nothing else happened then:
/// an impact leaves no more energy than there was, and so does a row of them (Newton's cradle; B.
/// Smith and others, "Reflections on simultaneous impact", ACM Transactions on Graphics 31(4),
/// 2012).
void ContactSolver::collide(const Bodies& bodies) {
    meetings_.clear();
    for (std::uint32_t i = 0; i < watched_; ++i) {
        if (watches_[i].time < kNoImpact) {
            meetings_.push_back(i);
        }
    }
    if (meetings_.empty()) {
        return;
    }
    if (leaps_) {
        take_back_pushes();
        joints_.solve(moving_);
    }
    list_watches_of_slots();
    for (int round = 0; round < kMostImpactRounds && !meetings_.empty(); ++round) {
        std::sort(meetings_.begin(), meetings_.end(), [this](std::uint32_t a, std::uint32_t b) {
            return std::pair(watches_[a].time, a) < std::pair(watches_[b].time, b);
        });
        struck_.clear();
        for (const std::uint32_t i : meetings_) {
            const float time = arrival(watches_[i], meeting_time(watches_[i]));
            if (time < kNoImpact) {
                strike(bodies, watches_[i], time);
            }
        }
        find_next_meetings();
    }
}

/// Contacts gave their last impulses again before anybody knew who flies apart by now. Where that
/// drives surfaces apart faster than any part that rest, it is taken back: the contact solver would
/// take the energy out again, but an impact gives it on.
void ContactSolver::take_back_pushes() {
    const float rest = bounce_speed(parameters_.gravity.norm());
    for (ContactBatch& batch : batches_) {
        for (std::size_t lane = 0; lane < kLanes && batch.contact[lane] != kNoIndex; ++lane) {
            const Single at(batch, lane, moving_, 0.0F);
            const Motions m{moving_.motion[at.a], moving_.motion[at.b]};
            Blow blow{{}, {}, {}, batch.impulse1[lane], batch.impulse2[lane], batch.twist[lane]};
            float push = 0.0F;
            float power = 0.0F;
            for (std::size_t k = 0; k < batch.count; ++k) {
                const PointLanes& p = points_[batch.points + k];
                blow.push[k] = p.impulse[lane];
                push += blow.push[k];
                power += blow.push[k] * at.speed(m, p.arm.get(lane));
            }
            if (!(power > rest * push)) {
                continue;
            }
            shove(batch, lane, at, blow, -1.0F);
            for (std::size_t k = 0; k < batch.count; ++k) {
                points_[batch.points + k].impulse[lane] = 0.0F;
            }
            batch.impulse1[lane] = batch.impulse2[lane] = batch.twist[lane] = 0.0F;
            if (batch.rolls != 0) {
                take_back_rolling(batch, lane);
            }
        }
    }
}

/// The contacts of each slot, once for all substeps; now all are watched that an impact may reach.
void ContactSolver::list_watches_of_slots() {
    if (!first_watch_.empty()) {
        return;
    }
    for (std::uint32_t i = 0; i < batches_.size(); ++i) {
        for (std::uint32_t lane = 0; lane < kLanes && batches_[i].contact[lane] != kNoIndex;
             ++lane) {
            if ((batches_[i].watched >> lane & 1U) == 0) {
                watches_.push_back({i, lane, 0.0F, kNoImpact});
            }
        }
    }
    first_watch_.assign(moving_.size() + 1, 0);
    const auto each_slot = [this](const SolverWatch& w, auto&& visit) {
        for (const std::uint32_t slot :
             {batches_[w.batch].a[w.lane], batches_[w.batch].b[w.lane]}) {
            if (moving_.moved_by_impulses(slot)) {
                visit(slot);
            }
        }
    };
    for (const SolverWatch& w : watches_) {
        each_slot(w, [this](std::uint32_t slot) { ++first_watch_[slot]; });
    }
    std::uint32_t sum = 0;
    for (std::uint32_t& first : first_watch_) {
        sum += first;
        first = sum;
    }
    watch_of_.resize(sum);
    for (std::uint32_t i = 0; i < watches_.size(); ++i) {
        each_slot(watches_[i], [&](std::uint32_t slot) { watch_of_[--first_watch_[slot]] = i; });
    }
}

/// Each contact of a struck body once: in a heap of thousands one is struck hundreds of times.
void ContactSolver::find_next_meetings() {
    meetings_.clear();
    std::sort(struck_.begin(), struck_.end());
    const auto end = std::unique(struck_.begin(), struck_.end());
    for (auto slot = struck_.begin(); slot != end; ++slot) {
        for (std::uint32_t k = first_watch_[*slot]; k < first_watch_[*slot + 1]; ++k) {
            if (!std::exchange(watches_[watch_of_[k]].listed, true)) {
                meetings_.push_back(watch_of_[k]);
            }
        }
    }
    std::erase_if(meetings_, [this](std::uint32_t i) {
        watches_[i].listed = false;
        watches_[i].time = meeting_time(watches_[i]);
        return watches_[i].time == kNoImpact;
    });
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
    const float size = size_of(w, at, m, blow);
    if (size > 0.0F) {
        delay_pulls(at, time);
    }
    const bool given = size > 0.0F && !makes_energy(before);
    if (!given) {
        take_back(at);
    }
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

/// Whether the blow left the bodies with more energy than they had; `before`: the share of this
/// substep's change of velocity that had not come yet. Where joints contradict each other their
/// pulls are all rounding.
bool ContactSolver::makes_energy(float before) const {
    float made = 0.0F;
    float moved = 0.0F;
    for (const auto& [slot, motion] : hit_) {
        const Row8 change = moving_.motion[slot] - motion;
        const Row8 gain = motion - moving_.start(slot);
        const Row8 mean = motion + 0.5F * change - before * gain;
        const Row8 push = moving_.momentum(slot, change);
        made += sum_of(push.at * mean.at);
        moved += sum_of(push.at * change.at);
    }
    return !(made <= kMostMade * moved);
}

void ContactSolver::take_back(const Single& at) {
    for (const auto& [slot, motion] : hit_) {
        moving_.motion[slot] = motion;
    }
    joints_.restore_impulses(at.a, at.b);
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
