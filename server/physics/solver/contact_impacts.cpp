// Impacts: the part of the contact solver that finds when surfaces meet within a substep, one after
// the other. How they bounce is in contact_blows.cpp.
#include "server/physics/solver/contact_lane.h"
#include "server/physics/solver/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::physics {

namespace {

/// Impacts of one substep that follow from each other, at most: what is left is the solver's.
constexpr int kMostImpactRounds = 64;
/// Steps to the time of a meeting.
constexpr int kTimeSteps = 6;
/// A bounce that lasts for fewer steps than this is none, twice over: a contact under the pull g
/// bounces from kShortBounce g dt on.
constexpr float kShortBounce = 3.0F;
/// Slower impacts never bounce, m/s: rounding.
constexpr float kSlowestBounce = 0.01F;
/// Contacts that one thread watches at a time.
constexpr std::size_t kWatchGrain = 64;

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
    const Approach at(w, moving_, 0.0F);
    const Motions m{moving_.motion[at.a], moving_.motion[at.b]};
    const Motions gain{m.a - moving_.start(at.a), m.b - moving_.start(at.b)};
    const float weight = std::abs(at.normal.dot(parameters_.gravity));
    float earliest = kNoImpact;
    for (std::size_t k = 0; k < w.count; ++k) {
        const SolverWatch::Point& p = w.points[k];
        const float gained = at.speed(gain, p.arm);
        const float gap = at.gap(p.separation, p.arm);
        const Meeting meeting = meeting_of(gap, at.speed(m, p.arm) - kept_ * gained, gained / h_);
        if (meeting.speed > bounce_speed(std::max(weight, -gained / h_))) {
            earliest = std::min(earliest, meeting.time);
        }
    }
    return earliest < h_ ? earliest : kNoImpact;
}

/// The same where bodies turn and slide on the way, which a straight line to the meeting leaves
/// out: Newton's method from there.
float ContactSolver::arrival(const SolverWatch& w, float time) const {
    for (int i = 0; i < kTimeSteps && time < h_; ++i) {
        const Approach at(w, moving_, time);
        const Motions m = motions_at(at, time);
        float wait = kNoImpact;
        for (std::size_t k = 0; k < w.count; ++k) {
            const SolverWatch::Point& p = w.points[k];
            const float gap = at.gap(p.separation, p.arm);
            if (gap <= kMeets) {
                return time;
            }
            const float speed = -at.speed(m, p.arm);
            wait = speed > 0.0F ? std::min(wait, gap / speed) : wait;
        }
        time += wait;
    }
    return kNoImpact;
}

/// Velocities `time` into the substep.
ContactSolver::Motions ContactSolver::motions_at(const Approach& at, float time) const {
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
                watch(i, lane, 0.0F);
            }
        }
    }
    first_watch_.assign(moving_.size() + 1, 0);
    const auto each_slot = [this](const SolverWatch& w, auto&& visit) {
        for (const std::uint32_t slot : {w.a, w.b}) {
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

}  // namespace zoned::physics
