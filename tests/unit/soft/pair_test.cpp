// Soft bodies against soft ones: none passes through another, and nothing comes from nowhere.
#include "server/compute/worker_pool.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/soft/pair_scenes.h"
#include "shared/core/archive/field_archive.h"

#include <cmath>

namespace zoned::physics::soft {
namespace {

class SoftPairsBy : public testing::TestWithParam<SoftMethod> {
  protected:
    [[nodiscard]] SoftDef by(SoftDef def) const { return solved_by(GetParam(), std::move(def)); }
};

INSTANTIATE_TEST_SUITE_P(Methods,
                         SoftPairsBy,
                         testing::Values(SoftMethod::kXpbd,
                                         SoftMethod::kImplicitEuler,
                                         SoftMethod::kSemiImplicitEuler),
                         [](const auto& method) { return std::string(name_of(method.param)); });

SoftSettings with_frames(SoftSettings settings) {
    settings.step_s = kFrame;
    return settings;
}

struct TwoThatMeet {
    const char* name;
    SoftDef lower, upper;
};

/// Gravity and the springs give no more than they hold at first, E0, as contacts end an approach
/// and part an overlap without speed. A position is rounded to 2^-24 of its size in each of some
/// 10^4 substeps: of a relative 10^-4 of the energy in sum where each errs to the same side by a
/// sixth of that.
TEST_P(SoftPairsBy, FallOnEachOtherAndComeToRest) {
    const std::vector<TwoThatMeet> scenes{
        {"jelly on jelly", jelly_at(Vec3(0, 0.53F, 0)), jelly_at(Vec3(0.1F, 1.9F, 0.15F))},
        {"cloth on balloon", balloon_at(Vec3(0, 0.53F, 0)), sheet_at(Vec3(-1, 1.4F, -0.9F), 11)},
        {"balloon on jelly", jelly_at(Vec3(0, 0.53F, 0)), balloon_at(Vec3(0.02F, 1.7F, 0.01F))},
        {"rope on jelly", jelly_at(Vec3(0, 0.53F, 0)), rope_at(Vec3(0, 1.4F, 0.1F))},
    };
    for (const TwoThatMeet& scene : scenes) {
        SCOPED_TRACE(scene.name);
        SoftBodies bodies(with_frames({}));
        const MeetingBody lower = put_meeting(bodies, by(scene.lower));
        const MeetingBody upper = put_meeting(bodies, by(scene.upper));
        Scene ground{PhysicsSettings()};
        add_floor(ground);
        const auto energy = [&] {
            return bodies.energy(lower.id) + bodies.energy(upper.id);
        };
        const double most = energy() * (1.0 + 1e-4);
        const float apart = lower.thickness + upper.thickness;
        int step = 0;
        while (step < 1500 && !(bodies.asleep(lower.id) && bodies.asleep(upper.id))) {
            bodies.step(kFrame, &ground);
            ASSERT_LE(energy(), most) << step;
            if (++step % 60 == 0) {
                ASSERT_GT(gap_between(bodies, lower, upper), 0.5F * apart) << step;
            }
        }
        EXPECT_TRUE(bodies.asleep(lower.id) && bodies.asleep(upper.id)) << "no rest";
        EXPECT_NEAR(gap_between(bodies, lower, upper), apart, 0.1F * apart);
        EXPECT_GT(centre_of(bodies, upper.id).y(), centre_of(bodies, lower.id).y());
    }
}

TEST_P(SoftPairsBy, StackOfThreeStaysAStack) {
    SoftSettings settings = with_frames(awake_soft());  // no rest but by its own balance
    SoftBodies bodies(settings);
    std::vector<MeetingBody> stack;
    for (const Vec3& at : {Vec3(0, 0.52F, 0), Vec3(0.02F, 1.57F, 0.03F), Vec3(-0.02F, 2.62F, 0)}) {
        stack.push_back(put_meeting(bodies, by(jelly_at(at, 1.0F, 3))));
    }
    Scene ground{PhysicsSettings()};
    add_floor(ground);
    run(bodies, 60, &ground);
    std::vector<Vec3> settled;
    for (const MeetingBody& body : stack) {
        settled.push_back(centre_of(bodies, body.id));
    }
    run(bodies, 1200, &ground);
    for (std::size_t i = 0; i < stack.size(); ++i) {
        // It sways and sags by no more than the distance that two bodies keep.
        EXPECT_LT((centre_of(bodies, stack[i].id) - settled[i]).norm(), 0.04F) << i;
        if (i > 0) {
            EXPECT_NEAR(gap_between(bodies, stack[i - 1], stack[i]), 0.04F, 0.004F) << i;
        }
    }
}

/// Both free, no gravity, no drag. The sum of linear momentum stays but for rounding: each of N
/// substeps of h s rounds a position x to 2^-24 |x| and so a velocity to 2^-24 |x| / h, which adds
/// up as a random walk does. Friction acts at the node and at the face, which are apart by the
/// distance that they keep: angular momentum stays but for that arm.
TEST_P(SoftPairsBy, KeepMomentumAndGainNoEnergy) {
    struct Thrown {
        const char* name;
        SoftDef a, b;
        Vec3 v;
    };

    std::vector<Thrown> scenes{
        {"jellies", jelly_at(Vec3(0, 0, 0)), jelly_at(Vec3(0.3F, 1.2F, 0.2F)), Vec3(1, -4, 0)},
        {"balloon", jelly_at(Vec3(0, 0, 0)), balloon_at(Vec3(0.2F, 1.2F, 0)), Vec3(0, -4, 1)},
        {"sheet", balloon_at(Vec3(0, 0, 0)), sheet_at(Vec3(-1, 0.7F, -0.9F)), Vec3(0.5F, -3, 0)},
        {"rope", jelly_at(Vec3(0, 0, 0)), rope_at(Vec3(0, 0.7F, 0.1F)), Vec3(1, -3, 0)},
    };
    for (Thrown& scene : scenes) {
        SCOPED_TRACE(scene.name);
        scene.a.material.drag = scene.b.material.drag = 0.0F;
        for (SoftNode& n : scene.b.nodes) {
            n.velocity = scene.v;
        }
        SoftBodies bodies(with_frames(weightless_soft()));
        const SoftId a = put(bodies, by(scene.a));
        const SoftId b = put(bodies, by(scene.b));
        const auto sum = [&] {
            Momenta m = momenta(bodies, a);
            const Momenta other = momenta(bodies, b);
            m.linear += other.linear;
            m.angular += other.angular;
            m.size += other.size;
            return m;
        };
        const Momenta before = sum();
        const Vec3d alone = momenta(bodies, a).linear;
        const double energy = bodies.energy(a) + bodies.energy(b);
        double most = 0.0;
        double substeps = 0.0;
        double shortest = 1.0;
        for (int i = 0; i < 60; ++i) {
            const double n = 0.5 * bodies.step(kFrame, nullptr).substeps;
            substeps += n;
            shortest = std::min(shortest, static_cast<double>(kFrame) / n);
            most = std::max(most, bodies.energy(a) + bodies.energy(b));
        }
        const Momenta after = sum();
        EXPECT_GT((momenta(bodies, a).linear - alone).norm(), 0.1 * before.size) << "no hit";
        const double mass = bodies.rigid_hull(a).mass + bodies.rigid_hull(b).mass;
        const double farthest = 4.0;  // m: 4 m/s for a second
        EXPECT_LT((after.linear - before.linear).norm(),
                  mass * 0x1p-24 * farthest / shortest * std::sqrt(substeps));
        EXPECT_LT((after.angular - before.angular).norm(), 0.02 * before.size);
        EXPECT_LT(most, energy + 1e-4 * std::abs(energy) + 1e-3);
    }
}

/// v^2 / (2 mu g), with the geometric mean of both coefficients.
TEST_P(SoftPairsBy, FrictionEndsASlide) {
    for (const float mu : {0.2F, 0.6F}) {
        SoftDef slab = jelly_at(Vec3(0, 0, 0), 2.0F, 4);
        for (SoftNode& n : slab.nodes) {
            n.pinned = true;
        }
        slab.material.friction = 2.0F * mu;
        SoftDef slider = jelly_at(Vec3(-0.5F, 1.19F, 0.1F), 0.3F, 3, 1.0F);
        slider.material.friction = 0.5F * mu;
        SoftBodies bodies(with_frames(awake_soft()));
        put(bodies, by(slab));
        const SoftId id = put(bodies, by(slider));
        run(bodies, 60);
        const Vec3 from = centre_of(bodies, id);
        bodies.push(id, Vec3(1, 0, 0));
        run(bodies, 90);
        const float way = (centre_of(bodies, id) - from).norm();
        // It rocks as it stops, by less than a tenth of its side.
        EXPECT_NEAR(way, 1.0F / (2.0F * mu * kGravity), 0.03F) << mu;
    }
}

/// Whichever was added first: a node of either finds a face of the other that has no node near.
TEST_P(SoftPairsBy, FineAndCoarseMeetBothWays) {
    for (const bool fine_below : {false, true}) {
        for (const bool fine_first : {false, true}) {
            SoftDef coarse = jelly_at(Vec3(0, fine_below ? 1.2F : 0.0F, 0), 1.0F, 2);
            SoftDef fine = jelly_at(Vec3(0.1F, fine_below ? 0.0F : 1.0F, 0.1F), 0.4F, 4, 1.0F);
            for (SoftNode& n : (fine_below ? fine : coarse).nodes) {
                n.pinned = true;
            }
            SoftBodies bodies(with_frames(awake_soft()));
            MeetingBody a = put_meeting(bodies, by(fine_first ? fine : coarse));
            MeetingBody b = put_meeting(bodies, by(fine_first ? coarse : fine));
            for (int i = 0; i < 6; ++i) {
                run(bodies, 15);
                EXPECT_GT(gap_between(bodies, a, b), 0.02F) << fine_below << fine_first << i;
            }
        }
    }
}

TEST(SoftPairs, MoveAlikeOnAnyNumberOfThreads) {
    std::vector<std::uint64_t> hashes;
    for (const unsigned threads : {1U, 2U, 4U}) {
        compute::WorkerPool pool(threads);
        compute::Team team;
        team.join_pool(pool);
        SoftBodies bodies(with_frames({}));
        bodies.work_with(&team);
        // Four piles and one that all of them touch in the end.
        for (int pile = 0; pile < 4; ++pile) {
            const Vec3 at(1.5F * static_cast<float>(pile), 0.6F, 0);
            const auto method = static_cast<SoftMethod>(pile % 3);
            put(bodies, solved_by(method, jelly_at(at)));
            put(bodies, solved_by(method, balloon_at(at + Vec3(0.1F, 1.2F, 0))));
        }
        put(bodies, rope_at(Vec3(2, 2.6F, 0), 5.0F, 40));
        Scene ground{PhysicsSettings()};
        add_floor(ground);
        run(bodies, 40);  // in the air, each island a task
        run(bodies, 60, &ground);
        hashes.push_back(hash_of(bodies));
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(SoftPairs, GoOnAlikeFromASnapshot) {
    SoftBodies bodies(with_frames({}));
    put(bodies, jelly_at(Vec3(0, 0.53F, 0)));
    put(bodies, sheet_at(Vec3(-1, 1.2F, -0.9F)));
    put(bodies, balloon_at(Vec3(0.1F, 1.9F, 0)));
    Scene ground{PhysicsSettings()};
    add_floor(ground);
    for (int i = 0; i < 5; ++i) {
        run(bodies, 25, &ground);
        std::vector<std::uint8_t> bytes;
        core::FieldWriter writer(bytes);
        bodies.save(writer);
        SoftBodies copy(with_frames({}));
        core::FieldReader reader(bytes);
        copy.load(reader);
        Scene same{PhysicsSettings()};
        add_floor(same);
        run(copy, 25, &same);
        run(bodies, 25, &ground);
        EXPECT_EQ(hash_of(bodies), hash_of(copy)) << i;
    }
}

TEST(SoftPairs, ASleeperWakesByATouchAlone) {
    SoftBodies bodies;
    const SoftId sleeper = put(bodies, jelly_at(Vec3(0, 0.52F, 0)));
    bodies.sleep(sleeper);
    const SoftId passing = put(bodies, jelly_at(Vec3(-3, 2.3F, 0)));
    bodies.push(passing, Vec3(8, 2, 0));
    for (int i = 0; i < 40; ++i) {
        bodies.step(kFrame, nullptr);
        ASSERT_TRUE(bodies.asleep(sleeper)) << "it passed above " << i;
    }
    const SoftId comes = put(bodies, jelly_at(Vec3(0.2F, 1.7F, 0)));
    for (int i = 0; i < 60 && bodies.asleep(sleeper); ++i) {
        bodies.step(kFrame, nullptr);
    }
    EXPECT_FALSE(bodies.asleep(sleeper));
    EXPECT_LT(centre_of(bodies, comes).y(), 1.7F);
}

TEST(SoftPairs, WhatSleptOnOneThatGoesWakes) {
    for (const bool removed : {true, false}) {
        SoftBodies bodies;
        const SoftId lower = put(bodies, jelly_at(Vec3(0, 0.52F, 0)));
        const SoftId upper = put(bodies, jelly_at(Vec3(0, 1.56F, 0)));
        const SoftId afar = put(bodies, jelly_at(Vec3(9, 0.52F, 0)));
        for (const SoftId id : {lower, upper, afar}) {
            bodies.sleep(id);
        }
        if (removed) {
            bodies.remove(lower);
        } else {
            bodies.place(lower, Vec3(5, 0.52F, 0), Quat::Identity());
        }
        EXPECT_FALSE(bodies.asleep(upper));
        EXPECT_TRUE(bodies.asleep(afar));
    }
}

TEST(SoftPairs, MeetOnlyWhereBothCollide) {
    for (const bool collides : {false, true}) {
        SoftDef upper = jelly_at(Vec3(0.1F, 1.3F, 0));
        upper.material.collides = collides;
        SoftDef lower = jelly_at(Vec3(0, 0, 0));
        for (SoftNode& n : lower.nodes) {
            n.pinned = true;
        }
        SoftBodies bodies;
        put(bodies, lower);
        const SoftId id = put(bodies, upper);
        run(bodies, 60);
        EXPECT_EQ(centre_of(bodies, id).y() > 0.8F, collides);
    }
}

TEST(SoftPairs, AllocateNothingAfterWarmUp) {
    SoftBodies bodies(with_frames(awake_soft()));
    put(bodies, jelly_at(Vec3(0, 0.53F, 0)));
    put(bodies, jelly_at(Vec3(0.1F, 1.6F, 0.1F)));
    put(bodies, rope_at(Vec3(0, 2.3F, 0)));
    put(bodies, balloon_at(Vec3(4, 0.53F, 0)));
    put(bodies, sheet_at(Vec3(3, 1.2F, -1)));
    Scene ground{PhysicsSettings()};
    add_floor(ground);
    run(bodies, 300, &ground);
    ASSERT_GT(bodies.stats().contacts, 0U);
    const std::uint64_t before = allocation_count();
    for (int i = 0; i < 120; ++i) {
        bodies.step(kFrame, &ground);
    }
    EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace zoned::physics::soft
