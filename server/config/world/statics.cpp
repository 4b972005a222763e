#include "server/config/world/statics.h"

#include "server/config/text/config_numbers.h"
#include "proto/config/config.pb.h"
#include "shared/core/elementary/elementary.h"

#include <cmath>
#include <cstdio>
#include <numbers>

namespace zoned::config {

namespace {

using motion::StaticBox;

/// A ramp ends this far before the next edge of its tread, so that there is ground to step on, m.
constexpr double kRampFoot_m = 0.3;
constexpr double kRampThickness_m = 0.4;

using Quatd = Eigen::Quaterniond;

StaticBox make_box(const Vec3d& centre,
                   const Vec3d& size,
                   const Quatd& orientation,
                   double friction,
                   double restitution) {
    StaticBox box;
    box.centre = centre.cast<float>();
    box.half_extents = (0.5 * size).cast<float>();
    box.orientation = narrow(orientation);
    box.friction = static_cast<float>(friction);
    box.restitution = static_cast<float>(restitution);
    return box;
}

/// A hill's boxes. Terrace i (from 0) is a slab from i h to (i + 1) h above the ground; its ramp
/// rises from the tread below (or the ground) to its top.
void add_hill(const proto::config::Hill& hill, double ground, std::vector<StaticBox>& out) {
    const double h = hill.terrace_height_m();
    const double slope = hill.ramp_slope_deg() * kRadians;
    const double run = h / elementary::tan(slope);
    const Quatd turned = turn(hill.yaw_deg(), Vec3d::UnitY());
    const Vec3d centre(hill.x_m(), ground, hill.z_m());
    for (std::uint32_t i = 0; i < hill.terraces(); ++i) {
        const double size =
            hill.top_size_m() + 2.0 * hill.terrace_depth_m() * (hill.terraces() - 1 - i);
        const double top = h * (i + 1);
        out.push_back(make_box(centre + Vec3d(0.0, top - 0.5 * h, 0.0),
                               Vec3d(size, h, size),
                               turned,
                               hill.friction(),
                               0.0));
        for (std::uint32_t side = 0; side < hill.ramp_sides(); ++side) {
            // Built for the side +x, then turned: +x, -x, +z, -z.
            static constexpr double kSides[] = {0.0, 180.0, -90.0, 90.0};
            const Quatd facing = turned * turn(kSides[side], Vec3d::UnitY());
            // The top face runs from (edge, top) down to (edge + run, top - h); the box hangs below
            // it by half its thickness along the face's normal (sin, cos).
            const double length = run / elementary::cos(slope);
            const Vec3d middle(
                0.5 * size + 0.5 * run - 0.5 * kRampThickness_m * elementary::sin(slope),
                top - 0.5 * h - 0.5 * kRampThickness_m * elementary::cos(slope),
                0.0);
            out.push_back(make_box(centre + facing * middle,
                                   Vec3d(length, kRampThickness_m, hill.ramp_width_m()),
                                   facing * turn(-hill.ramp_slope_deg(), Vec3d::UnitZ()),
                                   hill.friction(),
                                   0.0));
        }
    }
}

void check_hill(const proto::config::Hill& hill,
                const std::string& path,
                Diagnostics& diagnostics) {
    const double run = hill.terrace_height_m() / elementary::tan(hill.ramp_slope_deg() * kRadians);
    if (hill.terraces() > 1 && run + kRampFoot_m > hill.terrace_depth_m()) {
        char text[200];
        std::snprintf(text,
                      sizeof(text),
                      "a ramp of %g deg needs %.2f m to rise %g m and does not fit on a tread of "
                      "%g m; make terrace_depth_m at least %.2f",
                      hill.ramp_slope_deg(),
                      run + kRampFoot_m,
                      hill.terrace_height_m(),
                      hill.terrace_depth_m(),
                      run + kRampFoot_m);
        diagnostics.add(path + ".terrace_depth_m", text);
    }
    if (hill.ramp_width_m() > hill.top_size_m()) {
        diagnostics.add(path + ".ramp_width_m", "a ramp cannot be wider than the top terrace");
    }
}

/// Boxes along the polyline, each at most segment_m long, with gap_m between one and the next.
void add_wall(const proto::config::Wall& wall, double ground, std::vector<StaticBox>& out) {
    for (int p = 0; p + 1 < wall.point_size(); ++p) {
        const Vec3d from(wall.point(p).x_m(), ground, wall.point(p).z_m());
        const Vec3d to(wall.point(p + 1).x_m(), ground, wall.point(p + 1).z_m());
        const double length = (to - from).norm();
        if (!(length > 1e-6)) {
            continue;
        }
        const Vec3d along = (to - from) / length;
        const auto pieces = static_cast<int>(
            std::max(1.0, std::ceil((length + wall.gap_m()) / (wall.segment_m() + wall.gap_m()))));
        const double piece = (length - wall.gap_m() * (pieces - 1)) / pieces;
        // The local x axis points along the wall: a turn about +y takes x to (cos, 0, -sin).
        const Quatd facing = turn_rad(elementary::atan2(-along.z(), along.x()), Vec3d::UnitY());
        for (int i = 0; i < pieces && piece > 0.01; ++i) {
            const double middle = i * (piece + wall.gap_m()) + 0.5 * piece;
            out.push_back(make_box(from + along * middle + Vec3d(0.0, 0.5 * wall.height_m(), 0.0),
                                   Vec3d(piece, wall.height_m(), wall.thickness_m()),
                                   facing,
                                   wall.friction(),
                                   wall.restitution()));
        }
    }
}

void check_wall(const proto::config::Wall& wall,
                const std::string& path,
                Diagnostics& diagnostics) {
    for (int p = 0; p < wall.point_size(); ++p) {
        const auto& point = wall.point(p);
        const std::string here = join_path(path, "point", p);
        if (!point.has_x_m() || !point.has_z_m()) {
            diagnostics.add(here, "a point needs x_m and z_m");
        } else if (p > 0 && point.x_m() == wall.point(p - 1).x_m() &&
                   point.z_m() == wall.point(p - 1).z_m()) {
            diagnostics.add(here, "is the same point as the one before");
        }
    }
}

}  // namespace

StaticBox static_box(const proto::config::Box& box) {
    return make_box(Vec3d(box.x_m(), box.y_m(), box.z_m()),
                    Vec3d(box.size().x_m(), box.size().y_m(), box.size().z_m()),
                    turn(box.yaw_deg(), box.pitch_deg(), box.roll_deg()),
                    box.friction(),
                    box.restitution());
}

void check_inside(const proto::config::World& world,
                  const StaticBox& box,
                  const std::string& path,
                  Diagnostics& diagnostics) {
    const Vec3 half = box.orientation.toRotationMatrix().cwiseAbs() * box.half_extents;
    const Vec3d lower = (box.centre - half).cast<double>();
    const Vec3d upper = (box.centre + half).cast<double>();
    if (upper.x() < world.min_x_m() || lower.x() > world.max_x_m() || upper.z() < world.min_z_m() ||
        lower.z() > world.max_z_m()) {
        diagnostics.add(path, "lies outside the world");
    }
}

std::vector<StaticBox> expand_statics(const proto::config::Config& config,
                                      Diagnostics& diagnostics) {
    std::vector<StaticBox> out;
    const double ground = config.world().ground_height_m();
    const auto& statics = config.statics();
    const auto check_from = [&](std::size_t first, const std::string& path) {
        for (std::size_t b = first; b < out.size(); ++b) {
            const std::size_t before = diagnostics.size();
            check_inside(config.world(), out[b], path, diagnostics);
            if (diagnostics.size() != before) {
                return;
            }
        }
    };
    for (int i = 0; i < statics.box_size(); ++i) {
        out.push_back(static_box(statics.box(i)));
        check_from(out.size() - 1, join_path("statics", "box", i));
    }
    for (int i = 0; i < statics.hill_size(); ++i) {
        const std::string path = join_path("statics", "hill", i);
        const std::size_t first = out.size();
        check_hill(statics.hill(i), path, diagnostics);
        add_hill(statics.hill(i), ground, out);
        check_from(first, path);
    }
    for (int i = 0; i < statics.wall_size(); ++i) {
        const std::string path = join_path("statics", "wall", i);
        const std::size_t first = out.size();
        check_wall(statics.wall(i), path, diagnostics);
        add_wall(statics.wall(i), ground, out);
        check_from(first, path);
    }
    return out;
}

}  // namespace zoned::config
