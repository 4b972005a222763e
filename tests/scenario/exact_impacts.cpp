#include "tests/scenario/exact_impacts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace zoned::scenario {

namespace {

constexpr double kRests = 1e-10;  // m/s
constexpr int kMostEvents = 1'000'000;
constexpr double kNever = std::numeric_limits<double>::infinity();

/// Seconds until the two touch while they approach.
double time_to_touch(const FlyingBall& a, const FlyingBall& b) {
    const Vec3d x = b.position - a.position;
    const Vec3d v = b.velocity - a.velocity;
    const double closing = -x.dot(v);
    if (closing <= kRests * x.norm()) {
        return kNever;
    }
    const double reach = a.radius + b.radius;
    const double gap = x.squaredNorm() - reach * reach;
    const double discriminant = closing * closing - v.squaredNorm() * gap;
    if (discriminant < 0.0) {
        return kNever;
    }
    // The smaller root of |x + v t| = reach, without cancellation.
    return std::max(gap / (closing + std::sqrt(discriminant)), 0.0);
}

void collide(FlyingBall& a, FlyingBall& b, double restitution) {
    const Vec3d normal = (b.position - a.position).normalized();
    const double closing = normal.dot(a.velocity - b.velocity);
    const double impulse = (1.0 + restitution) * closing / (1.0 / a.mass + 1.0 / b.mass);
    a.velocity -= impulse / a.mass * normal;
    b.velocity += impulse / b.mass * normal;
}

}  // namespace

std::vector<FlyingBall> fly(std::span<const FlyingBall> start, double restitution, double seconds) {
    std::vector<FlyingBall> balls(start.begin(), start.end());
    double left = seconds;
    for (int event = 0; event < kMostEvents; ++event) {
        double soonest = kNever;
        std::size_t first = 0;
        std::size_t second = 0;
        for (std::size_t i = 0; i < balls.size(); ++i) {
            for (std::size_t k = i + 1; k < balls.size(); ++k) {
                const double t = time_to_touch(balls[i], balls[k]);
                if (t < soonest) {
                    soonest = t;
                    first = i;
                    second = k;
                }
            }
        }
        const double step = std::min(soonest, left);
        for (FlyingBall& ball : balls) {
            ball.position += step * ball.velocity;
        }
        left -= step;
        if (soonest == kNever || left <= 0.0) {
            return balls;
        }
        collide(balls[first], balls[second], restitution);
    }
    throw std::runtime_error("the balls collide without end");
}

}  // namespace zoned::scenario
