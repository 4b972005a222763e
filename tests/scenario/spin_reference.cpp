#include "tests/scenario/spin_reference.h"

#include <cmath>

namespace zoned::scenario {

SpinReference free_spin(const Vec3d& inertia, const Vec3d& omega, double seconds) {
    constexpr double kStep = 100e-6;
    const auto rate = [&inertia](const Vec3d& w) -> Vec3d {
        const Vec3d momentum = inertia.cwiseProduct(w);
        return momentum.cross(w).cwiseQuotient(inertia);
    };
    const auto energy = [&inertia](const Vec3d& w) {
        return 0.5 * w.dot(inertia.cwiseProduct(w));
    };
    SpinReference result;
    Vec3d w = omega;
    FlipCounter flips;
    flips.add(0.0, w.y());
    const auto steps = static_cast<long>(std::lround(seconds / kStep));
    for (long i = 0; i < steps; ++i) {
        const Vec3d k1 = rate(w);
        const Vec3d k2 = rate(w + 0.5 * kStep * k1);
        const Vec3d k3 = rate(w + 0.5 * kStep * k2);
        const Vec3d k4 = rate(w + kStep * k3);
        w += kStep / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        flips.add(static_cast<double>(i + 1) * kStep, w.y());
    }
    result.flips = flips.flips();
    result.interval_s = flips.interval_s();
    result.omega_end = w;
    result.energy_drift = energy(w) / energy(omega) - 1.0;
    return result;
}

void FlipCounter::add(double t, double value) {
    if (started_ && (value > 0.0) != (value_ > 0.0)) {
        last_ = t_ + (t - t_) * value_ / (value_ - value);
        if (flips_++ == 0) {
            first_ = last_;
        }
    }
    started_ = true;
    t_ = t;
    value_ = value;
}

double FlipCounter::interval_s() const {
    return flips_ > 1 ? (last_ - first_) / (flips_ - 1) : 0.0;
}

}  // namespace zoned::scenario
