#include "tests/scenario/solid_geometry.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

namespace zoned::scenario {

namespace {

using Mat3d = Eigen::Matrix3d;

/// Volume, centre and second moments of a body of density one.
struct Mass {
    double volume = 0.0;
    Vec3d first = Vec3d::Zero();   ///< integral of x
    Mat3d second = Mat3d::Zero();  ///< integral of x x^T

    /// A tetrahedron at the origin (Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia
    /// tensor", Journal of Mathematics and Statistics 1, 2005).
    void add(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
        const double v = a.dot(b.cross(c)) / 6.0;
        const Vec3d sum = a + b + c;
        volume += v;
        first += 0.25 * v * sum;
        second +=
            v / 20.0 *
            (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
    }

    void add(const SolidPart& part) {
        const double v = part.solid.volume();
        const Vec3d moments = v * part.solid.inertia_per_mass();
        // Moments about an axis are sums of two second moments.
        const Vec3d seconds = Vec3d::Constant(0.5 * moments.sum()) - moments;
        const Mat3d r = part.pose.orientation.toRotationMatrix();
        const Vec3d& x = part.pose.position;
        volume += v;
        first += v * x;
        second += r * seconds.asDiagonal() * r.transpose() + v * x * x.transpose();
    }
};

/// Sets volume and moments of `out`; gives the frame of its principal axes.
Pose settle(const Mass& mass, SolidGeometry& out) {
    if (!(mass.volume > 0.0)) {
        throw std::invalid_argument("a solid without volume");
    }
    Pose pose;
    pose.position = mass.first / mass.volume;
    const Mat3d central = mass.second / mass.volume - pose.position * pose.position.transpose();
    const Eigen::SelfAdjointEigenSolver<Mat3d> axes(central);
    Mat3d turn = axes.eigenvectors();
    if (turn.determinant() < 0.0) {
        turn.col(2) = -turn.col(2);
    }
    pose.orientation = Quatd(turn);
    const Vec3d& q = axes.eigenvalues();
    out.volume = mass.volume;
    out.inertia_per_mass = Vec3d(q.y() + q.z(), q.x() + q.z(), q.x() + q.y());
    return pose;
}

/// Corners on the plane in order around its normal.
std::vector<std::uint32_t> ring_of(std::span<const Vec3d> points,
                                   std::vector<std::uint32_t> on,
                                   const Vec3d& normal) {
    Vec3d middle = Vec3d::Zero();
    for (const std::uint32_t i : on) {
        middle += points[i] / static_cast<double>(on.size());
    }
    const Vec3d u = (points[on.front()] - middle).normalized();
    const Vec3d v = normal.cross(u);
    const auto angle = [&](std::uint32_t i) {
        const Vec3d d = points[i] - middle;
        return std::atan2(d.dot(v), d.dot(u));
    };
    std::sort(on.begin(), on.end(), [&](std::uint32_t a, std::uint32_t b) {
        return angle(a) < angle(b);
    });
    return on;
}

/// All planes through three points that have every point on one side.
std::vector<SolidFace> faces_of(std::span<const Vec3d> points) {
    std::vector<SolidFace> faces;
    const auto count = static_cast<std::uint32_t>(points.size());
    double size = 0.0;
    for (const Vec3d& p : points) {
        size = std::max(size, (p - points.front()).norm());
    }
    const double flat = 1e-9 * size;
    const auto look = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
        Vec3d normal = (points[j] - points[i]).cross(points[k] - points[i]);
        if (normal.norm() < flat * size) {
            return;
        }
        normal.normalize();
        double least = 0.0;
        double most = 0.0;
        for (const Vec3d& p : points) {
            const double height = normal.dot(p - points[i]);
            least = std::min(least, height);
            most = std::max(most, height);
        }
        if (least < -flat && most > flat) {
            return;
        }
        if (most > flat) {
            normal = -normal;
        }
        SolidFace face;
        face.normal = normal;
        face.offset = normal.dot(points[i]);
        for (const SolidFace& known : faces) {
            if (known.normal.dot(normal) > 1.0 - 1e-12 &&
                std::abs(known.offset - face.offset) < flat) {
                return;
            }
        }
        std::vector<std::uint32_t> on;
        for (std::uint32_t p = 0; p < count; ++p) {
            if (std::abs(normal.dot(points[p]) - face.offset) <= flat) {
                on.push_back(p);
            }
        }
        face.ring = ring_of(points, std::move(on), normal);
        faces.push_back(std::move(face));
    };
    for (std::uint32_t i = 0; i < count; ++i) {
        for (std::uint32_t j = i + 1; j < count; ++j) {
            for (std::uint32_t k = j + 1; k < count; ++k) {
                look(i, j, k);
            }
        }
    }
    return faces;
}

void find_edges(SolidGeometry& out) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> open;
    for (std::uint32_t f = 0; f < out.faces.size(); ++f) {
        const auto& ring = out.faces[f].ring;
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const std::uint32_t a = ring[i];
            const std::uint32_t b = ring[(i + 1) % ring.size()];
            const auto other = open.find({b, a});
            if (other == open.end()) {
                open[{a, b}] = f;
            } else {
                out.edges.push_back({{b, a}, {other->second, f}});
            }
        }
    }
}

void find_radius(SolidGeometry& out) {
    for (const Vec3d& p : out.points) {
        out.radius = std::max(out.radius, p.norm());
    }
}

Solid solid_of(Form form, SolidGeometry geometry) {
    Solid solid;
    solid.form = form;
    solid.radius = geometry.radius;
    solid.geometry = std::make_shared<const SolidGeometry>(std::move(geometry));
    return solid;
}

/// Lists the triangles of a surface by the cells that their boxes touch.
void sort_into_cells(SolidGeometry& out) {
    const auto cells_of = [&out](const SolidFace& face, auto&& visit) {
        Eigen::Vector2d lower = Eigen::Vector2d::Constant(INFINITY);
        Eigen::Vector2d upper = -lower;
        for (const std::uint32_t i : face.ring) {
            const Eigen::Vector2d p(out.points[i].x(), out.points[i].z());
            lower = lower.cwiseMin(p);
            upper = upper.cwiseMax(p);
        }
        for (int x = static_cast<int>(std::floor(lower.x() / out.cell));
             x <= static_cast<int>(std::floor(upper.x() / out.cell));
             ++x) {
            for (int z = static_cast<int>(std::floor(lower.y() / out.cell));
                 z <= static_cast<int>(std::floor(upper.y() / out.cell));
                 ++z) {
                visit(x, z);
            }
        }
    };
    std::array<int, 2> lower{INT32_MAX, INT32_MAX};
    std::array<int, 2> upper{INT32_MIN, INT32_MIN};
    for (const SolidFace& face : out.faces) {
        cells_of(face, [&](int x, int z) {
            lower = {std::min(lower[0], x), std::min(lower[1], z)};
            upper = {std::max(upper[0], x), std::max(upper[1], z)};
        });
    }
    out.cell_lower = lower;
    out.cell_counts = {upper[0] - lower[0] + 1, upper[1] - lower[1] + 1};
    const auto index = [&](int x, int z) {
        return static_cast<std::size_t>(z - lower[1]) *
                   static_cast<std::size_t>(out.cell_counts[0]) +
               static_cast<std::size_t>(x - lower[0]);
    };
    std::vector<std::vector<std::uint32_t>> lists(static_cast<std::size_t>(out.cell_counts[0]) *
                                                  static_cast<std::size_t>(out.cell_counts[1]));
    for (std::uint32_t f = 0; f < out.faces.size(); ++f) {
        cells_of(out.faces[f], [&](int x, int z) { lists[index(x, z)].push_back(f); });
    }
    for (const auto& list : lists) {
        out.cell_starts.push_back(static_cast<std::uint32_t>(out.cell_triangles.size()));
        out.cell_triangles.insert(out.cell_triangles.end(), list.begin(), list.end());
    }
    out.cell_starts.push_back(static_cast<std::uint32_t>(out.cell_triangles.size()));
}

}  // namespace

BuiltSolid solid_hull(std::span<const Vec3d> points) {
    SolidGeometry out;
    const std::vector<SolidFace> faces = faces_of(points);
    Mass mass;
    for (const SolidFace& face : faces) {
        for (std::size_t i = 2; i < face.ring.size(); ++i) {
            mass.add(points[face.ring[0]], points[face.ring[i - 1]], points[face.ring[i]]);
        }
    }
    const Pose pose = settle(mass, out);
    for (const Vec3d& p : points) {
        out.points.push_back(pose.orientation.conjugate() * (p - pose.position));
    }
    out.faces = faces;
    for (SolidFace& face : out.faces) {
        face.normal = pose.orientation.conjugate() * face.normal;
        face.offset = face.normal.dot(out.points[face.ring[0]]);
    }
    find_edges(out);
    find_radius(out);
    return {solid_of(Form::kHull, std::move(out)), pose};
}

BuiltSolid solid_compound(std::span<const SolidPart> parts) {
    SolidGeometry out;
    Mass mass;
    for (const SolidPart& part : parts) {
        mass.add(part);
    }
    const Pose pose = settle(mass, out);
    const Quatd back = pose.orientation.conjugate();
    for (const SolidPart& part : parts) {
        out.parts.push_back({part.solid,
                             {back * (part.pose.position - pose.position),
                              (back * part.pose.orientation).normalized()}});
        double reach = part.solid.radius;
        if (part.solid.form == Form::kBox) {
            reach = part.solid.half_extents.norm();
        } else if (part.solid.form == Form::kCapsule) {
            reach += part.solid.half_segment;
        }
        out.radius = std::max(out.radius, out.parts.back().pose.position.norm() + reach);
    }
    return {solid_of(Form::kCompound, std::move(out)), pose};
}

Solid solid_surface(std::vector<Vec3d> points, std::span<const std::uint32_t> indices) {
    SolidGeometry out;
    out.points = std::move(points);
    double longest = 0.0;
    for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        SolidFace face;
        face.ring = {indices[i], indices[i + 1], indices[i + 2]};
        const Vec3d& a = out.points[face.ring[0]];
        const Vec3d ab = out.points[face.ring[1]] - a;
        const Vec3d ac = out.points[face.ring[2]] - a;
        face.normal = ab.cross(ac).normalized();
        face.offset = face.normal.dot(a);
        longest = std::max({longest, ab.norm(), ac.norm()});
        out.faces.push_back(std::move(face));
    }
    out.cell = longest;
    find_radius(out);
    sort_into_cells(out);
    return solid_of(Form::kMesh, std::move(out));
}

Solid solid_terrain(int cells_x,
                    int cells_z,
                    double cell,
                    double lower_x,
                    double lower_z,
                    double (*height)(double x, double z)) {
    std::vector<Vec3d> points;
    for (int k = 0; k <= cells_z; ++k) {
        for (int i = 0; i <= cells_x; ++i) {
            const double x = lower_x + i * cell;
            const double z = lower_z + k * cell;
            points.emplace_back(x, height(x, z), z);
        }
    }
    std::vector<std::uint32_t> indices;
    const auto row = static_cast<std::uint32_t>(cells_x + 1);
    for (std::uint32_t k = 0; k < static_cast<std::uint32_t>(cells_z); ++k) {
        for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(cells_x); ++i) {
            const std::uint32_t a = k * row + i;
            for (const std::uint32_t corner : {a, a + row, a + 1, a + 1, a + row, a + row + 1}) {
                indices.push_back(corner);
            }
        }
    }
    return solid_surface(std::move(points), indices);
}

SolidGeometry polyhedron_of(const Solid& solid) {
    if (solid.form == Form::kHull) {
        return *solid.geometry;
    }
    if (solid.form != Form::kBox) {
        throw std::logic_error("a solid without flat faces");
    }
    std::vector<Vec3d> corners;
    for (int i = 0; i < 8; ++i) {
        corners.push_back(
            Vec3d((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 4) != 0 ? 1.0 : -1.0)
                .cwiseProduct(solid.half_extents));
    }
    SolidGeometry out;
    out.points = corners;
    out.faces = faces_of(corners);
    find_edges(out);
    find_radius(out);
    return out;
}

}  // namespace zoned::scenario
