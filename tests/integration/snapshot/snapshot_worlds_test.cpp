#include "tests/random_worlds/snapshot_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>

namespace zoned::snapshot {
namespace {

/// A shipped world, and why copies of it do not go on exactly; null: they do.
struct SnapshotWorld {
    const char* name;
    std::size_t bots;
    Tick first;
    Tick follows;
    const char* falls_short;
};

constexpr SnapshotWorld kWorlds[] = {
    {"minimal", 4, 40, 120, nullptr},
    {"arena", 6, 40, 120, nullptr},
    {"bridge", 3, 40, 60, nullptr},
    {"circuit", 3, 40, 60, nullptr},
    {"cloth", 3, 40, 60, nullptr},
    {"cubes", 3, 40, 60, nullptr},
    {"doors", 3, 40, 60, nullptr},
    {"hamlet", 3, 40, 60, nullptr},
    {"hills", 3, 40, 60, nullptr},
    {"learned", 3, 40, 60, nullptr},
    {"machines", 3, 40, 60, nullptr},
    {"methods/ai_code", 3, 40, 60, nullptr},
    {"methods/ai_gates", 3, 40, 60, nullptr},
    {"methods/ai_roads", 3, 40, 60, nullptr},
    {"solids", 3, 40, 60, nullptr},
    {"swarms", 3, 30, 40, nullptr},
    {"town", 3, 30, 40, nullptr},
    {"valley", 6, 40, 60, nullptr},
    {"weather", 3, 40, 60, nullptr},
    {"methods/conjugate_gradient", 3, 40, 60, nullptr},
    {"methods/direct", 3, 40, 60, nullptr},
    {"methods/distances", 3, 40, 60, nullptr},
    {"methods/fabric", 3, 40, 60, nullptr},
    {"methods/gauss_seidel", 3, 40, 60, nullptr},
    {"methods/impulses", 3, 40, 60, nullptr},
    {"methods/jacobi", 3, 40, 60, nullptr},
    {"methods/over_relaxation", 3, 40, 60, nullptr},
    {"methods/penalty", 3, 40, 60, nullptr},
    {"methods/projection", 3, 40, 60, nullptr},
};

/// They take ten seconds: the target snapshots_long runs them.
constexpr SnapshotWorld kLargeWorlds[] = {
    {"city", 3, 30, 40, nullptr},
};

void PrintTo(const SnapshotWorld& world, std::ostream* out) {
    *out << world.name;
}

/// Many more ticks and bots, for the long form.
int length() {
    const char* text = std::getenv("ZONED_SNAPSHOT_LENGTH");
    return text != nullptr ? std::max(1, std::atoi(text)) : 1;
}

/// "methods/ai_roads" as "methods_ai_roads".
std::string test_name(std::string world) {
    std::replace(world.begin(), world.end(), '/', '_');
    return world;
}

class SnapshotOfWorld : public ::testing::TestWithParam<SnapshotWorld> {};

void print(const char* name, const SnapshotCourse& course, const SnapshotResult& result) {
    std::printf(
        "%s with %zu clients: %zu copies, %zu hashes, %.2f MB, saved in %.2f ms, "
        "loaded in %.1f ms, refused for %d ticks\n",
        name,
        course.bots,
        result.copies,
        result.compared,
        1e-6 * static_cast<double>(result.most_bytes),
        result.save_ms,
        result.load_ms,
        result.refused);
}

TEST_P(SnapshotOfWorld, GoesOnBitForBit) {
    const SnapshotWorld& world = GetParam();
    SnapshotCourse course;
    course.config = std::string(ZONED_SOURCE_DIR "/config/") + world.name + ".txtpb";
    course.bots = world.bots * static_cast<std::size_t>(length());
    course.first = world.first;
    course.follows = world.follows * length();
    course.snapshots = length() == 1 ? 2 : 3 * length();
    course.every = length() == 1 ? 20 : 90;
    if (const char* seed = std::getenv("ZONED_SEED")) {
        course.seed = std::strtoull(seed, nullptr, 10);
    }
    if (const char* set = std::getenv("ZONED_SNAPSHOT_SET")) {
        course.sets.emplace_back(set);
    }
    const SnapshotResult result = run_course(course);
    print(world.name, course, result);
    if (world.falls_short != nullptr) {
        EXPECT_NE(result.wrong, "")
            << "it goes on exactly by now: strike its reason from the table";
        return;
    }
    EXPECT_EQ(result.wrong, "");
    EXPECT_EQ(result.copies, static_cast<std::size_t>(course.snapshots));
}

INSTANTIATE_TEST_SUITE_P(Shipped,
                         SnapshotOfWorld,
                         ::testing::ValuesIn(kWorlds),
                         [](const auto& world) { return test_name(world.param.name); });

INSTANTIATE_TEST_SUITE_P(Large,
                         SnapshotOfWorld,
                         ::testing::ValuesIn(kLargeWorlds),
                         [](const auto& world) { return test_name(world.param.name); });

/// Prints the cost of a snapshot of a crowd; the target snapshots_long runs it.
TEST(LargeSnapshot, OfACrowdGoesOnToo) {
    SnapshotCourse course;
    course.config = ZONED_SOURCE_DIR "/config/valley.txtpb";
    course.bots = 200;
    course.first = 60;
    course.every = 10;
    course.follows = 20;
    const SnapshotResult result = run_course(course);
    print("valley", course, result);
    EXPECT_EQ(result.wrong, "");
    EXPECT_EQ(result.copies, static_cast<std::size_t>(course.snapshots));
    for (const core::ArchiveSection& part : result.sections) {
        if (part.name.find(": client ") != std::string::npos) {
            continue;
        }
        std::printf("  %-48s %9zu bytes\n", part.name.c_str(), part.end - part.begin);
    }
}

TEST(SnapshotWorlds, AreAllThatAreShipped) {
    std::set<std::string> named;
    for (const SnapshotWorld& world : kWorlds) {
        named.insert(world.name);
    }
    for (const SnapshotWorld& world : kLargeWorlds) {
        named.insert(world.name);
    }
    const std::filesystem::path config = ZONED_SOURCE_DIR "/config";
    for (const std::string folder : {"", "methods/"}) {
        for (const auto& entry : std::filesystem::directory_iterator(config / folder)) {
            if (entry.path().extension() == ".txtpb") {
                EXPECT_TRUE(named.contains(folder + entry.path().stem().string())) << entry.path();
            }
        }
    }
}

}  // namespace
}  // namespace zoned::snapshot
