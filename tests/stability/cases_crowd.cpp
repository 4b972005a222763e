// Crowds: a hundred thousand bodies in one place.
#include "tests/stability/world.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>

namespace zoned::stability {

namespace {

/// Steps of a crowd within a ball of that radius (0: all in one point), and the time of the
/// longest.
struct Crowd {
    double longest_ms = 0.0;
    std::uint32_t pairs = 0;
};

Crowd gather(World& world, core::Rng& rng, int count, float radius, int steps) {
    world.ground();
    for (int i = 0; i < count; ++i) {
        const float x = rng.range(-radius, radius);
        const float y = rng.range(-radius, radius);
        const float z = rng.range(-radius, radius);
        world.add(mixed_body(i, Vec3(x, 3.0F + y, z)));
    }
    Crowd crowd;
    for (int i = 0; i < steps && world.step(); ++i) {
        crowd.longest_ms = std::max(crowd.longest_ms, world.step_ms());
        crowd.pairs = world.pairs();
    }
    return crowd;
}

/// With no cap, any two bodies would be a pair: 5 x 10^9 of them. Settings::max_pairs (2^18) bounds
/// the pairs of dynamic bodies; as many again and more join bodies and their supports. A crowd a
/// tenth as large is at that cap too. So only the cost of each body by itself can grow, which is
/// less than a half of the step. A bound of 4 times the smaller crowd's time covers that growth,
/// noise included, and lies far below the 100 times of all pairs. Overlaps may push a body by the
/// sum of its contacts, bounded by the engine's limit for any body.
void crowd(Run& run, int count, float radius) {
    const std::string place = radius > 0.0F ? "within 2 m" : "in one point";
    const int steps = run.pick(2, 25);
    Run alone;  // the measure: its row is not shown
    core::Rng rng(run.seed, 44);
    World small(alone, "crowd", "");
    const Crowd tenth = gather(small, rng, count / 10, radius, steps);
    World world(run, "crowd", std::to_string(count) + " bodies " + place);
    world.fault_at = 0;
    const Crowd all = gather(world, rng, count, radius, steps);
    world.row.check("step_ms", all.longest_ms, 4.0 * tenth.longest_ms);
    world.row.check("pairs", all.pairs, 3.0 * (1U << 18));
    world.limits.speed_mps = 1.001e4;
    world.finish();
}

void crowds(Run& run) {
    crowd(run, run.pick(10'000, 100'000), 0.0F);
    if (!run.quick) {
        crowd(run, 100'000, 2.0F);
    }
}

}  // namespace

std::vector<Case> crowd_cases() {
    return {{"crowd", "a hundred thousand bodies in one place: time per step is bounded", crowds}};
}

}  // namespace zoned::stability
