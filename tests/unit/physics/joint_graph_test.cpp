// Random graphs of joints: trees, loops, redundant joints, all kinds, uneven masses.
#include "server/physics/joints/joint_rows.h"
#include "tests/unit/physics/joint_scene.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace zoned::physics {
namespace {

Vec3 any_vector(core::Rng& rng, float size) {
    const float x = rng.range(-size, size);
    const float y = rng.range(-size, size);
    const float z = rng.range(-size, size);
    return {x, y, z};
}

/// A graph of joints with what is needed to look at it from outside.
class Graph {
  public:
    Graph(std::uint64_t seed, const Vec3& gravity) : scene(gravity), rng_(seed) {}

    void add_bodies(std::uint32_t count, float heaviest) {
        for (std::uint32_t i = 0; i < count; ++i) {
            BodyDef def;
            def.shape = Shape::box(Vec3::Constant(0.2F) + 0.5F * any_vector(rng_, 0.3F).cwiseAbs());
            def.mass = std::pow(heaviest, rng_.unit());
            def.position = any_vector(rng_, 2.0F);
            def.orientation = Quat(rng_.range(-1, 1), rng_.range(-1, 1), 0.5F, 0.2F).normalized();
            def.filter.mask = 0;
            ids.push_back(scene.add(def));
        }
    }

    void join(BodyId a, BodyId b) {
        constexpr std::array kKinds{JointKind::kBall,
                                    JointKind::kHinge,
                                    JointKind::kSlider,
                                    JointKind::kFixed,
                                    JointKind::kDistance,
                                    JointKind::kSpring};
        JointDef def;
        def.kind = kKinds[rng_.below(kKinds.size())];
        def.a = a;
        def.b = b;
        const Vec3 at_b = scene.scene.state(b).position;
        const Vec3 at_a =
            a == BodyId() ? Vec3(at_b + any_vector(rng_, 1.0F)) : scene.scene.state(a).position;
        def.anchor = 0.5F * (at_a + at_b) + any_vector(rng_, 0.2F);
        def.anchor_b = at_b + any_vector(rng_, 0.2F);
        def.axis = any_vector(rng_, 1.0F);
        if (rng_.below(2) == 0) {
            def.limited = true;
            def.lower = rng_.range(-0.5F, 0.0F);
            def.upper = rng_.range(0.0F, 0.5F);
        }
        if (rng_.below(4) == 0) {  // a brake
            def.motor = true;
            def.motor_max = rng_.range(0.0F, 20.0F);
        }
        scene.join(def);
        joints_.push_back(make_joint(def, pose(a), pose(b)));
    }

    /// A tree that hangs from the world, and `extra` joints that close loops or double others.
    void join_all(std::uint32_t extra) {
        join(BodyId(), ids[0]);
        for (std::size_t i = 1; i < ids.size(); ++i) {
            join(ids[rng_.below(static_cast<std::uint32_t>(i))], ids[i]);
        }
        for (std::uint32_t k = 0; k < extra && ids.size() > 1; ++k) {
            const auto count = static_cast<std::uint32_t>(ids.size());
            const std::uint32_t a = rng_.below(count);
            const std::uint32_t b = (a + 1 + rng_.below(count - 1)) % count;
            join(ids[a], ids[b]);
        }
    }

    [[nodiscard]] JointPose pose(BodyId id) const {
        if (id == BodyId()) {
            return {};
        }
        const BodyState s = scene.scene.state(id);
        return {s.position, s.orientation.toRotationMatrix()};
    }

    /// Largest error of a row that must hold, m or rad; limits where they are exceeded.
    [[nodiscard]] float worst() const {
        float most = 0.0F;
        for (const Joint& joint : joints_) {
            JointRows rows;
            write_rows(joint, pose(joint.def.a), pose(joint.def.b), rows);
            for (std::size_t i = 0; i < rows.count; ++i) {
                const float error = rows.rows[i].error;
                if (rows.rows[i].kind == RowKind::kHard) {
                    most = std::max(most, std::abs(error));
                } else if (rows.rows[i].kind == RowKind::kLimit) {
                    most = std::max(most, -error);
                }
            }
        }
        return most;
    }

    JointScene scene;
    std::vector<BodyId> ids;

  private:
    core::Rng rng_;
    std::vector<Joint> joints_;
};

void hangs_together(std::uint64_t seed, float heaviest, std::uint32_t extra) {
    Graph g(seed, Vec3(0, -kGravity, 0));
    g.add_bodies(2 + static_cast<std::uint32_t>(seed % 15), heaviest);
    g.join_all(extra);
    const double before = g.scene.sums().energy;
    double weight = 0.0;
    for (const auto& body : g.scene.bodies) {
        weight += static_cast<double>(body.def.mass) * 9.81;
    }
    for (int i = 0; i < 300; ++i) {
        ASSERT_EQ(g.scene.scene.step(kFrame).quarantined, 0U) << seed << " " << i;
        const auto sums = g.scene.sums();
        ASSERT_TRUE(sums.finite) << seed << " " << i;
        // Nothing puts energy in. What the solver adds is measured by the height to which it could
        // raise all of the graph.
        ASSERT_LT((sums.energy - before) / weight, 0.05) << seed << " " << i;
        ASSERT_LT(g.worst(), 0.05F) << seed << " " << i;
    }
}

TEST(JointGraph, TreesHangTogether) {
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        hangs_together(seed, 10.0F, 0);
    }
}

TEST(JointGraph, LoopsAndRedundantJointsHangTogether) {
    for (std::uint64_t seed = 100; seed < 140; ++seed) {
        hangs_together(seed, 10.0F, 1 + seed % 5);
    }
}

TEST(JointGraph, HangsTogetherWhereMassesDifferByAThousand) {
    for (std::uint64_t seed = 200; seed < 220; ++seed) {
        hangs_together(seed, 1000.0F, seed % 4);
    }
}

}  // namespace
}  // namespace zoned::physics
