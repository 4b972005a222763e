// Random scenes: the generator, its files, the invariants and the shrinker do what they say.
#include "tests/scenario/minimise.h"
#include "tests/stability/random/random_lab.h"
#include "tests/stability/random/scene_generator.h"
#include "tests/stability/random/scene_shrink.h"
#include "tests/stability/random/scene_text.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace zoned::stability {
namespace {

using physics::BodyKind;
using physics::JointKind;
using physics::ShapeKind;

RandomBody box_at(const Vec3& at, const Vec3& half = Vec3::Constant(0.5F)) {
    RandomBody body;
    body.parts.emplace_back();
    body.parts.front().half = half;
    body.at = at;
    return body;
}

RandomBody ball_at(const Vec3& at, float radius = 0.5F) {
    RandomBody body = box_at(at);
    body.parts.front().kind = ShapeKind::kSphere;
    body.parts.front().radius = radius;
    return body;
}

RandomJoint joint_of(int a, int b, const Vec3& anchor) {
    RandomJoint joint;
    joint.a = a;
    joint.b = b;
    joint.def.anchor = joint.def.anchor_b = anchor;
    return joint;
}

/// A box that rests on the ground.
RandomScene resting() {
    RandomScene scene;
    scene.ground.kind = GroundKind::kBox;
    scene.seconds = 12.0F;
    scene.bodies.push_back(box_at(Vec3(0.0F, 0.5F, 0.0F)));
    return scene;
}

/// Two balls on a joint that turn about each other without gravity.
RandomScene adrift() {
    RandomScene scene;
    scene.gravity = Vec3::Zero();
    scene.seconds = 1.0F;
    scene.bodies = {ball_at(Vec3::Zero()), ball_at(Vec3(1.5F, 0.0F, 0.0F))};
    scene.bodies.front().velocity = Vec3(0.0F, 1.0F, 0.0F);
    scene.joints.push_back(joint_of(0, 1, Vec3(0.75F, 0.0F, 0.0F)));
    return scene;
}

SceneVerdict run_with(const RandomScene& scene, Fault fault) {
    SceneRunOptions options;
    options.spoil = spoil_with(fault);
    return run_scene(scene, options);
}

TEST(RandomScene, HoldsAllInvariantsWhereNothingIsWrong) {
    for (const RandomScene& scene : {resting(), adrift()}) {
        const SceneVerdict verdict = run_scene(scene);
        EXPECT_EQ(verdict.refused, "");
        EXPECT_TRUE(verdict.breaches.empty());
        EXPECT_GT(verdict.steps, 50U);
    }
}

TEST(RandomScene, FindsEachFault) {
    EXPECT_TRUE(run_with(resting(), Fault::kNan).fails(Invariant::kFinite));
    EXPECT_TRUE(run_with(resting(), Fault::kEnergy).fails(Invariant::kEnergy));
    EXPECT_TRUE(run_with(resting(), Fault::kAwake).fails(Invariant::kSleep));
    EXPECT_TRUE(run_with(resting(), Fault::kFloor).fails(Invariant::kTunnel));
    EXPECT_TRUE(run_with(adrift(), Fault::kMomentum).fails(Invariant::kMomentum));
    EXPECT_TRUE(run_with(adrift(), Fault::kJoint).fails(Invariant::kJoint));
}

TEST(RandomScene, FindsBodiesThatTheEngineStopped) {
    SceneRunOptions options;
    options.spoil = [](std::uint64_t, Observation& now) {
        now.stats.quarantined = 1;
    };
    EXPECT_TRUE(run_scene(resting(), options).fails(Invariant::kFinite));
}

TEST(RandomScene, FindsABodyBeyondAWall) {
    RandomScene scene;
    scene.gravity = Vec3::Zero();
    scene.seconds = 1.0F;
    scene.bodies = {box_at(Vec3::Zero(), Vec3(0.05F, 2.0F, 2.0F)),
                    ball_at(Vec3(-2.0F, 0.0F, 0.0F))};
    scene.bodies.front().kind = BodyKind::kStatic;
    EXPECT_TRUE(run_scene(scene).breaches.empty());
    SceneRunOptions options;
    options.spoil = [](std::uint64_t, Observation& now) {
        now.states.back().position.x() = 2.0F;
    };
    EXPECT_TRUE(run_scene(scene, options).fails(Invariant::kTunnel));
}

TEST(RandomScene, FindsATornJointOfEachKind) {
    for (const JointKind kind : {JointKind::kBall,
                                 JointKind::kHinge,
                                 JointKind::kSlider,
                                 JointKind::kFixed,
                                 JointKind::kDistance}) {
        RandomScene scene = adrift();
        scene.joints.front().def.kind = kind;
        scene.joints.front().def.anchor_b =
            kind == JointKind::kDistance ? Vec3(1.5F, 0.0F, 0.0F) : scene.joints.front().def.anchor;
        EXPECT_FALSE(run_scene(scene).fails(Invariant::kJoint)) << static_cast<int>(kind);
        SceneRunOptions options;  // across the slider's axis
        options.spoil = [](std::uint64_t, Observation& now) {
            now.states.back().position.z() += 1.0F;
        };
        EXPECT_TRUE(run_scene(scene, options).fails(Invariant::kJoint)) << static_cast<int>(kind);
    }
}

TEST(RandomScene, ReportsOpenJointsApartWhereEffortGaveUp) {
    SceneRunOptions options;
    options.spoil = [](std::uint64_t, Observation& now) {
        now.states.back().position.z() += 1.0F;
        now.stats.substep_limited = 1;
    };
    const SceneVerdict verdict = run_scene(adrift(), options);
    EXPECT_FALSE(verdict.fails(Invariant::kJoint));
    EXPECT_TRUE(std::any_of(verdict.breaches.begin(), verdict.breaches.end(), [](const Breach& b) {
        return b.what == Invariant::kJoint && b.gave_up;
    }));
}

TEST(RandomScene, GrantsMotorsAndMoversTheirWork) {
    RandomScene turned = resting();
    turned.seconds = 3.0F;
    turned.bodies.front() = box_at(Vec3(0.5F, 1.0F, 0.0F), Vec3(0.5F, 0.05F, 0.05F));
    turned.joints.push_back(joint_of(-1, 0, Vec3(0.0F, 1.0F, 0.0F)));
    physics::JointDef& hinge = turned.joints.front().def;
    hinge.kind = JointKind::kHinge;
    hinge.motor = true;
    hinge.motor_speed = 3.0F;
    hinge.motor_max = 50.0F;
    EXPECT_TRUE(run_scene(turned).breaches.empty());
    RandomScene lifted = resting();
    lifted.seconds = 3.0F;
    lifted.bodies.push_back(box_at(Vec3(0.0F, 1.2F, 0.0F), Vec3(2.0F, 0.1F, 2.0F)));
    std::swap(lifted.bodies[0], lifted.bodies[1]);
    lifted.bodies[0].kind = BodyKind::kKinematic;
    lifted.bodies[0].velocity = Vec3(0.0F, 1.0F, 0.0F);
    lifted.bodies[1].at.y() = 1.8F;
    EXPECT_TRUE(run_scene(lifted).breaches.empty());
}

TEST(RandomScene, RefusesUnsoundStarts) {
    RandomScene overlapping = resting();
    overlapping.bodies.push_back(ball_at(Vec3(0.3F, 1.3F, 0.0F)));
    EXPECT_NE(run_scene(overlapping).refused.find("overlap"), std::string::npos);
    overlapping.joints.push_back(joint_of(0, 1, Vec3(0.0F, 1.0F, 0.0F)));
    EXPECT_EQ(run_scene(overlapping).refused, "") << "joined bodies do not collide";
    RandomScene sunk = resting();
    sunk.bodies.front().at.y() = 0.4F;
    for (const GroundKind kind : {GroundKind::kBox, GroundKind::kMesh, GroundKind::kHeightfield}) {
        sunk.ground.kind = kind;
        EXPECT_NE(run_scene(sunk).refused.find("ground"), std::string::npos);
    }
    RandomScene bent = adrift();
    bent.joints.front().def.kind = JointKind::kHinge;
    bent.joints.front().def.limited = true;
    bent.joints.front().def.lower = bent.joints.front().def.upper = 0.5F;
    EXPECT_NE(run_scene(bent).refused.find("limits"), std::string::npos);
}

TEST(RandomScene, KnowsTheHeightOfItsGround) {
    RandomGround ground{.kind = GroundKind::kMesh, .half = 4.0F, .amplitude = 1.0F, .wave = 1.0F};
    EXPECT_NEAR(ground_height(ground, 1.0, 2.0), std::sin(1.0) * std::sin(2.0), 1e-12);
    EXPECT_NEAR(ground_height(ground, 1.5, 1.5),
                0.5 * (std::sin(1.0) * std::sin(1.0) + std::sin(2.0) * std::sin(2.0)),
                1e-12)
        << "cells are cut from their lowest corner to their highest";
    EXPECT_FALSE(std::isfinite(ground_height(ground, 4.1, 0.0)));
}

TEST(RandomScene, ComesFromItsTwoNumbersAlone) {
    std::size_t bodies = 0;
    for (std::uint64_t k = 0; k < 60; ++k) {
        const RandomScene scene = generate_scene(5, k);
        EXPECT_EQ(scene, generate_scene(5, k));
        EXPECT_EQ(why_unsound(scene), "");
        bodies += scene.bodies.size();
    }
    EXPECT_GT(bodies, 200U);
    EXPECT_NE(generate_scene(5, 1), generate_scene(6, 1));
}

/// Scenes that random search found and shrunk, each of which an engine or the lab itself once got
/// wrong: tests/stability/found.
TEST(RandomScene, ThatWasFoundBreaksNothingNow) {
    std::size_t count = 0;
    for (const auto& entry :
         std::filesystem::directory_iterator(ZONED_SOURCE_DIR "/tests/stability/found")) {
        std::ifstream file(entry.path());
        const std::string text(std::istreambuf_iterator<char>(file), {});
        const auto scene = scene_from_text(text);
        ASSERT_TRUE(scene.ok()) << entry.path() << (scene.ok() ? "" : scene.error());
        const SceneVerdict verdict = run_scene(*scene);
        EXPECT_EQ(verdict.refused, "") << entry.path();
        for (const Breach& breach : verdict.breaches) {
            ADD_FAILURE() << entry.path() << ": "
                          << invariant_names()[static_cast<std::size_t>(breach.what)] << ' '
                          << breach.figure << " of " << breach.bound;
        }
        ++count;
    }
    EXPECT_GE(count, 4U);
}

/// Numbers and hashes of texts are the same with each compiler, and so has the order of draws to
/// be.
TEST(RandomScene, IsTheSameWithEachCompiler) {
    std::uint64_t hash = 0xCBF29CE484222325U;  // FNV-1a
    for (std::uint64_t k = 0; k < 40; ++k) {
        for (const char c : scene_to_text(generate_scene(1, k))) {
            hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
        }
    }
    EXPECT_EQ(hash, 4706515633592621376U);
}

TEST(RandomScene, EachFamilyFindsPlaces) {
    for (const std::string& family : family_names()) {
        int found = 0;
        for (std::uint64_t k = 0; k < 20; ++k) {
            found += generate_scene(3, k, {family}).bodies.empty() ? 0 : 1;
        }
        EXPECT_GE(found, 5) << family;
    }
}

TEST(RandomLab, SaysTheSameForAnyNumberOfThreads) {
    RandomLabOptions options;
    options.seed = 11;
    options.count = 12;
    options.keep = 0;
    options.fault = Fault::kEnergy;  // so that there is something to say
    RandomLabResult one = run_random_lab(options);
    options.threads = 2;
    RandomLabResult two = run_random_lab(options);
    one.cpu_ms = two.cpu_ms = 0.0;
    EXPECT_EQ(to_table(one), to_table(two));
    EXPECT_FALSE(one.failures.empty());
}

TEST(RandomLab, WritesShrunkScenesThatReplay) {
    const std::filesystem::path folder =
        std::filesystem::path(testing::TempDir()) / "zoned-random-lab";
    std::filesystem::create_directories(folder);
    RandomLabOptions options;
    options.seed = 11;
    options.count = 4;
    options.only = {Invariant::kFinite};
    options.fault = Fault::kNan;
    options.folder = folder.string();
    const RandomLabResult result = run_random_lab(options);
    ASSERT_FALSE(result.failures.empty());
    const std::string file = result.failures.front().file;
    ASSERT_FALSE(file.empty());
    EXPECT_FALSE(replay_scene(file, {}, Fault::kNan));
    EXPECT_TRUE(replay_scene(file, {}, Fault::kNone));
    std::filesystem::remove_all(folder);
}

TEST(SceneShrink, FindsTheSmallestSubset) {
    int budget = 1000;
    const auto fails = [](const std::vector<std::size_t>& kept) {
        return std::count(kept.begin(), kept.end(), 13U) == 1 &&
               std::count(kept.begin(), kept.end(), 40U) == 1;
    };
    EXPECT_EQ(scenario::minimise(64, fails, budget), (std::vector<std::size_t>{13, 40}));
    EXPECT_GT(budget, 800) << "logarithmic for few causes";
    budget = 100;
    EXPECT_TRUE(scenario::minimise(
                    8, [](const auto&) { return true; }, budget)
                    .empty());
}

TEST(SceneShrink, LeavesWhatAFailureNeeds) {
    // It needs a heavy ball that is joined to something.
    const auto fails = [](const RandomScene& scene) {
        return std::any_of(scene.joints.begin(), scene.joints.end(), [&](const RandomJoint& joint) {
            const RandomBody& body = scene.bodies[static_cast<std::size_t>(joint.b)];
            return joint.a >= 0 && body.mass > 50.0F && body.parts[0].kind == ShapeKind::kSphere;
        });
    };
    RandomScene scene;
    for (std::uint64_t k = 0; !fails(scene); ++k) {
        ASSERT_LT(k, 200U);
        scene = generate_scene(9, k, {"chain", "loop", "pair"});
    }
    const RandomScene small = shrink_scene(scene, fails, 2000);
    EXPECT_TRUE(fails(small));
    EXPECT_EQ(why_unsound(small), "");
    EXPECT_EQ(small.bodies.size(), 2U);
    EXPECT_EQ(small.joints.size(), 1U);
    EXPECT_EQ(small.offset, Vec3(Vec3::Zero()));
    EXPECT_EQ(small.ground.kind, GroundKind::kNone);
    EXPECT_EQ(small.bodies[0].mass, 1.0F);
    EXPECT_FALSE(small.joints[0].def.motor);
    EXPECT_LE(small.seconds, 0.2F);
}

TEST(SceneText, GivesBackTheVeryScene) {
    for (std::uint64_t k = 0; k < 60; ++k) {
        const RandomScene scene = generate_scene(4, k);
        const auto again = scene_from_text(scene_to_text(scene));
        ASSERT_TRUE(again.ok()) << again.error();
        EXPECT_EQ(*again, scene) << k;
    }
}

TEST(SceneText, NamesTheLineOfEachError) {
    const std::vector<std::pair<std::string, std::string>> cases{
        {"", "line 1: the first line is 'zoned-scene 1'"},
        {"zoned-scene 2\n", "line 1: the first line"},
        {"zoned-scene 1\nbox\n", "line 2: a line begins with"},
        {"zoned-scene 1\n\nscene dt x\n", "line 3: 'dt' needs a number, not 'x'"},
        {"zoned-scene 1\nscene dt 0.1 dt 0.1\n", "line 2: 'dt' is given twice"},
        {"zoned-scene 1\nscene dt nan\n", "line 2: 'dt' is not finite"},
        {"zoned-scene 1\nscene dt 1e99\n", "line 2: 'dt' needs a number"},
        {"zoned-scene 1\nscene gravity 0 0\n", "line 2: 'gravity' needs a number, not ''"},
        {"zoned-scene 1\nscene\nscene\n", "line 3: 'scene' is given twice"},
        {"zoned-scene 1\nbody heavy\n", "line 2: unknown kind 'heavy'"},
        {"zoned-scene 1\nbody dynamic\n", "body 0 has no part"},
        {"zoned-scene 1\npart box\n", "line 2: a part before the first body"},
        {"zoned-scene 1\nbody dynamic\npart hull points 99\n", "line 3: a hull has 4 to 64 points"},
        {"zoned-scene 1\njoint ball limited maybe\n",
         "line 2: 'limited' is yes or no, not 'maybe'"},
        {"zoned-scene 1\njoint ball \x01\x02\n", "line 2: unknown word '\?\?'"},
    };
    for (const auto& [text, reason] : cases) {
        const auto read = scene_from_text(text);
        ASSERT_FALSE(read.ok()) << text;
        EXPECT_NE(read.error().find(reason), std::string::npos) << read.error();
    }
    EXPECT_FALSE(scene_from_text(std::string(kMostSceneTextBytes + 1, '#')).ok());
}

TEST(SceneText, LeavesBadNumbersToTheRun) {
    const auto scene = scene_from_text("zoned-scene 1\nscene dt 9\n");
    ASSERT_TRUE(scene.ok());
    EXPECT_NE(run_scene(*scene).refused.find("dt"), std::string::npos);
}

}  // namespace
}  // namespace zoned::stability
