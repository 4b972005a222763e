// zoned bake: its output for users and scripts.
#include "server/app/commands/commands.h"
#include "server/assets/baked_geometry.h"
#include "server/assets/geometry_files.h"
#include "tests/unit/assets/geometry_samples.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace zoned::app {
namespace {

core::Result<physics::Shape> load_baked(const std::string& path) {
    return assets::read_baked(*assets::read_geometry_file(path));
}

using ::testing::HasSubstr;
using ::testing::Not;

struct Outcome {
    int code = -1;
    std::string output;
    std::string errors;
};

Outcome run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "zoned");
    std::vector<char*> argv;
    for (std::string& argument : arguments) {
        argv.push_back(argument.data());
    }
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    Outcome out;
    out.code = run_command_line(static_cast<int>(argv.size()), argv.data());
    out.output = ::testing::internal::GetCapturedStdout();
    out.errors = ::testing::internal::GetCapturedStderr();
    return out;
}

std::string read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

/// A folder of its own for each test, with a mesh and a heightfield in it.
class Bake : public ::testing::Test {
  protected:
    Bake() {
        const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = ::testing::TempDir() + "/bake-" + name + "-" + std::to_string(getpid());
        std::filesystem::create_directories(folder_);
        std::ofstream(obj(), std::ios::binary) << assets::test::waves_obj(8, 10.0);
        std::vector<std::uint16_t> pixels;
        for (std::uint32_t i = 0; i < 64 * 48; ++i) {
            pixels.push_back(static_cast<std::uint16_t>(500 * (i % 64) + 10 * (i / 64)));
        }
        const auto bytes = assets::test::png_of(64, 48, PNG_FORMAT_LINEAR_Y, pixels.data());
        std::ofstream(png(), std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()),
                   static_cast<std::streamsize>(bytes.size()));
    }

    ~Bake() override { std::filesystem::remove_all(folder_); }

    [[nodiscard]] std::string at(const std::string& name) const { return folder_ + "/" + name; }

    // Names that do not show the content.
    [[nodiscard]] std::string obj() const { return at("first.dat"); }

    [[nodiscard]] std::string png() const { return at("second.dat"); }

  private:
    std::string folder_;
};

TEST_F(Bake, ReportsAMeshAndWritesWhatChecksGood) {
    const Outcome baked = run({"bake", obj()});
    EXPECT_EQ(baked.code, kGood) << baked.errors;
    for (const char* words : {"OBJ text",
                              "64, cut into 128 triangles",
                              "0 without area",
                              "32 of one triangle only (first: vertices of lines 1, 2)",
                              "0 of more than two triangles",
                              "0 edges whose two triangles face opposite ways",
                              "from (-5, ",
                              "levels",
                              "memory",
                              "times as fast",
                              "read back and compared",
                              "wrote "}) {
        EXPECT_THAT(baked.output, HasSubstr(words));
    }
    const auto loaded = load_baked(obj() + ".baked");
    ASSERT_TRUE(loaded.ok()) << loaded.error();
    EXPECT_EQ(physics::mesh_of(*loaded).triangle_count(), 128U);
    const Outcome checked = run({"bake", "--check", obj() + ".baked"});
    EXPECT_EQ(checked.code, kGood) << checked.errors;
    EXPECT_THAT(checked.output, HasSubstr("checksum good"));
    EXPECT_THAT(checked.output, HasSubstr("built anew         the same"));
}

TEST_F(Bake, TakesTheOptionsOfItsKindOnly) {
    EXPECT_EQ(run({"bake", obj(), "--scale", "2", "--weld", "0.01", "--out", at("m")}).code, kGood);
    EXPECT_EQ(physics::mesh_of(*load_baked(at("m"))).box().upper.x(), 10.0F);
    const Outcome field = run({"bake",
                               png(),
                               "--height",
                               "65.535",
                               "--spacing",
                               "2",
                               "--offset",
                               "-1",
                               "--thickness",
                               "3",
                               "--out",
                               at("f")});
    EXPECT_EQ(field.code, kGood) << field.errors;
    EXPECT_THAT(field.output, HasSubstr("16 bits, 0.001 m each"));
    EXPECT_THAT(field.output, HasSubstr("64 x 48"));
    EXPECT_THAT(field.output, HasSubstr("at the pixel of column"));
    EXPECT_THAT(field.output, Not(HasSubstr("warning")));
    const auto loaded = load_baked(at("f"));
    EXPECT_FLOAT_EQ(physics::field_of(*loaded).height(1, 1), -0.49F);
    EXPECT_EQ(physics::field_of(*loaded).box().lower.y(), -4.0F);
    for (const char* option : {"--height", "--spacing", "--offset", "--thickness"}) {
        const Outcome wrong = run({"bake", obj(), option, "1"});
        EXPECT_EQ(wrong.code, kUsage);
        EXPECT_THAT(wrong.errors, HasSubstr(std::string(option) + " belongs to PNG images"));
    }
    EXPECT_EQ(run({"bake", png(), "--height", "1", "--scale", "1"}).code, kUsage);
    const Outcome flat = run({"bake", png()});
    EXPECT_EQ(flat.code, kUsage);
    EXPECT_THAT(flat.errors, HasSubstr("give --height"));
    EXPECT_EQ(run({"bake", obj(), "--error-budget", "0"}).code, kUsage);
}

TEST_F(Bake, NamesAllMistakesOfAnObjWithTheirLines) {
    std::ofstream(obj()) << "v 0 0 0\nv 1 zero 0\nv 0 0 1\nf 1 2\nf 1 2 3\nf 3 2 8\n";
    const Outcome wrong = run({"bake", obj()});
    EXPECT_EQ(wrong.code, kUsage);
    for (const char* words : {":2: 'zero' is no finite number",
                              ":4: a face has three corners",
                              ":6: names vertex 8 of 3",
                              "3 mistakes in "}) {
        EXPECT_THAT(wrong.errors, HasSubstr(words));
    }
    EXPECT_FALSE(std::filesystem::exists(obj() + ".baked"));
}

TEST_F(Bake, TellsOddPlacesOfAMeshThatIsUsedAllTheSame) {
    // Two triangles that face opposite directions, one without area, a vertex twice and one that no
    // triangle uses.
    std::ofstream(obj()) << "# odd\nv 0 0 0\nv 0 0 1\nv 1 0 0\nv -1 0 0\nv 0 0 1\nv 7 7 7\n"
                            "f 1 2 3\nf 1 5 4\nf 1 1 2\nf 2 3 1\n";
    const Outcome out = run({"bake", obj()});
    EXPECT_EQ(out.code, kGood) << out.errors;
    EXPECT_THAT(out.output, HasSubstr("1 without area, left out (first: face of line 10)"));
    EXPECT_THAT(out.output,
                HasSubstr("1 that are there already, left out (first: face of line 11)"));
    EXPECT_THAT(out.output, HasSubstr("1 of 6; 1 that no face names left out"));
    EXPECT_THAT(out.output,
                HasSubstr("1 edges whose two triangles face opposite ways (first: vertices of "
                          "lines 2, 3)"));
}

TEST_F(Bake, WarnsOfWhatThePhysicsCannotCarry) {
    std::ofstream(obj()) << "v 0 0 0\nv 0 0 1\nv 0.001 0 0\nf 1 2 3\n";
    const Outcome thin = run({"bake", obj(), "--check"});
    EXPECT_EQ(thin.code, kGood) << thin.errors;
    EXPECT_THAT(thin.output, HasSubstr("warning: 1 triangles are slivers"));
    EXPECT_THAT(run({"bake", obj(), "--check", "--error-budget", "0.0005"}).output,
                Not(HasSubstr("warning")));
}

TEST_F(Bake, NamesTheRowOfABrokenImage) {
    const std::string bytes = read(png());
    std::ofstream(png(), std::ios::binary) << bytes.substr(0, bytes.size() / 2);
    const Outcome out = run({"bake", png(), "--height", "1"});
    EXPECT_EQ(out.code, kUsage);
    EXPECT_THAT(out.errors, HasSubstr("the image is broken at row "));
    EXPECT_THAT(out.errors, HasSubstr(" of 48"));
}

TEST_F(Bake, ChecksBakedFilesToTheBottom) {
    ASSERT_EQ(run({"bake", obj()}).code, kGood);
    const std::string path = obj() + ".baked";
    const std::string good = read(path);
    const auto check = [&](const std::string& bytes) {
        std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
        return run({"bake", "--check", path});
    };
    std::string damaged = good;
    damaged[good.size() / 2] = static_cast<char>(damaged[good.size() / 2] ^ 4);
    EXPECT_EQ(check(damaged).code, kUsage);
    EXPECT_THAT(check(damaged).errors, HasSubstr("checksum does not fit"));
    EXPECT_THAT(check(good.substr(0, 100)).errors, HasSubstr("cut short"));
    // The file is whole and sealed, but an open edge is marked as flat. The bends lie behind 81
    // vertices and 128 triangles.
    std::string forged = good;
    const std::size_t bend = assets::kBakedBodyAt + 16 + 81 * 12 + 128 * 12;
    const float flat[2] = {0.6F, 0.8F};
    forged.replace(bend, sizeof(flat), reinterpret_cast<const char*>(flat), sizeof(flat));
    assets::seal_baked(forged);
    EXPECT_EQ(check(forged).code, kUsage);
    EXPECT_THAT(check(forged).errors,
                HasSubstr("is not what its triangles give when they are "
                          "baked: bends"));
    EXPECT_EQ(check(good).code, kGood);
    const Outcome again = run({"bake", path});
    EXPECT_EQ(again.code, kUsage);
    EXPECT_THAT(again.errors, HasSubstr("is baked already"));
}

TEST_F(Bake, KeepsItsHandsOffOtherFiles) {
    const std::string before = read(obj());
    EXPECT_EQ(run({"bake", obj(), "--out", obj()}).code, kUsage);
    EXPECT_EQ(read(obj()), before);
    EXPECT_EQ(run({"bake", obj(), "--out", "/no/such/folder/x"}).code, kEnvironment);
    EXPECT_EQ(run({"bake", at("missing")}).code, kEnvironment);
    std::ofstream(at("bytes"), std::ios::binary) << std::string(9, '\0');
    const Outcome unknown = run({"bake", at("bytes")});
    EXPECT_EQ(unknown.code, kUsage);
    EXPECT_THAT(unknown.errors, HasSubstr("is no PNG image, no OBJ text and no baked file"));
    EXPECT_EQ(run({"bake", obj(), "--check"}).code, kGood);
    EXPECT_FALSE(std::filesystem::exists(obj() + ".baked"));
}

TEST_F(Bake, ShowsHelpWithExamples) {
    const Outcome help = run({"bake", "--help"});
    EXPECT_EQ(help.code, kGood);
    EXPECT_THAT(help.output, HasSubstr("zoned bake --check"));
}

TEST(Check, WarnsOfInstabilityAfterTheGoodLine) {
    const std::string config = ZONED_SOURCE_DIR "/config/minimal.txtpb";
    const Outcome good = run({"check", config});
    EXPECT_EQ(good.code, kGood);
    EXPECT_THAT(good.output, Not(HasSubstr("warning")));
    const Outcome substep_limited = run({"check", config, "--set", "physics.substeps=1"});
    EXPECT_EQ(substep_limited.code, kGood) << substep_limited.errors;
    EXPECT_LT(substep_limited.output.find(": good: "),
              substep_limited.output.find("warning: physics: the step"));
    EXPECT_THAT(substep_limited.output,
                HasSubstr("warning: physics: the step is too long for contacts"));
}

}  // namespace
}  // namespace zoned::app
