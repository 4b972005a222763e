// Meters of conserved values: energy and angular momentum of a spin, energy of a chain.
#include "tests/bench/motion_sums.h"
#include "tests/bench/physics_meters.h"
#include "tests/scenario/spin_reference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::bench {

namespace {

/// Kinetic energy, J, and angular momentum about the centre, kg m2/s, world axes.
struct Turning {
    double energy = 0.0;
    Vec3d momentum = Vec3d::Zero();
    Vec3d body_spin = Vec3d::Zero();  ///< rad/s, body axes
};

Turning turning(const scenario::Body& body, const Motion& motion) {
    Turning t;
    const Vec3d inertia = body.mass * body.solid.inertia_per_mass();
    const auto& q = motion.pose.orientation;
    t.body_spin = q.conjugate() * motion.spin;
    const Vec3d momentum = inertia.cwiseProduct(t.body_spin);
    t.energy = 0.5 * t.body_spin.dot(momentum);
    t.momentum = q * momentum;
    return t;
}

double larger_size(double a, double b) {
    return std::abs(b) > std::abs(a) ? b : a;
}

class SpinMeter : public Meter {
  public:
    explicit SpinMeter(const scenario::Description& description) : description_(description) {
        Motion start;
        start.pose = body().pose;
        start.spin = body().spin;
        start_ = turning(body(), start);
        flips_.add(0.0, start_.body_spin.y());
    }

    void after_step(const Simulator& simulator) override {
        const Turning now = turning(body(), simulator.motion(0));
        energy_ = now.energy / start_.energy - 1.0;
        energy_largest_ = larger_size(energy_largest_, energy_);
        size_ = now.momentum.norm() / start_.momentum.norm() - 1.0;
        size_largest_ = larger_size(size_largest_, size_);
        const double sine = now.momentum.cross(start_.momentum).norm();
        direction_ = std::atan2(sine, now.momentum.dot(start_.momentum)) * 180.0 / std::numbers::pi;
        direction_largest_ = std::max(direction_largest_, direction_);
        flips_.add(++steps_ * description_.dt, now.body_spin.y());
    }

    void finish(const Simulator& /*simulator*/, Row& row) override {
        row.error = energy_largest_;
        row.error_unit = "1";
        row.metric("energy_drift_end", energy_);
        row.metric("momentum_size_drift_end", size_);
        row.metric("momentum_size_drift_largest", size_largest_);
        row.metric("direction_error_end_deg", direction_);
        row.metric("direction_error_largest_deg", direction_largest_);
        row.metric("flips", flips_.flips());
        row.metric("flip_interval_s", flips_.interval_s());
        const double seconds = steps_ * description_.dt;
        const scenario::SpinReference reference = scenario::free_spin(
            body().mass * body().solid.inertia_per_mass(), body().spin, seconds);
        row.metric("flips_reference", reference.flips);
        row.metric("flip_interval_reference_s", reference.interval_s);
    }

  private:
    [[nodiscard]] const scenario::Body& body() const { return description_.bodies.front(); }

    scenario::Description description_;
    Turning start_;
    double energy_ = 0.0;
    double energy_largest_ = 0.0;
    double size_ = 0.0;
    double size_largest_ = 0.0;
    double direction_ = 0.0;
    double direction_largest_ = 0.0;
    scenario::FlipCounter flips_;
    int steps_ = 0;
};

class ChainMeter : public Meter {
  public:
    explicit ChainMeter(const scenario::Description& description) : description_(description) {
        for (const scenario::Body& body : description.bodies) {
            // Falling from level to straight down turns at most this much into motion.
            scale_ += body.mass * 9.81 * body.pose.position.norm();
        }
    }

    void after_step(const Simulator& simulator) override {
        const MotionSums sums = sums_now(description_, simulator);
        const double energy = sums.kinetic + sums.potential;
        energy_ = energy / scale_;  // it is zero at the start: all bodies lie level with the origin
        energy_largest_ = larger_size(energy_largest_, energy_);
        const double gap = joint_errors(description_, simulator).gap_m;
        gap_ = gap;
        gap_largest_ = std::max(gap_largest_, gap);
        ++steps_;
        gap_sum_ += gap;
    }

    void finish(const Simulator& /*simulator*/, Row& row) override {
        row.error = gap_largest_;
        row.error_unit = "m";
        row.metric("gap_end_m", gap_);
        row.metric("gap_mean_m", gap_sum_ / std::max(steps_, 1));
        row.metric("energy_error_end", energy_);
        row.metric("energy_error_largest", energy_largest_);
    }

  private:
    scenario::Description description_;
    double scale_ = 0.0;
    double energy_ = 0.0;
    double energy_largest_ = 0.0;
    double gap_ = 0.0;
    double gap_largest_ = 0.0;
    double gap_sum_ = 0.0;
    int steps_ = 0;
};

}  // namespace

std::unique_ptr<Meter> spin_meter(const scenario::Description& description) {
    return std::make_unique<SpinMeter>(description);
}

std::unique_ptr<Meter> chain_meter(const scenario::Description& description) {
    return std::make_unique<ChainMeter>(description);
}

}  // namespace zoned::bench
