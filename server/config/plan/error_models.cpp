#include "server/config/plan/error_models.h"

#include "server/physics/solver/contact_solver.h"
#include "server/physics/solver/substep_policy.h"
#include "shared/wire/quantize.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::config {

namespace {

/// Places nearer than this are one column of a pile, m.
constexpr double kColumn_m = 0.1;

}  // namespace

void PileCount::add(double x_m, double z_m) {
    int& column = columns_[{std::lround(x_m / kColumn_m), std::lround(z_m / kColumn_m)}];
    most_ = std::max(most_, ++column);
}

double Pile::load_mps2() const {
    return gravity_mps2 * std::max(bodies, 2 * (bodies - 1));
}

double contact_give_m(double load_mps2, double substep_s) {
    const double rate = 2.0 * std::numbers::pi * static_cast<double>(physics::kContactRateShare);
    const double share_s = substep_s / rate;
    return load_mps2 * share_s * share_s;
}

int substeps_for(double budget_m, double load_mps2, double tick_s) {
    const double rate = 2.0 * std::numbers::pi * static_cast<double>(physics::kContactRateShare);
    const double need =
        tick_s * std::max(std::sqrt(load_mps2 / budget_m) / rate,
                          1.0 / static_cast<double>(physics::SubstepPolicy::kLongestSubstep));
    int substeps = 1;
    while (substeps < physics::SubstepPolicy::kMostSubsteps && substeps < need) {
        substeps *= 2;
    }
    return substeps;
}

double pile_sag_m(const Pile& pile, int substeps, double tick_s) {
    // n on the ground and 2 (n - k) at the k-th contact above it add up to n^2.
    return kFlatShare *
           contact_give_m(pile.gravity_mps2 * pile.bodies * pile.bodies, tick_s / substeps);
}

double publications_ps(double bound, double missed_per_s2, double heartbeat_s, double tick_s) {
    const double lasts = std::sqrt(2.0 * bound / missed_per_s2);
    return 1.0 / std::clamp(lasts, tick_s, std::max(heartbeat_s, tick_s));
}

double orientation_quantum_rad(int bits) {
    wire::Quantization q;
    q.orientation_bits = bits;
    q.yaw_bits = bits;
    return static_cast<double>(
        std::max(q.orientation_quantum_rad(false), q.orientation_quantum_rad(true)));
}

}  // namespace zoned::config
