// The bandwidth meter from end to end: the server's figures equal the bytes sent and received.
#include "server/app/world/world.h"
#include "server/session/host/session_host.h"
#include "tests/harness/game_test.h"
#include "shared/wire/packet.h"

namespace zoned::harness {
namespace {

constexpr std::uint64_t kAround =
    wire::kDatagramHeaderBytes + wire::kSealTagBytes + wire::kDownTransportBytes;

class Traffic : public GameTest, public testing::WithParamInterface<const char*> {
  protected:
    Traffic() {
        server.sets.emplace_back("replication.bandwidth_meter=true");
        server.sets.emplace_back(std::string("replication.codec=") + GetParam());
        bots.meter = true;
        bots.bots = 12;
        bots.seconds = 8.0;
        bots.ramp_per_s = 1000.0;
    }

    [[nodiscard]] wire::TrafficTable made() const {
        wire::TrafficTable table;
        world->world().sum_traffic(table);
        return table;
    }
};

TEST_P(Traffic, IsWhatLeftTheServerByteForByte) {
    const measure::RunReport report = run();
    const session::HostStats& stats = world->host().stats();
    ASSERT_GT(made().packets(), 1000U);
    std::uint64_t withheld = 0;
    for (const char* reason : {"out_no_session", "out_sequence", "out_suspended"}) {
        withheld += stats.rejected.contains(reason) ? stats.rejected.at(reason) : 0;
    }
    EXPECT_EQ(withheld, 0U);
    EXPECT_EQ(made().packets(), stats.packets_out);
    EXPECT_EQ(made().bits() / 8 + kAround * made().packets(), stats.bytes_out);
    std::uint64_t frames = 0;
    for (const auto& [number, bytes] : stats.frame_bytes_by_message) {
        frames += bytes;
    }
    EXPECT_EQ(frames, stats.frame_bytes_out);
    EXPECT_GT(stats.frame_bytes_by_message.at(proto::ServerMessage::kEventFieldNumber), 0U);
}

TEST_P(Traffic, IsCountedAlikeByBothSides) {
    const measure::RunReport report = run();
    const wire::TrafficTable sent = made();
    const wire::TrafficTable& came = report.traffic;
    EXPECT_EQ(came.bits(wire::TrafficReason::kUnread), 0U);
    // Nothing is lost. At the end a tick's packets are on their path to each client, and a few go
    // out before a client has the world's description.
    const double under_way = 3.0 * static_cast<double>(bots.bots);
    EXPECT_NEAR(
        static_cast<double>(came.packets()), static_cast<double>(sent.packets()), under_way);
    const double few = 0.02;
    const auto agree = [&](std::uint64_t there, std::uint64_t here, const std::string& what) {
        EXPECT_NEAR(static_cast<double>(here),
                    static_cast<double>(there),
                    few * static_cast<double>(there) + 8.0 * 400.0)
            << what;
    };
    ASSERT_EQ(came.rows().size(), sent.rows().size());
    for (std::size_t i = 0; i < sent.rows().size(); ++i) {
        agree(sent.bits_of_row(i), came.bits_of_row(i), "row " + std::to_string(i));
    }
    for (std::size_t p = 0; p < wire::kTrafficParts; ++p) {
        agree(sent.bits_of_part(p), came.bits_of_part(p), wire::traffic_part_name(p));
    }
    agree(sent.bits(wire::TrafficReason::kRemoval),
          came.bits(wire::TrafficReason::kRemoval),
          "removals");
}

TEST_P(Traffic, DiffersByWhatWasLost) {
    server.network.loss = 0.1;
    server.network.delay_s = 0.03;
    const measure::RunReport report = run();
    EXPECT_TRUE(report.consistent) << reasons(report);
    const double share =
        static_cast<double>(report.traffic.bits()) / static_cast<double>(made().bits());
    // A tenth was lost: 0.9 within four standard deviations of some thousand packets.
    const auto packets = static_cast<double>(made().packets());
    EXPECT_NEAR(static_cast<double>(report.traffic.packets()) / packets,
                0.9,
                4.0 * std::sqrt(0.09 / packets) + 36.0 / packets);
    EXPECT_NEAR(share, 0.9, 0.04);
    EXPECT_GT(made().bits(wire::TrafficReason::kRepeat), 0U);
}

INSTANTIATE_TEST_SUITE_P(Codecs,
                         Traffic,
                         testing::Values("SHARED", "PER_CLIENT"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace zoned::harness
