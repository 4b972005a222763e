// Every physics setting that a config can name, in a zone that runs.
#include "server/app/world/world.h"
#include "server/config/expand/load_settings.h"
#include "server/zone/context/zone_context.h"
#include "tests/integration/plain/plain_log.h"
#include "proto/config/physics.pb.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace zoned {
namespace {

constexpr int kTicks = 90;
constexpr int kThrownAt = 5;

struct Outcome {
    std::uint64_t hash = 0;
    bool finite = true;
    float lowest_m = 1.0e9F;  ///< of all centres, above the ground
};

using Overrides = std::vector<std::string>;

/// Stones, tables and dumbbells are thrown about, and come down on the ground and on each other.
void throw_everything(zone::ZoneState& state) {
    core::Rng rng(7);
    std::vector<EntityId> props;
    for (world::Row row = 0; row < state.entities.size(); ++row) {
        if (state.entities.body[row]) {
            props.push_back(state.entities.id[row]);
        }
    }
    zone::ZoneContext context(state);
    for (const EntityId id : props) {
        context.add_velocity(
            id, {rng.range(-5.0F, 5.0F), rng.range(1.0F, 4.0F), rng.range(-5.0F, 5.0F)});
    }
}

Outcome play(Overrides overrides, unsigned threads) {
    // The world's budget would choose the integrator; here each is named.
    overrides.emplace_back("budget.position_m=");
    config::Settings settings;
    std::vector<config::ConfigError> errors;
    if (!config::load_settings(
            ZONED_SOURCE_DIR "/config/solids.txtpb", overrides, settings, errors)) {
        ADD_FAILURE() << config::format_errors("solids.txtpb", errors);
        return {};
    }
    app::World world(settings, threads);
    std::vector<mailbox::OutboxItem> out;
    zone::ZoneState& state = world.zones()[0]->state();
    for (int tick = 0; tick < kTicks; ++tick) {
        if (tick == kThrownAt) {
            throw_everything(state);
        }
        out.clear();
        world.tick({}, out);
    }
    Outcome outcome;
    outcome.hash = world.state_hash();
    for (world::Row row = 0; row < state.entities.size(); ++row) {
        outcome.finite = outcome.finite && state.entities.position[row].allFinite();
        outcome.lowest_m = std::min(outcome.lowest_m, state.entities.position[row].y());
    }
    return outcome;
}

/// The same for any number of threads, without NaN, and with nothing through the ground.
std::uint64_t sound_hash(const Overrides& overrides) {
    const Outcome one = play(overrides, 1);
    const Outcome three = play(overrides, 3);
    const std::string what = overrides.empty() ? "" : overrides.back();
    EXPECT_EQ(one.hash, three.hash) << what;
    EXPECT_TRUE(one.finite) << what;
    EXPECT_GT(one.lowest_m, 0.0F) << what;
    return one.hash;
}

/// Of each value of an enum, set at a path.
std::vector<std::uint64_t> hashes_of(const google::protobuf::EnumDescriptor& values,
                                     const std::string& path,
                                     const Overrides& base = {},
                                     const std::string& refused = "") {
    std::vector<std::uint64_t> hashes;
    for (int i = 0; i < values.value_count(); ++i) {
        if (values.value(i)->name() == refused) {
            continue;
        }
        Overrides overrides = base;
        overrides.push_back(path + "=" + values.value(i)->name());
        hashes.push_back(sound_hash(overrides));
    }
    return hashes;
}

std::size_t different(const std::vector<std::uint64_t>& hashes) {
    return std::set<std::uint64_t>(hashes.begin(), hashes.end()).size();
}

class PhysicsSettings : public testing::Test {
  protected:
    const Overrides rows{"physics.method=GAUSS_SEIDEL"};
    const Overrides penalty{"physics.method=PENALTY"};
};

TEST_F(PhysicsSettings, RunEachContactMethodInAZone) {
    const auto hashes = hashes_of(*proto::config::ContactMethod_descriptor(), "physics.method");
    EXPECT_EQ(different(hashes), hashes.size()) << "a method is not what its name says";
}

TEST_F(PhysicsSettings, RunEachModelOfFrictionManifoldsAndStabilisation) {
    const std::string parameters = "physics.method_parameters.";
    for (const auto& [values, name] :
         {std::pair(proto::config::FrictionModel_descriptor(), "friction"),
          {proto::config::ManifoldMode_descriptor(), "manifold"},
          {proto::config::Stabilisation_descriptor(), "stabilisation"}}) {
        const auto hashes = hashes_of(*values, parameters + name, rows);
        EXPECT_EQ(different(hashes), hashes.size()) << name;
    }
    const auto hashes = hashes_of(
        *proto::config::PenaltyIntegrator_descriptor(), parameters + "penalty_integrator", penalty);
    EXPECT_EQ(different(hashes), hashes.size()) << "penalty_integrator";
}

TEST_F(PhysicsSettings, FindTheSamePairsByEachBroadphase) {
    const auto hashes =
        hashes_of(*proto::config::BroadphaseKind_descriptor(), "physics.broadphase");
    EXPECT_EQ(different(hashes), 1U);
}

TEST_F(PhysicsSettings, RunEachIntegratorInAZone) {
    // Methods of first order miss a fall by g dt t / 2 to either side, all others by rounding.
    const auto hashes = hashes_of(
        *proto::config::Physics_Integrator_descriptor(), "physics.body_integrator", {}, "VERLET");
    EXPECT_GE(different(hashes), 3U);
}

}  // namespace
}  // namespace zoned
