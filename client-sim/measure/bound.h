// The promised bound: by how much a predicted state may differ from the truth, as a formula.
#pragma once

#include "client-sim/link/arrival_log.h"
#include "client-sim/view/world_info.h"

#include <limits>

namespace zoned::measure {

/// What the formula depends on.
struct BoundInputs {
    double bound = 0.0;    ///< promised at the LOD, m (or rad)
    double quantum = 0.0;  ///< half a quantisation step along each axis, as a length (or angle)
    double age_s = 0.0;    ///< D: how old news can be
    /// Time since the truth last left what its newest publication predicted; infinity: never.
    double since_breach_s = std::numeric_limits<double>::infinity();
};

/// allowed = bound + quantum + a_max D^2 / 2 + dv_max D, the last term only within D after a breach
/// (a sudden change that the client cannot have heard of yet). m.
double allowed_position_error(const BoundInputs& inputs, double a_max, double dv_max);

/// Orientation likewise. No type declares how fast it may turn, so: a character turns where it
/// likes (any angle within D after a breach), a prop spins by at most kMaxSpinRps more than it was
/// predicted to. rad, at most pi.
double allowed_orientation_error(const BoundInputs& inputs, bool character);

inline constexpr double kMaxSpinRps = 40.0;

/// D of a view that displayed a tick `behind_s` after the server had it: what old news can be short
/// of. `now` is the age of news when the tick was displayed, `then` at the tick itself. Zero once
/// all that was sent up to the tick had come (both neighbours are known then); where a packet was
/// lost around either, news of a change may have been replaced by that of a later one and never
/// come, so nothing is taken off.
double past_age_s(const link::UpdateAge& now, const link::UpdateAge& then, double behind_s);

/// Likewise where nothing of it was lost: UpdateAge::plain_s of both.
double past_plain_s(const link::UpdateAge& now, const link::UpdateAge& then, double behind_s);

/// How old news is on a path that works: half its least round trip and a tick; where the newest was
/// lost, a round trip and a tick more. `spread_s`: by how much a link conditioner of our own makes
/// one-way delays differ, which is no fault of anybody's. s.
double usual_age_s(double least_rtt_s, double tick_s, bool loss, double spread_s);

/// True when news is older than twice the usual age and three ticks: jitter and reordering explain
/// no more. Then a machine is starved or a path queues or breaks, the allowed error grows with the
/// square of that age, and a comparison says little.
bool is_stale(double age_s, double least_rtt_s, double tick_s, bool loss, double spread_s);

/// Index of the LOD promised at a horizontal distance.
std::size_t lod_at(const view::WorldInfo& world, double distance_m);

}  // namespace zoned::measure
