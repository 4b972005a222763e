// The same bits twice, and no memory once a method has warmed up.
#include "server/compute/worker_pool.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/solver_variants/variant_scene.h"
#include "shared/core/state_hash.h"

namespace zoned::physics {
namespace {

/// `side` bodies along each edge.
void fill_pit(VariantScene& s, int side = 3) {
    s.ground();
    for (int i = 0; i < side * side * side; ++i) {
        const auto x = static_cast<float>(i % side);
        const auto y = static_cast<float>(i / (side * side));
        const auto z = static_cast<float>((i / side) % side);
        BodyDef def;
        def.shape = i % 3 == 0   ? Shape::sphere(0.5F)
                    : i % 3 == 1 ? Shape::box(Vec3::Constant(0.5F))
                                 : Shape::capsule(0.4F, 0.2F);
        def.position = Vec3(1.1F * x + 0.07F * y, 0.7F + 1.2F * y, 1.1F * z - 0.05F * y);
        def.mass = 1.0F + static_cast<float>(i % 4);
        s.add(def);
    }
}

std::uint64_t hash_after(const PhysicsSettings& settings, float seconds) {
    VariantScene s(settings);
    fill_pit(s);
    s.run(seconds);
    core::StateHash hash;
    s.scene.hash(hash);
    return hash.value();
}

TEST(SolverVariants, GiveTheSameBitsTwice) {
    for (const SolverVariant method : all_methods()) {
        const PhysicsSettings settings = settings_of(method);
        EXPECT_EQ(hash_after(settings, 0.6F), hash_after(settings, 0.6F)) << name_of(method);
    }
}

/// 1,000 bodies in a heap: threads help with more than 512 contacts.
TEST(SolverVariants, JacobiGivesTheSameBitsForAnyNumberOfThreads) {
    PhysicsSettings settings = settings_of(SolverVariant::kJacobi);
    settings.methods.iterations = 5;
    std::uint64_t alone = 0;
    for (const unsigned threads : {1U, 2U, 4U}) {
        compute::WorkerPool pool(threads);
        compute::Team team;
        team.join_pool(pool);
        VariantScene s(settings);
        fill_pit(s, 10);
        s.scene.work_with(&team);
        s.run(0.5F);
        core::StateHash hash;
        s.scene.hash(hash);
        alone = threads == 1 ? hash.value() : alone;
        EXPECT_EQ(hash.value(), alone) << threads;
    }
}

TEST(SolverVariants, GiveOtherBitsWhereRowsAreVisitedInAnotherOrder) {
    PhysicsSettings settings = settings_of(SolverVariant::kGaussSeidel);
    const std::uint64_t straight = hash_after(settings, 1.5F);
    settings.methods.shuffle = 7;
    const std::uint64_t shuffled = hash_after(settings, 1.5F);
    EXPECT_NE(straight, shuffled);
    EXPECT_EQ(shuffled, hash_after(settings, 1.5F));
}

TEST(SolverVariants, AllocateNothingOnceWarm) {
    for (const SolverVariant method : all_methods()) {
        for (const auto mode : {Stabilisation::kBaumgarte, Stabilisation::kSplit}) {
            PhysicsSettings settings = settings_of(method);
            settings.methods.stabilisation = mode;
            settings.methods.measure = true;
            VariantScene s(settings);
            s.ground();
            for (int i = 0; i < 12; ++i) {
                s.box(
                    Vec3(1.5F * static_cast<float>(i % 4), 0.5F + static_cast<float>(i / 4), 0.0F));
            }
            s.run(1.0F);
            const std::uint64_t before = allocation_count();
            s.run(0.5F);
            EXPECT_EQ(allocation_count(), before) << name_of(method);
        }
    }
}

}  // namespace
}  // namespace zoned::physics
