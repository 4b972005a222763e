// The worlds that come with the server: they load, keep their promises, and expand alike each time.
#include "server/config/expand/load_settings.h"
#include "server/config/text/sha256.h"
#include "server/config/world/terrain.h"
#include "server/config/world/world_description.h"
#include "shared/core/state_hash.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace zoned::config {
namespace {

Settings load(const std::string& name, const std::vector<std::string>& sets = {}) {
    Settings settings;
    std::vector<ConfigError> errors;
    EXPECT_TRUE(load_settings(ZONED_SOURCE_DIR "/config/" + name, sets, settings, errors))
        << format_errors(name, errors);
    return settings;
}

const Settings& valley() {
    static const Settings settings = load("valley.txtpb");
    return settings;
}

std::uint64_t hash_of(const Settings& settings) {
    core::StateHash hash;
    for (const InitialEntity& e : settings.initial) {
        hash.add(e.type);
        hash.add(e.yaw);
        hash.add(e.asleep);
        for (int axis = 0; axis < 3; ++axis) {
            hash.add(e.position[axis]);
            hash.add(e.orientation.coeffs()[axis]);
        }
    }
    for (const motion::StaticBox& box : settings.boxes) {
        for (int axis = 0; axis < 3; ++axis) {
            hash.add(box.centre[axis]);
            hash.add(box.half_extents[axis]);
            hash.add(box.orientation.coeffs()[axis]);
        }
    }
    return hash.value();
}

std::map<std::string, int> count_types(const Settings& settings) {
    std::map<std::string, int> counts;
    for (const InitialEntity& e : settings.initial) {
        ++counts[settings.types[e.type].name];
    }
    return counts;
}

TEST(Valley, HoldsTwoThousandPropsAndFiveHundredNpcsInFourZones) {
    int props = 0;
    int hanging = 0;
    int npcs = 0;
    std::set<std::string> agents;
    for (const InitialEntity& e : valley().initial) {
        const world::EntityType& type = valley().types[e.type];
        if (type.kind == world::EntityKind::kProp) {
            // Cars, the bridge and the flag hang on springs and ropes, which have to settle first.
            const bool hangs = type.assembly != 0 || type.shape == world::TypeShape::kSoft;
            ++(hangs ? hanging : props);
            EXPECT_EQ(e.asleep, !hangs) << type.name;
        } else {
            ++npcs;
            agents.insert(valley().ai.brains[type.brain - 1u].name);
        }
    }
    EXPECT_EQ(props, 1998);
    EXPECT_EQ(hanging, 6);
    EXPECT_EQ(npcs, 500);
    EXPECT_EQ(agents.size(), 11u);
    EXPECT_EQ(valley().zones.size(), 4u);
    EXPECT_GE(valley().spawn_points.size(), 40u);
    EXPECT_GE(valley().boxes.size(), 150u);
    EXPECT_EQ(valley().tick_rate_hz, 30.0);
}

TEST(Valley, SpreadsItsStaticsOverAllPartsOfTheMap) {
    // Each of the 16 squares of 500 m must hold some boxes, or part of the map would be a void.
    std::map<std::pair<int, int>, int> squares;
    for (const motion::StaticBox& box : valley().boxes) {
        ++squares[{static_cast<int>(std::floor(box.centre.x() / 500.0F)),
                   static_cast<int>(std::floor(box.centre.z() / 500.0F))}];
    }
    for (int x = -2; x < 2; ++x) {
        for (int z = -2; z < 2; ++z) {
            EXPECT_GE((squares[{x, z}]), 5) << x << " " << z;
        }
    }
}

TEST(Valley, HasSpawnPointsNearBothBordersAndInAllZones) {
    int near_x = 0;
    int near_z = 0;
    std::set<std::string> zones;
    for (const zone::SpawnPoint& spawn : valley().spawn_points) {
        const Vec3d& p = spawn.position;
        near_x += std::abs(p.x()) < 15.0 ? 1 : 0;
        near_z += std::abs(p.z()) < 15.0 ? 1 : 0;
        for (const ZoneRegion& zone : valley().zones) {
            if (p.x() > zone.min_x && p.x() < zone.max_x && p.z() > zone.min_z &&
                p.z() < zone.max_z) {
                zones.insert(zone.name);
            }
        }
    }
    EXPECT_GE(near_x, 10);
    EXPECT_GE(near_z, 10);
    EXPECT_EQ(zones.size(), 4u);
}

/// Half the height of an entity as it stands or lies.
float half_height(const world::EntityType& type) {
    if (type.kind == world::EntityKind::kCharacter) {
        return type.radius + type.half_segment;
    }
    return type.shape == world::TypeShape::kBox ? type.half_extents.y() : type.radius;
}

float half_width(const world::EntityType& type) {
    if (type.kind == world::EntityKind::kCharacter || type.shape == world::TypeShape::kSphere) {
        return type.radius;
    }
    return type.shape == world::TypeShape::kBox
               ? std::min(type.half_extents.x(), type.half_extents.z())
               : type.radius;
}

/// Entities on boxes or the ground with a shape that half_height and half_width know: no stones,
/// tables and cars, and nothing on the hill that comes from an image.
std::vector<InitialEntity> plain_entities() {
    std::vector<InitialEntity> plain;
    for (const InitialEntity& e : valley().initial) {
        const world::EntityType& type = valley().types[e.type];
        const bool on_the_hill =
            std::abs(e.position.x() - 620.0) < 50.0 && std::abs(e.position.z() + 100.0) < 50.0;
        if (type.shape != world::TypeShape::kSolid && type.shape != world::TypeShape::kSoft &&
            type.assembly == 0 && !on_the_hill) {
            plain.push_back(e);
        }
    }
    return plain;
}

TEST(Valley, StandsEverythingOnTheTerrainClearOfStaticsAndOfEachOther) {
    const Terrain terrain(valley().boxes, valley().ground_height_m);
    const std::vector<InitialEntity> entities = plain_entities();
    EXPECT_GT(entities.size(), 2400U);
    int raised = 0;
    for (const InitialEntity& e : entities) {
        const world::EntityType& type = valley().types[e.type];
        const Vec3 p = e.position.cast<float>();
        const float bottom = p.y() - half_height(type);
        // A clearance of 2 mm, give or take float rounding at heights of some metres.
        EXPECT_NEAR(bottom - terrain.height(p.x(), p.z()), 0.002F, 1e-5F) << type.name;
        raised += bottom > 0.1F ? 1 : 0;
        const float w = half_width(type);
        EXPECT_TRUE(terrain.clear({Vec3(p.x() - w, bottom, p.z() - w),
                                   Vec3(p.x() + w, p.y() + half_height(type), p.z() + w)}));
    }
    EXPECT_GT(raised, 5) << "some stand on hills and platforms";
    for (std::size_t i = 0; i < entities.size(); ++i) {
        for (std::size_t k = i + 1; k < entities.size(); ++k) {
            const double apart = (entities[i].position - entities[k].position).norm();
            EXPECT_GT(apart,
                      half_width(valley().types[entities[i].type]) +
                          half_width(valley().types[entities[k].type]));
        }
    }
}

TEST(Valley, LaysBarrelsOnTheirSidesAndKeepsCharactersUpright) {
    for (const InitialEntity& e : plain_entities()) {
        const world::EntityType& type = valley().types[e.type];
        const float up = (e.orientation * Vec3::UnitY()).y();
        if (type.kind == world::EntityKind::kProp && type.shape == world::TypeShape::kCapsule) {
            EXPECT_NEAR(up, 0.0F, 1e-6F);
        } else {
            EXPECT_NEAR(up, 1.0F, 1e-6F);
        }
        EXPECT_NEAR(e.orientation.norm(), 1.0F, 1e-6F);
    }
}

TEST(Valley, ExpandsAlikeEachTimeAndOtherwiseWithAnotherSeed) {
    const Settings again = load("valley.txtpb");
    EXPECT_EQ(hash_of(valley()), hash_of(again));
    EXPECT_EQ(valley().digest, again.digest);
    const Settings other = load("valley.txtpb", {"world.seed=99"});
    EXPECT_NE(hash_of(valley()), hash_of(other));
    EXPECT_EQ(count_types(valley()), count_types(other));
    EXPECT_NE(valley().digest, other.digest) << "clients compute its clouds from the seed";
    EXPECT_EQ(load("solids.txtpb").digest, load("solids.txtpb", {"world.seed=99"}).digest)
        << "clients cannot tell seeds apart where they compute nothing from them";
}

TEST(Valley, LoadsAgainFromItsOwnCanonicalText) {
    Settings again;
    std::vector<ConfigError> errors;
    ASSERT_TRUE(parse_settings(valley().text, {}, again, errors)) << format_errors("text", errors);
    EXPECT_EQ(again.text, valley().text);
    EXPECT_EQ(hash_of(again), hash_of(valley()));
    EXPECT_EQ(again.digest, valley().digest);
}

TEST(Minimal, LoadsAndHoldsAPlayerType) {
    const Settings settings = load("minimal.txtpb");
    EXPECT_EQ(settings.zones.size(), 1u);
    EXPECT_EQ(settings.types.front().name, "player");
    EXPECT_EQ(settings.initial.size(), 12u);
}

TEST(Digest, ChangesWithWhatClientsAreToldAndWithNothingElse) {
    const std::string digest = load("minimal.txtpb").digest;
    EXPECT_EQ(digest.size(), 64u);
    for (const char* set : {"network.tcp_port=7777",
                            "session.grace_s=5",
                            "ai.far_m=10",
                            "replication.budget_bytes_per_s=9000",
                            "world.name=other",
                            "testing.wrong_limit={}"}) {
        EXPECT_EQ(load("minimal.txtpb", {set}).digest, digest) << set;
    }
    for (const char* set : {"world.tick_rate_hz=60",
                            "type[crate].max_acceleration_mps2=30",
                            "lod[0].position_bound_m=0.06",
                            "statics.box[0].y_m=0.9",
                            "replication.quantization.yaw_bits=9",
                            "interest.hysteresis=0.2"}) {
        EXPECT_NE(load("minimal.txtpb", {set}).digest, digest) << set;
    }
}

TEST(Digest, IsSha256) {
    // FIPS 180-4 example: "abc".
    EXPECT_EQ(sha256_hex("abc"),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(WorldDescription, DeclaresWrongLimitsOnlyWhenAFaultAsksForThem) {
    const Settings honest = load("minimal.txtpb");
    EXPECT_EQ(describe_world(honest).types(0).max_acceleration_mps2(), 20.0F);
    const Settings wrong = load(
        "minimal.txtpb", {"testing.wrong_limit={type: \"player\" max_acceleration_mps2: 0.5}"});
    EXPECT_EQ(describe_world(wrong).types(0).max_acceleration_mps2(), 0.5F);
    EXPECT_EQ(describe_world(wrong).types(1).max_acceleration_mps2(), 20.0F);
    EXPECT_EQ(wrong.types[0].max_acceleration_mps2, 20.0F) << "the simulation keeps the truth";
}

}  // namespace
}  // namespace zoned::config
