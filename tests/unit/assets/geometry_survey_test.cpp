// The figures of surfaces, against known figures, and the warnings of the physics.
#include "server/assets/geometry_survey.h"

#include <gmock/gmock.h>

namespace zoned::assets {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr float kBudget = 0.005F;

/// A closed box, its faces outwards.
MeshSurvey box_survey(const Vec3& size, const Vec3& at = Vec3::Zero()) {
    std::vector<Vec3> v;
    for (int k = 0; k < 8; ++k) {
        v.push_back(at + size.cwiseProduct(Vec3(static_cast<float>(k & 1),
                                                static_cast<float>(k >> 1 & 1),
                                                static_cast<float>(k >> 2))));
    }
    const std::vector<std::uint32_t> i = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                          2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    const auto built = physics::build_mesh(v, i);
    EXPECT_EQ(built->open_edges + built->turned_edges + built->shared_edges, 0U);
    return survey(*built->mesh, kBudget);
}

TEST(GeometrySurvey, MeasuresABox) {
    const MeshSurvey s = box_survey(Vec3(3, 4, 12), Vec3(10, -30, 0));
    EXPECT_EQ(s.triangles, 12U);
    EXPECT_EQ(s.vertices, 8U);
    EXPECT_EQ(s.shortest_edge, 3.0F);
    EXPECT_FLOAT_EQ(s.longest_edge, std::sqrt(16.0F + 144.0F));
    EXPECT_EQ(s.farthest, 30.0F);
    EXPECT_GE(s.depth, 3U);  // twelve triangles in leaves of four
    EXPECT_EQ(s.sheet.count + s.small.count + s.thin.count, 0U);
    EXPECT_THAT(stability_warnings_of(s, kBudget), IsEmpty());
}

TEST(GeometrySurvey, FindsAWallThatIsTooThin) {
    const MeshSurvey s = box_survey(Vec3(3, 4, 0.0125F));
    EXPECT_EQ(s.sheet.count, 4U);  // two of each large side
    EXPECT_FLOAT_EQ(s.sheet.least, 0.0125F);
    EXPECT_THAT(stability_warnings_of(s, kBudget),
                ElementsAre(HasSubstr("4 triangles have the surface's other side within the "
                                      "contact margin of 0.02 m behind them (0.0125 m at ")));
}

TEST(GeometrySurvey, FindsTrianglesThatAreTooSmallOrSlivers) {
    const std::vector<Vec3> v = {
        {0, 0, 0}, {0, 0, 1}, {0.004F, 0, 0}, {9, 0, 0}, {9, 0, 0.002F}, {9.002F, 0, 0}};
    const auto built = physics::build_mesh(v, std::vector<std::uint32_t>{0, 1, 2, 3, 4, 5});
    const MeshSurvey s = survey(*built->mesh, kBudget);
    EXPECT_EQ(s.thin.count, 1U);
    EXPECT_NEAR(s.thin.least, 0.004F, 1e-6F);
    EXPECT_EQ(s.small.count, 1U);
    EXPECT_NEAR(s.small.least, 0.002F * std::sqrt(2.0F), 1e-5F);  // a float at 9 m: 1e-6 m
    EXPECT_THAT(stability_warnings_of(s, kBudget),
                ElementsAre(HasSubstr("smaller"), HasSubstr("slivers")));
    const MeshSurvey finer = survey(*built->mesh, 0.001F);
    EXPECT_EQ(finer.small.count + finer.thin.count, 0U);
}

TEST(GeometrySurvey, LooksBehindASampleWhereTooManyLieInAHeap) {
    // Thin triangles, all through one place: the box of each meets the rays of all others.
    std::vector<Vec3> v = {Vec3::Zero()};
    std::vector<std::uint32_t> i;
    for (std::uint32_t k = 0; k < 40000; ++k) {
        const float angle = 1.5e-4F * static_cast<float>(k);
        v.emplace_back(std::cos(angle), 0.0F, -std::sin(angle));
        if (k > 0) {
            i.insert(i.end(), {0, k, k + 1});
        }
    }
    const MeshSurvey s = survey(*physics::build_mesh(v, i)->mesh, kBudget);
    EXPECT_EQ(s.triangles, 39999U);
    EXPECT_LT(s.looked, s.triangles);
    EXPECT_GT(s.looked, 1000U);
    EXPECT_EQ(box_survey(Vec3(3, 4, 12)).looked, 12U);
}

TEST(GeometrySurvey, FindsWhatLiesTooFarOut) {
    const MeshSurvey s = box_survey(Vec3(3, 4, 12), Vec3(0, 0, 5000));
    EXPECT_THAT(stability_warnings_of(s, kBudget), ElementsAre(HasSubstr("reaches 5012 m out")));
}

TEST(GeometrySurvey, MeasuresAHeightfield) {
    // A slope of 45 degrees along x, and one cell that rises by 3 m over 2 m along z.
    physics::FieldOptions options;
    options.columns = 4;
    options.rows = 3;
    options.spacing_x = 1.0F;
    options.spacing_z = 2.0F;
    const std::vector<float> heights = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 6};
    const FieldSurvey s = survey(**physics::build_heightfield(heights, options));
    EXPECT_EQ(s.box.lower, Vec3(-1.5F, 0, -2));
    EXPECT_EQ(s.box.upper, Vec3(1.5F, 6, 2));
    // In that cell one triangle has the slopes 1 and 1.5, the other one 4 and 0.
    EXPECT_NEAR(s.steepest_deg, std::atan(4.0F) * 180.0F / 3.14159265F, 1e-3F);
    EXPECT_EQ(s.steepest_i, 2U);
    EXPECT_EQ(s.steepest_k, 1U);
    EXPECT_THAT(stability_warnings_of(s, 0.0F, kBudget), IsEmpty());
    EXPECT_THAT(stability_warnings_of(s, 0.01F, kBudget),
                ElementsAre(HasSubstr("steps of 0.01 m")));
    options.thickness = 0.0F;
    const FieldSurvey thin = survey(**physics::build_heightfield(heights, options));
    EXPECT_THAT(stability_warnings_of(thin, 0.0F, kBudget), ElementsAre(HasSubstr("is 0 m thick")));
}

}  // namespace
}  // namespace zoned::assets
