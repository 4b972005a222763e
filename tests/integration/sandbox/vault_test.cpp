// The arena's vault: players work its levers and walk through its door, which clients know before
// it turns.
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

constexpr std::uint16_t kLeverButton = 1U << 6U;

/// Walks in and out of the vault; works a lever now and then on its way.
class Visitor final : public bot::OwnScript {
  public:
    explicit Visitor(std::size_t index) : index_(index) {}

    motion::InputCommand decide(const view::View& view, Tick tick, bot::Voice&) override {
        const Vec3d me = view.own().position();
        // Outside by the lever, the doorway, inside by the other lever, and back. Each its own way.
        constexpr double kStops[][2] = {{-37.5, 18.2}, {-37.5, 20.0}, {-42.5, 20.0}, {-42.5, 18.2}};
        const auto& stop = kStops[(step_ + index_) % 4];
        const double x = stop[0] - me.x();
        const double z = stop[1] - me.z();
        if (std::hypot(x, z) < 0.7 || tick > next_) {
            ++step_;
            next_ = tick + 90;
        }
        motion::InputCommand command = bot::walk_towards(x, z);
        if ((tick + static_cast<Tick>(17 * index_)) % 75 == 0) {
            command.buttons |= kLeverButton;
        }
        return command;
    }

  private:
    std::size_t index_;
    std::size_t step_ = 0;
    Tick next_ = 120;
};

class Vault : public GameTest {
  protected:
    Vault() {
        server.config = ZONED_SOURCE_DIR "/config/arena.txtpb";
        bots.bots = 8;
        bots.seconds = 30.0;
        bots.make_own_script = [](std::size_t index, const std::string&) {
            return std::make_unique<Visitor>(index);
        };
    }

    void look(VirtualServer& now) {
        for (const auto& zone : now.world().zones()) {
            const zone::ZoneState& state = zone->state();
            if (state.doors.body.empty() || state.now == last_[state.settings.id]) {
                continue;
            }
            last_[state.settings.id] = state.now;
            turns_ += state.report.plan.has(zone::Pass::kDoors) ? 1 : 0;
            const world::Entities& e = state.entities;
            for (world::Row row = 0; row < e.size(); ++row) {
                if (e.client[row] && !e.has(row, world::kGhost)) {
                    const double x = state.settings.region().origin().x() +
                                     static_cast<double>(e.position[row].x());
                    const bool inside = x < -40.0;
                    const auto [at, fresh] = inside_.emplace(e.id[row], inside);
                    passages_ += at->second != inside ? 1 : 0;
                    at->second = inside;
                }
            }
        }
    }

    std::map<ZoneId, Tick> last_;
    std::map<EntityId, bool> inside_;
    int turns_ = 0;
    int passages_ = 0;  ///< through the door
};

TEST_F(Vault, NeedsNoCorrectionWhereInputsComeInTime) {
    server.network.delay_s = 0.04;
    const auto report = run([this](VirtualServer& now, double) { look(now); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_GT(turns_, 6) << "of the door, in the zones that know of it";
    EXPECT_GT(passages_, 4);
    EXPECT_GT(report.audit.environment_samples, 50U);
    EXPECT_EQ(report.audit.environment_violations, 0U);
    EXPECT_GT(report.own_correction_m.count(), 1000U);
    EXPECT_EQ(report.own_correction_m.percentile(0.99), 0.0);
}

TEST_F(Vault, IsConsistentUnderLoss) {
    server.network.delay_s = 0.06;
    server.network.loss = 0.05;
    server.network.jitter_s = 0.02;
    const auto report = run([this](VirtualServer& now, double) { look(now); });
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.audit.environment_violations, 0U);
    EXPECT_GT(turns_, 6);
}

TEST_F(Vault, IsFoundOutWhereItsDoorIsAnotherThanClientsWereTold) {
    // The checkers are checked: the server's door stands open all the time.
    server.network.delay_s = 0.04;
    bool spoilt = false;
    const auto report = run([&](VirtualServer& now, double) {
        look(now);
        if (!std::exchange(spoilt, true)) {
            for (const auto& zone : now.world().zones()) {
                zone::ZoneState& state = zone->state();
                auto courses = std::make_shared<motion::DoorCourses>(1);
                courses->announce(0, {0, true}, 0);
                state.settings.statics = std::make_shared<const motion::StaticGeometry>(
                    state.settings.statics->with_courses(courses));
            }
        }
    });
    EXPECT_GT(report.own_correction_m.percentile(0.99), 0.0);
}

TEST_F(Vault, IsTheSameEachTimeItIsPlayed) {
    bots.seconds = 8.0;
    EXPECT_EQ(difference_between_runs(), "");
}

}  // namespace
}  // namespace zoned::harness
