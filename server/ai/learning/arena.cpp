#include "server/ai/learning/arena.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::ai::learning {

namespace {

constexpr float kArenaStep = 0.1F;  // s
constexpr int kScored = 50;
constexpr int kJudged = 4;

/// Uniform in a disc: rejection from the square needs no trigonometry.
Vec2 point_in_disc(core::Rng& rng, float radius) {
    Vec2 point = Vec2::Zero();
    do {
        point.x() = rng.range(-1.0F, 1.0F);
        point.y() = rng.range(-1.0F, 1.0F);
    } while (point.squaredNorm() > 1.0F);
    return point * radius;
}

Vec2 limited(const Vec2& v, float length) {
    const float norm = v.norm();
    return norm > length ? Vec2(v * (length / norm)) : v;
}

/// One goal after the other.
class Goal {
  public:
    Goal(const Arena& arena, core::Rng& rng) : arena_(arena), rng_(rng) { move_elsewhere(); }

    void move_elsewhere() {
        at = point_in_disc(rng_, arena_.goal_reach_m);
        next_ = point_in_disc(rng_, arena_.goal_reach_m);
    }

    void step() {
        const Vec2 way = next_ - at;
        if (way.norm() <= arena_.goal_speed * kArenaStep) {
            next_ = point_in_disc(rng_, arena_.goal_reach_m);
        }
        velocity = limited(way / kArenaStep, arena_.goal_speed);
        at += velocity * kArenaStep;
    }

    Vec2 at = Vec2::Zero();
    Vec2 velocity = Vec2::Zero();

  private:
    const Arena& arena_;
    core::Rng& rng_;
    Vec2 next_ = Vec2::Zero();
};

double mean_points(const Arena& arena, const Policy* policy, core::Rng rng, int episodes) {
    double points = 0.0;
    for (int e = 0; e < episodes; ++e) {
        points += play(arena, policy, core::Rng(rng.next(), 1)).points();
    }
    return points / episodes;
}

}  // namespace

Policy arena_policy(const Arena& arena, NeuralNetwork network) {
    Policy policy;
    policy.name = "arena";
    const float scale = 1.0F / arena.wall_m;
    policy.inputs = {{Ego::kTargetDistance, "", scale, 0.0F},
                     {Ego::kHomeAlong, "", scale, 0.0F},
                     {Ego::kHomeAcross, "", scale, 0.0F},
                     {Ego::kHomeDistance, "", 4.0F * scale, -3.0F},  // from -1 to 1 near the wall
                     {Ego::kTargetSpeedAcross, "", 1.0F / arena.speed, 0.0F}};
    policy.network = std::move(network);
    return policy;
}

ArenaResult play(const Arena& arena, const Policy* policy, core::Rng rng) {
    std::array<float, kMaxValues> values;
    ArenaResult result;
    Goal goal(arena, rng);
    Situation s;
    s.has_target = true;
    s.here = point_in_disc(rng, 0.5F * arena.wall_m);
    const int steps = static_cast<int>(arena.seconds / kArenaStep);
    for (int step = 0; step < steps; ++step) {
        s.target = goal.at;
        s.target_velocity = goal.velocity;
        const Vec2 desired =
            policy != nullptr ? decide(*policy, s, {}, values).move : facing_of(Facing::kTarget, s);
        s.velocity += limited(desired * arena.speed - s.velocity, arena.acceleration * kArenaStep);
        s.here += s.velocity * kArenaStep;
        if (s.here.norm() >= arena.wall_m) {
            s.here = limited(s.here, arena.wall_m);
            result.wall_s += kArenaStep;
        }
        goal.step();
        const float off = (goal.at - s.here).norm();
        result.mean_off_m += off / static_cast<float>(steps);
        if (off < arena.touch_m) {
            ++result.reached;
            goal.move_elsewhere();
        }
    }
    return result;
}

double ArenaTask::fitness(const NeuralNetwork& network, std::uint64_t course) const {
    const Policy policy = arena_policy(arena_, network);
    core::Rng rng(course, 0xA2E4A);
    double sum = 0.0;
    for (int e = 0; e < kJudged; ++e) {
        const ArenaResult result = play(arena_, &policy, core::Rng(rng.next(), 1));
        sum += result.points() - 0.1 * static_cast<double>(result.mean_off_m);
    }
    // A walker is at the wall at most for a whole episode, and at most both radii off.
    const double worst = 2.0 * static_cast<double>(arena_.seconds) +
                         0.1 * static_cast<double>(arena_.wall_m + arena_.goal_reach_m);
    return std::max(0.0, sum / kJudged + worst);
}

double ArenaTask::score(const NeuralNetwork& network, std::uint64_t course) const {
    const Policy policy = arena_policy(arena_, network);
    return mean_points(arena_, &policy, core::Rng(course, 0x7E57), kScored);
}

double straight_score(const Arena& arena, std::uint64_t course) {
    return mean_points(arena, nullptr, core::Rng(course, 0x7E57), kScored);
}

double ArenaTask::solved_at() const {
    return straight_score(arena_, 1);
}

}  // namespace zoned::ai::learning
