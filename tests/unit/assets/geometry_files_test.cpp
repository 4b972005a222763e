#include "server/assets/geometry_files.h"

#include "tests/unit/assets/geometry_samples.h"
#include "shared/core/rng.h"

#include <gtest/gtest.h>

#include <fstream>
#include <vector>

namespace zoned::assets {
namespace {

using test::png_of;

physics::FieldOptions spacing(float m) {
    physics::FieldOptions options;
    options.spacing_x = m;
    options.spacing_z = m;
    return options;
}

TEST(HeightfieldFromPng, TakesEightBitsAsTheyAre) {
    const std::uint8_t pixels[] = {0, 51, 255, 102, 153, 204};
    physics::FieldOptions options = spacing(2.0F);
    options.offset = -1.0F;
    const auto field = heightfield_from_png(png_of(3, 2, PNG_FORMAT_GRAY, pixels), 10.0F, options);
    ASSERT_TRUE(field.ok()) << field.error();
    EXPECT_EQ((*field)->tables().columns, 3U);
    EXPECT_EQ((*field)->tables().rows, 2U);
    EXPECT_FLOAT_EQ((*field)->height(0, 0), -1.0F);
    EXPECT_FLOAT_EQ((*field)->height(1, 0), 1.0F);
    EXPECT_FLOAT_EQ((*field)->height(2, 0), 9.0F);
    EXPECT_FLOAT_EQ((*field)->height(0, 1), 3.0F);
    EXPECT_FLOAT_EQ((*field)->box().upper.x(), 2.0F);
}

TEST(HeightfieldFromPng, TakesSixteenBitsAsTheyAre) {
    const std::uint16_t pixels[] = {0, 1, 65535, 32768};
    const auto field =
        heightfield_from_png(png_of(2, 2, PNG_FORMAT_LINEAR_Y, pixels), 65.535F, spacing(1.0F));
    ASSERT_TRUE(field.ok()) << field.error();
    EXPECT_FLOAT_EQ((*field)->height(1, 0), 0.001F);
    EXPECT_FLOAT_EQ((*field)->height(0, 1), 65.535F);
    EXPECT_FLOAT_EQ((*field)->height(1, 1), 32.768F);
}

TEST(HeightfieldFromPng, SaysWhyItRefuses) {
    const std::uint8_t pixels[12] = {};
    const auto reason = [](std::vector<std::byte> bytes) {
        const auto field = heightfield_from_png(bytes, 1.0F, spacing(1.0F));
        return field ? std::string() : field.error();
    };
    EXPECT_EQ(reason(png_of(2, 2, PNG_FORMAT_RGB, pixels)),
              "heightfield: the image is not plain greyscale: it has red, green and blue");
    EXPECT_EQ(reason(png_of(1, 2, PNG_FORMAT_GRAY, pixels)).substr(0, 29),
              "heightfield: columns and rows");
    EXPECT_EQ(reason({}), "heightfield: is no PNG image: ends too early");
    std::vector<std::byte> cut = png_of(2, 2, PNG_FORMAT_GRAY, pixels);
    cut.resize(cut.size() - 20);
    EXPECT_EQ(reason(cut), "heightfield: the image is broken at row 0 of 2: ends too early");
    const std::vector<std::uint8_t> large(1000 * 1000);
    std::vector<std::byte> claim = png_of(1000, 1000, PNG_FORMAT_GRAY, large.data());
    ASSERT_TRUE(heightfield_from_png(claim, 1.0F, spacing(1.0F)).ok());
    claim.resize(100);
    EXPECT_EQ(reason(claim),
              "heightfield: the image is broken: 100 bytes cannot hold 1000 x 1000 samples");
}

TEST(HeightfieldFromPng, SurvivesBrokenImages) {
    core::Rng rng(5);
    std::vector<std::uint16_t> pixels(64 * 64);
    for (auto& p : pixels) {
        p = static_cast<std::uint16_t>(rng.below(65536));
    }
    const std::vector<std::byte> good = png_of(64, 64, PNG_FORMAT_LINEAR_Y, pixels.data());
    for (int round = 0; round < 500; ++round) {
        std::vector<std::byte> bytes = good;
        for (std::uint32_t k = 0; k <= rng.below(4); ++k) {
            bytes[rng.below(static_cast<std::uint32_t>(bytes.size()))] =
                static_cast<std::byte>(rng.below(256));
        }
        const auto field = heightfield_from_png(bytes, 1.0F, spacing(1.0F));
        EXPECT_TRUE(field.ok() || !field.error().empty());
    }
}

TEST(MeshFromObj, ReadsPolygonsOfAllGroups) {
    // A unit cube of quadrilaterals in two groups, relative and absolute indices mixed.
    const std::string text =
        "mtllib ../nowhere.mtl\n"
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
        "g a\nf 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\n"
        "g b\nf 3 4 8 7\nf -8 -4 -1 -5\nf 2//1 3//1 7//1 6//1\n";
    const auto built = mesh_from_obj(text, 2.0F, {});
    ASSERT_TRUE(built.ok()) << built.error();
    EXPECT_EQ(built->mesh->triangle_count(), 12U);
    EXPECT_EQ(built->open_edges, 0U);
    EXPECT_EQ(built->turned_edges, 0U);
    EXPECT_EQ(built->mesh->box().upper, Vec3(2, 2, 2));
}

TEST(MeshFromObj, SaysWhyItRefuses) {
    const auto reason = [](const std::string& text) {
        const auto mesh = mesh_from_obj(text, 1.0F, {});
        return mesh ? std::string() : mesh.error();
    };
    EXPECT_EQ(reason(""), "mesh: no triangle has an area");
    EXPECT_EQ(reason("v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 7\n"), "mesh: line 4: names vertex 7 of 3");
    EXPECT_EQ(reason("v 0 0 0\nv 1e30 0 0\nv 0 0 1\nf 1 2 3\n"),
              "mesh: line 2: the vertex lies more than 1000000 m out");
}

TEST(GeometryFiles, NameTheFileThatCannotBeOpened) {
    const auto missing = read_geometry_file("/no/such/file.obj");
    ASSERT_FALSE(missing.ok());
    EXPECT_EQ(missing.error(), "/no/such/file.obj: cannot be opened");
}

TEST(MeshFromObj, RoundsCoordinatesToTheNearestFloat) {
    const auto built = mesh_from_obj("v 0.1 16.7773 .3\nv 1 0 0\nv 0 0 1e-1\nf 1 2 3\n", 0.5F, {});
    ASSERT_TRUE(built.ok()) << built.error();
    const Vec3& v = built->mesh->tables().vertices[0];
    EXPECT_EQ(v, Vec3(0.05F, 8.38865F, 0.15F));
}

TEST(ContentOf, GoesByTheBytes) {
    const std::uint8_t pixels[4] = {};
    const auto png = png_of(2, 2, PNG_FORMAT_GRAY, pixels);
    EXPECT_EQ(content_of({reinterpret_cast<const char*>(png.data()), png.size()}),
              GeometryContent::kPng);
    EXPECT_EQ(content_of("v 1 2 3\n"), GeometryContent::kText);
    EXPECT_EQ(content_of("ZONEDGEO"), GeometryContent::kBaked);
    EXPECT_EQ(content_of(std::string(3, '\0')), GeometryContent::kUnknown);
}

TEST(MeshFromObj, SurvivesBrokenText) {
    core::Rng rng(6);
    std::string good = "o thing\n";
    for (int i = 0; i < 60; ++i) {
        good += "v " + std::to_string(rng.range(-1, 1)) + " " + std::to_string(rng.range(-1, 1)) +
                " " + std::to_string(rng.range(-1, 1)) + "\n";
    }
    for (int i = 0; i + 2 < 60; ++i) {
        good += "f " + std::to_string(i + 1) + "/1 " + std::to_string(i + 2) + "/2 " +
                std::to_string(i + 3) + "/3\n";
    }
    for (int round = 0; round < 500; ++round) {
        std::string text = good;
        for (std::uint32_t k = 0; k <= rng.below(6); ++k) {
            text[rng.below(static_cast<std::uint32_t>(text.size()))] =
                static_cast<char>(32 + rng.below(95));
        }
        const auto mesh = mesh_from_obj(text, 1.0F, {});
        EXPECT_TRUE(mesh.ok() || !mesh.error().empty());
    }
}

}  // namespace
}  // namespace zoned::assets
