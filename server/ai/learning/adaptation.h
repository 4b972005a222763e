// Adaptation: parameters that follow what players do, slowly and within a cap.
#pragma once

#include <algorithm>
#include <cmath>

namespace zoned::ai::learning {

/// Keeps a chase or a race close ("rubber banding"): who is behind becomes a little faster, who is
/// ahead a little slower.
struct RubberBand {
    float gap_m = 8.0F;       ///< wanted distance, > 0
    float gain = 0.5F;        ///< of the factor per gap that is missing or too much, >= 0
    float least = 0.8F;       ///< cap on the factor, > 0, at most 1
    float most = 1.2F;        ///< cap on the factor, at least 1
    float rate_per_s = 0.1F;  ///< the factor changes no faster, > 0
};

/// Factor of speed after `dt` s at a distance of `gap_m`, m, from what is chased; `factor` is that
/// before. Within the cap whatever comes in; without a number for the gap it goes towards 1.
inline float banded(const RubberBand& band, float factor, float gap_m, float dt) {
    const float off = (gap_m - band.gap_m) / band.gap_m;
    float wish = 1.0F + band.gain * off;
    wish = std::isfinite(wish) ? std::clamp(wish, band.least, band.most) : 1.0F;
    const float before = std::isfinite(factor) ? std::clamp(factor, band.least, band.most) : 1.0F;
    const float step = std::isfinite(dt) ? std::max(0.0F, band.rate_per_s * dt) : 0.0F;
    return before + std::clamp(wish - before, -step, step);
}

/// Difficulty that follows how often players succeed: harder by `step` times the wanted share of
/// failures after a success, easier by `step` times that of successes after a failure, so that it
/// stays where they succeed as often as wanted. (Kaernbach, "Simple adaptive testing with the
/// weighted up-down method", Perception & Psychophysics 49, 1991.)
struct Staircase {
    float success = 0.6F;  ///< wanted share of successes, (0, 1)
    float step = 0.05F;    ///< > 0
    float least = 0.0F;    ///< cap
    float most = 1.0F;     ///< cap, >= least
};

/// Difficulty after an encounter; `level` is that before. Within the cap whatever comes in.
inline float stepped(const Staircase& staircase, float level, bool player_succeeded) {
    const float before =
        std::isfinite(level) ? std::clamp(level, staircase.least, staircase.most) : staircase.least;
    const float change = player_succeeded ? staircase.step * (1.0F - staircase.success)
                                          : -staircase.step * staircase.success;
    return std::clamp(before + change, staircase.least, staircase.most);
}

}  // namespace zoned::ai::learning
