// Flight choice: the integrator and its pieces a tick that carry free flight within a budget.
#pragma once

#include "server/physics/integrator/integrator_kind.h"
#include "server/physics/method_selection/method_choice.h"
#include "shared/math/types.h"

#include <span>
#include <string>
#include <vector>

namespace zoned::physics::method_selection {

/// One kind of free flight: v' = gravity - (linear_drag + quadratic_drag |v - wind|) (v - wind).
struct Flight {
    std::string name;  ///< for messages
    Vec3d gravity = Vec3d::Zero();
    double linear_drag = 0.0;     ///< 1/s, >= 0
    double quadratic_drag = 0.0;  ///< 1/m, >= 0
    Vec3d wind = Vec3d::Zero();   ///< m/s
    double fastest = 0.0;         ///< m/s, >= 0: the launch at 45 degrees; another is from rest

    /// The largest rate at which a small change of velocity dies off, 1/s.
    [[nodiscard]] double steepest_drag() const;
};

struct FlightBudget {
    double error_m = 0.0;        ///< at any tick
    double seconds = 2.0;        ///< > 0
    double tick_s = 1.0 / 30.0;  ///< > 0
};

/// Numbers of pieces that are tried.
inline constexpr std::array kFlightPieces{1, 2, 4, 8};

/// Which methods are tried where none is named.
inline constexpr std::array kFlightMethods{IntegratorKind::kDefault,
                                           IntegratorKind::kExplicitEuler,
                                           IntegratorKind::kSemiImplicitEuler,
                                           IntegratorKind::kVelocityVerlet,
                                           IntegratorKind::kRk2,
                                           IntegratorKind::kImplicitEuler,
                                           IntegratorKind::kRk4,
                                           IntegratorKind::kAdaptive};

/// Ends of ticks on the exact path from the origin with `velocity`, m/s.
std::vector<Vec3d> exact_path(const Flight& flight,
                              const Vec3d& velocity,
                              double tick_s,
                              int ticks);

/// A launch at 45 degrees at the fastest speed.
Vec3d launch_of(const Flight& flight);

/// Ticks within the time of a budget, at least one.
int ticks_of(const FlightBudget& budget);

/// Why a method in so many pieces a tick cannot bear a flight's drag; empty where it can.
std::string why_unstable(IntegratorKind kind, int pieces, const Flight& flight, double tick_s);

/// Largest distance, m, at the end of any tick within `seconds`, of the engine's own flight in
/// floats (free_flight_in; of the same methods on the whole force where drag is quadratic: the
/// default then takes it implicitly with the speed that a piece begins with, as the particle stage
/// does) from the exact path: the closed solution where drag is linear, the adaptive pair at 1e-9
/// where it is not. Begins at the zone's origin: a place 1 km off rounds by up to 3e-5 m more.
double flight_error(IntegratorKind kind,
                    int pieces,
                    const Flight& flight,
                    const FlightBudget& budget);

/// The cheapest of `methods` that keeps the budget on each of the flights (not empty). Codes of
/// candidates are IntegratorKinds.
MethodChoice choose_flight(std::string subject,
                           std::span<const Flight> flights,
                           const FlightBudget& budget,
                           std::span<const IntegratorKind> methods = kFlightMethods);

}  // namespace zoned::physics::method_selection
