// Particle choice: the pieces a tick in which a system's particles move within a budget.
#pragma once

#include "server/physics/method_selection/flight_choice.h"
#include "server/physics/particles/particle_system.h"

#include <array>

namespace zoned::physics::method_selection {

inline constexpr std::array kParticlePieces{1, 2, 4, 8, 16, 32, 64};

/// The air that particles of a system fly through. Gusts are left out: they are no less wind for
/// being computed in longer steps.
Flight flight_of(const ParticleSystemDef& def, double fastest);

/// Largest distance, m, of the system's own particles from the exact path, at the end of any tick
/// within budget.seconds. The particles meet nothing; they start at rest, and thrown at `fastest`
/// m/s.
double particle_error(const ParticleSystemDef& def,
                      int pieces,
                      double fastest,
                      const FlightBudget& budget);

/// The fewest pieces that keep the budget. Particles know one
/// method: semi-implicit Euler, the drag taken implicitly, which is stable for any step.
MethodChoice choose_particle_pieces(const ParticleSystemDef& def,
                                    double fastest,
                                    const FlightBudget& budget);

}  // namespace zoned::physics::method_selection
