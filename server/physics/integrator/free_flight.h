// Free flight: the centre of mass of a body or particle that nothing touches, through one step.
#pragma once

#include "server/physics/integrator/constant_acceleration.h"
#include "server/physics/integrator/integrator_kind.h"
#include "shared/math/types.h"

namespace zoned::physics {

inline constexpr int kMostFlightPieces = 64;  ///< of a step

/// free_flight for all kinds but kDefault.
bool free_flight_by(IntegratorKind kind,
                    const FreeFall<float, 3>& fall,
                    float dt,
                    Vec3& position,
                    Vec3& velocity);

/// Carries a position (m) and velocity (m/s) over dt seconds of constant pull and linear drag. Each
/// step is a motion of its own: contacts and impulses come in between, so that nothing is
/// remembered from one to the next. kVerlet is none of these methods (see why_unfit_integrator).
/// kAdaptive works in doubles, to 1e-6 of its result. False where it gave up: then the state is of
/// no use.
inline bool free_flight(IntegratorKind kind,
                        const FreeFall<float, 3>& fall,
                        float dt,
                        Vec3& position,
                        Vec3& velocity) {
    if (kind == IntegratorKind::kDefault) {
        ConstantAcceleration<Vec3>().step(position, velocity, 0.0F, dt, fall);
        return true;
    }
    return free_flight_by(kind, fall, dt, position, velocity);
}

/// The same in `pieces` equal pieces, from 1 to kMostFlightPieces. One piece gives the very bits of
/// the above. The paths of several are summed up before the position is rounded to its own
/// fineness.
bool free_flight_in(int pieces,
                    IntegratorKind kind,
                    const FreeFall<float, 3>& fall,
                    float dt,
                    Vec3& position,
                    Vec3& velocity);

}  // namespace zoned::physics
