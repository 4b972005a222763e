#include "server/world/entities.h"
#include "tests/unit/wire/wire_samples.h"
#include "shared/core/archive/field_archive.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <map>

namespace zoned::world {
namespace {

using wire::testing::change_field;
using wire::testing::health_alone;
using wire::testing::sample_fields;

constexpr TypeIndex kNone = 0;
constexpr TypeIndex kOne = 1;
constexpr TypeIndex kFive = 2;

wire::FieldSchemas schemas() {
    return {nullptr, health_alone(), sample_fields()};
}

TEST(FieldColumns, FollowTheirRowsThroughRemovalsAndChangesOfType) {
    Entities e;
    e.declare_fields(schemas());
    core::Rng rng(2);
    std::map<std::uint32_t, std::vector<std::uint32_t>> truth;
    std::uint32_t next = 1;
    for (int step = 0; step < 20'000; ++step) {
        const std::uint32_t what = rng.below(10);
        if (truth.empty() || (what < 3 && truth.size() < 60)) {
            const auto type = static_cast<TypeIndex>(rng.below(3));
            const Row row = e.add(EntityId(next), type);
            const auto fresh = e.field_values(row);
            truth[next++].assign(fresh.begin(), fresh.end());
            const wire::FieldSchema* schema = e.fields().schema(type);
            ASSERT_EQ(fresh.size(), schema != nullptr ? schema->words() : 0U);
            if (schema != nullptr) {
                ASSERT_TRUE(std::ranges::equal(fresh, schema->initial()));
            }
            continue;
        }
        auto at = truth.begin();
        std::advance(at, rng.below(static_cast<std::uint32_t>(truth.size())));
        const Row row = e.find(EntityId(at->first));
        if (what < 5) {
            e.remove(row);
            truth.erase(at);
        } else if (what == 5) {
            e.set_type(row, static_cast<TypeIndex>(rng.below(3)));
            const auto fresh = e.field_values(row);
            const auto same_type = fresh.size() == at->second.size();
            if (!same_type) {
                ASSERT_TRUE(fresh.empty() ||
                            std::ranges::equal(fresh, e.fields().schema(e.type[row])->initial()));
            }
            at->second.assign(fresh.begin(), fresh.end());
        } else if (const wire::FieldSchema* schema = e.fields().schema(e.type[row])) {
            const auto count = static_cast<std::uint32_t>(schema->fields().size());
            const wire::DeclaredField& field = schema->fields()[rng.below(count)];
            change_field(rng, field, at->second);
            e.put_field(row, field, wire::words_of<const std::uint32_t>(field, at->second), step);
        }
        for (const auto& [id, words] : truth) {
            ASSERT_TRUE(std::ranges::equal(e.field_values(e.find(EntityId(id))), words)) << step;
        }
    }
}

TEST(FieldColumns, SurviveASnapshotAndRefuseADamagedOne) {
    Entities e;
    e.declare_fields(schemas());
    for (std::uint32_t id = 1; id <= 9; ++id) {
        e.add(EntityId(id), static_cast<TypeIndex>(id % 3));
    }
    const wire::DeclaredField& health = e.fields().schema(kOne)->fields()[0];
    const std::uint32_t forty = 40;
    e.put_field(e.find(EntityId(4)), health, {&forty, 1}, 17);
    e.remove(e.find(EntityId(2)));
    std::vector<std::uint8_t> bytes;
    core::FieldWriter writer(bytes);
    writer(e);
    Entities again;
    again.declare_fields(schemas());
    core::FieldReader reader(bytes);
    reader(again);
    ASSERT_TRUE(reader.good()) << reader.wrong();
    EXPECT_EQ(again.field_values(again.find(EntityId(4)))[0], 40U);
    EXPECT_EQ(again.fields().changed(again.find(EntityId(4)), kOne)[0], 17U);
    EXPECT_TRUE(again.field_values(again.find(EntityId(3))).empty());
    EXPECT_EQ(again.field_values(again.find(EntityId(5))).size(),
              e.fields().schema(kFive)->words());
    Entities undeclared;  // a world whose types declare nothing
    core::FieldReader other(bytes);
    other(undeclared);
    EXPECT_FALSE(other.good());
}

TEST(FieldColumns, TakeNothingWhereNoTypeDeclaresAField) {
    Entities e;
    const Row row = e.add(EntityId(1), kNone);
    EXPECT_FALSE(e.fields().any());
    EXPECT_TRUE(e.field_values(row).empty());
    EXPECT_TRUE(e.fields().block(row, kNone).empty());
}

}  // namespace
}  // namespace zoned::world
