#include "client-sim/audit/bound.h"

#include <algorithm>
#include <numbers>

namespace zoned::audit {

namespace {

/// Ticks are compared as seconds: a little slack keeps "exactly D" on the right side.
constexpr double kSlackS = 1e-6;
constexpr double kAngleSlack = 1e-5;

bool breach_within(const BoundInputs& inputs) {
    return inputs.since_breach_s <= inputs.age_s + kSlackS;
}

}  // namespace

double allowed_position_error(const BoundInputs& inputs, double a_max, double dv_max) {
    const double d = inputs.age_s;
    const double sudden = breach_within(inputs) ? dv_max * d : 0.0;
    return inputs.bound + inputs.quantum + 0.5 * a_max * d * d + sudden;
}

double allowed_orientation_error(const BoundInputs& inputs, bool character, double spin_max) {
    double turn = 0.0;
    if (breach_within(inputs)) {
        turn = character ? std::numbers::pi : spin_max * inputs.age_s;
    }
    // Half a turn is the largest angle there is; the slack absorbs that angles are measured in
    // float.
    return std::min(std::numbers::pi + kAngleSlack, inputs.bound + inputs.quantum + turn);
}

double past_age_s(const link::UpdateAge& now, const link::UpdateAge& then, double behind_s) {
    if (now.loss || then.loss) {
        return std::max(now.age_s, then.age_s);
    }
    return now.delay_s <= behind_s + kSlackS ? 0.0 : std::max(0.0, now.age_s - behind_s);
}

double past_plain_s(const link::UpdateAge& now, const link::UpdateAge& then, double behind_s) {
    const link::UpdateAge heard{now.delay_s, now.plain_s, false, {}, true, now.plain_s};
    const link::UpdateAge before{then.delay_s, then.plain_s, false, {}, true, then.plain_s};
    return past_age_s(heard, before, behind_s);
}

double usual_age_s(double least_rtt_s, double tick_s, bool loss, double spread_s) {
    const double resend_s = least_rtt_s + 2.0 * spread_s + tick_s;
    return 0.5 * least_rtt_s + spread_s + tick_s + (loss ? resend_s : 0.0);
}

bool is_stale(double age_s, double least_rtt_s, double tick_s, bool loss, double spread_s) {
    return age_s > 2.0 * usual_age_s(least_rtt_s, tick_s, loss, spread_s) + 3.0 * tick_s;
}

std::size_t lod_at(const view::WorldInfo& world, double distance_m) {
    for (std::size_t i = 0; i + 1 < world.lods.size(); ++i) {
        if (distance_m <= static_cast<double>(world.lods[i].radius_m)) {
            return i;
        }
    }
    return world.lods.size() - 1;
}

}  // namespace zoned::audit
