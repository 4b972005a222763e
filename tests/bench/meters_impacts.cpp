// Meters of chains of impacts: a row and a break against the exact solution, and a cradle.
#include "tests/bench/motion_sums.h"
#include "tests/bench/physics_meters.h"
#include "tests/scenario/exact_impacts.h"
#include "tests/scenario/impact_scenes.h"

#include <algorithm>
#include <cmath>

namespace zoned::bench {

namespace {

double kinetic(std::span<const scenario::FlyingBall> balls) {
    double sum = 0.0;
    for (const scenario::FlyingBall& ball : balls) {
        sum += 0.5 * ball.mass * ball.velocity.squaredNorm();
    }
    return sum;
}

/// A row: error = largest error of a speed, over the first ball's speed. A break, which no engine
/// follows ball by ball: error = kinetic energy over the exact one, less one.
class ImpactMeter : public Meter {
  public:
    ImpactMeter(const scenario::Description& description, bool speeds)
        : description_(description),
          start_(sums_at_start(description)),
          speeds_(speeds) {}

    void after_step(const Simulator& simulator) override {
        const MotionSums now = sums_now(description_, simulator);
        energy_ = std::max(energy_, now.kinetic);
        ++steps_;
    }

    void finish(const Simulator& simulator, Row& row) override {
        std::vector<scenario::FlyingBall> balls;
        for (const scenario::Body& body : description_.bodies) {
            balls.push_back({body.pose.position, body.velocity, body.solid.radius, body.mass});
        }
        const std::vector<scenario::FlyingBall> exact =
            scenario::fly(balls, description_.bodies.front().restitution, steps_ * description_.dt);
        const double first = balls.front().velocity.norm();
        double off = 0.0;
        for (std::size_t i = 0; i < exact.size(); ++i) {
            const double error = (simulator.motion(i).velocity - exact[i].velocity).norm() / first;
            off = std::isfinite(error) ? std::max(off, error) : INFINITY;
        }
        const MotionSums now = sums_now(description_, simulator);
        row.error = speeds_ ? off : now.kinetic / kinetic(exact) - 1.0;
        row.error_unit = "1";
        row.metric("speed_error", off);
        row.metric("energy_error", (now.kinetic - kinetic(exact)) / start_.kinetic);
        row.metric("energy_gain_percent", 100.0 * (energy_ / start_.kinetic - 1.0));
        row.metric("momentum_error",
                   (now.momentum - start_.momentum).norm() / start_.momentum_size);
    }

  private:
    scenario::Description description_;
    MotionSums start_;
    bool speeds_;
    double energy_ = 0.0;
    int steps_ = 0;
};

class CradleMeter : public Meter {
  public:
    explicit CradleMeter(const scenario::Description& description)
        : description_(description),
          start_(height_energy(sums_at_start(description))) {}

    void after_step(const Simulator& simulator) override {
        largest_ = std::max(largest_, height_energy(sums_now(description_, simulator)));
        gap_ = std::max(gap_, joint_errors(description_, simulator).gap_m);
    }

    void finish(const Simulator& simulator, Row& row) override {
        const MotionSums now = sums_now(description_, simulator);
        row.error = now.not_finite > 0 ? INFINITY : height_energy(now) / start_ - 1.0;
        row.error_unit = "1";
        row.metric("energy_gain_percent", 100.0 * (largest_ / start_ - 1.0));
        row.metric("gap_m_max", gap_);
    }

  private:
    /// The balls hang at y = 0.
    static double height_energy(const MotionSums& sums) { return sums.kinetic + sums.potential; }

    scenario::Description description_;
    double start_;
    double largest_ = 0.0;
    double gap_ = 0.0;
};

}  // namespace

std::unique_ptr<Meter> row_meter(const scenario::Description& description) {
    return std::make_unique<ImpactMeter>(description, true);
}

std::unique_ptr<Meter> break_meter(const scenario::Description& description) {
    return std::make_unique<ImpactMeter>(description, false);
}

std::unique_ptr<Meter> cradle_meter(const scenario::Description& description) {
    return std::make_unique<CradleMeter>(description);
}

}  // namespace zoned::bench
