#include "client-sim/view/aim.h"

#include "tests/unit/client/fake_server.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <vector>

namespace zoned::view {
namespace {

constexpr TypeIndex kPlayer = 1;

/// Characters 10 m ahead of a ray along x, each so far beside it; numbered from 1 on.
View view_of(const std::array<float, 10>& beside) {
    const auto world =
        std::make_shared<const WorldInfo>(*test::read_world(test::FakeServer().world()));
    View view(world, {}, nullptr);
    view.evaluate(100);
    std::vector<std::uint8_t> records;
    link::OpenedPacket packet;
    packet.sequence = 1;
    packet.head.tick = 100;
    packet.head.zone = ZoneId(1);
    for (std::uint32_t i = 0; i < beside.size(); ++i) {
        wire::RecordHead head;
        head.entity = EntityId(i + 1);
        head.tick_low = 100;
        head.type = kPlayer;
        motion::KinematicState s;
        s.position = Vec3(10.0F, 1.0F, beside[i]);
        const wire::Quantization q = world->quantization;
        const auto state = wire::quantize(s, motion::PredictorOrder::kLinear, true, false, 0, q);
        wire::encode_absolute(head, state, true, q, records);
    }
    packet.records = records;
    view.apply(packet, 100.0 / 30.0);
    view.evaluate(101);
    return view;
}

TEST(Aim, NamesTheNearestEightFirstTheNearerThenTheLowerNumber) {
    const View view = view_of({1.7F, 0.5F, 0.7F, 0.5F, 1.1F, 0.3F, 1.5F, 0.1F, 0.9F, 1.3F});
    const Aim found = aim(view, Vec3d(0.0, 1.0, 0.0), Vec3d::UnitX(), 100.0);
    std::vector<std::uint32_t> near;
    for (const AimSight& sight : found.near) {
        near.push_back(sight.entity.value);
    }
    EXPECT_EQ(near, (std::vector<std::uint32_t>{8, 6, 2, 4, 3, 9, 5, 10}));
    EXPECT_EQ(found.hit, EntityId(8)) << "the nearest along the ray";
}

}  // namespace
}  // namespace zoned::view
