// Paths around crowds: a crowd spreads over two gates.
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace zoned::ai {
namespace {

using namespace test;

motion::StaticBox wall_between(float from_z, float to_z) {
    motion::StaticBox box;
    box.centre = Vec3(0.0F, 1.0F, 0.5F * (from_z + to_z));
    box.half_extents = Vec3(0.25F, 1.0F, 0.5F * (to_z - from_z));
    return box;
}

/// A wall along z at x = 0 with two gates of 4 m, at z = 0 and at z = 12 m. People stand 1 m apart
/// before the first gate and want to spread over a place behind it.
class Gates {
  public:
    Gates(const std::optional<pathfinding::CrowdPathSettings>& crowding, std::uint32_t walkers)
        : walkers_(walkers),
          through_(walkers + 1, false),
          changes_(walkers + 1, 0) {
        PoiSettings points_of_interest;
        points_of_interest.points_of_interest.resize(1);
        points_of_interest.points_of_interest[0].name = "there";
        points_of_interest.points_of_interest[0].at = {26.0, 0.0};
        points_of_interest.points_of_interest[0].radius_m = 12.0F;
        field.points_of_interest = PointsOfInterest(points_of_interest, Vec2d::Zero(), kDt);
        field.solid = true;
        field.statics = motion::StaticGeometry(
            {wall_between(-30.0F, -2.0F), wall_between(2.0F, 10.0F), wall_between(14.0F, 30.0F)},
            0.0F);
        world::EntityType& walker = field.types[kGuard];
        walker.brain = 1;
        walker.radius = walker.character.radius = 0.4F;
        walker.half_segment = walker.character.half_segment = 0.5F;
        walker.character.acceleration = 20.0F;
        walker.character.speed = 3.0F;
        field.settings.brains = {single(ActionKind::kGo)};
        field.settings.avoidance = steering::AvoidanceSettings{};
        compile(field.settings, kDt);
        PathfindingSettings paths;
        paths.cell_m = 0.5F;
        paths.crowding = crowding;
        field.paths = PathService(paths, field.statics, {-40, -30, 40, 30}, field.types, 0);
        for (std::uint32_t id = 1; id <= walkers_; ++id) {
            const auto n = static_cast<int>(id - 1);
            field.add_npc(
                id,
                kGuard,
                0,
                Vec3(
                    -28.0F + static_cast<float>(n % 20), 0.9F, -7.0F + static_cast<float>(n / 20)));
            field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
            begin(*field.agents.find(EntityId(id)), field.settings.compiled[0], 0);
        }
    }

    /// Until so many are through, 250 s at most.
    void run(std::size_t most) {
        std::vector<int> heads(walkers_ + 1, 0);
        while (passed_ < most && field.now < 250 * 30) {
            field.step();
            for (std::uint32_t id = 1; id <= walkers_; ++id) {
                if (!through_[id]) {
                    look(id, heads[id]);
                }
            }
        }
    }

    [[nodiscard]] double seconds() const { return static_cast<double>(field.now) * double{kDt}; }

    [[nodiscard]] int by_far_gate() const { return by_far_gate_; }

    /// How often an agent's new path led through another gate than before.
    [[nodiscard]] const std::vector<int>& changes() const { return changes_; }

    Field field;

  private:
    void look(std::uint32_t id, int& heads) {
        const Vec3& at = field.position(id);
        if (at.x() > 0.6F) {
            through_[id] = true;
            ++passed_;
            by_far_gate_ += at.z() > 6.0F ? 1 : 0;
            return;
        }
        const Slot slot = field.agents.slot_of(EntityId(id));
        if (!field.paths.has(slot, EntityId(id))) {
            return;
        }
        pathfinding::Spot before{at.x(), at.z()};
        for (const pathfinding::Spot& corner : field.paths.answer(slot).corners) {
            if (before.x <= 0.0F && corner.x > 0.0F) {
                const float share = -before.x / (corner.x - before.x);
                const int gate = before.z + share * (corner.z - before.z) > 6.0F ? 2 : 1;
                changes_[id] += heads != 0 && heads != gate ? 1 : 0;
                heads = gate;
                return;
            }
            before = corner;
        }
    }

    std::uint32_t walkers_;
    std::size_t passed_ = 0;
    int by_far_gate_ = 0;
    std::vector<bool> through_;
    std::vector<int> changes_;
};

/// Discs of 0.4 m leave no room to move at 1.6 on a square metre: four fifths of it.
pathfinding::CrowdPathSettings around_crowds() {
    pathfinding::CrowdPathSettings crowding;
    crowding.jam_per_m2 = 1.6F;
    return crowding;
}

/// Two gates let twice as many through as one. Without crowd-aware paths, only agents that the
/// throng pushes far enough along the wall take the second gate. The time for which a throng stays
/// jammed in a gate is chance, so single crowds differ by half. Crowds of 280, 290, 300 and 310
/// people were tried. Half were through in 54, 42, 52 and 39 s, without in 82, 72, 89 and 57 s
/// (0.62 of it). 95 % were through in 119, 81, 158 and 101 s, without in 154, 165, 189 and 129 s
/// (0.72 of it).
TEST(Crowding, ACrowdSpreadsOverTwoGatesAndIsThroughSooner) {
    double without_s = 0.0;
    double around_s = 0.0;
    int far_without = 0;
    int far_around = 0;
    for (const std::uint32_t walkers : {280U, 310U}) {
        Gates without(std::nullopt, walkers);
        without.run(walkers / 2);
        Gates around(around_crowds(), walkers);
        around.run(walkers / 2);
        EXPECT_EQ(without.field.paths.counts().around_crowds, 0U);
        EXPECT_GT(around.field.paths.counts().around_crowds, walkers);
        without_s += without.seconds();
        around_s += around.seconds();
        far_without += without.by_far_gate();
        far_around += around.by_far_gate();
        // No agent goes to and fro, though paths are checked each half second. An agent changes
        // gates where its gate is full, and back where the other one is full by then. It also
        // changes, as without, where a throng has pushed it nearer to the other gate.
        EXPECT_LE(*std::max_element(around.changes().begin(), around.changes().end()), 5);
        int changes = 0;
        for (const int count : around.changes()) {
            changes += count;
        }
        EXPECT_LT(changes, static_cast<int>(walkers));
    }
    EXPECT_LT(around_s, 0.8 * without_s);
    EXPECT_GT(far_around, far_without + 60);
}

TEST(Crowding, CountsNobodyWhereItIsNotAskedFor) {
    Gates without(std::nullopt, 300);
    without.run(1);
    EXPECT_FALSE(without.field.paths.counts_bodies());
    EXPECT_EQ(without.field.paths.counts().crowd_work, 0U);
    Gates around(around_crowds(), 300);
    const std::size_t more = around.field.paths.bytes();
    EXPECT_GT(more, without.field.paths.bytes());
}

}  // namespace
}  // namespace zoned::ai
