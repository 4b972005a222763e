#include "client-sim/view/view.h"

#include "tests/unit/client/fake_server.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::view {
namespace {

constexpr wire::Quantization kQ;
constexpr TypeIndex kBall = 0;

std::shared_ptr<const WorldInfo> fake_world() {
    static const auto world =
        std::make_shared<const WorldInfo>(*test::read_world(test::FakeServer().world()));
    return world;
}

motion::KinematicState moving(float x, float vx) {
    motion::KinematicState s;
    s.position = Vec3(x, 1.0F, 0.0F);
    s.velocity = Vec3(vx, 0.0F, 0.0F);
    return s;
}

wire::QuantizedState quantized(const motion::KinematicState& s) {
    return wire::quantize(s, motion::PredictorOrder::kLinear, false, false, 0, kQ);
}

/// Builds packets by hand.
struct ViewTest : testing::Test {
    explicit ViewTest(ViewKind kind = ViewKind::kExtrapolate)
        : view(fake_world(), {motion::ConvergenceMethod::kLinear, true, kind}, nullptr) {}

    void absolute(std::uint32_t id,
                  Tick tick,
                  const motion::KinematicState& s,
                  int keyframe,
                  int lod = 0) {
        wire::RecordHead head;
        head.entity = EntityId(id);
        head.lod = static_cast<std::uint8_t>(lod);
        head.keyframe = static_cast<std::uint8_t>(keyframe);
        head.tick_low = static_cast<std::uint8_t>(tick);
        head.type = kBall;
        wire::encode_absolute(head, quantized(s), false, kQ, records);
    }

    void delta(std::uint32_t id,
               Tick tick,
               const motion::KinematicState& s,
               const motion::KinematicState& base,
               int keyframe) {
        wire::RecordHead head;
        head.kind = wire::RecordKind::kDelta;
        head.entity = EntityId(id);
        head.keyframe = static_cast<std::uint8_t>(keyframe);
        head.tick_low = static_cast<std::uint8_t>(tick);
        wire::encode_delta(head, quantized(s), quantized(base), false, kQ, records);
    }

    void remove(std::uint32_t id) { wire::encode_remove(EntityId(id), records); }

    void deliver(std::uint64_t sequence, Tick tick, std::uint16_t zone = 1) {
        link::OpenedPacket packet;
        packet.sequence = sequence;
        packet.head.tick = tick;
        packet.head.zone = ZoneId(zone);
        packet.records = records;
        view.apply(packet, static_cast<double>(tick) / 30.0);
        records.clear();
    }

    double predicted_x(std::uint32_t id, Tick tick) const {
        const Entity* e = view.store().find(EntityId(id));
        const Version* v = e != nullptr ? EntityStore::version_at(*e, tick) : nullptr;
        return v != nullptr && v->present ? view.store().predicted(*v, tick).position.x() : -1e9;
    }

    bool present(std::uint32_t id, Tick tick) const { return predicted_x(id, tick) > -1e8; }

    View view;
    std::vector<std::uint8_t> records;
};

TEST_F(ViewTest, ExtrapolatesFromTheNewestPublication) {
    view.evaluate(101);
    absolute(5, 100, moving(10.0F, 3.0F), 0);
    deliver(1, 100);
    // Half a step of position and of velocity over one second.
    EXPECT_NEAR(predicted_x(5, 130), 13.0, 0.005 + 1.0 / 128.0);
    EXPECT_FALSE(present(5, 101)) << "it came after tick 101 had been displayed";
    EXPECT_TRUE(present(5, 102));
}

TEST_F(ViewTest, RemembersWhatWasDisplayedAtRecentTicks) {
    view.evaluate(101);
    absolute(5, 100, moving(10.0F, 3.0F), 0);
    deliver(1, 100);
    view.evaluate(111);
    absolute(5, 110, moving(20.0F, 0.0F), 1);
    deliver(2, 110);
    EXPECT_NEAR(predicted_x(5, 111), 11.1, 0.02);
    EXPECT_NEAR(predicted_x(5, 112), 20.0, 0.006);
}

TEST_F(ViewTest, DecodesDeltasAgainstTheKeyframeThatTheyName) {
    const auto base = moving(10.0F, 3.0F);
    absolute(5, 100, base, 3);
    deliver(1, 100);
    absolute(5, 105, moving(50.0F, 0.0F), 4);
    deliver(2, 105);
    delta(5, 110, moving(11.0F, 3.5F), base, 3);
    deliver(3, 110);
    EXPECT_NEAR(predicted_x(5, 110), 11.0, 0.006);
    EXPECT_EQ(view.stats().unknown_keyframes, 0U);
}

TEST_F(ViewTest, IgnoresPublicationsOlderThanTheNewest) {
    absolute(5, 110, moving(20.0F, 0.0F), 1);
    deliver(2, 110);
    absolute(5, 100, moving(10.0F, 0.0F), 0);
    deliver(1, 100);
    EXPECT_NEAR(predicted_x(5, 120), 20.0, 0.006);
    // But the late keyframe is known: the server may know that it arrived.
    delta(5, 112, moving(12.0F, 0.0F), moving(10.0F, 0.0F), 0);
    deliver(3, 112);
    EXPECT_NEAR(predicted_x(5, 120), 12.0, 0.006);
}

TEST_F(ViewTest, ChangesTheLevelOfDetailByThePacketNotByThePublication) {
    absolute(5, 110, moving(20.4F, 0.0F), 0, 1);
    deliver(1, 110);
    // Nearer now: the finer stream's newest publication is older, but it is the valid one.
    absolute(5, 104, moving(20.0F, 0.0F), 0, 0);
    deliver(2, 112);
    EXPECT_NEAR(predicted_x(5, 120), 20.0, 0.006);
    // A late copy from the coarse stream does not come back.
    absolute(5, 111, moving(30.0F, 0.0F), 1, 1);
    deliver(1, 111);
    EXPECT_NEAR(predicted_x(5, 120), 20.0, 0.006);
}

TEST_F(ViewTest, ARemoveWinsOnlyOverOlderPackets) {
    absolute(5, 100, moving(1.0F, 0.0F), 0);
    deliver(1, 100);
    absolute(5, 102, moving(2.0F, 0.0F), 1);
    deliver(3, 102);
    remove(5);
    deliver(2, 101);
    EXPECT_TRUE(present(5, 110));
    remove(5);
    deliver(4, 103);
    EXPECT_FALSE(present(5, 110));
    EXPECT_EQ(view.store().present_count(), 0U);
    // A record that came after a later remove stays out; a newer one comes in.
    absolute(5, 102, moving(2.0F, 0.0F), 1);
    deliver(3, 102);
    EXPECT_FALSE(present(5, 110));
    absolute(5, 100, moving(1.0F, 0.0F), 2);
    deliver(5, 105);
    EXPECT_TRUE(present(5, 110));
}

TEST_F(ViewTest, ARemoveThatOvertakesTheFirstRecordKeepsItOut) {
    remove(8);
    deliver(2, 101);
    absolute(8, 100, moving(1.0F, 0.0F), 0);
    deliver(1, 100);
    EXPECT_FALSE(present(8, 110));
}

TEST_F(ViewTest, KeepsWorldCoordinatesWhenTheClientChangesZones) {
    absolute(5, 100, moving(490.0F, 0.0F), 0);
    deliver(1, 100);
    view.evaluate(100);
    // The second zone's origin lies 1000 m further along x.
    absolute(5, 101, moving(-510.0F, 0.0F), 0);
    deliver(2, 101, 2);
    EXPECT_NEAR(predicted_x(5, 102), 490.0, 0.006);
    const Entity* e = view.store().find(EntityId(5));
    const WorldState shown = view.store().displayed(*EntityStore::version_at(*e, 102), 102);
    EXPECT_NEAR(shown.position.x(), 490.0, 0.02) << "convergence starts from the same place";
    EXPECT_EQ(view.stats().zone_changes, 1U);
}

TEST_F(ViewTest, LeadsTheDisplayedStateToThePredictedOneWithoutAJump) {
    absolute(5, 100, moving(10.0F, 0.0F), 0);
    deliver(1, 100);
    view.evaluate(104);
    absolute(5, 104, moving(11.0F, 0.0F), 1);
    deliver(2, 104);
    const Entity* e = view.store().find(EntityId(5));
    const auto shown = [&](Tick t) {
        return view.store().displayed(*EntityStore::version_at(*e, t), t).position.x();
    };
    EXPECT_NEAR(shown(104), 10.0, 0.01);
    // Linear over kBlendS = 4.5 ticks: a jump of 1 m falls by 1/4.5 m per tick.
    for (Tick t = 105; t <= 108; ++t) {
        EXPECT_NEAR(shown(t), 10.0 + static_cast<double>(t - 104) / 4.5, 0.01);
    }
    EXPECT_NEAR(shown(109), 11.0, 0.006);
    EXPECT_NEAR(predicted_x(5, 105), 11.0, 0.006) << "the prediction jumps at once";
}

TEST_F(ViewTest, AsksForAResetWhenADeltaNamesAnUnknownKeyframe) {
    absolute(5, 100, moving(1.0F, 0.0F), 0);
    absolute(6, 100, moving(2.0F, 0.0F), 0);
    deliver(1, 100);
    delta(5, 104, moving(1.5F, 0.0F), moving(1.0F, 0.0F), 9);
    absolute(6, 104, moving(3.0F, 0.0F), 1);
    deliver(2, 104);
    EXPECT_EQ(view.stats().unknown_keyframes, 1U);
    EXPECT_NEAR(predicted_x(6, 110), 3.0, 0.006) << "the rest of the packet is still good";
    EXPECT_FALSE(view.take_reset_wish(4.0).empty());
    EXPECT_EQ(view.stats().resets, 1U);
    // During the reset no further one is requested.
    delta(5, 105, moving(1.5F, 0.0F), moving(1.0F, 0.0F), 9);
    deliver(3, 105);
    EXPECT_TRUE(view.take_reset_wish(4.5).empty());
    // Entities heard again stay, the rest goes.
    absolute(6, 106, moving(4.0F, 0.0F), 2);
    deliver(4, 106);
    view.take_reset_wish(4.0 + View::kResetS + 0.1);
    view.evaluate(300);
    EXPECT_TRUE(present(6, 301));
    EXPECT_FALSE(present(5, 301));
    EXPECT_EQ(view.stats().dropped_by_reset, 1U);
}

TEST_F(ViewTest, SurvivesHostileRecords) {
    core::Rng rng(3);
    for (int round = 0; round < 20000; ++round) {
        absolute(1 + rng.below(5),
                 100 + round / 100,
                 moving(1.0F, 1.0F),
                 static_cast<int>(rng.below(16)));
        if (rng.below(2) == 0) {
            // Some bits of a good packet flip, or its end is missing.
            for (std::uint32_t i = rng.below(4); i > 0; --i) {
                records[rng.below(static_cast<std::uint32_t>(records.size()))] ^=
                    static_cast<std::uint8_t>(1U << rng.below(8));
            }
            records.resize(rng.below(static_cast<std::uint32_t>(records.size()) + 1));
        } else {
            records.resize(rng.below(80));
            for (auto& b : records) {
                b = static_cast<std::uint8_t>(rng.next());
            }
        }
        deliver(static_cast<std::uint64_t>(round + 1),
                100 + round / 100,
                static_cast<std::uint16_t>(1 + rng.below(3)));
        view.take_reset_wish(round * 0.01);
    }
    view.maintain(1e6);
    EXPECT_GT(view.stats().malformed_records, 0U);
    EXPECT_GT(view.stats().resets, 0U);
}

TEST(ReadWorld, RefusesWhatAClientCouldNotWorkWith) {
    const proto::WorldDescription good = test::FakeServer().world();
    EXPECT_TRUE(test::read_world(good).ok());
    const auto refused = [&](auto&& spoil) {
        proto::WorldDescription w = good;
        spoil(w);
        return !test::read_world(w).ok();
    };
    EXPECT_TRUE(refused([](auto& w) { w.set_tick_rate_hz(0.0); }));
    EXPECT_TRUE(refused([](auto& w) { w.clear_lods(); }));
    EXPECT_TRUE(refused([](auto& w) { w.clear_zones(); }));
    EXPECT_TRUE(refused([](auto& w) { w.mutable_zones(0)->clear_origin(); }));
    EXPECT_TRUE(refused([](auto& w) { w.add_boxes()->add_centre(1.0F); }));
    EXPECT_TRUE(refused([](auto& w) { w.mutable_quantization()->set_position_step_m(0.0F); }));
    EXPECT_TRUE(refused([](auto& w) { w.mutable_quantization()->set_orientation_bits(31); }));
}

/// A slope of 2 x 2 m as heights, and a triangle.
proto::WorldDescription with_surfaces() {
    proto::WorldDescription w = test::FakeServer().world();
    proto::StaticSurface& slope = *w.add_surfaces();
    for (const double at : {10.0, 1.0, 0.0}) {
        slope.add_position(at);
    }
    proto::StaticSurface::Heights& heights = *slope.mutable_heights();
    heights.set_columns(2);
    heights.set_rows(2);
    heights.set_spacing_x(2.0F);
    heights.set_spacing_z(2.0F);
    for (const float height : {0.0F, 1.0F, 0.0F, 1.0F}) {
        heights.add_height(height);
    }
    proto::StaticSurface& triangle = *w.add_surfaces();
    for (const double at : {-10.0, 0.0, 0.0}) {
        triangle.add_position(at);
    }
    for (const float n : {0.0F, 2.0F, 0.0F, 0.0F, 2.0F, 3.0F, 3.0F, 2.0F, 0.0F}) {
        triangle.mutable_triangles()->add_vertex(n);
    }
    for (const std::uint32_t corner : {0U, 1U, 2U}) {
        triangle.mutable_triangles()->add_corner(corner);
    }
    w.add_surfaces()->mutable_position()->Resize(3, 0.0);  // the server keeps this one to itself
    return w;
}

TEST(ReadWorld, PutsSurfacesAroundTheOriginOfEachZone) {
    const auto world = test::read_world(with_surfaces());
    ASSERT_TRUE(world.ok()) << world.error();
    for (const ZoneInfo& zone : world->zones) {
        ASSERT_EQ(zone.geometry.surfaces().size(), 2u);
        const auto at = [&](double x, double z) {
            return zone.geometry.floor_at(static_cast<float>(x - zone.origin.x()),
                                          static_cast<float>(z - zone.origin.z())) +
                   static_cast<float>(zone.origin.y());
        };
        EXPECT_FLOAT_EQ(at(10.0, 0.2), 1.5F);
        EXPECT_FLOAT_EQ(at(-9.5, 0.5), 2.0F);
        EXPECT_LT(at(-20.0, 0.0), 0.5F);
    }
    EXPECT_EQ(&world->zones.front().geometry.surfaces()[0].surface(),
              &world->zones.back().geometry.surfaces()[0].surface())
        << "zones share one copy";
}

TEST(ReadWorld, RefusesMalformedSurfaces) {
    ASSERT_TRUE(test::read_world(with_surfaces()).ok());
    const auto refused = [&](auto&& spoil) {
        proto::WorldDescription w = with_surfaces();
        spoil(*w.mutable_surfaces(0), *w.mutable_surfaces(1));
        return !test::read_world(w).ok();
    };
    EXPECT_TRUE(refused([](auto& h, auto&) { h.clear_position(); }));
    EXPECT_TRUE(refused([](auto& h, auto&) { h.set_position(1, NAN); }));
    EXPECT_TRUE(refused([](auto& h, auto&) { h.add_orientation(1.0F); }));
    EXPECT_TRUE(refused([](auto& h, auto&) { h.mutable_triangles(); }));
    EXPECT_TRUE(refused([](auto& h, auto&) { h.mutable_heights()->set_columns(3); }));
    EXPECT_TRUE(refused([](auto& h, auto&) { h.mutable_heights()->set_columns(1U << 31U); }));
    EXPECT_TRUE(refused([](auto& h, auto&) { h.mutable_heights()->set_spacing_x(0.0F); }));
    EXPECT_TRUE(refused([](auto& h, auto&) { h.mutable_heights()->set_height(1, NAN); }));
    EXPECT_TRUE(refused([](auto&, auto& t) { t.mutable_triangles()->set_corner(2, 3); }));
    EXPECT_TRUE(refused([](auto&, auto& t) { t.mutable_triangles()->add_corner(0); }));
    EXPECT_TRUE(refused([](auto&, auto& t) { t.mutable_triangles()->add_vertex(0.0F); }));
    EXPECT_TRUE(refused([](auto&, auto& t) { t.mutable_triangles()->clear_corner(); }));
    EXPECT_TRUE(refused([](auto&, auto& t) { t.mutable_triangles()->set_vertex(0, INFINITY); }));
}

struct OwnAvatarTest : testing::Test {
    /// The server's result for the same inputs.
    motion::CharacterState server_step(const motion::InputCommand& c) {
        state = motion::apply_input(state,
                                    c,
                                    fake_world()->types[1].limits,
                                    fake_world()->zone(ZoneId(1))->geometry,
                                    static_cast<float>(fake_world()->tick_s));
        return state;
    }

    static motion::InputCommand command(Tick tick) {
        motion::InputCommand c;
        c.tick = tick;
        c.move_x = static_cast<std::int8_t>(((tick / 20) % 3 - 1) * 127);
        c.move_z = static_cast<std::int8_t>(((tick / 35) % 3 - 1) * 100);
        c.buttons = static_cast<std::uint16_t>(tick % 50 == 0 ? motion::kButtonJump : 0);
        return c;
    }

    static wire::OwnState own(Tick tick, const motion::CharacterState& s) {
        wire::OwnState o;
        o.avatar = EntityId(9);
        o.input_tick = tick;
        o.state = s;
        return o;
    }

    OwnAvatarTest() {
        state.position = Vec3(3.0F, 0.9F, 4.0F);
        state.grounded = true;
    }

    motion::CharacterState state;
    OwnAvatar avatar{*fake_world()};
};

TEST_F(OwnAvatarTest, NeedsNoCorrectionWhenTheServerHadTheSameInputs) {
    const Tick lead = 5;
    avatar.reconcile(own(100, state), ZoneId(1));
    for (Tick t = 101; t <= 101 + lead; ++t) {
        avatar.push(command(t));
    }
    for (Tick t = 101; t < 400; ++t) {
        const motion::CharacterState truth = server_step(command(t));
        const Correction c = avatar.reconcile(own(t, truth), ZoneId(1));
        EXPECT_TRUE(c.compared);
        EXPECT_EQ(c.distance_m, 0.0) << "at tick " << t;
        avatar.push(command(t + lead + 1));
    }
}

TEST_F(OwnAvatarTest, ReplaysTheNewerInputsOverACorrection) {
    avatar.reconcile(own(100, state), ZoneId(1));
    for (Tick t = 101; t <= 110; ++t) {
        avatar.push(command(t));
    }
    for (Tick t = 101; t <= 104; ++t) {
        server_step(command(t));
    }
    state.position.x() += 0.5F;  // another body pushed the avatar
    const Correction c = avatar.reconcile(own(104, state), ZoneId(1));
    EXPECT_NEAR(c.distance_m, 0.5, 1e-4);
    for (Tick t = 105; t <= 110; ++t) {
        server_step(command(t));
    }
    EXPECT_EQ(avatar.position(), state.position.cast<double>());
    // Once corrected the states agree again.
    EXPECT_EQ(avatar.reconcile(own(110, state), ZoneId(1)).distance_m, 0.0);
}

TEST_F(OwnAvatarTest, IgnoresStatesOlderThanTheNewest) {
    avatar.reconcile(own(100, state), ZoneId(1));
    avatar.reconcile(own(105, state), ZoneId(1));
    state.position.x() += 7.0F;
    EXPECT_FALSE(avatar.reconcile(own(103, state), ZoneId(1)).applied);
}

TEST_F(OwnAvatarTest, StaysInPlaceWhenItChangesZones) {
    avatar.reconcile(own(100, state), ZoneId(1));
    for (Tick t = 101; t <= 110; ++t) {
        avatar.push(command(t));
        server_step(command(t));
    }
    motion::CharacterState there = state;
    there.position.x() -= 1000.0F;
    const Correction c = avatar.reconcile(own(110, there), ZoneId(2));
    // Half a unit in the last place of a float near 1000: 3e-5.
    EXPECT_NEAR(c.distance_m, 0.0, 1e-4);
    EXPECT_EQ(avatar.zone(), ZoneId(2));
}

/// A server may send a state of any tick. Its place in the ring may hold the newest command.
TEST_F(OwnAvatarTest, SendsOnlyConsecutiveCommandsAfterAStateAWholeRingAway) {
    const auto ring = static_cast<Tick>(OwnAvatar::kRing);
    for (const Tick away : {-ring, ring, 2 * ring, 1000 * ring}) {
        OwnAvatar own(*fake_world());
        motion::InputCommand command;
        for (command.tick = 1; command.tick <= 2 * ring; ++command.tick) {
            own.push(command);
        }
        wire::OwnState sent;
        sent.avatar = EntityId(7);
        sent.input_tick = 2 * ring + away;
        own.reconcile(sent, ZoneId(1));
        const auto commands = own.newest_commands(wire::kMaxCommandsPerPacket);
        for (std::size_t i = 0; i < commands.size(); ++i) {
            EXPECT_EQ(commands[i].tick, 2 * ring + 1 - static_cast<Tick>(commands.size() - i))
                << away;
        }
    }
}

TEST_F(OwnAvatarTest, SendsTheNewestCommandsInOrder) {
    for (Tick t = 101; t <= 110; ++t) {
        avatar.push(command(t));
    }
    const auto newest = avatar.newest_commands(4);
    ASSERT_EQ(newest.size(), 4U);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_EQ(newest[i], command(107 + static_cast<Tick>(i)));
    }
}

struct InterpolatingViewTest : ViewTest {
    InterpolatingViewTest() : ViewTest(ViewKind::kInterpolate) {}

    /// Ticks pass; nothing comes.
    void until(Tick tick) {
        for (Tick t = view.tick() + 1; t <= tick; ++t) {
            view.evaluate(t);
        }
    }

    double shown_x(std::uint32_t id, double tick) const {
        const Entity* e = view.store().find(EntityId(id));
        const auto shown = view.store().interpolated(*e, tick, view.tick(), &remaining);
        return shown ? shown->position.x() : -1e9;
    }

    mutable double remaining = 0.0;
};

TEST_F(InterpolatingViewTest, HoldsThePredictionUntilTheNextPublicationAndLeadsToIt) {
    view.evaluate(103);
    absolute(5, 100, moving(10.0F, 3.0F), 0);
    deliver(1, 100);
    until(113);
    absolute(5, 110, moving(11.05F, 0.0F), 1);
    deliver(2, 110);
    until(114);
    // The prediction of the first, 3 m/s, holds until shortly before the second.
    EXPECT_NEAR(shown_x(5, 106.0), 10.6, 0.006);
    EXPECT_EQ(remaining, 0.0);
    // The path leads to the second within the remaining error, and is exact once it holds.
    double before = shown_x(5, 108.0);
    for (double tick = 108.0; tick < 110.0; tick += 0.1) {
        const double x = shown_x(5, tick);
        const double implied = 10.0 + 0.1 * (tick - 100.0);
        EXPECT_LE(std::abs(x - implied), remaining + 0.006) << tick;
        EXPECT_LT(std::abs(x - before), 0.04) << "no jump";
        before = x;
    }
    EXPECT_NEAR(before, 11.05, 0.02);
    EXPECT_NEAR(shown_x(5, 110.0), 11.05, 0.006);
    // A cubic Hermite spline has the velocities of both ends, too.
    const double h = 0.05;
    EXPECT_NEAR((shown_x(5, 108.0 + h) - shown_x(5, 108.0)) / h, 0.1, 0.02);
    EXPECT_NEAR((shown_x(5, 110.0 - 1e-6) - shown_x(5, 110.0 - h)) / h, 0.0, 0.02);
}

TEST_F(InterpolatingViewTest, ShowsAPublicationThatWasOvertakenFromItsTickOn) {
    view.evaluate(101);
    absolute(5, 100, moving(10.0F, 0.0F), 0);
    deliver(1, 100);
    absolute(5, 108, moving(30.0F, 0.0F), 2);
    deliver(3, 108);
    absolute(5, 104, moving(20.0F, 0.0F), 1);
    deliver(2, 104);
    until(115);
    const Entity* e = view.store().find(EntityId(5));
    EXPECT_EQ(EntityStore::implied(*e, 103, 115)->publication_tick, 100);
    EXPECT_EQ(EntityStore::implied(*e, 106, 115)->publication_tick, 104);
    EXPECT_EQ(EntityStore::implied(*e, 109, 115)->publication_tick, 108);
    // A view cannot have displayed an update that was not known yet.
    EXPECT_EQ(EntityStore::implied(*e, 100, 101), nullptr);
}

TEST_F(InterpolatingViewTest, AnEntityGoesAtTheTickOfItsRemoval) {
    view.evaluate(103);
    absolute(5, 100, moving(10.0F, 3.0F), 0);
    deliver(1, 100);
    remove(5);
    deliver(2, 110);
    until(115);
    EXPECT_GT(shown_x(5, 109.5), 0.0);
    EXPECT_EQ(shown_x(5, 110.0), -1e9);
}

TEST_F(InterpolatingViewTest, ATeleportIsNotLedTo) {
    view.evaluate(103);
    absolute(5, 100, moving(10.0F, 0.0F), 0);
    deliver(1, 100);
    absolute(5, 110, moving(50.0F, 0.0F), 1);
    deliver(2, 110);
    until(115);
    EXPECT_NEAR(shown_x(5, 109.9), 10.0, 0.006);
    EXPECT_NEAR(shown_x(5, 110.0), 50.0, 0.006);
}

}  // namespace
}  // namespace zoned::view
