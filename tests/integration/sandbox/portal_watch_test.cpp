// Players hear of the world behind a portal before they are in it.
#include "server/app/world/portal_watch.h"

#include "server/app/world/world.h"
#include "tests/harness/game_test.h"

#include <map>

namespace zoned::harness {
namespace {

using app::PortalWatch;

class PortalAhead : public GameTest {
  protected:
    PortalAhead() {
        bots.bots = 12;
        bots.seconds = 20.0;
        box.lower_m = {-6.0, -10.0, -6.0};
        box.upper_m = {6.0, 10.0, 6.0};
        box.to_world = "meadow";
        box.wait_s = 1000.0;
    }

    struct Mover {
        Vec3d position;
        Vec3d velocity;
    };

    /// All avatars that are there, by client.
    static std::map<ClientId, Mover> avatars(const app::World& world) {
        std::map<ClientId, Mover> all;
        for (const auto& zone : world.zones()) {
            const zone::ZoneState& state = zone->state();
            for (const zone::ZoneClient& client : state.clients) {
                const world::Row row = state.entities.find(client.avatar);
                if (row != world::kNoRow && !state.entities.has(row, world::kHidden)) {
                    all[client.client] = {state.settings.region().origin() +
                                              state.entities.position[row].cast<double>(),
                                          state.entities.velocity[row].cast<double>()};
                }
            }
        }
        return all;
    }

    /// Whether it is in the box so many seconds from now.
    [[nodiscard]] bool inside(const Mover& mover, double after_s = 0.0) const {
        const double* at = mover.position.data();
        const double* velocity = mover.velocity.data();
        const double* lower = box.lower_m.data();
        const double* upper = box.upper_m.data();
        bool is = true;
        for (int axis = 0; axis < 3; ++axis) {
            const double there = at[axis] + after_s * velocity[axis];
            is = is && there >= lower[axis] && there <= upper[axis];
        }
        return is;
    }

    /// Whether it comes into the box within so many seconds, by looking every millisecond.
    [[nodiscard]] bool enters(const Mover& mover, double seconds) const {
        for (double t = 0.0; t <= seconds; t += 0.001) {
            if (inside(mover, t)) {
                return true;
            }
        }
        return false;
    }

    config::PortalSettings box;
};

TEST_F(PortalAhead, IsAnnouncedToWhoeverIsAboutToEnterAndToNobodyElse) {
    const std::vector<config::PortalSettings> portals{box};
    std::unique_ptr<PortalWatch> watch;
    std::map<ClientId, double> heard_s;
    std::map<ClientId, bool> was_inside;
    int entered = 0, outside = 0;
    run([&](VirtualServer& now, double) {
        if (now.world().zones()[0]->state().frozen) {
            return;  // nobody goes anywhere
        }
        if (!watch) {
            watch = std::make_unique<PortalWatch>(portals, 30.0);
        }
        const double at_s = static_cast<double>(now.world().now()) / 30.0;
        std::vector<app::TravelWish> wishes;
        std::vector<app::TravelAhead> ahead;
        watch->look(now.world(), wishes, ahead);
        const std::map<ClientId, Mover> all = avatars(now.world());
        for (const app::TravelAhead& one : ahead) {
            EXPECT_EQ(one.world, "meadow");
            const Mover& mover = all.at(one.client);
            EXPECT_TRUE(enters(mover, PortalWatch::kAhead_s + 0.002)) << at_s;
            outside += inside(mover) ? 0 : 1;
            const auto before = heard_s.find(one.client);
            EXPECT_TRUE(before == heard_s.end() ||
                        at_s - before->second >= PortalWatch::kAnnounceEvery_s - 0.001);
            heard_s[one.client] = at_s;
        }
        for (const auto& [client, mover] : all) {
            const bool is = inside(mover);
            entered += is && !was_inside[client] ? 1 : 0;
            was_inside[client] = is;
            if (enters(mover, PortalWatch::kAhead_s - 0.002)) {
                ASSERT_TRUE(heard_s.contains(client)) << at_s;
                EXPECT_LE(at_s - heard_s[client], PortalWatch::kAnnounceEvery_s + 0.04);
            }
        }
    });
    EXPECT_GT(entered, 3);
    EXPECT_GT(outside, 3) << "nobody was seen before it was there";
}

}  // namespace
}  // namespace zoned::harness
