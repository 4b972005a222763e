// bound: the promised bound, a formula for the largest difference between a predicted state and the
// truth.
#pragma once

#include "client-sim/link/arrival_log.h"
#include "client-sim/view/world_info.h"

#include <limits>

namespace zoned::audit {

/// Inputs of the formula.
struct BoundInputs {
    double bound = 0.0;    ///< promised at the LOD, m (or rad)
    double quantum = 0.0;  ///< half a quantisation step along each axis, as a length (or angle)
    double age_s = 0.0;    ///< D: greatest age of updates
    /// Time since the truth last left the prediction from its newest publication; infinity: never.
    double since_breach_s = std::numeric_limits<double>::infinity();
};

/// allowed = bound + quantum + a_max D^2 / 2 + dv_max D, the last term only within D after a breach
/// (a sudden change about which the client cannot have an update yet). m.
double allowed_position_error(const BoundInputs& inputs, double a_max, double dv_max);

/// The same for orientation. A character may turn by any angle within D after a breach, anything
/// else may spin by at most `spin_max` more than predicted. rad, at most pi.
double allowed_orientation_error(const BoundInputs& inputs, bool character, double spin_max);

/// D of a view that displayed a tick `behind_s` after the server had it: the time that its updates
/// can lack. `now` is the age of updates when the tick was displayed, `then` at the tick itself. D
/// is zero once all packets up to the tick had come: both neighbours are known then. Where a packet
/// was lost around either, a later update may have replaced the update of a change, which then
/// never comes. So nothing is taken off.
double past_age_s(const link::UpdateAge& now, const link::UpdateAge& then, double behind_s);

/// The same where none of its updates was lost: UpdateAge::plain_s of both.
double past_plain_s(const link::UpdateAge& now, const link::UpdateAge& then, double behind_s);

/// Age of updates on a good network path: half its least round trip and a tick. Where the newest
/// update was lost, a round trip and a tick more. `spread_s`: spread of one-way delays by our own
/// link conditioner, which is no fault. s.
double usual_age_s(double least_rtt_s, double tick_s, bool loss, double spread_s);

/// True when updates are older than twice the usual age and three ticks: jitter and reordering
/// explain no more. Then a computer is starved, or a network path queues or breaks. The allowed
/// error grows with the square of that age, so a comparison says little.
bool is_stale(double age_s, double least_rtt_s, double tick_s, bool loss, double spread_s);

/// Index of the LOD promised at a horizontal distance.
std::size_t lod_at(const view::WorldInfo& world, double distance_m);

}  // namespace zoned::audit
