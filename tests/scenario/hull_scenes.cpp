#include "tests/scenario/hull_scenes.h"

#include "tests/scenario/scene_parts.h"
#include "tests/scenario/solid_geometry.h"
#include "shared/core/rng.h"

#include <array>
#include <cmath>
#include <numbers>

namespace zoned::scenario {

namespace {

constexpr double kSurfaceFriction = 0.5;

double chance(core::Rng& rng) {
    return static_cast<double>(rng.range(-1.0F, 1.0F));
}

Body surface(Solid solid) {
    Body body;
    body.solid = std::move(solid);
    body.mass = 0.0;
    body.friction = kSurfaceFriction;
    return body;
}

/// Random points on a ball of this radius.
BuiltSolid random_hull(core::Rng& rng, int count, double radius) {
    std::vector<Vec3d> points;
    while (static_cast<int>(points.size()) < count) {
        const double x = chance(rng);
        const double y = chance(rng);
        const Vec3d p(x, y, chance(rng));
        if (p.norm() < 1.0 && p.norm() > 0.1) {
            points.push_back(radius * p.normalized());
        }
    }
    return solid_hull(points);
}

/// A cone about y, open at both ends, whose front is inside.
Solid cone(double lower_radius, double upper_radius, double lower, double upper) {
    constexpr int kSides = 64;
    constexpr int kRings = 10;
    std::vector<Vec3d> points;
    for (int ring = 0; ring <= kRings; ++ring) {
        const double t = static_cast<double>(ring) / kRings;
        const double r = lower_radius + t * (upper_radius - lower_radius);
        for (int i = 0; i < kSides; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / kSides;
            points.emplace_back(
                r * std::cos(angle), lower + t * (upper - lower), r * std::sin(angle));
        }
    }
    std::vector<std::uint32_t> indices;
    for (std::uint32_t ring = 0; ring < kRings; ++ring) {
        for (std::uint32_t i = 0; i < kSides; ++i) {
            const std::uint32_t a = ring * kSides + i;
            const std::uint32_t b = ring * kSides + (i + 1) % kSides;
            for (const std::uint32_t corner : {a, b, a + kSides, b, b + kSides, a + kSides}) {
                indices.push_back(corner);
            }
        }
    }
    return solid_surface(std::move(points), indices);
}

double plate(double x, double z) {
    return 0.1 * std::sin(0.5 * x) * std::sin(0.4 * z);
}

double hillside(double x, double z) {
    return -0.4 * z + 0.3 * std::sin(0.5 * x) * std::sin(0.4 * z);
}

double downs(double x, double z) {
    return 1.5 * std::sin(0.1 * x) * std::cos(0.08 * z) + 0.2 * std::sin(0.8 * x + 0.5 * z);
}

/// A hexagonal prism along y.
BuiltSolid prism(double radius, double half_length) {
    std::vector<Vec3d> points;
    for (int i = 0; i < 6; ++i) {
        const double angle = std::numbers::pi / 3.0 * i;
        for (const double end : {-1.0, 1.0}) {
            points.emplace_back(
                radius * std::cos(angle), end * half_length, radius * std::sin(angle));
        }
    }
    return solid_hull(points);
}

/// A trunk of two prisms with twenty branches around it.
BuiltSolid tree() {
    const BuiltSolid trunk = prism(0.2, 0.75);
    const BuiltSolid branch = prism(0.06, 0.45);
    std::vector<SolidPart> parts;
    const auto add = [&parts](const BuiltSolid& part, const Vec3d& middle, const Quatd& turn) {
        // The solid's own axes need not be those of the points.
        parts.push_back(
            {part.solid, {middle + turn * part.pose.position, turn * part.pose.orientation}});
    };
    for (const double y : {-0.75, 0.75}) {
        add(trunk, {0.0, y, 0.0}, Quatd::Identity());
    }
    for (int i = 0; i < 20; ++i) {
        const double angle = 2.4 * i;
        const Quatd turn = Quatd(Eigen::AngleAxisd(angle, Vec3d::UnitY())) *
                           Quatd(Eigen::AngleAxisd(-1.2, Vec3d::UnitZ()));
        const Vec3d foot(0.0, -1.0 + 0.12 * i, 0.0);
        add(branch, foot + turn * Vec3d(0.0, 0.6, 0.0), turn);
    }
    return solid_compound(parts);
}

Body placed(const BuiltSolid& built, double mass, const Vec3d& position, const Quatd& turn) {
    Body body = at(built.solid, mass, position, kSurfaceFriction);
    body.pose.orientation = turn * built.pose.orientation;
    return body;
}

}  // namespace

Description hull_funnel(int count) {
    constexpr int kSide = 10;
    constexpr double kApart = 1.0;
    Description d;
    d.bodies.push_back(surface(solid_terrain(60, 60, 1.0, -30.0, -30.0, plate)));
    d.bodies.push_back(surface(cone(2.5, 12.5, 4.0, 14.0)));
    core::Rng rng(17);
    for (int i = 0; i < count; ++i) {
        const BuiltSolid hull = random_hull(rng, 24, 0.4);
        const Vec3d place((i % kSide - 0.5 * (kSide - 1)) * kApart + 0.1 * chance(rng),
                          10.0 + i / (kSide * kSide) * kApart,
                          (i / kSide % kSide - 0.5 * (kSide - 1)) * kApart + 0.1 * chance(rng));
        d.bodies.push_back(placed(hull, hull.solid.volume(), place, Quatd::Identity()));
    }
    return d;
}

Description rolling_trees(int count) {
    constexpr int kSide = 10;
    Description d;
    d.bodies.push_back(surface(solid_terrain(150, 200, 1.0, -75.0, -50.0, hillside)));
    const BuiltSolid built = tree();
    const Quatd lying(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3d::UnitZ()));
    for (int i = 0; i < count; ++i) {
        const Vec3d place((i % kSide - 0.5 * (kSide - 1)) * 6.0, 0.0, i / kSide * 5.0);
        const double y = hillside(place.x(), place.z()) + 2.0;
        d.bodies.push_back(placed(built, 100.0, place + Vec3d(0.0, y, 0.0), lying));
    }
    return d;
}

Description mixed_on_mesh(int side) {
    constexpr double kApart = 2.0;
    Description d;
    d.bodies.push_back(surface(solid_terrain(100, 100, 3.0, -150.0, -150.0, downs)));
    const std::array<Vec3d, 5> corners{Vec3d(0.5, -0.3, 0.5),
                                       Vec3d(-0.5, -0.3, 0.5),
                                       Vec3d(-0.5, -0.3, -0.5),
                                       Vec3d(0.5, -0.3, -0.5),
                                       Vec3d(0.0, 0.7, 0.0)};
    const BuiltSolid pyramid = solid_hull(corners);
    const std::array<BuiltSolid, 4> kinds{BuiltSolid{Solid::box({1.0, 1.0, 1.0}), {}},
                                          BuiltSolid{Solid::sphere(0.5), {}},
                                          BuiltSolid{Solid::capsule(0.35, 0.35), {}},
                                          pyramid};
    for (int y = 0; y < 4; ++y) {
        for (int z = 0; z < side; ++z) {
            for (int x = 0; x < side; ++x) {
                const Vec3d place((x - 0.5 * (side - 1)) * kApart + 0.05 * y,
                                  4.0 + 1.5 * y,
                                  (z - 0.5 * (side - 1)) * kApart + 0.03 * y);
                const auto kind = static_cast<std::size_t>((x + y + z) % 4);
                d.bodies.push_back(
                    placed(kinds[kind], kinds[kind].solid.volume(), place, Quatd::Identity()));
            }
        }
    }
    return d;
}

Description static_field(int side) {
    constexpr double kTile = 10.0;
    constexpr int kBalls = 100;
    Description d;
    d.steps = 300;
    d.sleeping = true;
    const Solid tile = Solid::box({kTile, 0.5, kTile});
    for (int z = 0; z < side; ++z) {
        for (int x = 0; x < side; ++x) {
            d.bodies.push_back(
                at(tile,
                   0.0,
                   {(x - 0.5 * (side - 1)) * kTile, -0.25, (z - 0.5 * (side - 1)) * kTile},
                   kSurfaceFriction));
        }
    }
    for (int i = 0; i < kBalls; ++i) {
        const Vec3d place((i % 10 - 4.5) * 7.0, 2.0, (i / 10 - 4.5) * 7.0);
        d.bodies.push_back(at(Solid::sphere(0.5), 1.0, place, kSurfaceFriction));
    }
    Body& last = d.bodies.back();
    last.pose.position.y() = 0.5;
    last.velocity = Vec3d(2.0, 0.0, 0.0);
    last.spin = Vec3d(0.0, 0.0, -4.0);
    return d;
}

}  // namespace zoned::scenario
