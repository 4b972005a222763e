// A scene that was saved and loaded is the scene that was saved, to the last byte, whatever is in
// it.
#include "server/physics/scene/scene.h"
#include "server/physics/shapes/shape_archive.h"
#include "shared/core/archive/field_archive.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace zoned::physics {
namespace {

using SceneBytes = std::vector<std::uint8_t>;

SceneBytes saved(const Scene& scene) {
    SceneBytes bytes;
    GeometryTable geometries;
    core::FieldWriter archive(bytes);
    archive.lend(geometries);
    scene.save(archive);
    return bytes;
}

/// Loads `bytes` into `scene`; returns what was wrong.
std::string load(const SceneBytes& bytes, Scene& scene) {
    GeometryTable geometries;
    core::FieldReader archive(bytes);
    archive.lend(geometries);
    scene.load(archive);
    return archive.wrong();
}

/// Saves it, loads that, and goes on with both for a while.
void expect_same_copy(Scene& scene) {
    const SceneBytes bytes = saved(scene);
    Scene copy{PhysicsSettings()};
    ASSERT_EQ(load(bytes, copy), "");
    ASSERT_EQ(saved(copy), bytes);
    for (int i = 0; i < 10; ++i) {
        scene.step(1.0F / 60.0F);
        copy.step(1.0F / 60.0F);
    }
    EXPECT_EQ(saved(copy), saved(scene));
}

BodyDef level_ground() {
    BodyDef def;
    def.kind = BodyKind::kStatic;
    def.shape = Shape::plane();
    return def;
}

BodyDef drawn_body(core::Rng& rng) {
    static constexpr BodyKind kKinds[] = {
        BodyKind::kStatic, BodyKind::kKinematic, BodyKind::kDynamic, BodyKind::kParticle};
    BodyDef def;
    def.kind = kKinds[rng.below(4)];
    def.shape = rng.below(2) == 0 || def.kind == BodyKind::kParticle
                    ? Shape::sphere(0.1F + rng.unit())
                    : Shape::box(Vec3(0.1F + rng.unit(), 0.1F + rng.unit(), 0.1F + rng.unit()));
    def.position = Vec3(20.0F * rng.unit(), 4.0F * rng.unit(), 20.0F * rng.unit());
    def.asleep = def.kind == BodyKind::kDynamic && rng.below(2) == 0;
    return def;
}

TEST(SceneSnapshot, OfNothingIsLoaded) {
    Scene scene{PhysicsSettings()};
    expect_same_copy(scene);
}

TEST(SceneSnapshot, OfAGroundAloneIsLoaded) {
    Scene scene{PhysicsSettings()};
    ASSERT_TRUE(scene.add(level_ground()).ok());
    expect_same_copy(scene);
}

TEST(SceneSnapshot, OfParticlesAloneIsLoaded) {
    Scene scene{PhysicsSettings()};
    BodyDef def;
    def.kind = BodyKind::kParticle;
    def.shape = Shape::sphere(0.1F);
    ASSERT_TRUE(scene.add(def).ok());
    expect_same_copy(scene);
}

TEST(SceneSnapshot, OfWhateverCameAndWentIsLoaded) {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        SCOPED_TRACE(seed);
        core::Rng rng(seed);
        Scene scene{PhysicsSettings()};
        std::vector<BodyId> bodies;
        if (rng.below(2) == 0) {
            bodies.push_back(*scene.add(level_ground()));
        }
        for (int round = 0; round < 4; ++round) {
            for (std::uint32_t i = rng.below(40); i > 0; --i) {
                bodies.push_back(*scene.add(drawn_body(rng)));
            }
            for (std::uint32_t i = rng.below(6); i > 0 && !bodies.empty(); --i) {
                const std::size_t at = rng.below(static_cast<std::uint32_t>(bodies.size()));
                scene.remove(bodies[at]);
                bodies.erase(bodies.begin() + static_cast<std::ptrdiff_t>(at));
            }
            for (std::uint32_t i = rng.below(30); i > 0; --i) {
                scene.step(1.0F / 60.0F);
            }
            expect_same_copy(scene);
        }
    }
}

}  // namespace
}  // namespace zoned::physics
