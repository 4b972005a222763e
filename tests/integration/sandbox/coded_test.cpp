// Packets of coded records that a client can't decode: both sides lose them, and nothing more.
#include "server/app/world/world.h"
#include "tests/harness/game_test.h"
#include "tests/harness/transport_tap.h"
#include "shared/wire/packet.h"
#include "shared/wire/seal.h"

#include <optional>
#include <utility>

namespace zoned::harness {
namespace {

/// The damage to packets of coded records on their path to all clients.
struct Spoiling {
    std::function<bool(std::uint64_t sequence)> chosen;
    std::uint64_t packets = 0;
};

/// Opens each datagram down under its own key and cuts the code of chosen packets to a byte, which
/// is too short for any head: authentic, fresh, and not to be decoded.
class SpoilingTransport final : public TransportTap {
  public:
    SpoilingTransport(std::unique_ptr<link::Transport> inner, std::shared_ptr<Spoiling> spoiling)
        : TransportTap(std::move(inner)),
          spoiling_(std::move(spoiling)) {}

  private:
    void on_frame(link::Bytes& frame) override {
        wire::ServerMessage message;
        ASSERT_TRUE(wire::decode_message(frame, message));
        if (const auto* welcome = std::get_if<wire::WelcomeMessage>(&message.message)) {
            seal_.emplace(wire::SealKey::from(welcome->datagram_key_down).value());
        }
    }

    void on_datagram(link::Bytes& datagram) override {
        const auto header = wire::read_datagram_header(datagram);
        if (!header || !seal_) {
            return;
        }
        const std::uint64_t sequence = wire::expand_sequence(header->sequence_low, newest_ + 1);
        const std::span<const std::uint8_t> all(datagram);
        const auto associated = all.first(wire::kDatagramHeaderBytes);
        std::vector<std::uint8_t> plain;
        if (!seal_->open(sequence, associated, all.subspan(wire::kDatagramHeaderBytes), plain)) {
            return;
        }
        newest_ = std::max(newest_, sequence);
        const auto body = std::span(plain).subspan(wire::kDownTransportBytes);
        const auto head = wire::read_down_head(body);
        if (!head || !head->head.coded || !spoiling_->chosen(sequence)) {
            return;
        }
        plain.resize(wire::kDownTransportBytes + head->records_offset + 1);
        link::Bytes again(associated.begin(), associated.end());
        const link::Bytes same(again);
        seal_->seal(sequence, same, plain, again);
        datagram = std::move(again);
        ++spoiling_->packets;
    }

    std::shared_ptr<Spoiling> spoiling_;
    std::optional<wire::Seal> seal_;
    std::uint64_t newest_ = 0;
};

class CodedRecords : public GameTest {
  protected:
    CodedRecords() {
        server.sets = {"replication.codec=PER_CLIENT"};
        server.network.delay_s = 0.04;
        bots.seconds = 8.0;
        wrap = [this](std::unique_ptr<link::Transport> inner) {
            return std::make_unique<SpoilingTransport>(std::move(inner), spoiling);
        };
    }

    /// Consistent but for the packets that could not be decoded.
    void expect_whole(const measure::RunReport& report) const {
        EXPECT_EQ(report.converged_bots, 8u) << reasons(report);
        EXPECT_EQ(report.reasons.size(), 1u) << reasons(report);
        EXPECT_TRUE(has_reason(report, "wire: ")) << reasons(report);
        EXPECT_EQ(report.malformed_records, spoiling->packets);
        EXPECT_EQ(report.malformed, 0u);
        EXPECT_GT(report.audit.samples_after_loss, 0u);
    }

    std::shared_ptr<Spoiling> spoiling = std::make_shared<Spoiling>();
};

TEST_F(CodedRecords, ThatCannotBeDecodedAreToldAgainWithoutAReset) {
    spoiling->chosen = [](std::uint64_t sequence) {
        return sequence % 9 == 5;
    };
    const measure::RunReport report = run();
    expect_whole(report);
    EXPECT_GT(spoiling->packets, 50u);
    EXPECT_EQ(report.view_resets, 0u);
}

TEST_F(CodedRecords, OfWhichNoneCanBeDecodedForAWhileEndInAReset) {
    spoiling->chosen = [this](std::uint64_t) {
        return world->now_s() > 3.0 && world->now_s() < 3.5;
    };
    const measure::RunReport report = run();
    expect_whole(report);
    EXPECT_GT(spoiling->packets, 8u * 4u);
    EXPECT_GE(report.view_resets, 1u);
    EXPECT_LE(report.view_resets, 8u);
}

TEST(ChosenCodec, IsTheSameForAnyNumberOfThreadsAndFollowsThePrice) {
    struct Run : GameTest {
        void TestBody() override {}

        /// The hash of the clients' received state, at the end, and the most viewers of a zone that
        /// had records coded for them.
        std::pair<std::uint64_t, std::uint32_t> play(unsigned threads, std::uint32_t budget_us) {
            server.sets = {"replication.codec=AUTO",
                           "replication.codec_budget_us_per_tick=" + std::to_string(budget_us),
                           "zones.zone_grid.columns=2",
                           "scatter[1].count=60",
                           "brain[0].state[0].transition[0].threshold=100000"};
            server.network.delay_s = 0.03;
            server.threads = threads;
            std::uint32_t most = 0;
            const auto report = run([&](VirtualServer& server_now, double) {
                for (const auto& zone : server_now.world().zones()) {
                    most = std::max(most, zone->report().replication.codec.coded);
                }
            });
            EXPECT_TRUE(report.consistent) << reasons(report);
            core::StateHash hash;
            for (const auto& zone : world->world().zones()) {
                zone->state().replicator.hash(hash);
            }
            return {hash.value(), most};
        }
    };

    Run one;
    const auto alone = one.play(1, 1000);
    EXPECT_GE(alone.second, 2u);
    EXPECT_EQ(Run().play(3, 1000), alone);
    const auto none = Run().play(1, 0);
    EXPECT_EQ(none.second, 0u);
    EXPECT_NE(none.first, alone.first);
}

}  // namespace
}  // namespace zoned::harness
