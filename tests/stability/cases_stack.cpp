// Stacks, and steps of all lengths.
#include "tests/stability/world.h"

#include <cmath>

namespace zoned::stability {

namespace {

void stack(Run& run, const std::string& name, int count, float dt, float seconds) {
    World world(run,
                name,
                std::to_string(count) + " boxes, dt 1/" +
                    std::to_string(static_cast<int>(std::lround(1.0F / dt))) + " s");
    world.ground();
    for (int i = 0; i < count; ++i) {
        BodyDef def = body_of(
            Shape::box(Vec3::Constant(0.5F)), 1.0F, Vec3(0.0F, 0.5F + static_cast<float>(i), 0.0F));
        def.material.friction = 0.6F;
        world.add(def);
    }
    // Each contact may give way by the budget; at the top the budgets of all contacts below add up.
    // The first moments, in which loads are not known yet, are granted as much again.
    world.limits.depth_m = 2.0 * kGive + 0.5 * 9.81 * static_cast<double>(dt * dt);
    world.limits.drift_m = 2.0 * kGive * count;
    world.limits.energy_share = 1.0e-3;
    // Speed of a fall by the compression of all contacts together.
    world.limits.speed_mps = std::sqrt(2.0 * 9.81 * kGive * count);
    world.run(seconds, dt);
    world.finish();
}

void stacks(Run& run) {
    const auto counts = run.pick<std::vector<int>>({5, 20}, {5, 10, 20, 40});
    for (const int count : counts) {
        stack(run, "stack", count, kFrame, run.pick(5.0F, 20.0F));
    }
}

void step_lengths(Run& run) {
    const auto rates = run.pick<std::vector<int>>({240, 10}, {240, 120, 30, 20, 10});
    for (const int rate : rates) {
        stack(run, "step-length", 10, 1.0F / static_cast<float>(rate), run.pick(3.0F, 10.0F));
    }
    for (const int rate : rates) {
        World world(run, "step-length", "pile, dt 1/" + std::to_string(rate) + " s");
        world.room(3.0F, 12.0F);
        for (int i = 0; i < 60; ++i) {
            world.add(mixed_body(i,
                                 Vec3(static_cast<float>(i % 4) * 1.3F - 2.0F,
                                      1.0F + static_cast<float>(i / 16) * 1.3F,
                                      static_cast<float>(i / 4 % 4) * 1.3F - 2.0F)));
        }
        // Bodies fall from 5 m at most, to 10 m/s. A body that falls on others sinks in by less
        // than its travel in a substep of 1/240 s, and by no more than a quarter of its size.
        world.limits.depth_m = 0.12;
        world.limits.energy_share = 1.0e-3;
        world.limits.speed_mps = 11.0;
        world.run(run.pick(3.0F, 10.0F), 1.0F / static_cast<float>(rate));
        world.finish();
    }
}

}  // namespace

std::vector<Case> stack_cases() {
    return {{"stack",
             "columns of unit boxes stand: each contact gives way by the error budget, twice at "
             "first",
             stacks},
            {"step-length", "a column and a pile at steps of 1/240 to 1/10 s", step_lengths}};
}

}  // namespace zoned::stability
