// The declared fields that a view holds: whole after each newest record, and none that are refused.
#include "client-sim/view/view.h"
#include "tests/unit/client/fake_server.h"
#include "tests/unit/wire/wire_samples.h"

#include <gtest/gtest.h>

#include <cmath>

namespace zoned::view {
namespace {

constexpr wire::Quantization kSteps;

std::shared_ptr<const WorldInfo> world_with_health() {
    WorldInfo world = *test::read_world(test::FakeServer().world());
    world.fields.resize(world.types.size());
    world.fields[0] = wire::testing::health_alone();
    return std::make_shared<const WorldInfo>(std::move(world));
}

struct ViewFields : testing::Test {
    ViewFields()
        : view(world_with_health(),
               {motion::ConvergenceMethod::kLinear, true, ViewKind::kExtrapolate},
               nullptr) {}

    /// `health` below 0: the record has no declared fields. It is written as it is, in range or
    /// not.
    void record(bool absolute, Tick tick, int health) {
        wire::RecordHead head;
        head.entity = EntityId(5);
        head.tick_low = static_cast<std::uint8_t>(tick);
        motion::KinematicState s;
        s.position = Vec3(1.0F, 1.0F, 0.0F);
        const auto state =
            wire::quantize(s, motion::PredictorOrder::kStatic, false, true, 0, kSteps);
        std::vector<wire::DeclaredField> wider(1);  // of a server that lies about the range
        wider[0].name = "health";
        wider[0].most = 127;
        wider[0].initial[0] = 100;
        const auto schema = *wire::FieldSchema::make(std::move(wider));
        const std::vector<std::uint32_t> words{static_cast<std::uint32_t>(std::max(health, 0))};
        const wire::DeclaredPart part{schema.get(), words, health >= 0 ? 1U : 0U};
        if (absolute) {
            wire::encode_absolute(head, state, false, kSteps, records, part);
        } else {
            wire::encode_delta(head, state, state, false, kSteps, records, part);
        }
    }

    void deliver(std::uint64_t sequence, Tick tick) {
        link::OpenedPacket packet;
        packet.sequence = sequence;
        packet.head.tick = tick;
        packet.head.zone = ZoneId(1);
        packet.records = records;
        view.apply(packet, static_cast<double>(tick) / 30.0);
        records.clear();
    }

    [[nodiscard]] int health(Tick tick) const {
        const Entity* entity = view.store().find(EntityId(5));
        const auto words = entity != nullptr ? EntityStore::fields_at(*entity, tick)
                                             : std::span<const std::uint32_t>();
        return words.empty() ? -1 : static_cast<int>(words[0]);
    }

    View view;
    std::vector<std::uint8_t> records;
};

/// A soft body with a lattice of 2 x 1 x 1 control points behind a field of the game.
proto::WorldDescription world_with_lattice() {
    proto::WorldDescription world = test::FakeServer().world();
    proto::EntityType& type = *world.mutable_types(0);
    for (const char* name : {"health", "control_point_0", "control_point_1"}) {
        proto::DeclaredField& field = *type.add_fields();
        field.set_name(name);
        field.set_quantum(1.0);
        field.set_steps(wire::kMostFieldSteps);
    }
    proto::Deformation& lattice = *type.mutable_deformation();
    lattice.set_first_field(1);
    for (const std::uint32_t points : {2U, 1U, 1U}) {
        lattice.add_points(points);
        lattice.add_lower(-1.0F);
        lattice.add_upper(1.0F);
    }
    lattice.set_quantum_m(0.01F);
    lattice.set_bound_m(0.05F);
    return world;
}

TEST(ViewDeformation, IsReadWhereTheTypeHasFieldsForIt) {
    const auto read = test::read_world(world_with_lattice());
    ASSERT_TRUE(read.ok()) << read.error();
    ASSERT_TRUE(read->types[0].deformation.has_value());
    EXPECT_EQ(read->types[0].deformation->size(), 2U);
    EXPECT_EQ(read->types[0].first_control_point, 1U);
    EXPECT_FALSE(test::read_world(test::FakeServer().world())->types[0].deformation.has_value());
}

TEST(ViewDeformation, IsRefusedWhereItIsNone) {
    using Change = void (*)(proto::EntityType&);
    for (const Change change : {
             Change([](proto::EntityType& t) { t.clear_fields(); }),
             Change([](proto::EntityType& t) { t.mutable_deformation()->set_first_field(2); }),
             Change([](proto::EntityType& t) { t.mutable_deformation()->set_first_field(~0U); }),
             Change([](proto::EntityType& t) { t.mutable_deformation()->set_points(0, 0); }),
             Change([](proto::EntityType& t) { t.mutable_deformation()->set_points(0, 3); }),
             Change([](proto::EntityType& t) { t.mutable_deformation()->set_points(1, ~0U); }),
             Change([](proto::EntityType& t) { t.mutable_deformation()->add_points(1); }),
             Change([](proto::EntityType& t) { t.mutable_deformation()->set_lower(2, 2.0F); }),
             Change([](proto::EntityType& t) { t.mutable_deformation()->set_upper(0, NAN); }),
             Change([](proto::EntityType& t) { t.mutable_deformation()->set_quantum_m(0.0F); }),
             Change([](proto::EntityType& t) { t.mutable_deformation()->set_bound_m(NAN); }),
             Change([](proto::EntityType& t) { t.mutable_fields(2)->set_steps(100); }),
         }) {
        proto::WorldDescription world = world_with_lattice();
        change(*world.mutable_types(0));
        const auto read = test::read_world(world);
        ASSERT_FALSE(read.ok());
        EXPECT_EQ(read.error(), "malformed deformation of an entity type");
    }
}

TEST_F(ViewFields, AreKnownAtEachRecentTick) {
    record(true, 100, -1);
    deliver(1, 100);
    EXPECT_EQ(health(99), -1);
    EXPECT_EQ(health(100), 100);  // initial
    record(false, 104, 60);
    deliver(3, 104);
    record(false, 102, 80);  // overtaken: the newer one says all that it said
    deliver(2, 103);
    EXPECT_EQ(health(103), 100);
    EXPECT_EQ(health(104), 60);
    record(false, 106, -1);
    deliver(4, 106);
    EXPECT_EQ(health(106), 60);
    record(true, 108, -1);
    deliver(5, 108);
    EXPECT_EQ(health(107), 60);
    EXPECT_EQ(health(108), 100);
    EXPECT_EQ(view.stats().malformed_records, 0U);
}

// Values from before a long silence are compared with audits of the ticks just after it.
TEST_F(ViewFields, HoldOverALongSilenceUntilTheNextChange) {
    record(true, 100, 70);
    deliver(1, 100);
    constexpr Tick kLater = 100 + 3 * EntityStore::kHistoryTicks;
    record(false, kLater, 60);
    deliver(2, kLater);
    record(false, kLater + 2, 50);
    deliver(3, kLater + 2);
    EXPECT_EQ(health(kLater - 1), 70);
    EXPECT_EQ(health(kLater + 1), 60);
    EXPECT_EQ(health(kLater + 2), 50);
}

TEST_F(ViewFields, BeyondTheirRangeAreRefusedAndCounted) {
    record(true, 100, 50);
    deliver(1, 100);
    record(false, 102, 101);
    deliver(2, 102);
    EXPECT_EQ(health(102), 50);
    EXPECT_EQ(view.stats().malformed_records, 1U);
    EXPECT_EQ(view.stats().refused_fields[static_cast<std::size_t>(wire::DeclaredFault::kRange)],
              1U);
    EXPECT_EQ(view.take_reset_wish(4.0), "a declared field beyond its range");
}

}  // namespace
}  // namespace zoned::view
