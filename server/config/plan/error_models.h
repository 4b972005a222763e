// Error models: how far off a world is, from its settings alone.
#pragma once

#include <map>
#include <utility>

namespace zoned::config {

/// A pile: `bodies` equal ones, one on the other, under gravity.
struct Pile {
    int bodies = 1;
    double gravity_mps2 = 9.81;

    /// Load of its most loaded contact: force times the inverse masses that it acts on, m/s2. The
    /// lowest body carries all on the ground; the contact above it acts on two bodies.
    [[nodiscard]] double load_mps2() const;
};

/// Counts the bodies of piles while their places come one by one.
class PileCount {
  public:
    void add(double x_m, double z_m);

    /// Of the tallest pile, at least 1.
    [[nodiscard]] int most() const { return most_; }

  private:
    std::map<std::pair<long, long>, int> columns_;  // bodies by their place
    int most_ = 1;
};

/// How far a contact gives under a load in substeps of `substep_s`, m: the spring that the solver
/// stands for it, of angular frequency 2 pi kContactRateShare / h on the effective mass
/// (server/physics/solver/substep_policy.h).
double contact_give_m(double load_mps2, double substep_s);

/// Substeps of a tick that the policy gives an island with that load, 1 to 64 in powers of two.
int substeps_for(double budget_m, double load_mps2, double tick_s);

/// A box that lies flat gives less than the formula: on four points, and damped. Measured on piles
/// of 1 to 8 cubes in 8 to 64 substeps, 0.42 to 0.44 of it.
inline constexpr double kFlatShare = 0.43;

/// How far the top of a pile of boxes is expected to sink in so many substeps a tick, m: the sum of
/// the gives below it, times kFlatShare.
double pile_sag_m(const Pile& pile, int substeps, double tick_s);

/// Publications of a moving entity a second. A prediction of first order that misses an
/// acceleration a is off by a t^2 / 2, so a bound b lasts sqrt(2 b / a); never longer than a
/// heartbeat, never shorter than a tick.
double publications_ps(double bound, double missed_per_s2, double heartbeat_s, double tick_s);

/// The acceleration that predictions of walkers miss on average, m/s2: they change direction now
/// and then. Set by hand; shares of a budget are compared by it, none is promised by it.
inline constexpr double kMissed_mps2 = 0.5;

/// Largest angle between an orientation and its smallest-three form in so many bits a component,
/// rad.
double orientation_quantum_rad(int bits);

}  // namespace zoned::config
