// The arena's lift and ferry: players ride them, which clients know before they move.
#include "server/app/world/world.h"
#include "server/zone/zone_state.h"
#include "tests/harness/game_test.h"

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>

namespace zoned::harness {
namespace {

constexpr std::uint16_t kLiftButton = 1U << 6U;
constexpr std::uint32_t kLift = 0;
constexpr std::uint32_t kFerry = 1;

/// Rides the lift or the ferry; walks about on it, jumps, and leaves it now and then.
class Commuter final : public bot::OwnScript {
  public:
    explicit Commuter(std::size_t index) : index_(index) {}

    motion::InputCommand decide(const view::View& view, Tick tick, bot::Voice&) override {
        const view::ZoneInfo* zone = view.world().zone(view.own().zone());
        if (zone == nullptr) {
            return {};
        }
        const std::uint32_t platform = index_ % 2 == 0 ? kLift : kFerry;
        const motion::StaticBox box = zone->geometry.platform_box(platform, tick);
        // A place of its own on the platform.
        const double turn = 2.4 * static_cast<double>(index_);
        const Vec3d goal = zone->origin + box.centre.cast<double>() +
                           Vec3d(0.9 * std::cos(turn), 0.0, 0.9 * std::sin(turn));
        const Vec3d me = view.own().position();
        const auto phase = (tick + static_cast<Tick>(37 * index_)) % 450;
        motion::InputCommand command;
        if (phase < 60) {
            command = bot::walk_towards(std::sin(turn), std::cos(turn));
        } else if (std::hypot(goal.x() - me.x(), goal.z() - me.z()) > 0.4) {
            command = bot::walk_towards(goal.x() - me.x(), goal.z() - me.z());
        } else if (phase % 90 == 0) {
            command.buttons |= motion::kButtonJump;
        }
        if (platform == kLift && phase % 100 == 0) {
            command.buttons |= kLiftButton;
        }
        return command;
    }

  private:
    std::size_t index_;
};

class ArenaPlatforms : public GameTest {
  protected:
    ArenaPlatforms() {
        server.config = ZONED_SOURCE_DIR "/config/arena.txtpb";
        bots.bots = 20;
        bots.seconds = 30.0;
        bots.make_own_script = [](std::size_t index, const std::string&) {
            return std::make_unique<Commuter>(index);
        };
    }

    /// Counts the ticks in which players stand on what moves.
    void look(VirtualServer& now) {
        for (const auto& zone : now.world().zones()) {
            const zone::ZoneState& state = zone->state();
            if (state.now == last_[state.settings.id]) {
                continue;
            }
            last_[state.settings.id] = state.now;
            const motion::StaticGeometry& statics = *state.settings.statics;
            const world::Entities& e = state.entities;
            for (world::Row row = 0; row < e.size(); ++row) {
                if (!e.client[row] || e.has(row, world::kGhost) || !e.has(row, world::kGrounded)) {
                    continue;
                }
                for (std::uint32_t p = 0; p < statics.platforms().size(); ++p) {
                    const motion::StaticBox box = statics.platform_box(p, state.now);
                    const Vec3 away = e.position[row] - box.centre;
                    const Vec3 move = statics.platform_move(p, state.now);
                    const bool on = std::abs(away.x()) < box.half_extents.x() &&
                                    std::abs(away.z()) < box.half_extents.z() &&
                                    std::abs(away.y() - 1.0F) < 0.05F;
                    if (on && !move.isZero(0.0F)) {
                        ++(std::abs(move.y()) > 0.0F ? lifted_ : ferried_);
                        crossed_ +=
                            std::abs(e.position[row].x() +
                                     static_cast<float>(state.settings.region().origin().x())) <
                                    0.5F
                                ? 1
                                : 0;
                    }
                }
            }
        }
    }

    std::map<ZoneId, Tick> last_;
    int lifted_ = 0;
    int ferried_ = 0;
    int crossed_ = 0;  ///< on the ferry at the border between the zones
};

TEST_F(ArenaPlatforms, NeedNoCorrectionWhereInputsComeInTime) {
    server.network.delay_s = 0.04;
    const auto report = run([this](VirtualServer& now, double) { look(now); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(lifted_, 100);
    EXPECT_GT(ferried_, 1000);
    EXPECT_GT(crossed_, 10);
    EXPECT_GT(report.audit.environment_samples, 50U);
    EXPECT_EQ(report.audit.environment_violations, 0U);
    EXPECT_GT(report.own_correction_m.count(), 1000U);
    EXPECT_EQ(report.own_correction_m.percentile(0.99), 0.0);
}

TEST_F(ArenaPlatforms, AreConsistentUnderLoss) {
    server.network.delay_s = 0.06;
    server.network.loss = 0.05;
    server.network.jitter_s = 0.02;
    const auto report = run([this](VirtualServer& now, double) { look(now); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.audit.environment_violations, 0U);
    EXPECT_GT(lifted_, 100);
    EXPECT_GT(ferried_, 1000);
}

TEST_F(ArenaPlatforms, AreFoundOutWhereTheyMoveOtherwiseThanClientsWereTold) {
    // The checkers are checked: the server's lift never moves.
    server.network.delay_s = 0.04;
    bool spoilt = false;
    const auto report = run([&](VirtualServer& now, double) {
        if (!std::exchange(spoilt, true)) {
            for (const auto& zone : now.world().zones()) {
                zone::ZoneState& state = zone->state();
                state.settings.statics = std::make_shared<const motion::StaticGeometry>(
                    state.settings.statics->with_courses(state.settings.door_courses));
            }
        }
    });
    EXPECT_GT(report.own_correction_m.percentile(0.99), 0.0);
}

TEST_F(ArenaPlatforms, AreTheSameEachTimeTheyArePlayed) {
    bots.seconds = 8.0;
    EXPECT_EQ(difference_between_runs(), "");
}

}  // namespace
}  // namespace zoned::harness
