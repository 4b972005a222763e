// Deformations: the shapes of soft bodies as clients hear of them, beside the nodes themselves.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/simulation/deformation_fit.h"
#include "server/zone/simulation/zone_soft_bodies.h"
#include "tests/harness/game_test.h"
#include "shared/core/rng.h"

#include <cmath>
#include <numbers>

namespace zoned::harness {
namespace {

/// A sheet of 1 x 1 m with as many nodes along each side, and a lattice of control points over it.
struct Sheet {
    Sheet(std::uint32_t nodes, std::uint32_t points) {
        for (std::uint32_t i = 0; i < nodes * nodes; ++i) {
            physics::soft::SoftNode& node = def.nodes.emplace_back();
            node.position =
                Vec3(static_cast<float>(i % nodes), static_cast<float>(i / nodes), 0.0F) /
                    static_cast<float>(nodes - 1) -
                Vec3(0.5F, 0.5F, 0.0F);
        }
        lattice.points = {points, points, 1};
        lattice.lower = Vec3(-0.5F, -0.5F, 0.0F);
        lattice.upper = Vec3(0.5F, 0.5F, 0.0F);
        lattice.quantum_m = 0.01F;
        codes.assign(lattice.size(), wire::DeformationLattice::kUndisplaced);
        moved.assign(def.nodes.size(), Vec3::Zero());
    }

    physics::soft::SoftDef def;
    wire::DeformationLattice lattice;
    std::vector<std::uint32_t> codes;
    std::vector<Vec3> moved;
};

/// Rounding puts each coordinate of a control point off by half a step at most, and the ridge takes
/// a thousandth of the displacement for each node that a point has.
float rounding_of(const Sheet& sheet, float farthest) {
    return 0.5F * std::numbers::sqrt3_v<float> * sheet.lattice.quantum_m + 0.001F * farthest;
}

TEST(DeformationFit, HoldsAllNodesWhereEachHasAControlPoint) {
    Sheet sheet(6, 6);
    zone::DeformationFit fit(sheet.lattice, sheet.def);
    core::Rng rng(5);
    for (int shape = 0; shape < 50; ++shape) {
        float farthest = 0.0F;
        for (Vec3& moved : sheet.moved) {
            moved = Vec3(rng.range(-0.6F, 0.6F), rng.range(-0.6F, 0.6F), rng.range(-0.6F, 0.6F));
            farthest = std::max(farthest, moved.norm());
        }
        const float left = fit.follow(sheet.moved, true, sheet.codes);
        EXPECT_LE(left, rounding_of(sheet, farthest));
    }
}

/// Between control points h apart, a curve of curvature k is off a line by k h^2 / 8 at most, and
/// by twice that where both directions bend (de Boor, A Practical Guide to Splines, chapter III).
/// The best fit is at least as good in the mean, and no node is worse than with points on the
/// surface by more than the fit moves those: as much again.
TEST(DeformationFit, HoldsABentSheetByFewerControlPoints) {
    Sheet sheet(13, 4);
    zone::DeformationFit fit(sheet.lattice, sheet.def);
    for (const float curvature : {0.2F, 0.5F, 1.0F}) {
        for (std::size_t i = 0; i < sheet.moved.size(); ++i) {
            const Vec3 rest = sheet.def.nodes[i].position;
            sheet.moved[i] = Vec3(0.0F, 0.0F, 0.5F * curvature * rest.x() * rest.x());
        }
        const float between = curvature / 9.0F / 8.0F;
        EXPECT_LE(fit.follow(sheet.moved, true, sheet.codes),
                  2.0F * between + rounding_of(sheet, 0.125F * curvature));
    }
}

TEST(DeformationFit, ChangesOnlyWhatIsBeyondTheBoundAndOnlyThere) {
    Sheet sheet(13, 7);
    sheet.lattice.bound_m = 0.05F;
    zone::DeformationFit fit(sheet.lattice, sheet.def);
    std::fill(sheet.moved.begin(), sheet.moved.end(), Vec3(0.0F, 0.0F, 0.04F));
    EXPECT_NEAR(fit.follow(sheet.moved, false, sheet.codes), 0.04F, 1.0e-6F);
    EXPECT_EQ(
        std::count(sheet.codes.begin(), sheet.codes.end(), wire::DeformationLattice::kUndisplaced),
        49);
    // The corner of node 0 is the corner of control point 0.
    sheet.moved[0].z() = 0.12F;
    EXPECT_LE(fit.follow(sheet.moved, false, sheet.codes), sheet.lattice.bound_m);
    EXPECT_NE(sheet.codes[0], wire::DeformationLattice::kUndisplaced);
    EXPECT_EQ(
        std::count(sheet.codes.begin(), sheet.codes.end(), wire::DeformationLattice::kUndisplaced),
        48);
}

/// Of the owned soft body: its node that is farthest from where pose and declared fields put it, m;
/// below 0 where its type sends no deformation.
float told_error(const zone::ZoneState& state, const zone::SoftLink& link) {
    const world::Entities& e = state.entities;
    const world::Row row = e.find(link.entity);
    const world::EntityType& type = (*state.settings.types)[e.type[row]];
    if (type.deformation == nullptr) {
        return -1.0F;
    }
    const auto codes = e.field_values(row).subspan(
        type.fields->fields()[type.first_control_point].word, type.deformation->size());
    float worst = 0.0F;
    const auto& nodes = state.settings.softs[type.solid]->nodes;
    for (std::size_t node = 0; node < nodes.size(); ++node) {
        const Vec3 rest = nodes[node].position;
        const Vec3 shown =
            e.position[row] +
            e.orientation[row] * Vec3(rest + type.deformation->displacement_at(
                                                 type.deformation->weights_at(rest), codes));
        worst = std::max(worst, (shown - state.soft->bodies.position(link.body, node)).norm());
    }
    return worst;
}

class Deformation : public GameTest {
  protected:
    /// Plays a world and looks at all soft bodies after each tick.
    measure::RunReport play_and_look(const char* file) {
        server.config = ZONED_SOURCE_DIR "/config/" + std::string(file);
        return run([&](VirtualServer& now, double) {
            for (const auto& zone : now.world().zones()) {
                if (zone->state().soft != nullptr && !zone->state().frozen &&
                    zone->report().tick != seen_[zone.get()]) {
                    seen_[zone.get()] = zone->report().tick;
                    look(zone->state());
                }
            }
        });
    }

    void look(const zone::ZoneState& state) {
        std::uint32_t beyond = 0;
        for (const zone::SoftLink& link : state.soft->links) {
            const float left = told_error(state, link);
            const world::Row row = state.entities.find(link.entity);
            const world::EntityType& type = (*state.settings.types)[state.entities.type[row]];
            // A body that sleeps was counted as it fell asleep.
            if (left < 0.0F || state.soft->bodies.rigid(link.body) ||
                state.soft->bodies.asleep(link.body)) {
                continue;
            }
            ++looks;
            // Rounding of the rotations, of a metre or two.
            beyond += left > type.deformation->bound_m + 1.0e-5F ? 1 : 0;
            worst_share = std::max(worst_share, left / type.deformation->bound_m);
        }
        counted += state.report.deformations_beyond;
        found += beyond;
        ASSERT_LE(beyond, state.report.deformations_beyond)
            << "a shape is beyond its bound, and nobody counts it";
    }

    std::map<const zone::Zone*, Tick> seen_;
    std::uint64_t looks = 0;
    std::uint64_t counted = 0;
    std::uint64_t found = 0;
    float worst_share = 0.0F;
};

TEST_F(Deformation, IsWithinItsBoundAtEachTickAndArrivesAtClients) {
    bots.bots = 12;
    bots.seconds = 10.0;
    const measure::RunReport report = play_and_look("cloth.txtpb");
    EXPECT_GT(looks, 1000U);
    EXPECT_LE(counted, looks / 100);
    // The bots stop in a frozen world and compare all declared fields.
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.converged_bots, 12U);
    std::printf("%llu looks, worst %.2f of the bound, %llu beyond\n",
                static_cast<unsigned long long>(looks),
                static_cast<double>(worst_share),
                static_cast<unsigned long long>(counted));
}

TEST_F(Deformation, OfClothThatTearsAndFoldsIsCountedWhereItsPointsAreTooFew) {
    bots.bots = 4;
    bots.seconds = 8.0;
    std::uint32_t torn = 0;
    const measure::RunReport report = play_and_look("methods/fabric.txtpb");
    const zone::ZoneState& state = world->world().zones()[0]->state();
    for (const zone::SoftLink& link : state.soft->links) {
        const world::Row row = state.entities.find(link.entity);
        const world::EntityType& type = (*state.settings.types)[state.entities.type[row]];
        if (type.torn_field != 0) {
            const std::uint32_t told =
                state.entities.field_values(row)[type.fields->fields()[type.torn_field - 1U].word];
            EXPECT_EQ(told, state.soft->bodies.torn(link.body)) << type.name;
            torn += told;
        }
    }
    EXPECT_GT(torn, 0U);
    EXPECT_GT(found, 0U) << "a cloth that is in two pieces has no lattice that holds it";
    EXPECT_TRUE(report.consistent) << reasons(report);
    EXPECT_EQ(report.converged_bots, 4U);
    std::printf("%llu looks, worst %.2f of the bound, %llu beyond, %u springs torn\n",
                static_cast<unsigned long long>(looks),
                static_cast<double>(worst_share),
                static_cast<unsigned long long>(counted),
                torn);
}

}  // namespace
}  // namespace zoned::harness
