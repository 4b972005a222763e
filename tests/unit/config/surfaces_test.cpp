// Surfaces from files in a config: loading and sharing, each mistake at its place, the digest's
// content, and entities that stand on surfaces.
#include "server/config/world/surfaces.h"

#include "server/assets/baked_geometry.h"
#include "server/assets/geometry_files.h"
#include "server/config/expand/load_settings.h"
#include "server/config/expand/stability_report.h"
#include "server/config/world/world_description.h"
#include "tests/unit/assets/geometry_samples.h"
#include "tests/unit/config/config_helpers.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace zoned::config {
namespace {

using test::parse;
using test::place_of;
using test::with;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A folder with a config and geometry files: hill.png (a cone 8 m high over 33 x 33 samples, 2 m
/// apart), waves.obj, waves.baked.
class Surfaces : public testing::Test {
  protected:
    Surfaces()
        : folder_(std::filesystem::temp_directory_path() /
                  ("zoned-surfaces-" + std::to_string(::getpid()))) {
        std::filesystem::create_directories(folder_);
        write("waves.obj", assets::test::waves_obj(8, 16.0));
        write(
            "waves.baked",
            assets::bake(*assets::mesh_from_obj(assets::test::waves_obj(8, 16.0), 1.0F, {})->mesh));
        write_hill(1.0);
    }

    ~Surfaces() override { std::filesystem::remove_all(folder_); }

    void write(const std::string& name, const std::string& bytes) {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
    }

    void write_hill(double top) {
        std::vector<std::uint16_t> pixels;
        for (int k = 0; k < 33; ++k) {
            for (int i = 0; i < 33; ++i) {
                const double from_top = std::hypot(i - 16, k - 16) / 16.0;
                pixels.push_back(
                    static_cast<std::uint16_t>(65535.0 * top * std::max(0.0, 1.0 - from_top)));
            }
        }
        const auto bytes = assets::test::png_of(33, 33, PNG_FORMAT_LINEAR_Y, pixels.data());
        write("hill.png", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    }

    /// The tests' own config with `statics` and `more`, from a file in the folder.
    test::Outcome load(const std::string& statics,
                       const std::string& more = {},
                       const std::vector<std::string>& sets = {}) {
        text_ = test::kValid + "statics {\n" + statics + "\n}\n" + more + "\n";
        write("world.txtpb", text_);
        test::Outcome out;
        out.ok = load_settings((folder_ / "world.txtpb").string(), sets, out.settings, out.errors);
        return out;
    }

    /// Exactly one mistake, at the place of `needle`, that holds `words`.
    void expect_mistake(const std::string& statics,
                        const std::string& needle,
                        const std::string& words) {
        SCOPED_TRACE(words);
        const test::Outcome out = load(statics);
        ASSERT_EQ(out.errors.size(), 1u) << format_errors("test", out.errors);
        const auto [line, column] = place_of(text_, needle);
        EXPECT_EQ(out.errors[0].line, line) << format_errors("test", out.errors);
        EXPECT_EQ(out.errors[0].column, column) << format_errors("test", out.errors);
        EXPECT_THAT(out.errors[0].text, HasSubstr(words));
    }

    std::filesystem::path folder_;
    std::string text_;
};

const std::string kHill = R"(surface { file: "hill.png" height_m: 8 spacing_m: 2 x_m: 20 })";

TEST_F(Surfaces, LoadsEachKindOfFileFromTheConfigsFolder) {
    const auto out = load(
        kHill + "\n" +
        R"(surface { file: "waves.obj" x_m: -50 y_m: 1 yaw_deg: 90 friction: 0.25 restitution: 0.5 }
surface { file: "waves.baked" x_m: -20 replicated: false })");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const auto& s = out.settings.surfaces;
    ASSERT_EQ(s.size(), 3u);
    EXPECT_EQ(s[0].shape.kind, physics::ShapeKind::kHeightfield);
    EXPECT_FLOAT_EQ(s[0].surface->box().upper.y(), 8.0F);
    EXPECT_FLOAT_EQ(s[0].surface->box().upper.x(), 32.0F);
    EXPECT_EQ(s[1].shape.kind, physics::ShapeKind::kMesh);
    EXPECT_EQ(s[1].friction, 0.25F);
    EXPECT_EQ(s[1].restitution, 0.5F);
    EXPECT_EQ(s[1].position, Vec3d(-50.0, 1.0, 0.0));
    // A quarter turn about y takes x to -z.
    EXPECT_LT((s[1].orientation * Vec3::UnitX() + Vec3::UnitZ()).norm(), 1e-6F);
    EXPECT_TRUE(s[1].replicated);
    EXPECT_FALSE(s[2].replicated);
    EXPECT_EQ(assets::difference_of(s[1].shape, s[2].shape), "");
    EXPECT_EQ(s[1].content, s[2].content);
    EXPECT_THAT(stability_warnings_of(out.settings), IsEmpty());
}

TEST_F(Surfaces, HoldsAFileThatStandsInSeveralPlacesOnce) {
    const auto out = load(R"(surface { file: "waves.obj" x_m: -50 }
surface { file: "waves.obj" x_m: 50 yaw_deg: 30 friction: 1 replicated: false }
surface { file: "waves.obj" x_m: 20 scale: 0.5 })");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const auto& s = out.settings.surfaces;
    EXPECT_EQ(s[0].shape.geometry, s[1].shape.geometry);
    EXPECT_EQ(s[0].surface, s[1].surface);
    EXPECT_NE(s[0].shape.geometry, s[2].shape.geometry);
    EXPECT_FLOAT_EQ(s[2].surface->box().upper.x(), 0.5F * s[0].surface->box().upper.x());
    // Movement reads the very vertices that bodies collide with.
    EXPECT_EQ(s[0].surface->mesh().vertices.data(),
              physics::mesh_of(s[0].shape).tables().vertices.data());
}

TEST_F(Surfaces, NamesEachMistakeAtItsPlace) {
    expect_mistake("surface { x_m: 3 }", "surface {", "needs a file");
    expect_mistake(R"(surface { file: "none.obj" })", R"(file: "none.obj")", "cannot be opened");
    std::filesystem::create_directories(folder_ / "folder.obj");
    expect_mistake(R"(surface { file: "folder.obj" })", R"(file: "folder)", "is a folder");
    write("damaged.baked",
          "ZONEDGEO and then something else that is long enough to be a header ..");
    expect_mistake(R"(surface { file: "damaged.baked" })", R"(file: "damaged)", "damaged.baked: ");
    write("binary", std::string("\1\0\2\3", 4));
    expect_mistake(R"(surface { file: "binary" })", R"(file: "binary)", "is no PNG image");
    write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 0 one\nf 1 2 9\n");
    expect_mistake(R"(surface { file: "bad.obj" })", R"(file: "bad.obj)", "line 3");
    expect_mistake(R"(surface { file: "hill.png" })", "surface {", "set height_m");
    expect_mistake(
        R"(surface { file: "hill.png" height_m: 3 scale: 2 })", "scale: 2", "belongs to OBJ files");
    expect_mistake(
        R"(surface { file: "waves.obj" spacing_m: 2 })", "spacing_m: 2", "belongs to PNG images");
    expect_mistake(
        R"(surface { file: "waves.baked" scale: 3 })", "scale: 3", "this is a baked file");
    expect_mistake(
        R"(surface { file: "waves.obj" scale: 0 })", "scale: 0", "must lie in [0.0001..10000]");
    expect_mistake(R"(surface { file: "waves.obj" x_m: 300 })", "surface {", "outside the world");
    expect_mistake(R"(surface { file: "waves.obj" y_m: 999 scale: 90 })",
                   "surface {",
                   "higher than states can tell");
    expect_mistake(R"(surface { file: "waves.obj" sha256: "short" })", "sha256:", "64");
    expect_mistake(R"(surface { file: "waves.obj" sha256: ")" + std::string(64, '0') + "\" }",
                   "sha256:",
                   "has another content than is asked for");
}

TEST_F(Surfaces, RefusesAFileThatIsTooLarge) {
    std::ofstream(folder_ / "large.obj").close();
    std::filesystem::resize_file(folder_ / "large.obj",
                                 assets::kMaxGeometryFile + 1);  // a hole: no bytes
    expect_mistake(R"(surface { file: "large.obj" })", R"(file: "large)", "is larger than");
}

TEST_F(Surfaces, RefusesMoreThanClientsCanBeTold) {
    // 1,100 x 1,100 samples of 4 bytes are more than 4 MiB.
    const std::vector<std::uint8_t> pixels(std::size_t{1100} * 1100, 0);
    const auto bytes = assets::test::png_of(1100, 1100, PNG_FORMAT_GRAY, pixels.data());
    write("wide.png", std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    const std::string wide = R"(surface { file: "wide.png" height_m: 1 spacing_m: 0.1 )";
    expect_mistake(wide + "}", "surface {", "more than 4194304");
    EXPECT_TRUE(load(wide + "replicated: false }").ok);
}

TEST_F(Surfaces, ReportsAllMistakesAtOnce) {
    const auto out = load(R"(surface { file: "none.obj" }
surface { file: "hill.png" }
surface { file: "waves.obj" x_m: -400 }
box { x_m: 900 })");
    EXPECT_EQ(out.errors.size(), 4u) << format_errors("test", out.errors);
}

TEST_F(Surfaces, AreInTheDigestByTheirContent) {
    const std::string digest = load(kHill).settings.digest;
    EXPECT_NE(digest, load("").settings.digest);
    EXPECT_EQ(digest, load(kHill).settings.digest);
    EXPECT_NE(digest, load(with("x_m: 20", "x_m: 21", kHill)).settings.digest);
    EXPECT_NE(digest, load(with("height_m: 8", "height_m: 8.001", kHill)).settings.digest);
    EXPECT_NE(digest, load(with("height_m", "replicated: false height_m", kHill)).settings.digest);
    EXPECT_EQ(digest, load(with("height_m", "friction: 0.1 height_m", kHill)).settings.digest);
    write_hill(0.999);
    EXPECT_NE(digest, load(kHill).settings.digest);
    // Text and baked form of one mesh are the same world.
    EXPECT_EQ(load(R"(surface { file: "waves.obj" })").settings.digest,
              load(R"(surface { file: "waves.baked" })").settings.digest);
}

TEST_F(Surfaces, RecordedTextRefusesAFileThatChanged) {
    const auto before = load(kHill);
    ASSERT_TRUE(before.ok);
    // The canonical text, as in a recording, names the file from where the server ran.
    test::Outcome again = parse(before.settings.text);
    EXPECT_TRUE(again.ok) << format_errors("test", again.errors);
    EXPECT_EQ(again.settings.digest, before.settings.digest);
    EXPECT_EQ(again.settings.text, before.settings.text);
    write_hill(0.5);
    again = parse(before.settings.text);
    ASSERT_EQ(again.errors.size(), 1u) << format_errors("test", again.errors);
    EXPECT_EQ(again.errors[0].path, "statics.surface[0].sha256");
    EXPECT_THAT(again.errors[0].text, HasSubstr("hill.png has another content"));
}

TEST_F(Surfaces, AreToldToClientsWhole) {
    const auto out = load(kHill + "\nsurface { file: \"waves.obj\" x_m: -50 }\n" +
                          "surface { file: \"waves.obj\" x_m: -20 replicated: false }");
    const proto::WorldDescription world = describe_world(out.settings);
    ASSERT_EQ(world.surfaces_size(), 3);
    EXPECT_EQ(world.surfaces(0).heights().height_size(), 33 * 33);
    EXPECT_EQ(world.surfaces(1).triangles().vertex_size(), 3 * 81);
    EXPECT_EQ(world.surfaces(1).triangles().corner_size(), 3 * 128);
    EXPECT_FALSE(world.surfaces(2).has_heights() || world.surfaces(2).has_triangles());
    EXPECT_EQ(world.surfaces(2).content(), world.surfaces(1).content());
}

TEST_F(Surfaces, CarryWhatIsPlacedAndScattered) {
    // The cone rises by 8 m over 32 m: 14 degrees. Its top lies over (20, 0).
    const auto out = load(kHill,
                          R"(entity { type: "crate" x_m: 36 z_m: 0 asleep: true }
scatter { type: "crate" count: 20 max_slope_deg: 20 asleep: true region { min_x_m: 0 min_z_m: -20 max_x_m: 40 max_z_m: 20 } }
spawn { x_m: 10 z_m: 5 })");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const auto cone = [](double x, double z) {
        return 8.0 * std::max(0.0, 1.0 - std::hypot(x - 20.0, z) / 32.0);
    };
    ASSERT_EQ(out.settings.initial.size(), 21u);
    for (const InitialEntity& e : out.settings.initial) {
        // On the highest place of the disc that it covers: at most 0.71 m uphill, 0.25 m a metre,
        // and the height that triangles cut off the cone.
        const double above = e.position.y() - 0.5 - cone(e.position.x(), e.position.z());
        EXPECT_GT(above, -0.02);
        EXPECT_LT(above, 0.25);
        EXPECT_FALSE(e.asleep) << "it hangs over the slope and has to come to rest";
    }
    const Vec3d& spawn = out.settings.spawn_points.back().position;
    EXPECT_NEAR(spawn.y(), cone(10.0, 5.0) + 0.9, 0.2);
    // Without a slope allowed, nothing on the cone is level.
    const auto level = load(kHill,
                            "scatter { type: \"crate\" count: 3 region { min_x_m: 5 min_z_m: -15 "
                            "max_x_m: 35 max_z_m: 15 } }");
    ASSERT_EQ(level.errors.size(), 1u);
    EXPECT_THAT(level.errors[0].text, HasSubstr("find a free and level place"));
    // No entity is put into the hill.
    const auto inside = load(kHill, "entity { type: \"crate\" x_m: 20 y_m: 4 z_m: 0 }");
    ASSERT_EQ(inside.errors.size(), 1u);
    EXPECT_THAT(inside.errors[0].text, HasSubstr("stands inside"));
}

TEST_F(Surfaces, AreSurveyedForStabilityWarnings) {
    write("thin.obj",
          assets::test::waves_obj(4, 1.0) + "v 0 1 0\nv 0.5 1 0\nv 0.25 1 0.0001\nf -3 -2 -1\n");
    const auto out = load(R"(surface { file: "thin.obj" }
surface { file: "thin.obj" x_m: 30 })");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const auto warnings = stability_warnings_of(out.settings);
    ASSERT_EQ(warnings.size(), 1u) << "the same geometry is told of once";
    EXPECT_THAT(warnings[0], HasSubstr("statics.surface[0] ("));
    EXPECT_THAT(warnings[0], HasSubstr("thin"));
}

TEST(Broadphase, ReachesTheEngineByNameAndIsTheEnginesOwnDefault) {
    const physics::PhysicsSettings engine;
    const auto plain = parse(test::kValid);
    EXPECT_EQ(plain.settings.physics.broadphase, engine.broadphase);
    EXPECT_EQ(plain.settings.physics.cell_depth, engine.cell_depth);
    EXPECT_EQ(plain.settings.physics.boxes_per_cell, engine.boxes_per_cell);
    for (const auto kind : {spatial::BroadphaseKind::kAutomatic,
                            spatial::BroadphaseKind::kAllPairs,
                            spatial::BroadphaseKind::kGrid,
                            spatial::BroadphaseKind::kOctree,
                            spatial::BroadphaseKind::kQuadtree,
                            spatial::BroadphaseKind::kSortAndSweep,
                            spatial::BroadphaseKind::kTree}) {
        std::string name(spatial::name_of(kind));
        for (char& c : name) {
            c = static_cast<char>(std::toupper(c));
        }
        const auto out = parse(
            test::kValid,
            {"physics.broadphase=" + name, "physics.cell_depth=9", "physics.boxes_per_cell=7"});
        ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
        EXPECT_EQ(out.settings.physics.broadphase, kind) << name;
        EXPECT_EQ(out.settings.physics.cell_depth, 9);
        EXPECT_EQ(out.settings.physics.boxes_per_cell, 7);
    }
    test::expect_single(
        test::kValid + "physics { cell_depth: 31 }\n", "cell_depth", "must lie in [1..30]");
    test::expect_single(
        test::kValid + "physics { broadphase: KD_TREE }\n", "broadphase", "choose one of");
}

}  // namespace
}  // namespace zoned::config
