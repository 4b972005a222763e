// Soft bodies from OBJ files in a config, cloth simulated coarser than it is drawn, and mistakes.
#include "server/config/expand/load_settings.h"
#include "server/config/text/sha256.h"
#include "server/config/types/soft_types.h"
#include "tests/unit/config/config_helpers.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace zoned::config {
namespace {

using ::testing::HasSubstr;

/// A level square of 10 x 10 cells of 1 unit, each one polygon.
std::string square_obj() {
    std::string out;
    for (int j = 0; j <= 10; ++j) {
        for (int i = 0; i <= 10; ++i) {
            out += "v " + std::to_string(i) + " 0 " + std::to_string(j) + "\n";
        }
    }
    for (int j = 0; j < 10; ++j) {
        for (int i = 0; i < 10; ++i) {
            const int a = 11 * j + i + 1;
            out += "f";
            for (const int corner : {a, a + 11, a + 12, a + 1}) {
                out += " " + std::to_string(corner);
            }
            out += "\n";
        }
    }
    return out;
}

const std::string kTetrahedron =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

class SoftMeshConfig : public testing::Test {
  protected:
    SoftMeshConfig()
        : folder_(std::filesystem::temp_directory_path() /
                  ("zoned-soft-mesh-" + std::to_string(::getpid()))) {
        std::filesystem::create_directories(folder_);
        write("sheet.obj", square_obj());
        write("gem.obj", kTetrahedron);
    }

    ~SoftMeshConfig() override { std::filesystem::remove_all(folder_); }

    void write(const std::string& name, const std::string& bytes) {
        std::ofstream(folder_ / name, std::ios::binary) << bytes;
    }

    test::Outcome load_text(const std::string& type) {
        write("world.txtpb", test::kValid + type);
        test::Outcome out;
        out.ok = load_settings((folder_ / "world.txtpb").string(), {}, out.settings, out.errors);
        return out;
    }

    test::Outcome load_mesh(const std::string& mesh, const std::string& soft = {}) {
        return load_text("type { name: \"thing\" mass_kg: 3 soft { mesh { " + mesh + " } " + soft +
                         " } }\n");
    }

    static const physics::soft::SoftDef& thing(const test::Outcome& out) {
        return *out.settings.softs.at(0);
    }

    void expect_mistake(const std::string& words,
                        const std::string& mesh,
                        const std::string& soft = {}) {
        SCOPED_TRACE(words);
        const test::Outcome out = load_mesh(mesh, soft);
        ASSERT_EQ(out.errors.size(), 1U) << format_errors("test", out.errors);
        EXPECT_THAT(out.errors[0].text, HasSubstr(words));
    }

    std::filesystem::path folder_;
};

TEST_F(SoftMeshConfig, IsReadFromTheConfigsFolder) {
    const auto out = load_mesh(R"(file: "sheet.obj" scale: 0.5 stiffness_npm: 700
        bend_stiffness_npm: 0 pin { radius_m: 0.6 } )");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const auto& def = thing(out);
    ASSERT_EQ(def.nodes.size(), 121U);
    EXPECT_TRUE(def.vertices.empty());
    EXPECT_EQ(def.faces.size(), 200U);
    EXPECT_EQ(def.springs.size(), 110U + 110U + 100U);
    double mass = 0.0;
    int pinned = 0;
    for (const auto& node : def.nodes) {
        mass += static_cast<double>(node.mass);
        pinned += node.pinned ? 1 : 0;
        // Its position is its centre of mass, the middle of the square.
        EXPECT_LE(node.position.cwiseAbs().maxCoeff(), 2.5F + 1e-6F);
        EXPECT_EQ(node.pinned, (node.position - Vec3(-2.5F, 0, -2.5F)).norm() < 0.61F);
    }
    EXPECT_NEAR(mass, 3.0, 1e-6);
    EXPECT_EQ(pinned, 3);
    EXPECT_FLOAT_EQ(
        std::max_element(def.springs.begin(),
                         def.springs.end(),
                         [](const auto& a, const auto& b) { return a.stiffness < b.stiffness; })
            ->stiffness,
        700.0F);
    EXPECT_EQ(out.settings.config->type(3).soft().mesh().sha256(), sha256_hex(square_obj()));
}

TEST_F(SoftMeshConfig, SimulatesAsManyNodesAsItSaysAndDrawsAll) {
    const auto out = load_mesh(R"(file: "sheet.obj" nodes: 40 pin { x_m: 5 z_m: 5 })");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(thing(out).nodes.size(), 40U);
    EXPECT_EQ(thing(out).vertices.size(), 121U);
    EXPECT_EQ(thing(out).drawn_faces.size(), 200U);
    EXPECT_EQ(std::count_if(thing(out).nodes.begin(),
                            thing(out).nodes.end(),
                            [](const auto& node) { return node.pinned; }),
              1);
    // The lattice that stands for it in trials has the same mass and the pin too.
    const auto coarse = build_soft(coarsened(out.settings.config->type(3), 2));
    ASSERT_TRUE(coarse.ok());
    EXPECT_EQ(coarse->def.nodes.size(), 10U);
}

/// The trials of a budget run on the nodes alone, without what is drawn.
TEST_F(SoftMeshConfig, HasItsMethodChosenWithinABudget) {
    for (const char* form : {R"(mesh { file: "sheet.obj" nodes: 40 pin { } })",
                             "cloth { columns: 9 rows: 9 coarsen: 2 pin { } }"}) {
        const auto out = load_text(std::string("budget { soft_share: 0.1 }\n") +
                                   "type { name: \"thing\" mass_kg: 3 soft { " + form + " } }\n");
        ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
        EXPECT_GT(thing(out).solver.substeps, 0);
        EXPECT_FALSE(thing(out).drawn_faces.empty());
    }
}

TEST_F(SoftMeshConfig, HoldsGasWhereItIsClosed) {
    const auto out = load_mesh(R"(file: "gem.obj" gas_pressure_pa: 102000)");
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    EXPECT_EQ(thing(out).material.gas_pressure, 102000.0F);
    expect_mistake("it has an open edge", R"(file: "sheet.obj" gas_pressure_pa: 102000)");
    expect_mistake("less than the 101325 Pa of the air around it",
                   R"(file: "gem.obj" gas_pressure_pa: 90000)");
}

TEST_F(SoftMeshConfig, NamesFileAndLineOfAMistake) {
    expect_mistake("a mesh needs a file", "nodes: 5");
    expect_mistake("none.obj: cannot be opened", R"(file: "none.obj")");
    write("image.obj", std::string("\x89PNG\r\n\x1a\n") + std::string(8, '\0'));
    expect_mistake("image.obj: is no OBJ text", R"(file: "image.obj")");
    write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n");
    expect_mistake("bad.obj: has 1 mistake; line 3:", R"(file: "bad.obj")");
    write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 7\n");
    expect_mistake("bad.obj: has 1 mistake; line 5: names vertex 7 of 3", R"(file: "bad.obj")");
    write("bad.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 4\nf 1 2 3\n");
    expect_mistake("bad.obj: mesh: line 6: the triangle has no area", R"(file: "bad.obj")");
    write("bad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 200 0\nf 1 2 3\nf 1 3 4\n");
    expect_mistake("bad.obj: mesh: line 4: the vertex lies more than 1000000 m out",
                   R"(file: "bad.obj" scale: 10000)");
    write("bad.obj", "");
    expect_mistake("bad.obj: mesh: no triangle has an area", R"(file: "bad.obj")");
    expect_mistake("sheet.obj: mesh: pin 1 holds no vertex",
                   R"(file: "sheet.obj" pin { y_m: 4 radius_m: 0.1 })");
    expect_mistake("sheet.obj: mesh: nodes: a surface has at least 3",
                   R"(file: "sheet.obj" nodes: 2)");
    expect_mistake(
        "none may hang on a body that tears", R"(file: "sheet.obj" nodes: 40)", "tear_strain: 0.5");
    expect_mistake("another content than is asked for",
                   R"(file: "sheet.obj" sha256: ")" + std::string(64, '0') + "\"");
}

/// A config that was loaded keeps to the content that it was loaded with.
TEST_F(SoftMeshConfig, RefusesAFileThatChanged) {
    const auto out = load_mesh(R"(file: "sheet.obj")");
    ASSERT_TRUE(out.ok);
    EXPECT_TRUE(build_soft(out.settings.config->type(3)).ok());
    write("sheet.obj", kTetrahedron);
    const auto changed = build_soft(out.settings.config->type(3));
    ASSERT_FALSE(changed.ok());
    EXPECT_THAT(changed.error(), HasSubstr("another content than is asked for"));
}

std::string cloth_type(const std::string& more) {
    return "type { name: \"thing\" mass_kg: 3 soft { cloth { columns: 17 rows: 9 "
           "pin { column: 16 row: 0 } " +
           more + " } } }\n";
}

TEST_F(SoftMeshConfig, ClothIsSimulatedCoarserWhereItSaysSo) {
    const auto whole = load_text(cloth_type(""));
    ASSERT_TRUE(whole.ok) << format_errors("test", whole.errors);
    EXPECT_EQ(thing(whole).nodes.size(), 17U * 9U);
    EXPECT_TRUE(thing(whole).vertices.empty());
    const auto out = load_text(cloth_type("coarsen: 4"));
    ASSERT_TRUE(out.ok) << format_errors("test", out.errors);
    const auto& def = thing(out);
    EXPECT_EQ(def.nodes.size(), 5U * 3U);
    EXPECT_EQ(def.vertices.size(), 17U * 9U);
    EXPECT_EQ(def.drawn_faces.size(), 16U * 8U * 2U);
    EXPECT_TRUE(def.nodes[4].pinned);
    // Drawn where the whole cloth's nodes are.
    for (std::size_t i = 0; i < def.vertices.size(); ++i) {
        Vec3 place = Vec3::Zero();
        for (std::size_t k = 0; k < 4; ++k) {
            place += def.vertices[i].weight[k] * def.nodes[def.vertices[i].node[k]].position;
        }
        EXPECT_LT((place - thing(whole).nodes[i].position).norm(), 1e-6F) << i;
    }
    EXPECT_EQ(thing(whole).faces, def.drawn_faces);
    const auto trial = build_soft(coarsened(out.settings.config->type(3), 2));
    ASSERT_TRUE(trial.ok());
    EXPECT_EQ(trial->def.nodes.size(), 3U * 2U);
    EXPECT_NEAR(trial->def.springs[0].damping / def.springs[0].damping, 1.0F, 0.3F);
    const auto odd = load_text(cloth_type("coarsen: 3"));
    ASSERT_EQ(odd.errors.size(), 1U);
    EXPECT_THAT(odd.errors[0].text, HasSubstr("no node at each corner and pin"));
}

}  // namespace
}  // namespace zoned::config
