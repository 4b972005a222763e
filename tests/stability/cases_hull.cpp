// Degenerate hulls: nearly flat, slivers, many points in a plane, the same point many times. They
// are refused with a reason, or they match their points and are simulated as others.
#include "server/physics/shapes/convex/hull.h"
#include "tests/stability/world.h"
#include "shared/core/rng.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace zoned::stability {

namespace {

using Points = std::vector<Vec3>;

Points box_points(const Vec3& half) {
    Points points;
    for (int i = 0; i < 8; ++i) {
        points.emplace_back((i & 1) != 0 ? half.x() : -half.x(),
                            (i & 2) != 0 ? half.y() : -half.y(),
                            (i & 4) != 0 ? half.z() : -half.z());
    }
    return points;
}

/// The box's surface, n x n points on each face.
Points grid_points(const Vec3& half, int n) {
    Points points;
    for (int axis = 0; axis < 3; ++axis) {
        for (int i = 0; i < n * n * 2; ++i) {
            Vec3 p;
            p[axis] = i % 2 == 0 ? -1.0F : 1.0F;
            p[(axis + 1) % 3] =
                2.0F * static_cast<float>(i / 2 % n) / static_cast<float>(n - 1) - 1.0F;
            p[(axis + 2) % 3] =
                2.0F * static_cast<float>(i / 2 / n) / static_cast<float>(n - 1) - 1.0F;
            points.push_back(p.cwiseProduct(half));
        }
    }
    return points;
}

/// Each point `times` times, shaken by up to `by` m.
Points repeated(const Points& of, int times, float by, core::Rng& rng) {
    Points points;
    for (int i = 0; i < times; ++i) {
        for (const Vec3& p : of) {
            const float x = rng.range(-by, by);
            const float y = rng.range(-by, by);
            const float z = rng.range(-by, by);
            points.push_back(p + Vec3(x, y, z));
        }
    }
    return points;
}

/// n points on a circle of radius 0.5 at a height, turned by `phase` of a sector.
void add_ring(Points& points, int n, float height, float phase, float radius = 0.5F) {
    for (int i = 0; i < n; ++i) {
        const float turn = 2.0F * std::numbers::pi_v<float> * (static_cast<float>(i) + phase) /
                           static_cast<float>(n);
        points.emplace_back(radius * std::cos(turn), height, radius * std::sin(turn));
    }
}

Points drum(int n, float height, float phase) {
    Points points;
    add_ring(points, n, 0.5F * height, 0.0F);
    add_ring(points, n, -0.5F * height, phase);
    return points;
}

Points moved(Points points, const Vec3& by) {
    for (Vec3& p : points) {
        p += by;
    }
    return points;
}

Points cone(int n) {
    Points points{Vec3(0.0F, 1.0F, 0.0F)};
    add_ring(points, n, 0.0F, 0.0F);
    return points;
}

Points ball(int count, core::Rng& rng) {
    Points points;
    while (static_cast<int>(points.size()) < count) {
        const float x = rng.range(-1.0F, 1.0F);
        const float y = rng.range(-1.0F, 1.0F);
        const float z = rng.range(-1.0F, 1.0F);
        const Vec3 p(x, y, z);
        if (p.norm() > 0.1F && p.norm() < 1.0F) {
            points.emplace_back(0.5F * p.normalized());
        }
    }
    return points;
}

/// The expected result for the points.
enum class Fate : std::uint8_t {
    kEither,
    kRefused,  ///< there is no body in them
    kTaken,    ///< thick enough everywhere
};

struct Cloud {
    std::string name;
    Points points;
    Fate fate = Fate::kEither;
    bool weak = false;  ///< known to be stopped
};

/// Clouds that have no inside, or that no hull can be made of.
std::vector<Cloud> hopeless(core::Rng& rng) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kInf = std::numeric_limits<float>::infinity();
    Points spoilt = box_points(Vec3::Constant(0.5F));
    spoilt[3].y() = kNan;
    Points endless = box_points(Vec3::Constant(0.5F));
    endless[5].x() = kInf;
    Points line;
    for (int i = 0; i < 50; ++i) {
        line.emplace_back(0.1F * static_cast<float>(i), 0.2F * static_cast<float>(i), 0.0F);
    }
    Points plane;
    add_ring(plane, 64, 0.0F, 0.0F);
    return {{"none", {}, Fate::kRefused},
            {"three", {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}, Fate::kRefused},
            {"one-many-times", Points(1000, Vec3(0.3F, 0.2F, 0.1F)), Fate::kRefused},
            {"line", line, Fate::kRefused},
            {"plane", plane, Fate::kRefused},
            {"nan", spoilt, Fate::kRefused},
            {"infinite", endless, Fate::kRefused},
            {"flat 1e-6", box_points(Vec3(0.5F, 5.0e-7F, 0.5F)), Fate::kRefused},
            {"flat shaken", repeated(plane, 8, 1.0e-6F, rng), Fate::kRefused},
            {"needle 1e-5", box_points(Vec3(0.5F, 1.0e-5F, 1.0e-5F)), Fate::kRefused}};
}

/// Thin ones, about the least thickness of a millimetre.
std::vector<Cloud> thin() {
    return {{"flat 0.9 mm", box_points(Vec3(0.5F, 4.5e-4F, 0.5F)), Fate::kRefused},
            {"flat 1.1 mm", box_points(Vec3(0.5F, 5.5e-4F, 0.5F)), Fate::kTaken},
            {"flat 10 mm", box_points(Vec3(0.5F, 5.0e-3F, 0.5F)), Fate::kTaken},
            {"drum 2 mm", drum(32, 2.0e-3F, 0.5F), Fate::kTaken},
            {"needle 2 mm", box_points(Vec3(0.5F, 1.0e-3F, 1.0e-3F)), Fate::kTaken, true},
            {"needle 20 mm", box_points(Vec3(0.5F, 1.0e-2F, 1.0e-2F)), Fate::kTaken},
            {"sliver",
             {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5F, 0.004F, 0), Vec3(0.5F, 0.002F, 0.004F)},
             Fate::kEither,
             true},
            {"wedge",
             {Vec3(0, 0, 0),
              Vec3(1, 0, 0),
              Vec3(0, 0, 1),
              Vec3(1, 0, 1),
              Vec3(1, 0.01F, 0),
              Vec3(1, 0.01F, 1)}}};
}

std::vector<Cloud> crowded(core::Rng& rng) {
    const Vec3 half = Vec3::Constant(0.5F);
    const Points corners = box_points(half);
    return {{"cube corners x 1000", repeated(corners, 1000, 0.0F, rng), Fate::kTaken},
            {"cube shaken 1e-7", repeated(corners, 200, 1.0e-7F, rng), Fate::kTaken},
            {"cube shaken 1e-5", repeated(corners, 200, 1.0e-5F, rng), Fate::kTaken},
            {"cube shaken 1e-3", repeated(corners, 200, 1.0e-3F, rng), Fate::kTaken},
            {"cube grid 50", grid_points(half, 50), Fate::kTaken},
            {"grid 50, shaken", repeated(grid_points(half, 50), 1, 2.0e-6F, rng), Fate::kTaken},
            {"plate grid", grid_points(Vec3(1.0F, 0.02F, 1.0F), 40), Fate::kTaken},
            {"drum of 256", drum(256, 0.5F, 0.0F), Fate::kTaken},
            {"drum askew", drum(31, 0.5F, 1.0e-4F), Fate::kTaken},
            {"cone of 64", cone(64), Fate::kTaken},
            {"cone of 1000", cone(1000), Fate::kTaken},
            {"ball of 4096", ball(4096, rng), Fate::kTaken},
            {"cube at 1 km", moved(corners, Vec3(1000.0F, -1000.0F, 500.0F)), Fate::kTaken},
            {"cube at 100 km", moved(corners, Vec3(1.0e5F, 1.0e5F, -1.0e5F))}};
}

/// How far points stand out of a hull, or its corners out of the box of the points, beyond the
/// hull's own cut-off and a tolerance: 1e-4 m or the resolution of floats there.
double misfit(const Points& points, const physics::BuiltHull& built) {
    const physics::HullView view = built.hull->view();
    double far = 0.0;
    double worst = 0.0;
    const Eigen::Quaterniond turn = built.frame.rotation.cast<double>().normalized();
    Aabb box{points[0], points[0]};
    for (const Vec3& p : points) {
        box = {box.lower.cwiseMin(p), box.upper.cwiseMax(p)};
        far = std::max(far, static_cast<double>(p.cwiseAbs().maxCoeff()));
        const Vec3d local =
            turn.conjugate() * (p.cast<double>() - built.frame.position.cast<double>());
        for (int f = 0; f < view.face_count; ++f) {
            const physics::HullFace& face = view.faces[f];
            worst = std::max(
                worst, face.normal.cast<double>().dot(local) - static_cast<double>(face.offset));
        }
    }
    worst -= static_cast<double>(built.cut_off);
    for (int i = 0; i < built.hull->vertex_count(); ++i) {
        const Vec3d p = built.frame.position.cast<double>() + turn * view.points[i].cast<double>();
        worst = std::max({worst,
                          (box.lower.cast<double>() - p).maxCoeff(),
                          (p - box.upper.cast<double>()).maxCoeff()});
    }
    return worst - 4.0e-7 * far;
}

/// Whether mass and moments are those of a body: no larger than the box of the points, and no
/// moment above the sum of the others (1e-3 for rounding of the flattest).
bool sound(const Points& points, const physics::ConvexHull& hull) {
    Aabb box{points[0], points[0]};
    for (const Vec3& p : points) {
        box = {box.lower.cwiseMin(p), box.upper.cwiseMax(p)};
    }
    const double room = (box.upper - box.lower).cast<double>().prod();
    const auto volume = static_cast<double>(hull.volume());
    const Vec3d m = hull.moments_per_kg().cast<double>();
    return volume > 0.0 && volume <= 1.01 * room && m.minCoeff() > 0.0 &&
           2.0 * m.maxCoeff() <= 1.001 * m.sum();
}

/// The lowest point of a body below the ground, m.
double below_ground(const physics::ConvexHull& hull, const BodyState& s) {
    const physics::HullView view = hull.view();
    const Eigen::Quaterniond turn = s.orientation.cast<double>().normalized();
    double lowest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < hull.vertex_count(); ++i) {
        lowest = std::min(lowest, (turn * view.points[i].cast<double>()).y());
    }
    return -(static_cast<double>(s.position.y()) + lowest);
}

/// Some of them fall onto the ground and each other, in all attitudes. They stay in
/// the room, add no energy, and come to rest on the ground, not below it.
void drop(Run& run, World& world, const std::shared_ptr<const physics::ConvexHull>& hull) {
    const int count = run.pick(3, 6);
    const float apart = 2.0F * hull->radius() + 0.1F;  // no overlap at first
    const float high = apart * static_cast<float>(count) + 1.0F;
    world.room(4.0F, high + 1.0F);
    core::Rng rng(run.seed, 43);
    std::vector<BodyId> ids;
    for (int i = 0; i < count; ++i) {
        BodyDef def = body_of(Shape::hull(hull),
                              1.0F,
                              Vec3(0.3F * static_cast<float>(i % 3) - 0.3F,
                                   1.0F + apart * (static_cast<float>(i) + 0.5F),
                                   0.2F * static_cast<float>(i / 3)));
        const float w = rng.range(-1.0F, 1.0F);
        const float x = rng.range(-1.0F, 1.0F);
        const float y = rng.range(-1.0F, 1.0F);
        const float z = rng.range(-1.0F, 1.0F);
        def.orientation = Quat(w, x, y, z).normalized();
        ids.push_back(world.add(def));
    }
    // A flat hull that lies down has its centre at its half thickness, and the ground gives way.
    world.limits.inside->lower.y() = -2.0F * static_cast<float>(kGive);
    world.limits.energy_share = 1.0e-3;
    // A fall from the top, and an end of a long body that another one comes down on: twice that.
    world.limits.speed_mps = 2.0 * std::sqrt(2.0 * kG * static_cast<double>(high));
    world.run(run.pick(4.0F, 12.0F));
    double sunk = 0.0;
    double speed = 0.0;
    for (const BodyId id : ids) {
        const BodyState s = world.watch(id);
        sunk = std::max(sunk, below_ground(*hull, s));
        speed = std::max(speed, static_cast<double>(s.velocity.norm()));
    }
    world.row.check("sunk_m", sunk, 2.0 * kGive);
    // Round bodies (drums, balls, needles) may still roll, no faster than down their own height.
    world.row.check("speed_at_end_mps", speed, 1.0);
}

void one_cloud(Run& run, const Cloud& cloud) {
    World world(run, "hull", cloud.name);
    const auto built = physics::build_hull(cloud.points);
    const bool fault = run.fault == Fault::kHull;
    if (!built) {
        const bool reason = !built.error().empty() && !fault;
        world.row.check("without_reason", reason ? 0.0 : 1.0, 0.0);
        world.row.check("wrongly_refused", cloud.fate == Fate::kTaken ? 1.0 : 0.0, 0.0);
        world.row.parameter += ": " + built.error();
        world.finish();
        return;
    }
    if (cloud.weak) {
        world.row.know(
            "a blow beside the axis of a needle a few millimetres thick gives it a spin that the "
            "engine does not follow: it gains energy or is stopped",
            {{"energy_share", 0.6}, {"quarantined", 1.0}});
    }
    world.row.check("wrongly_taken", cloud.fate == Fate::kRefused ? 1.0 : 0.0, 0.0);
    physics::BuiltHull seen = *built;
    seen.frame.position.x() += fault ? 1.0F : 0.0F;
    world.row.check("misfit_m", misfit(cloud.points, seen), 1.0e-4);
    world.row.check("unsound", sound(cloud.points, *built->hull) && !fault ? 0.0 : 1.0, 0.0);
    drop(run, world, built->hull);
    world.finish();
}

void hulls(Run& run) {
    core::Rng rng(run.seed, 42);
    for (const auto& list : {hopeless(rng), thin(), crowded(rng)}) {
        for (const Cloud& cloud : list) {
            one_cloud(run, cloud);
        }
    }
}

}  // namespace

std::vector<Case> hull_cases() {
    return {{"hull", "degenerate hulls: refused with a reason, or sound and simulated", hulls}};
}

}  // namespace zoned::stability
