// Contact events: which zone hears of the beginning, the lasting and the end of a contact.
#include "server/physics/scene/scene.h"
#include "tests/unit/allocation_count.h"

#include <gtest/gtest.h>

namespace zoned::physics {
namespace {

struct Count {
    int began = 0, lasted = 0, ended = 0;

    void take(const Scene& scene) {
        for (const ContactEvent& e : scene.contact_events()) {
            (e.began ? began : e.ended ? ended : lasted) += 1;
        }
    }
};

struct Drop {
    Scene scene{PhysicsSettings()};
    BodyId floor, ball;
    Count count;

    explicit Drop(std::uint8_t events, float restitution = 0.0F) {
        BodyDef def;
        def.kind = BodyKind::kStatic;
        def.shape = Shape::box({5, 0.5F, 5});
        def.position = Vec3(0, -0.5F, 0);
        floor = *scene.add(def);
        def = BodyDef();
        def.shape = Shape::sphere(0.5F);
        def.material.restitution = restitution;
        def.position = Vec3(0, 1.0F, 0);
        def.events = events;
        ball = *scene.add(def);
    }

    void run(int steps) {
        for (int i = 0; i < steps; ++i) {
            scene.step(1.0F / 60.0F);
            count.take(scene);
        }
    }
};

TEST(ContactEvents, AreNoneUntilSomebodyAsks) {
    Drop d(0);
    d.run(60);
    EXPECT_EQ(d.count.began + d.count.lasted + d.count.ended, 0);
}

TEST(ContactEvents, TellBeginOnceAndNothingElse) {
    Drop d(kTellBegin);
    d.run(120);
    EXPECT_EQ(d.count.began, 1);
    EXPECT_EQ(d.count.lasted + d.count.ended, 0);
}

TEST(ContactEvents, TellEachStepWithTheImpulseUntilTheBodySleeps) {
    Drop d(kTellPersist);
    d.run(40);  // lands after 0.32 s
    const auto events = d.scene.contact_events();
    ASSERT_EQ(events.size(), 1U);
    EXPECT_FALSE(events[0].began || events[0].ended);
    // A kilogram at rest: m g dt, within the swing of the soft contact.
    EXPECT_NEAR(events[0].impulse, 9.81F / 60.0F, 0.02F);
    EXPECT_NEAR(events[0].point.y(), 0.0F, 0.01F);
    EXPECT_NEAR(std::abs(events[0].normal.y()), 1.0F, 1e-4F);
    d.run(120);
    ASSERT_TRUE(d.scene.state(d.ball).asleep);
    EXPECT_TRUE(d.scene.contact_events().empty());
    EXPECT_EQ(d.count.ended, 0);
}

TEST(ContactEvents, EndWhenABallBouncesOff) {
    Drop d(kTellBegin | kTellEnd, 0.8F);
    d.run(45);
    EXPECT_GE(d.count.began, 1);
    EXPECT_EQ(d.count.began, d.count.ended);
}

TEST(ContactEvents, EndWhenABodyIsRemovedOrTeleportedButNotWhenItFallsAsleep) {
    for (const bool remove : {true, false}) {
        Drop d(kTellEnd);
        d.run(160);
        ASSERT_TRUE(d.scene.state(d.ball).asleep);
        ASSERT_EQ(d.count.ended, 0);
        if (remove) {
            d.scene.remove(d.floor);
        } else {
            BodyState s = d.scene.state(d.ball);
            s.position.y() += 3.0F;
            d.scene.set_state(d.ball, s);
        }
        d.run(1);
        EXPECT_EQ(d.count.ended, 1);
        EXPECT_TRUE(d.scene.contact_events()[0].ended);
        EXPECT_EQ(d.scene.contact_events()[0].a, d.floor);
        d.run(1);
        EXPECT_EQ(d.count.ended, 1);
    }
}

TEST(ContactEvents, AllocateNothingOnceWarm) {
    Drop d(kTellBegin | kTellPersist | kTellEnd, 0.9F);
    d.run(60);
    const auto before = allocation_count();
    for (int i = 0; i < 100; ++i) {
        d.scene.step(1.0F / 60.0F);
    }
    EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace zoned::physics
