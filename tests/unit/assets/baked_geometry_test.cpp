// Baked files: loading gives the baked geometry back, bit for bit, and finds any damage.
#include "server/assets/baked_geometry.h"

#include "server/assets/geometry_files.h"
#include "server/physics/scene/scene.h"
#include "tests/unit/assets/geometry_samples.h"
#include "shared/core/rng.h"

#include <gmock/gmock.h>

#include <cstring>
#include <fstream>

namespace zoned::assets {
namespace {

using physics::Shape;
using ::testing::HasSubstr;

Shape mesh_sample(int n = 12, double side = 12.0) {
    return Shape::mesh(mesh_from_obj(test::waves_obj(n, side), 1.0F, {})->mesh);
}

Shape field_sample(std::uint32_t n = 17) {
    std::vector<std::uint16_t> pixels;
    for (std::uint32_t i = 0; i < n * n; ++i) {
        pixels.push_back(static_cast<std::uint16_t>(32768.0 + 20000.0 * std::sin(0.9 * (i % n)) *
                                                                  std::cos(0.7 * (i / n))));
    }
    physics::FieldOptions options;
    options.offset = -1.0F;
    options.spacing_x = 0.75F;
    return Shape::heightfield(*heightfield_from_png(
        test::png_of(n, n, PNG_FORMAT_LINEAR_Y, pixels.data()), 1.7F, options));
}

Shape again(const Shape& shape) {
    const auto read = read_baked(bake(shape));
    EXPECT_TRUE(read.ok()) << read.error();
    return *read;
}

std::string reason(const std::string& bytes) {
    const auto read = read_baked(bytes);
    return read ? "none: it was read" : read.error();
}

physics::Scene scene_on(const Shape& ground) {
    physics::Scene scene{physics::PhysicsSettings{}};
    physics::BodyDef def;
    def.kind = physics::BodyKind::kStatic;
    def.shape = ground;
    EXPECT_TRUE(scene.add(def).ok());
    return scene;
}

/// The hits of 2,000 rays, and the state after bodies of all simple shapes have fallen for a
/// second.
std::uint64_t answers_of(const Shape& ground) {
    physics::Scene scene = scene_on(ground);
    core::Rng rng(3);
    core::StateHash hash;
    for (int i = 0; i < 2000; ++i) {
        const Vec3 from(rng.range(-6, 6), rng.range(-2, 4), rng.range(-6, 6));
        const Vec3 to(rng.range(-6, 6), rng.range(-2, 1), rng.range(-6, 6));
        physics::RayHit hit;
        if (scene.ray_cast(from, (to - from).normalized(), 20.0F, 0, hit)) {
            hash.add(hit.distance);
            for (int axis = 0; axis < 3; ++axis) {
                hash.add(hit.normal[axis]);
            }
        }
    }
    for (int i = 0; i < 30; ++i) {
        physics::BodyDef def;
        def.shape = i % 3 == 0   ? Shape::sphere(0.3F)
                    : i % 3 == 1 ? Shape::box(Vec3(0.3F, 0.2F, 0.4F))
                                 : Shape::capsule(0.2F, 0.3F);
        def.position = Vec3(rng.range(-5, 5), rng.range(1, 3), rng.range(-5, 5));
        EXPECT_TRUE(scene.add(def).ok());
    }
    for (int step = 0; step < 60; ++step) {
        scene.step(1.0F / 60.0F);
    }
    scene.hash(hash);
    return hash.value();
}

TEST(BakedGeometry, ReadsBackBitForBit) {
    for (const Shape& shape : {mesh_sample(), mesh_sample(1), field_sample(), field_sample(2)}) {
        const Shape read = again(shape);
        EXPECT_EQ(difference_of(shape, read), "");
        EXPECT_EQ(bake(read), bake(shape));
    }
}

TEST(BakedGeometry, GivesTheSameBytesForTheSameSource) {
    EXPECT_EQ(bake(mesh_sample()), bake(mesh_sample()));
    EXPECT_EQ(bake(field_sample()), bake(field_sample()));
    EXPECT_NE(bake(mesh_sample(12, 12.0)), bake(mesh_sample(12, 12.1)));
}

TEST(BakedGeometry, AnswersRaysAndCollisionsAsItsSourceDoes) {
    for (const Shape& shape : {mesh_sample(), field_sample()}) {
        EXPECT_EQ(answers_of(again(shape)), answers_of(shape));
    }
    // The comparison is worth something: another surface answers otherwise.
    EXPECT_NE(answers_of(mesh_sample(12, 12.01)), answers_of(mesh_sample()));
}

TEST(BakedGeometry, RefusesEveryFlippedBit) {
    for (const Shape& shape : {mesh_sample(2), field_sample(3)}) {
        const std::string good = bake(shape);
        for (std::size_t at = 0; at < good.size(); ++at) {
            for (int bit = 0; bit < 8; ++bit) {
                std::string bad = good;
                bad[at] = static_cast<char>(bad[at] ^ (1 << bit));
                const char* expected = at < 8    ? "does not begin with ZONEDGEO"
                                       : at < 12 ? "is of version"
                                       : at < 16 ? "the checksum does not fit"
                                       : at < 24 ? "the body has"
                                                 : "the checksum does not fit";
                ASSERT_THAT(reason(bad), HasSubstr(expected)) << "byte " << at;
            }
        }
    }
}

TEST(BakedGeometry, RefusesEveryLengthButItsOwn) {
    for (const Shape& shape : {mesh_sample(2), field_sample(3)}) {
        const std::string good = bake(shape);
        for (std::size_t length = 0; length < good.size(); ++length) {
            const char* expected = length < 8    ? "does not begin with ZONEDGEO"
                                   : length < 56 ? "ends within the head"
                                                 : "cut short";
            ASSERT_THAT(reason(good.substr(0, length)), HasSubstr(expected)) << length;
        }
        EXPECT_THAT(reason(good + 'x'), HasSubstr("written over"));
    }
}

/// A file with a 32-bit number of its body replaced and the checksum made to fit.
std::string forged(const Shape& shape, std::size_t at, std::uint32_t value) {
    std::string bytes = bake(shape);
    std::memcpy(bytes.data() + kBakedBodyAt + at, &value, sizeof(value));
    seal_baked(bytes);
    return bytes;
}

TEST(BakedGeometry, RefusesForgedMeshesWhoseChecksumFits) {
    const Shape mesh = mesh_sample(2);  // 9 vertices, 8 triangles
    constexpr std::size_t kVertices = 16;
    constexpr std::size_t kCorners = kVertices + 9 * 12;
    constexpr std::size_t kBends = kCorners + 8 * 12;
    constexpr std::size_t kOrder = kBends + 8 * 24;
    constexpr std::size_t kNodes = kOrder + 8 * 4;
    constexpr std::uint32_t kNan = 0x7FC00000;
    // Sizes that would ask for more memory than there is are compared with the file first.
    EXPECT_THAT(reason(forged(mesh, 0, 0xFFFFFFFF)), HasSubstr("4294967295 vertices"));
    EXPECT_THAT(reason(forged(mesh, 4, 0xFFFFFFFF)), HasSubstr("4294967295 triangles"));
    EXPECT_THAT(reason(forged(mesh, 8, 0xFFFFFFFF)), HasSubstr("4294967295 nodes"));
    EXPECT_THAT(reason(forged(mesh, 12, 1)), HasSubstr("reserved"));
    EXPECT_THAT(reason(forged(mesh, kVertices + 16, kNan)), HasSubstr("vertex 1 is not finite"));
    EXPECT_THAT(reason(forged(mesh, kCorners + 12, 9)), HasSubstr("triangle 1 names no vertex"));
    std::uint32_t corner = 0;
    std::memcpy(&corner, bake(mesh).data() + kBakedBodyAt + kCorners + 4, 4);
    EXPECT_THAT(reason(forged(mesh, kCorners, corner)), HasSubstr("triangle 0 has no area"));
    EXPECT_THAT(reason(forged(mesh, kBends + 24, kNan)), HasSubstr("triangle 1 has no bend"));
    EXPECT_THAT(reason(forged(mesh, kBends + 28, 0xBF000000)), HasSubstr("triangle 1 has no bend"));
    EXPECT_THAT(reason(forged(mesh, kOrder, 8)), HasSubstr("order is none of all items"));
    std::uint32_t second = 0;
    std::memcpy(&second, bake(mesh).data() + kBakedBodyAt + kOrder + 4, 4);
    EXPECT_THAT(reason(forged(mesh, kOrder, second)), HasSubstr("order is none of all items"));
    // The tree of eight triangles: an inner node, then a leaf and so on.
    const auto with_node = [&](std::size_t node, char items) {
        std::string bytes = bake(mesh);
        bytes[kBakedBodyAt + kNodes + node] = items;
        seal_baked(bytes);
        return reason(bytes);
    };
    EXPECT_THAT(with_node(0, 5), HasSubstr("node 0 has too many items"));
    EXPECT_THAT(with_node(0, 4), HasSubstr("node 1 lies beyond the last leaf"));
    EXPECT_THAT(with_node(1, 1), HasSubstr("tree:"));
    EXPECT_THAT(with_node(1, 0), HasSubstr("ends before it holds all items"));
}

TEST(BakedGeometry, RefusesForgedHeightfieldsWhoseChecksumFits) {
    const Shape field = field_sample(3);
    EXPECT_THAT(reason(forged(field, 0, 0xFFFFFFFF)), HasSubstr("do not fill a body"));
    EXPECT_THAT(reason(forged(field, 4, 4)), HasSubstr("3 x 4 heights do not fill"));
    EXPECT_THAT(reason(forged(field, 8, 0)), HasSubstr("spacing out of range"));
    EXPECT_THAT(reason(forged(field, 16, 0xBF800000)), HasSubstr("thickness out of range"));
    EXPECT_THAT(reason(forged(field, 20 + 4 * 4, 0x7F800000)),
                HasSubstr("sample 1 of row 1 is not finite"));
    std::string kind = bake(field);
    kind[12] = 3;
    seal_baked(kind);
    EXPECT_THAT(reason(kind), HasSubstr("holds kind 3"));
    std::string none = bake(field).substr(0, kBakedBodyAt);
    std::memset(none.data() + 16, 0, 8);
    seal_baked(none);
    EXPECT_THAT(reason(none), HasSubstr("ends within the sizes"));
    none[12] = 1;
    seal_baked(none);
    EXPECT_THAT(reason(none), HasSubstr("ends within the counts"));
}

TEST(BakedGeometry, IsReadBackFromAFile) {
    const std::string path = ::testing::TempDir() + "/waves.baked";
    std::ofstream(path, std::ios::binary) << bake(mesh_sample());
    const auto bytes = read_geometry_file(path);
    ASSERT_TRUE(bytes.ok()) << bytes.error();
    const auto loaded = read_baked(*bytes);
    ASSERT_TRUE(loaded.ok()) << loaded.error();
    EXPECT_EQ(difference_of(mesh_sample(), *loaded), "");
    EXPECT_EQ(read_geometry_file("/tmp").error(), "/tmp: is a folder");
}

TEST(BakedGeometry, TellsWhichTableDiffers) {
    EXPECT_EQ(difference_of(mesh_sample(), field_sample()), "kind");
    EXPECT_EQ(difference_of(mesh_sample(12, 12.0), mesh_sample(12, 12.5)), "vertices");
    EXPECT_EQ(difference_of(field_sample(3), field_sample(4)), "columns and rows");
}

}  // namespace
}  // namespace zoned::assets
