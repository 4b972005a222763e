#include "server/ai/steering/rubber_band.h"

#include "server/ai/steering/spline_following.h"

#include <cmath>
#include <limits>

namespace zoned::ai {

namespace {

Vec2 ground_place(const world::Entities& entities, world::Row row) {
    const Vec3& at = entities.position[row];
    return {at.x(), at.z()};
}

/// The rivals that are nearer to the player than this one. There are none in the tick in which the
/// first agent of a zone notices a player: the index of entities follows in the next.
std::uint32_t rivals_before(const Surroundings& around, const Vec2& player) {
    const world::Entities& e = around.ai.entities;
    const float own2 = (ground_place(e, around.self) - player).squaredNorm();
    std::uint32_t nearer = 0;
    around.ai.near->for_each_within(
        player.x(), player.y(), std::sqrt(own2) + 1e-3F, [&](world::Row row, float /*d2*/) {
            if (row == around.self || e.type[row] != e.type[around.self] ||
                e.has(row, world::kHidden)) {
                return;
            }
            const float d2 = (ground_place(e, row) - player).squaredNorm();
            nearer += d2 < own2 || (d2 == own2 && e.id[row] < e.id[around.self]) ? 1U : 0U;
        });
    return nearer;
}

/// The distance that the band is to act on, m. NaN where nobody is chased or raced with.
float gap_of(const Agent& agent,
             const BrainState& state,
             const learning::RubberBand& band,
             const Surroundings& around) {
    const world::Entities& e = around.ai.entities;
    const world::Row prey = agent.prey ? e.find(agent.prey) : world::kNoRow;
    if (prey == world::kNoRow || e.has(prey, world::kHidden)) {
        return std::numeric_limits<float>::quiet_NaN();
    }
    const Vec2 player = ground_place(e, prey);
    if (state.action != ActionKind::kFollowTrack) {
        const float gap = (player - ground_place(e, around.self)).norm();
        // The one ahead slows down when the other falls behind.
        return state.action == ActionKind::kFlee ? 2.0F * band.gap_m - gap : gap;
    }
    const float ahead = ahead_on_track(agent, player, around);
    if (!std::isfinite(ahead)) {
        return ahead;
    }
    const bool too_many = band.rivals > 0 && rivals_before(around, player) >= band.rivals;
    return learning::gap_on_track(band, ahead, too_many);
}

}  // namespace

void follow_band(Agent& agent, const BrainState& state, const Surroundings& around) {
    agent.band = state.rubber_band
                     ? learning::banded(*state.rubber_band,
                                        agent.band,
                                        gap_of(agent, state, *state.rubber_band, around),
                                        around.ai.dt)
                     : 1.0F;
}

}  // namespace zoned::ai
