#include "server/physics/integrator/stability.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>

namespace zoned::physics {

namespace {

/// Rounding of a spectral radius that is one.
constexpr double kGrowthRounding = 1.0e-13;

/// Trace and determinant of the matrix that takes (x, h v) over a step.
struct StepMatrix {
    double trace;
    double determinant;

    /// Both eigenvalues within the unit circle (Jury's criterion).
    [[nodiscard]] bool bounded() const {
        return determinant <= 1.0 + kGrowthRounding &&
               std::abs(trace) <= 1.0 + determinant + kGrowthRounding;
    }
};

/// velocity_verlet.h written out, with w = omega h and z the damping ratio.
StepMatrix velocity_verlet_matrix(double w, double z) {
    const double xx = 1.0 - 0.5 * w * w;
    const double xv = 1.0 - z * w;
    const double vx = w * w * (-1.0 + 0.25 * w * w + z * w);
    const double vv = 1.0 - 2.0 * z * w - 0.5 * w * w + 0.5 * z * w * w * w + 2.0 * z * z * w * w;
    return {xx + vv, xx * vv - xv * vx};
}

/// The polynomial by which a Runge-Kutta method multiplies exp's argument h lambda; coefficients by
/// ascending powers, from the first on (the zeroth is one).
template <std::size_t kDegree>
double growth(const std::array<double, kDegree>& coefficients, std::complex<double> at) {
    std::complex<double> sum = 0.0;
    for (std::size_t i = kDegree; i-- > 0;) {
        sum = (sum + coefficients[i]) * at;
    }
    return std::abs(1.0 + sum);
}

template <std::size_t kDegree>
bool runge_kutta_bounded(const std::array<double, kDegree>& coefficients, double w, double z) {
    const std::complex<double> root = std::sqrt(std::complex<double>(z * z - 1.0, 0.0));
    return growth(coefficients, w * (-z + root)) <= 1.0 + kGrowthRounding &&
           growth(coefficients, w * (-z - root)) <= 1.0 + kGrowthRounding;
}

constexpr std::array<double, 2> kRk2Growth{1.0, 0.5};
constexpr std::array<double, 4> kRk4Growth{1.0, 0.5, 1.0 / 6, 1.0 / 24};
/// The result of order 5; its sixth stage gives the last term.
constexpr std::array<double, 6> kPairGrowth{1.0, 0.5, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 600};

/// The smallest omega h, above which `bounded(omega h)` fails first.
template <class Bounded>
double first_failure(const Bounded& bounded, double z) {
    constexpr double kFactor = 1.01;
    double upper = 1.0e-4 / (1.0 + z);
    while (bounded(upper)) {
        upper *= kFactor;
    }
    double lower = upper / kFactor;
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (lower + upper);
        (bounded(middle) ? lower : upper) = middle;
    }
    return lower;
}

double explicit_euler_limit(double z) {
    return z <= 1.0 ? 2.0 * z : 2.0 * (z - std::sqrt(z * z - 1.0));
}

/// The largest omega h; zero: none, infinity: any.
double largest_product(IntegratorKind kind, double z) {
    switch (kind) {
        case IntegratorKind::kExplicitEuler:
            return explicit_euler_limit(z);
        case IntegratorKind::kImplicitEuler:
            return StabilityLimit::kAny;
        case IntegratorKind::kSemiImplicitEuler:
            return 2.0 * (std::sqrt(1.0 + z * z) - z);
        case IntegratorKind::kVerlet:
            return 2.0 * (std::sqrt(1.0 + 4.0 * z * z) - 2.0 * z);
        case IntegratorKind::kVelocityVerlet:
            return first_failure([z](double w) { return velocity_verlet_matrix(w, z).bounded(); },
                                 z);
        case IntegratorKind::kRk2:
            // Without damping it grows by (omega h)^4 / 8 a step, which drowns in rounding.
            return z == 0.0
                       ? 0.0
                       : first_failure(
                             [z](double w) { return runge_kutta_bounded(kRk2Growth, w, z); }, z);
        case IntegratorKind::kRk4:
            return first_failure([z](double w) { return runge_kutta_bounded(kRk4Growth, w, z); },
                                 z);
        case IntegratorKind::kAdaptive:
            return first_failure([z](double w) { return runge_kutta_bounded(kPairGrowth, w, z); },
                                 z);
        case IntegratorKind::kDefault:
            break;
    }
    return z > 0.0 ? std::min(4.0 * z, 1.0 / z) : 0.0;
}

/// The largest drag x h.
double largest_decay(IntegratorKind kind) {
    const auto on_axis = [](const auto& coefficients) {
        return first_failure(
            [&](double s) { return growth(coefficients, -s) <= 1.0 + kGrowthRounding; }, 0.0);
    };
    switch (kind) {
        case IntegratorKind::kExplicitEuler:
        case IntegratorKind::kSemiImplicitEuler:
        case IntegratorKind::kVelocityVerlet:  // its velocity is that of the midpoint rule
        case IntegratorKind::kRk2:
            return 2.0;
        case IntegratorKind::kVerlet:
            return 1.0;
        case IntegratorKind::kRk4:
            return on_axis(kRk4Growth);
        case IntegratorKind::kAdaptive:
            return on_axis(kPairGrowth);
        case IntegratorKind::kImplicitEuler:
        case IntegratorKind::kDefault:
            break;
    }
    return StabilityLimit::kAny;
}

StabilityLimit limit_of(IntegratorKind kind, double longest) {
    return {kind == IntegratorKind::kAdaptive ? StabilityLimit::kAny : longest, longest};
}

}  // namespace

StabilityLimit stability_limit(IntegratorKind kind, double omega, double damping_ratio) {
    ZONED_ASSERT(omega > 0.0 && damping_ratio >= 0.0, "a spring pulls back and a damper brakes");
    return limit_of(kind, largest_product(kind, damping_ratio) / omega);
}

StabilityLimit drag_limit(IntegratorKind kind, double drag) {
    ZONED_ASSERT(drag > 0.0, "a drag brakes");
    return limit_of(kind, largest_decay(kind) / drag);
}

std::string why_unstable(IntegratorKind kind, double omega, double damping_ratio, double h) {
    const StabilityLimit limit = stability_limit(kind, omega, damping_ratio);
    if (limit.stable(h)) {
        return {};
    }
    std::array<char, 240> text{};
    std::snprintf(text.data(),
                  text.size(),
                  "%s: a spring of %g rad/s with damping ratio %g is stable for steps up to %g s, "
                  "not for %g s (omega h = %.4g, at most %.4g)",
                  name_of(kind),
                  omega,
                  damping_ratio,
                  limit.step_s,
                  h,
                  omega * h,
                  omega * limit.step_s);
    return text.data();
}

std::string why_unstable_drag(IntegratorKind kind, double drag, double h) {
    if (!(drag > 0.0) || drag_limit(kind, drag).stable(h)) {
        return {};
    }
    const double longest = drag_limit(kind, drag).step_s;
    std::array<char, 200> text{};
    std::snprintf(text.data(),
                  text.size(),
                  "%s: a drag of %g 1/s is stable for steps up to %g s, not for %g s (drag x h = "
                  "%.4g, at most %.4g)",
                  name_of(kind),
                  drag,
                  longest,
                  h,
                  drag * h,
                  drag * longest);
    return text.data();
}

std::string why_unfit_integrator(IntegratorKind kind) {
    if (static_cast<std::size_t>(kind) >= kIntegratorKinds.size()) {
        return "unknown integrator";
    }
    if (kind == IntegratorKind::kVerlet) {
        return "verlet: goes by the positions of earlier steps, which impulses and contacts make "
               "void; started anew in each step it is velocity_verlet: take that";
    }
    return {};
}

}  // namespace zoned::physics
