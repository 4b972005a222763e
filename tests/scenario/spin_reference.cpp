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
    const auto steps = static_cast<long>(std::lround(seconds / kStep));
    for (long i = 0; i < steps; ++i) {
        const Vec3d k1 = rate(w);
        const Vec3d k2 = rate(w + 0.5 * kStep * k1);
        const Vec3d k3 = rate(w + 0.5 * kStep * k2);
        const Vec3d k4 = rate(w + kStep * k3);
        const Vec3d next = w + kStep / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        result.flips += (next.y() > 0.0) != (w.y() > 0.0) ? 1 : 0;
        w = next;
    }
    result.omega_end = w;
    result.energy_drift = energy(w) / energy(omega) - 1.0;
    return result;
}

}  // namespace zoned::scenario
