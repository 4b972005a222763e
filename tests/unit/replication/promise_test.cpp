// The promised bound: predicted errors at every tick, on perfect and on bad networks.
#include "tests/unit/replication/session.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace zoned::replication {
namespace {

/// The largest error of a prediction relative to the promise, over all clients at this tick.
/// `old_ticks` is the greatest age of updates (D), 0 for none.
struct Excess {
    float position_m = -1e9F;
    float angle_rad = -1e9F;
    int missing = 0;
};

Excess excess_over_promise(const Session& s, int old_ticks) {
    Excess worst;
    const float age = static_cast<float>(old_ticks) * kTickS;
    for (std::size_t i = 0; i < s.remotes.size(); ++i) {
        const ModelClient& model = s.remotes[i].model;
        for (const world::Visible& v : s.visibility[i].visible) {
            const auto it = model.known.find(v.entity);
            if (it == model.known.end()) {
                ++worst.missing;
                continue;
            }
            const world::Row row = s.world.entities.find(v.entity);
            const world::EntityType& type = s.types[s.world.entities.type[row]];
            const motion::KinematicState predicted = model.predict(it->second, s.world.now);
            const motion::KinematicState truth = s.world.entities.kinematic(row);
            // An entity that a client still follows at the coarser level is promised no more than
            // that.
            const std::uint8_t lod = std::max(v.lod, it->second.lod);
            const wire::Quantization q = wire::at_lod(s.settings.quantization, it->second.lod);
            float allowed = s.settings.lods[lod].position_m + q.position_quantum_m() +
                            0.5F * type.max_acceleration_mps2 * age * age + 1e-4F;
            const Tick breach = std::max(s.replicator.breach_tick(v.entity, v.lod),
                                         s.replicator.breach_tick(v.entity, it->second.lod));
            if (breach > 0 && breach > s.world.now - old_ticks) {
                allowed += type.max_velocity_jump_mps * age;
            }
            worst.position_m =
                std::max(worst.position_m, (predicted.position - truth.position).norm() - allowed);
            const float angle_allowed = s.settings.lods[lod].orientation_rad +
                                        q.orientation_quantum_rad(type.upright()) + 1e-3F;
            worst.angle_rad = std::max(
                worst.angle_rad,
                motion::angle_between(predicted.orientation, truth.orientation) - angle_allowed);
        }
    }
    return worst;
}

/// In place of an order: each its own, records coded for each client.
constexpr int kCoded = 100;

TEST(Replicator, KeepsThePromisedBoundAtEveryTickOnAPerfectNetwork) {
    for (const int order : {-1, 0, 1, 2, 3, 4, kCoded}) {
        ReplicationSettings settings = test_settings();
        settings.forced_order = order == kCoded ? -1 : order;
        settings.codec = order == kCoded ? Codec::kPerClient : Codec::kShared;
        settings.ground = std::make_shared<const motion::StaticGeometry>();
        Session s(7, settings, {}, 20, 20, 4, 40.0F);
        for (int tick = 0; tick < 900; ++tick) {
            s.step();
            const Excess excess = excess_over_promise(s, 0);
            ASSERT_LE(excess.position_m, 0.0F) << "tick " << tick << " order " << order;
            ASSERT_LE(excess.angle_rad, 0.0F) << "tick " << tick << " order " << order;
            ASSERT_EQ(excess.missing, 0);
        }
        EXPECT_EQ(s.remotes[0].model.undecodable, 0);
        EXPECT_EQ(s.report.limit_exceeded, 0U);
    }
}

TEST(Replicator, KeepsThePromisedBoundUnderDelay) {
    NetSettings net;
    net.delay_ticks = 3;
    Session s(8, test_settings(), net, 20, 20, 4, 25.0F);
    s.radius = 90.0F;
    for (int tick = 0; tick < 900; ++tick) {
        s.step();
        // The first update takes the delay; no entity enters or leaves a radius of 90 m here.
        if (tick > net.delay_ticks + 1) {
            const Excess excess = excess_over_promise(s, net.delay_ticks + 1);
            ASSERT_LE(excess.position_m, 0.0F) << "tick " << tick;
            ASSERT_EQ(excess.missing, 0);
        }
    }
}

void keep_the_bound_under_loss(Codec codec) {
    NetSettings net;
    net.delay_ticks = 2;
    net.loss = 0.05F;
    net.duplicate = 0.02F;
    ReplicationSettings settings = test_settings();
    settings.codec = codec;
    Session s(9, settings, net, 20, 20, 4, 25.0F);
    s.radius = 90.0F;
    // One direction's delay + a tick, and one resend: a round trip (2 + 2 ticks and one until the
    // ack leaves) + a tick.
    const int old_ticks = 3 + 6;
    for (int tick = 0; tick < 1500; ++tick) {
        s.step();
        // The estimate of the loss has to warm up before updates are repeated enough.
        if (tick > 200) {
            const Excess excess = excess_over_promise(s, old_ticks);
            ASSERT_LE(excess.position_m, 0.0F) << "tick " << tick;
            ASSERT_EQ(excess.missing, 0);
        }
    }
}

TEST(Replicator, KeepsThePromisedBoundUnderFivePercentLossWithOneResend) {
    keep_the_bound_under_loss(Codec::kShared);
}

TEST(Replicator, KeepsThePromisedBoundUnderLossWithCodedRecords) {
    keep_the_bound_under_loss(Codec::kPerClient);
}

}  // namespace
}  // namespace zoned::replication
