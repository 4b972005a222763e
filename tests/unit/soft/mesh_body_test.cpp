// Soft bodies from meshes: masses, springs, gas, and fewer nodes than vertices.
#include "server/compute/worker_pool.h"
#include "tests/unit/soft/mesh_shapes.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {
namespace {

/// A ball drawn out along x, with its top cut off: open, uneven, curved.
MeshBodyDef bowl_mesh() {
    MeshBodyDef def = ball_mesh(3);
    std::vector<std::uint32_t> kept;
    for (std::size_t i = 0; i < def.indices.size(); i += 3) {
        if (def.vertices[def.indices[i]].y() < 0.2F) {
            kept.insert(kept.end(), &def.indices[i], &def.indices[i] + 3);
        }
    }
    def.indices = kept;
    for (Vec3& v : def.vertices) {
        v.x() *= 3.0F;
    }
    return def;
}

TEST(MeshBody, HasTheMassAndTheCentreOfTheMesh) {
    for (const MeshBodyDef& whole : {square_mesh(7), ball_mesh(2, Vec3(3, -1, 2)), bowl_mesh()}) {
        const auto [mass, centre] = weight_of(whole);
        for (const int nodes : {0, 100, 30}) {
            MeshBodyDef def = whole;
            def.nodes = nodes;
            const auto [m, c] = weight_of(built_mesh(def));
            // Floats are rounded to 6e-8 of themselves.
            EXPECT_NEAR(m, mass, 1e-7 * mass) << nodes;
            EXPECT_LT((c - centre).norm(), 1e-7 * (1.0 + centre.norm()) * 4.0) << nodes;
        }
    }
}

TEST(MeshBody, GivesEachVertexAThirdOfTheTrianglesAround) {
    MeshBodyDef def;
    def.mass = 3.0F;
    def.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3, 1, 0}};
    def.indices = {0, 1, 2, 2, 1, 3};  // areas 1/2 and 3/2
    const SoftDef built = built_mesh(def);
    ASSERT_EQ(built.nodes.size(), 4U);
    EXPECT_FLOAT_EQ(built.nodes[0].mass, 0.25F);
    EXPECT_FLOAT_EQ(built.nodes[1].mass, 1.0F);
    EXPECT_FLOAT_EQ(built.nodes[2].mass, 1.0F);
    EXPECT_FLOAT_EQ(built.nodes[3].mass, 0.75F);
}

TEST(MeshBody, HasASpringAlongEachEdgeAndAcrossEachInnerOne) {
    MeshBodyDef def = square_mesh(9);
    def.stiffness = 2000.0F;
    def.bend_stiffness = 20.0F;
    const SoftDef built = built_mesh(def);
    // Rows, columns, diagonals; across each of those that is not on the rim.
    std::size_t edges = 0;
    std::size_t across = 0;
    for (const SoftSpring& spring : built.springs) {
        const Vec3 along = built.nodes[spring.b].position - built.nodes[spring.a].position;
        EXPECT_FLOAT_EQ(spring.rest, along.norm());
        if (spring.kind == SpringKind::kBend) {
            ++across;
            continue;
        }
        ++edges;
        const float cell = 0.25F;
        const bool diagonal = along.norm() > 1.1F * cell;
        const auto on_rim = [](float at) {
            return at == 0.0F || std::abs(at) == 2.0F;
        };
        const Vec3 at = built.nodes[spring.a].position;
        const bool rim = !diagonal && (along.x() != 0.0F ? on_rim(at.y()) : on_rim(at.x()));
        EXPECT_NEAR(spring.stiffness, (diagonal || rim) ? 1000.0F : 2000.0F, 0.01F);
    }
    EXPECT_EQ(edges, 9U * 8U + 8U * 9U + 8U * 8U);
    EXPECT_EQ(across, 7U * 8U + 8U * 7U + 8U * 8U);
}

TEST(MeshBody, IsOneNodeWhereVerticesLieAtTheSamePlace) {
    MeshBodyDef apart = square_mesh(5);
    std::vector<Vec3> corners;
    for (std::uint32_t& index : apart.indices) {
        corners.push_back(apart.vertices[index]);
        index = static_cast<std::uint32_t>(corners.size() - 1);
    }
    apart.vertices = corners;
    const SoftDef joined = built_mesh(apart);
    EXPECT_EQ(joined.nodes.size(), 25U);
    EXPECT_EQ(joined.springs.size(), built_mesh(square_mesh(5)).springs.size());
}

void pin_top(SoftDef& def) {
    for (SoftNode& node : def.nodes) {
        node.pinned = node.position.y() > -1e-6F;
    }
}

/// Work that gravity does on a hanging sheet of n x n nodes until it rests, J: twice the elastic
/// energy. Rayleigh: with fewer springs it is more, and (f.y)^2 / y.K y is no more for any move y.
struct HangingWork {
    double least = 0.0;
    double most = 0.0;

    HangingWork(const SoftDef& def, int n) {
        const auto g = static_cast<double>(kGravity);
        const double cell = 2.0 / (n - 1);
        // Fewer: columns that hang by themselves.
        for (int i = 0; i < n; ++i) {
            double below = 0.0;
            for (const SoftNode& node : def.nodes) {
                below += column(node, cell) == i ? static_cast<double>(node.mass) * g : 0.0;
            }
            double drop = 0.0;
            for (int j = 0; j < n; ++j) {
                const std::size_t at = node_at(def, i, j, cell);
                if (j > 0) {
                    drop += below / stiffness_between(def, node_at(def, i, j - 1, cell), at);
                }
                most += static_cast<double>(def.nodes[at].mass) * g * drop;
                below -= static_cast<double>(def.nodes[at].mass) * g;
            }
        }
        // A move straight down, as a rope under its own weight.
        const auto move = [](const SoftNode& node) {
            const auto h = static_cast<double>(-node.position.y());
            return h * (2.0 - 0.5 * h);
        };
        double work = 0.0;
        double energy = 0.0;
        for (const SoftNode& node : def.nodes) {
            work += static_cast<double>(node.mass) * g * move(node);
        }
        for (const SoftSpring& spring : def.springs) {
            const SoftNode& a = def.nodes[spring.a];
            const SoftNode& b = def.nodes[spring.b];
            const auto cosine = static_cast<double>((b.position - a.position).normalized().y());
            energy +=
                static_cast<double>(spring.stiffness) * std::pow(cosine * (move(b) - move(a)), 2.0);
        }
        least = work * work / energy;
    }

    static int column(const SoftNode& node, double cell) {
        return static_cast<int>(std::lround(static_cast<double>(node.position.x()) / cell));
    }

    static std::size_t node_at(const SoftDef& def, int i, int j, double cell) {
        for (std::size_t k = 0; k < def.nodes.size(); ++k) {
            const auto& at = def.nodes[k].position;
            if (column(def.nodes[k], cell) == i &&
                std::lround(static_cast<double>(-at.y()) / cell) == j) {
                return k;
            }
        }
        return 0;
    }

    static double stiffness_between(const SoftDef& def, std::size_t a, std::size_t b) {
        for (const SoftSpring& spring : def.springs) {
            if (std::minmax<std::size_t>(spring.a, spring.b) == std::minmax(a, b)) {
                return static_cast<double>(spring.stiffness);
            }
        }
        return 0.0;
    }
};

/// Work of gravity until it rests. Explicit springs rest where forces balance, exactly.
double work_of_hanging(SoftDef def) {
    pin_top(def);
    def.material.drag = 4.0F;
    def.solver.method = SoftMethod::kSemiImplicitEuler;
    SoftSettings settings = awake_soft();
    settings.step_s = kFrame;
    SoftBodies bodies(settings);
    const SoftId id = put(bodies, def);
    run(bodies, 600);
    double work = 0.0;
    for (std::size_t i = 0; i < def.nodes.size(); ++i) {
        work += static_cast<double>(def.nodes[i].mass * kGravity) *
                static_cast<double>(def.nodes[i].position.y() - bodies.position(id, i).y());
    }
    return work;
}

TEST(MeshBody, HangsAsAClothOfTheSameMaterial) {
    constexpr int kSide = 9;
    MeshBodyDef mesh = square_mesh(kSide);
    mesh.stiffness = 2000.0F;
    mesh.bend_stiffness = 20.0F;
    ClothDef cloth;
    cloth.nx = cloth.nz = kSide;
    cloth.size_x = cloth.size_z = 2.0F;
    cloth.density = 0.2F;
    cloth.stiffness = 2000.0F;
    cloth.shear_stiffness = 1000.0F;
    cloth.bend_stiffness = 20.0F;
    cloth.coarsen = 1;
    SoftDef woven = *build_cloth(cloth);
    for (SoftNode& node : woven.nodes) {
        node.position = Vec3(node.position.x(), -node.position.z(), 0.0F);
    }
    const SoftDef drawn_one = built_mesh(mesh);
    // Springs are linear but for a share as large as their strain, 8 N / 16000 N/m / 0.25 m.
    constexpr double kStrain = 0.01;
    const SoftDef& woven_one = woven;
    for (const SoftDef* def : {&drawn_one, &woven_one}) {
        const HangingWork bound(*def, kSide);
        const double work = work_of_hanging(*def);
        EXPECT_GT(work, (1.0 - kStrain) * bound.least);
        EXPECT_LT(work, (1.0 + kStrain) * bound.most);
    }
    // The one has half the springs along its rim that the other has: 8 columns for 9. Both have
    // springs along diagonals as well, which a sheet that may lean does not load.
    const double drawn_work = work_of_hanging(drawn_one);
    const double woven_work = work_of_hanging(woven);
    EXPECT_LT(std::abs(drawn_work - woven_work),
              std::max(HangingWork(drawn_one, kSide).most, HangingWork(woven, kSide).most) -
                  std::min(HangingWork(drawn_one, kSide).least, HangingWork(woven, kSide).least));
}

double volume_at_rest(SoftDef def) {
    def.material.drag = 20.0F;
    def.solver.method = SoftMethod::kImplicitEuler;
    SoftBodies bodies(weightless_soft());
    const SoftId id = put(bodies, def);
    run(bodies, 240);
    return bodies.volume(id);
}

/// At the same pressure a net of stiffer springs grows less (Rayleigh), so the mesh comes to rest
/// between balloons all of whose springs are as slack as its slackest and as stiff as its stiffest.
TEST(MeshBody, HoldsGasAsABalloonDoes) {
    constexpr float kPressure = 104325.0F;
    MeshBodyDef mesh = ball_mesh(2);
    mesh.stiffness = 5.0e4F;
    mesh.gas_pressure = kPressure;
    const SoftDef built = built_mesh(mesh);
    const auto by_stiffness = [](const SoftSpring& a, const SoftSpring& b) {
        return a.stiffness < b.stiffness;
    };
    const auto [slackest, stiffest] =
        std::minmax_element(built.springs.begin(), built.springs.end(), by_stiffness);
    BalloonDef balloon;
    balloon.splits = 2;
    balloon.gas_pressure = kPressure;
    balloon.stiffness = slackest->stiffness;
    const SoftDef slack = *build_balloon(balloon);
    balloon.stiffness = stiffest->stiffness;
    const SoftDef stiff = *build_balloon(balloon);
    EXPECT_EQ(built.material.gas_pressure, slack.material.gas_pressure);
    SoftBodies bodies;
    const double first = bodies.volume(put(bodies, slack));
    EXPECT_NEAR(bodies.volume(put(bodies, built)), first, 1e-6 * first);
    const double grown = volume_at_rest(built);
    EXPECT_GT(grown, volume_at_rest(stiff));
    EXPECT_LT(grown, volume_at_rest(slack));
    EXPECT_GT(grown, 1.01 * first);
}

TEST(CoarseMesh, IsDrawnAtRestWithAllVerticesOfTheMesh) {
    for (MeshBodyDef def : {square_mesh(13), ball_mesh(3), bowl_mesh()}) {
        const std::size_t all = built_mesh(def).nodes.size();
        for (const int nodes : {120, 60, 30}) {
            def.nodes = nodes;
            const SoftDef built = built_mesh(def);
            EXPECT_LE(built.nodes.size(), static_cast<std::size_t>(nodes));
            EXPECT_GE(built.nodes.size(), static_cast<std::size_t>(nodes) - 1);
            EXPECT_EQ(built.vertices.size(), all);
            EXPECT_EQ(3 * built.drawn_faces.size(), def.indices.size());
            expect_drawn_as_the_mesh(def, built);
        }
    }
}

/// Drawn vertices move with their nodes: turned as one, they are where the turned mesh has them.
TEST(CoarseMesh, IsDrawnTurnedAsItsNodesAre) {
    MeshBodyDef def = bowl_mesh();
    def.nodes = 50;
    const SoftDef built = built_mesh(def);
    SoftBodies bodies(weightless_soft());
    const SoftId id = put(bodies, built);
    const std::vector<Vec3> before = drawn(bodies, id);
    const Quat turn(Eigen::AngleAxisf(1.1F, Vec3(1, 2, -0.5F).normalized()));
    const Vec3 centre = weight_of(built).second.cast<float>();
    bodies.place(id, Vec3(1, 2, 3), turn);
    const std::vector<Vec3> after = drawn(bodies, id);
    for (std::size_t i = 0; i < before.size(); ++i) {
        EXPECT_LT((after[i] - (Vec3(1, 2, 3) + turn * (before[i] - centre))).norm(), 1e-5F) << i;
    }
}

TEST(CoarseMesh, StaysClosedAndKeepsGas) {
    MeshBodyDef def = ball_mesh(3);
    def.gas_pressure = 102000.0F;
    def.nodes = 162;
    const SoftDef built = built_mesh(def);
    EXPECT_EQ(built.nodes.size(), 162U);
    // Euler: as many faces as any triangulation of a sphere with these vertices.
    EXPECT_EQ(built.faces.size(), 2U * 162U - 4U);
    SoftBodies bodies;
    const double fine = bodies.volume(put(bodies, *build_balloon({})));
    BalloonDef even;
    even.splits = 2;
    const double as_even = bodies.volume(put(bodies, *build_balloon(even)));
    const double coarse = bodies.volume(put(bodies, built));
    // Vertices on a sphere enclose less by a share that grows as the area of their faces: even ones
    // lose as much as the balloon of 162 nodes, uneven ones some times that.
    EXPECT_LT(coarse, fine);
    EXPECT_GT(coarse, fine - 3.0 * (fine - as_even));
}

TEST(CoarseMesh, KeepsPinnedVerticesAsPinnedNodes) {
    MeshBodyDef def = square_mesh(13);
    def.stiffness = 200.0F;
    def.pins = {{Vec3(0, 0, 0), 0.01F}, {Vec3(2, 0, 0), 0.4F}, {Vec3(1, -1, 0), 0.01F}};
    for (const int nodes : {0, 40}) {
        def.nodes = nodes;
        const SoftDef built = built_mesh(def);
        std::size_t held = 0;
        for (const Vec3& v : def.vertices) {
            const bool pinned =
                std::any_of(def.pins.begin(), def.pins.end(), [&](const MeshPin& p) {
                    return (v - p.centre).norm() <= p.radius;
                });
            held += pinned ? 1 : 0;
        }
        std::size_t pinned = 0;
        for (const SoftNode& node : built.nodes) {
            pinned += node.pinned ? 1 : 0;
        }
        EXPECT_EQ(pinned, held);
        SoftBodies bodies(awake_soft());
        const SoftId id = put(bodies, built);
        run(bodies, 60);
        const std::vector<Vec3> after = drawn(bodies, id);
        for (std::size_t i = 0; i < after.size(); ++i) {
            const bool pin = std::any_of(def.pins.begin(), def.pins.end(), [&](const MeshPin& p) {
                return (def.vertices[i] - p.centre).norm() <= p.radius;
            });
            if (pin) {
                EXPECT_EQ(after[i], def.vertices[i]) << i;
            }
        }
        EXPECT_LT(after[12 * 13].y(), -2.01F) << "the rest hangs down";
    }
}

/// A cloth of kEnoughCells along a side is off by 1 % of its size at most (builders.h), and the
/// error of springs in place of a sheet grows as their length squared. A quarter of 33 x 33
/// vertices have 16 cells along a side: 1.6 %; twice that as they are uneven.
TEST(CoarseMesh, HangsAsTheWholeOneDoes) {
    constexpr int kSide = 33;
    MeshBodyDef def = square_mesh(kSide);
    def.stiffness = 5000.0F;
    def.pins = {{Vec3(0, 0, 0), 0.01F}, {Vec3(2, 0, 0), 0.01F}};
    std::vector<std::vector<Vec3>> seen;
    for (const int nodes : {0, kSide * kSide / 4}) {
        def.nodes = nodes;
        SoftDef built = built_mesh(def);
        for (SoftNode& node : built.nodes) {  // level at first: it swings down
            node.position = Vec3(node.position.x(), 0.0F, -node.position.y());
        }
        SoftBodies bodies(awake_soft());
        const SoftId id = put(bodies, built);
        run(bodies, 60);
        seen.push_back(drawn(bodies, id));
    }
    const double enough = static_cast<double>(kEnoughCells) / (0.5 * kSide);
    const double bound = 2.0 * 0.01 * enough * enough * 2.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < seen[0].size(); ++i) {
        sum += static_cast<double>((seen[0][i] - seen[1][i]).norm());
    }
    EXPECT_LT(sum / static_cast<double>(seen[0].size()), bound);
}

TEST(MeshBody, GivesTheSameBitsOnAnyNumberOfThreads) {
    std::vector<std::uint64_t> hashes;
    for (const unsigned threads : {1U, 2U, 4U}) {
        compute::WorkerPool pool(threads);
        compute::Team team;
        team.join_pool(pool);
        SoftBodies bodies;
        bodies.work_with(&team);
        MeshBodyDef sheet = square_mesh(45);
        sheet.pins = {{Vec3(0, 0, 0), 0.01F}};
        put(bodies, built_mesh(sheet));
        sheet.nodes = 1000;
        put(bodies, built_mesh(sheet));
        MeshBodyDef ball = ball_mesh(3);
        ball.gas_pressure = 103000.0F;
        ball.nodes = 200;
        put(bodies, built_mesh(ball));
        run(bodies, 6);
        hashes.push_back(hash_of(bodies));
    }
    EXPECT_EQ(hashes[0], hashes[1]);
    EXPECT_EQ(hashes[0], hashes[2]);
}

/// The hull of a coarse mesh is that of its nodes; its drawn vertices move with it.
TEST(CoarseMesh, StepsDownToItsHullAndUpAgain) {
    MeshBodyDef def = ball_mesh(3);
    def.nodes = 80;
    SoftDef built = built_mesh(def);
    for (SoftNode& node : built.nodes) {
        node.velocity = Vec3(1, 0, 0) + Vec3(0, 2, 1).cross(node.position);
    }
    SoftBodies bodies(weightless_soft());
    const SoftId id = put(bodies, built);
    run(bodies, 5);
    const std::vector<Vec3> before = drawn(bodies, id);
    const auto rigid = bodies.rigid_body(id);
    ASSERT_TRUE(rigid.ok()) << rigid.error();
    EXPECT_NEAR(rigid->mass, def.mass, 1e-6F);
    const RigidHull hull = bodies.step_down(id);
    const Quat turn(Eigen::AngleAxisf(0.7F, Vec3::UnitY()));
    bodies.step_up(id, hull.position + Vec3::UnitX(), turn, hull.velocity, hull.angular_velocity);
    const std::vector<Vec3> after = drawn(bodies, id);
    for (std::size_t i = 0; i < before.size(); ++i) {
        const Vec3 there = hull.position + Vec3::UnitX() + turn * (before[i] - hull.position);
        EXPECT_LT((after[i] - there).norm(), 1e-5F) << i;
    }
}

}  // namespace
}  // namespace zoned::physics::soft
