// The checks are checked: each deliberate fault makes its own check fail.
#include "tests/stability/world.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace zoned::stability {
namespace {

/// A box on the ground of a closed room and one that flies without gravity, all checked.
Row watch(Fault fault) {
    stability::Run run;
    run.fault = fault;
    World world(run, "watched", "");
    world.room(4.0F, 8.0F);
    world.add(body_of(Shape::box(Vec3::Constant(0.5F)), 1.0F, Vec3(0.0F, 0.5F, 0.0F)));
    world.limits.speed_mps = 1.0;
    world.limits.energy_share = 0.01;
    world.limits.depth_m = 0.02;
    world.limits.drift_m = 0.05;
    world.run(1.0F);
    world.finish();
    return run.results.rows.front();
}

Row watch_momentum(Fault fault) {
    stability::Run run;
    run.fault = fault;
    physics::PhysicsSettings settings;
    settings.gravity = Vec3::Zero();
    World world(run, "watched", "", settings);
    for (const float side : {-1.0F, 1.0F}) {
        BodyDef def = body_of(Shape::sphere(0.5F), 1.0F, Vec3(side, 0.2F * side, 0.0F));
        def.velocity = Vec3(-side, 0.0F, 0.0F);
        world.add(def);
    }
    world.limits.momentum_share = 1.0e-4;
    world.run(1.0F);
    world.finish();
    return run.results.rows.front();
}

bool fails(const Row& row, const std::string& what) {
    return std::any_of(row.checks.begin(), row.checks.end(), [&what](const Check& check) {
        return check.what == what && !check.good();
    });
}

TEST(StabilityChecks, PassWithoutAFault) {
    EXPECT_TRUE(watch(Fault::kNone).passed())
        << to_table({{}, {}, 0, false, {watch(Fault::kNone)}});
    EXPECT_TRUE(watch_momentum(Fault::kNone).passed());
}

TEST(StabilityChecks, FindWhatIsNotANumber) {
    EXPECT_TRUE(fails(watch(Fault::kNan), "not_finite"));
}

TEST(StabilityChecks, FindEnergyFromNowhere) {
    EXPECT_TRUE(fails(watch(Fault::kEnergy), "energy_share"));
    EXPECT_TRUE(fails(watch(Fault::kEnergy), "speed_mps"));
}

TEST(StabilityChecks, FindABodyInTheFloor) {
    EXPECT_TRUE(fails(watch(Fault::kFloor), "depth_m"));
}

TEST(StabilityChecks, FindABodyThatLeftItsRoom) {
    EXPECT_TRUE(fails(watch(Fault::kEscape), "escaped"));
}

TEST(StabilityChecks, FindABodyThatWanders) {
    EXPECT_TRUE(fails(watch(Fault::kDrift), "drift_m"));
}

TEST(StabilityChecks, FindMomentumFromNowhere) {
    EXPECT_TRUE(fails(watch_momentum(Fault::kMomentum), "momentum_share"));
}

TEST(StabilityChecks, CountStoppedBodies) {
    stability::Run run;
    World world(run, "watched", "");
    const BodyId id = world.add(body_of(Shape::sphere(0.5F), 1.0F, Vec3(0.0F, 5.0F, 0.0F)));
    world.scene.set_velocity(id, Vec3(1.0e9F, 0.0F, 0.0F), Vec3::Zero());
    world.step();
    world.finish();
    EXPECT_TRUE(fails(run.results.rows.front(), "quarantined"));
}

TEST(StabilityReport, TreatsNotANumberAsAFailure) {
    Row row;
    row.check("x", std::nan(""), 1.0);
    EXPECT_FALSE(row.passed());
}

TEST(StabilityReport, FailsKnownRowsBeyondTheirOwnBounds) {
    Row row;
    row.know("a reason", {{"depth_m", 3.0}});
    row.check("depth_m", 2.0, 1.0);
    EXPECT_FALSE(row.passed());
    EXPECT_FALSE(row.fails_run());
    row.checks.front().value = 4.0;
    EXPECT_TRUE(row.fails_run());
    row.checks.front().value = std::nan("");
    EXPECT_TRUE(row.fails_run());
    row.checks.front().value = 2.0;
    row.check("drift_m", 2.0, 1.0);
    EXPECT_TRUE(row.fails_run()) << "nothing is known of its drift";
}

TEST(StabilityReport, WritesFailedChecksBelowTheirRow) {
    Row row;
    row.name = "a";
    row.check("depth_m", 2.0, 1.0);
    const Results results{"", "", 1, false, {row}};
    EXPECT_NE(to_table(results).find("depth_m 2 > 1"), std::string::npos);
    EXPECT_NE(to_json(results).find("\"passed\": false"), std::string::npos);
}

}  // namespace
}  // namespace zoned::stability
