// Sequential collision impulses.
#include "server/physics/solver_variants/collision_response.h"
#include "server/physics/solver_variants/row_solvers/row_solvers.h"
#include "server/physics/solver_variants/rows/restitution.h"

namespace zoned::physics {

namespace {

/// True when the row closed and was pushed.
bool collide(RowSystem& s, std::uint32_t i, double h, double restitution_speed) {
    const double speed = s.speed(i);
    const double wanted = -s.bias[i];
    // A share of the rounding of the speeds: without it the last pushes would never end.
    constexpr double kStill = 1.0e-9;
    if (!(speed < wanted - kStill) || !(s.response[i] > 0.0)) {
        return false;
    }
    double bounce = wanted;
    if (speed < -restitution_speed && s.restitution[i] > 0.0) {
        // The speed includes the forces of the whole substep; the bounce needs the speed before it.
        bounce = bounce_speed(speed - s.pull[i] * h, s.gap[i], s.pull[i], s.restitution[i], h);
    }
    const double impulse = (std::max(bounce, wanted) - speed) / s.response[i];
    s.lambda[i] += impulse;
    s.push(i, impulse);
    return true;
}

}  // namespace

int respond_by_impulses(RowSystem& system, double h, double restitution_speed, int passes) {
    int pass = 0;
    for (bool any = true; any && pass < passes; ++pass) {
        any = false;
        for (const std::uint32_t row : system.order) {
            if (system.role[row] == RowRole::kNormal) {
                any |= collide(system, row, h, restitution_speed);
            } else {
                relax_row(system, row, 1.0);
                any |= system.role[row] == RowRole::kBounded;
            }
        }
    }
    return pass;
}

}  // namespace zoned::physics
