// Adaptation: parameters that follow the players' performance, slowly and within a cap.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace zoned::ai::learning {

/// RubberBand keeps a chase or a race close. The one behind becomes a little faster, the one ahead
/// a little slower.
struct RubberBand {
    float gap_m = 8.0F;       ///< wanted distance, > 0
    float gain = 0.5F;        ///< change of the factor per gap missing or in excess, >= 0
    float least = 0.8F;       ///< lower cap on the factor, > 0, at most 1
    float most = 1.2F;        ///< upper cap on the factor, at least 1
    float rate_per_s = 0.1F;  ///< fastest change of the factor, > 0
    /// On a track: so many of its type, the nearest to the player, are held near; 0: all are.
    std::uint32_t rivals = 0;
};

/// The factor of speed after `dt` s at a distance of `gap_m`, m, from the prey; `factor` is the one
/// before. It stays within the caps for any input. If the gap is not a number it goes towards 1.
inline float banded(const RubberBand& band, float factor, float gap_m, float dt) {
    const float off = (gap_m - band.gap_m) / band.gap_m;
    float wish = 1.0F + band.gain * off;
    wish = std::isfinite(wish) ? std::clamp(wish, band.least, band.most) : 1.0F;
    const float before = std::isfinite(factor) ? std::clamp(factor, band.least, band.most) : 1.0F;
    const float step = std::isfinite(dt) ? std::max(0.0F, band.rate_per_s * dt) : 0.0F;
    return before + std::clamp(wish - before, -step, step);
}

/// On a track: the distance that banded() gets for a player `ahead_m` ahead along the track, m;
/// below 0: behind. Within gap_m on either side a follower goes at its own speed. Beyond, it slows
/// down where it leads and speeds up where it lags. With `keeps_off` it is one rival too many. It
/// then lets the player go, or draws away, up to twice gap_m.
///
/// In balance with a player at v times the follower's own speed, within the caps, a follower is
/// gap_m (1 + |v - 1| / gain) away, and one that keeps off is gap_m (2 - |v - 1| / gain) away. So
/// 1.5 gap_m part the two where no cap is farther than gain / 2 from 1. Source: Jimenez, "The Pure
/// Advantage: Advanced Racing Game AI", Gamasutra, 2009: groups of rivals at distances from the
/// player, each of which goes faster or slower towards its group's distance.
inline float gap_on_track(const RubberBand& band, float ahead_m, bool keeps_off) {
    const float apart = std::abs(ahead_m);
    const float pull =
        keeps_off ? -std::max(0.0F, 2.0F * band.gap_m - apart) : std::max(0.0F, apart - band.gap_m);
    return band.gap_m + (ahead_m < 0.0F ? -pull : pull);
}

/// A difficulty that follows how often players succeed. A success makes it harder by `step` times
/// the wanted share of failures. A failure makes it easier by `step` times the wanted share of
/// successes. So it settles where they succeed as often as wanted. Source: Kaernbach, "Simple
/// adaptive testing with the weighted up-down method", Perception & Psychophysics 49, 1991.
struct Staircase {
    float success = 0.6F;  ///< wanted share of successes, (0, 1)
    float step = 0.05F;    ///< > 0
    float least = 0.0F;    ///< lower cap
    float most = 1.0F;     ///< upper cap, >= least
};

/// The difficulty after an encounter; `level` is the one before. It stays within the caps for any
/// input.
inline float stepped(const Staircase& staircase, float level, bool player_succeeded) {
    const float before =
        std::isfinite(level) ? std::clamp(level, staircase.least, staircase.most) : staircase.least;
    const float change = player_succeeded ? staircase.step * (1.0F - staircase.success)
                                          : -staircase.step * staircase.success;
    return std::clamp(before + change, staircase.least, staircase.most);
}

}  // namespace zoned::ai::learning
