// Meshes of which no soft body can be made are refused with the place; all others are bodies.
#include "tests/unit/soft/mesh_shapes.h"
#include "shared/core/rng.h"

#include <set>

namespace zoned::physics::soft {
namespace {

std::string mistake_of(const MeshBodyDef& def) {
    const auto built = build_mesh_body(def);
    return built.ok() ? "" : built.error();
}

TEST(MeshRefusal, IsRefusedWithThePlace) {
    MeshBodyDef def = square_mesh(3);
    def.lines = {11, 12, 13, 14, 15, 16, 17, 18};
    EXPECT_EQ(mistake_of(def), "");
    MeshBodyDef bad = def;
    bad.indices[3] = bad.indices[4];
    EXPECT_EQ(mistake_of(bad), "mesh: line 12: the triangle has no area");
    bad = def;
    bad.indices.insert(bad.indices.end(), bad.indices.begin(), bad.indices.begin() + 3);
    bad.lines.push_back(19);
    EXPECT_EQ(mistake_of(bad), "mesh: line 19: the triangle is there already");
    bad = def;
    bad.vertices.emplace_back(0.5F, -0.5F, 1.0F);
    bad.indices.insert(bad.indices.end(), {1, 3, 9});
    bad.lines.push_back(19);
    EXPECT_EQ(mistake_of(bad), "mesh: line 19: an edge has more than two triangles");
    bad = def;
    for (const Vec3& v : {Vec3(9, 0, 0), Vec3(8, 0, 0), Vec3(8, 1, 0)}) {
        bad.indices.push_back(static_cast<std::uint32_t>(bad.vertices.size()));
        bad.vertices.push_back(v);
    }
    bad.lines.push_back(19);
    EXPECT_EQ(mistake_of(bad),
              "mesh: line 19: nothing joins the triangle to the first one: a body is one part");
    bad = def;
    bad.gas_pressure = 102000.0F;
    EXPECT_EQ(mistake_of(bad), "mesh: line 11: gas needs a closed surface: it has an open edge");
    bad = def;
    bad.pins = {{Vec3(0, 0, 0), 0.1F}, {Vec3(9, 9, 9), 0.1F}};
    EXPECT_EQ(mistake_of(bad), "mesh: pin 2 holds no vertex");
    bad = def;
    bad.nodes = 2;
    EXPECT_EQ(mistake_of(bad), "mesh: nodes: a surface has at least 3");
    bad = def;
    bad.pins = {{Vec3(0, 0, 0), 9.0F}};
    bad.nodes = 4;
    EXPECT_EQ(mistake_of(bad),
              "mesh: it cannot be drawn together to 4 nodes, only to 9: pins and what joins it "
              "stay");
    bad = def;
    bad.vertices[4].x() = kNan;
    EXPECT_EQ(mistake_of(bad), "mesh: vertex 4 is not finite or out of range");
    bad = def;
    bad.indices[5] = 99;
    EXPECT_EQ(mistake_of(bad), "mesh: index 5 names no vertex");
    bad = def;
    bad.mass = -1.0F;
    EXPECT_EQ(mistake_of(bad), "mesh: mass not positive or out of range");
    bad = def;
    bad.stiffness = kNan;
    EXPECT_EQ(mistake_of(bad), "mesh: stiffness not positive or out of range");
    bad = def;
    bad.lines.pop_back();
    EXPECT_EQ(mistake_of(bad), "mesh: as many lines as triangles are asked for");
    EXPECT_EQ(mistake_of(square_mesh(258)), "mesh: 66564 vertices are more than 65536");
}

TEST(MeshRefusal, NeedsASurfaceThatFacesOutwardForGas) {
    MeshBodyDef def = ball_mesh(1);
    def.gas_pressure = 102000.0F;
    EXPECT_EQ(mistake_of(def), "");
    MeshBodyDef turned = def;
    std::swap(turned.indices[10], turned.indices[11]);
    EXPECT_NE(mistake_of(turned).find("it and its neighbour face in opposite directions"),
              std::string::npos);
    turned.gas_pressure = 0.0F;
    EXPECT_EQ(mistake_of(turned), "") << "a cloth has no outside";
    MeshBodyDef inward = def;
    for (std::size_t i = 0; i < inward.indices.size(); i += 3) {
        std::swap(inward.indices[i], inward.indices[i + 1]);
    }
    EXPECT_EQ(mistake_of(inward),
              "mesh: gas needs a surface that faces outward: all triangles face inward");
}

/// A sheet or a ball with holes, turned, repeated and moved triangles and vertices.
MeshBodyDef broken_mesh(core::Rng& rng) {
    const auto below = [&](std::uint32_t n) {
        return rng.next() % n;
    };
    MeshBodyDef def = below(2) == 0 ? square_mesh(3 + static_cast<int>(below(6)))
                                    : ball_mesh(static_cast<int>(below(3)));
    const auto triangles = [&] {
        return static_cast<std::uint32_t>(def.indices.size() / 3);
    };
    for (std::uint32_t k = below(8); k > 0 && triangles() > 1; --k) {
        const std::uint32_t at = 3 * below(triangles());
        const auto first = def.indices.begin() + at;
        switch (below(7)) {
            case 0:
            case 1:
            case 2:
                def.indices.erase(first, first + 3);
                break;
            case 3:
                std::swap(def.indices[at], def.indices[at + 1]);
                break;
            case 4:
                def.indices.insert(def.indices.end(), {def.indices[at], def.indices[at + 1], 0U});
                break;
            case 5:
                def.vertices[def.indices[at]] =
                    def.vertices[below(static_cast<std::uint32_t>(def.vertices.size()))];
                break;
            default:
                def.vertices[def.indices[at]] *= below(9) == 0 ? kNan : 0.5F;
        }
    }
    def.nodes = below(2) == 0 ? 0 : static_cast<int>(below(60));
    def.gas_pressure = below(3) == 0 ? 102000.0F : 0.0F;
    def.bend_stiffness = below(2) == 0 ? 0.0F : 10.0F;
    if (below(2) == 0) {
        def.pins = {{def.vertices[below(static_cast<std::uint32_t>(def.vertices.size()))], 0.2F}};
    }
    return def;
}

/// Each random mesh is refused with a reason, or is a body with the mesh's mass that looks like it.
TEST(MeshRefusal, HoldsOrIsRefusedWhateverTheMeshIs) {
    core::Rng rng(91);
    int held = 0;
    int coarse = 0;
    std::set<std::string> reasons;
    for (int i = 0; i < 3000; ++i) {
        const MeshBodyDef def = broken_mesh(rng);
        const auto built = build_mesh_body(def);
        if (!built) {
            reasons.insert(built.error().substr(built.error().find_last_of(':') + 1));
            continue;
        }
        ++held;
        coarse += built->vertices.empty() ? 0 : 1;
        ASSERT_EQ(why_unfit(*built), "");
        EXPECT_NEAR(weight_of(*built).first, def.mass, 1e-6 * def.mass);
        EXPECT_LT((weight_of(*built).second - weight_of(def).second).norm(), 4e-6);
        expect_drawn_as_the_mesh(def, *built);
        SoftBodies bodies(awake_soft());
        const SoftId id = put(bodies, *built);
        run(bodies, 2);
        for (const Vec3& v : drawn(bodies, id)) {
            ASSERT_TRUE(v.allFinite());
        }
    }
    EXPECT_GT(held, 300);
    EXPECT_GT(coarse, 100);
    EXPECT_GE(reasons.size(), 7U);
}

}  // namespace
}  // namespace zoned::physics::soft
