#include "server/physics/shapes/convex/quickhull.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics {

namespace {

__extension__ typedef __int128 Wide;  // NOLINT(modernize-use-using): `using` takes no __extension__

using GridPoint = std::array<std::int64_t, 3>;

constexpr double kGridSteps = 1 << 30;
constexpr int kNone = -1;

GridPoint difference(const GridPoint& a, const GridPoint& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Edges are below 2^31, so the components stay below 2^63.
GridPoint cross(const GridPoint& a, const GridPoint& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Wide dot(const GridPoint& a, const GridPoint& b) {
    return static_cast<Wide>(a[0]) * b[0] + static_cast<Wide>(a[1]) * b[1] +
           static_cast<Wide>(a[2]) * b[2];
}

double length(const GridPoint& a) {
    const Vec3d v(static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2]));
    return v.norm();
}

struct Face {
    SurfaceTriangle triangle;
    GridPoint normal{};
    double inverse_length = 0.0;
    bool alive = true;
    std::vector<int> outside;  // points above it, each in the list of one face only
    int farthest = kNone;
    double height = 0.0;  // of the farthest, in grid steps
};

class Builder {
  public:
    Builder(std::span<const Vec3d> points, double tolerance) {
        const Vec3d lower = extreme(points, true);
        const double extent = (extreme(points, false) - lower).maxCoeff();
        step_ = extent > 0.0 ? extent / kGridSteps : 1.0;
        tolerance_ = tolerance / step_;
        points_.reserve(points.size());
        for (const Vec3d& p : points) {
            GridPoint g{};
            for (int i = 0; i < 3; ++i) {
                g[static_cast<std::size_t>(i)] = std::llround((p[i] - lower[i]) / step_);
            }
            points_.push_back(g);
        }
    }

    std::string begin();
    TriangleHull grow(int max_vertices);

  private:
    static Vec3d extreme(std::span<const Vec3d> points, bool lowest) {
        Vec3d out = points[0];
        for (const Vec3d& p : points) {
            out = lowest ? Vec3d(out.cwiseMin(p)) : Vec3d(out.cwiseMax(p));
        }
        return out;
    }

    [[nodiscard]] const GridPoint& at(int i) const { return points_[static_cast<std::size_t>(i)]; }

    Face& face(int i) { return faces_[static_cast<std::size_t>(i)]; }

    /// Positive above the face, in units that only the sign is taken of.
    [[nodiscard]] Wide side(const Face& f, int point) const {
        return dot(f.normal, difference(at(point), at(f.triangle.corner[0])));
    }

    [[nodiscard]] double height(const Face& f, int point) const {
        return static_cast<double>(side(f, point)) * f.inverse_length;
    }

    template <class Measure>
    [[nodiscard]] int largest(Measure&& measure) const;
    int add_face(int a, int b, int c);
    void hand_over(const std::vector<int>& points, const std::vector<int>& faces, int except);
    void find_horizon(int point, int start);
    void add_point(int point, int start);

    std::vector<GridPoint> points_;
    double step_ = 1.0;  // m
    double tolerance_ = 0.0;
    std::vector<Face> faces_;
    int vertices_ = 4;

    // Scratch of add_point.
    struct HorizonEdge {
        int from, to;  // points
        int beyond;    // the face that stays
    };

    std::vector<HorizonEdge> horizon_;
    std::vector<int> visible_, fresh_, orphans_;
};

/// The point with the largest measure; the first of equals.
template <class Measure>
int Builder::largest(Measure&& measure) const {
    int best = 0;
    double value = measure(0);
    for (int i = 1; i < static_cast<int>(points_.size()); ++i) {
        const double m = measure(i);
        if (m > value) {
            value = m;
            best = i;
        }
    }
    return best;
}

int Builder::add_face(int a, int b, int c) {
    Face f;
    f.triangle.corner = {a, b, c};
    f.normal = cross(difference(at(b), at(a)), difference(at(c), at(a)));
    f.inverse_length = 1.0 / length(f.normal);
    faces_.push_back(std::move(f));
    return static_cast<int>(faces_.size()) - 1;
}

/// Gives each point to the face of `faces` that it is highest above; those above none are inside.
void Builder::hand_over(const std::vector<int>& points, const std::vector<int>& faces, int except) {
    for (const int p : points) {
        if (p == except) {
            continue;
        }
        int owner = kNone;
        double most = 0.0;
        for (const int i : faces) {
            if (side(face(i), p) > 0) {
                const double h = height(face(i), p);
                if (owner == kNone || h > most) {
                    owner = i;
                    most = h;
                }
            }
        }
        if (owner != kNone) {
            Face& f = face(owner);
            f.outside.push_back(p);
            if (f.farthest == kNone || most > f.height) {
                f.farthest = p;
                f.height = most;
            }
        }
    }
}

/// The first tetrahedron; returns why there is none.
std::string Builder::begin() {
    // The two points farthest apart along an axis.
    int a = 0;
    int b = 0;
    double apart = -1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const int high = largest([&](int i) { return static_cast<double>(at(i)[axis]); });
        const int low = largest([&](int i) { return -static_cast<double>(at(i)[axis]); });
        const auto d = static_cast<double>(at(high)[axis] - at(low)[axis]);
        if (d > apart) {
            apart = d;
            a = low;
            b = high;
        }
    }
    const GridPoint ab = difference(at(b), at(a));
    if (!(apart > tolerance_)) {
        return "hull: all points are one";
    }
    const auto off_line = [&](int i) {
        return length(cross(ab, difference(at(i), at(a))));
    };
    int c = largest(off_line);
    if (off_line(c) / length(ab) <= tolerance_) {
        return "hull: all points lie on a line";
    }
    const GridPoint normal = cross(ab, difference(at(c), at(a)));
    const auto off_plane = [&](int i) {
        return std::abs(static_cast<double>(dot(normal, difference(at(i), at(a)))));
    };
    const int d = largest(off_plane);
    if (off_plane(d) / length(normal) <= tolerance_) {
        return "hull: all points lie in a plane";
    }
    if (dot(normal, difference(at(d), at(a))) > 0) {
        std::swap(b, c);  // now d lies below the first face
    }
    add_face(a, b, c);
    add_face(a, d, b);
    add_face(b, d, c);
    add_face(c, d, a);
    face(0).triangle.neighbour = {1, 2, 3};
    face(1).triangle.neighbour = {3, 2, 0};
    face(2).triangle.neighbour = {1, 3, 0};
    face(3).triangle.neighbour = {2, 1, 0};
    std::vector<int> all(points_.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        all[i] = static_cast<int>(i);
    }
    hand_over(all, {0, 1, 2, 3}, kNone);
    return {};
}

/// The faces that see the point are whole facets of a convex surface, so their border with the rest
/// is one closed line.
void Builder::find_horizon(int point, int start) {
    visible_.clear();
    horizon_.clear();
    face(start).alive = false;
    visible_.push_back(start);
    for (std::size_t k = 0; k < visible_.size(); ++k) {
        const SurfaceTriangle triangle = face(visible_[k]).triangle;
        for (std::size_t e = 0; e < 3; ++e) {
            const int beyond = triangle.neighbour[e];
            if (face(beyond).alive && side(face(beyond), point) > 0) {
                face(beyond).alive = false;
                visible_.push_back(beyond);
            }
        }
    }
    for (const int v : visible_) {
        const SurfaceTriangle triangle = face(v).triangle;
        for (std::size_t e = 0; e < 3; ++e) {
            if (face(triangle.neighbour[e]).alive) {
                horizon_.push_back(
                    {triangle.corner[e], triangle.corner[(e + 1) % 3], triangle.neighbour[e]});
            }
        }
    }
}

void Builder::add_point(int point, int start) {
    find_horizon(point, start);
    fresh_.clear();
    for (const HorizonEdge& edge : horizon_) {
        const int f = add_face(edge.from, edge.to, point);
        fresh_.push_back(f);
        face(f).triangle.neighbour[0] = edge.beyond;
        SurfaceTriangle& other = face(edge.beyond).triangle;
        for (std::size_t e = 0; e < 3; ++e) {
            if (other.corner[e] == edge.to && other.corner[(e + 1) % 3] == edge.from) {
                other.neighbour[e] = f;
            }
        }
    }
    for (const int f : fresh_) {
        const int to = face(f).triangle.corner[1];
        const auto next = std::find_if(
            fresh_.begin(), fresh_.end(), [&](int g) { return face(g).triangle.corner[0] == to; });
        face(f).triangle.neighbour[1] = *next;
        face(*next).triangle.neighbour[2] = f;
    }
    orphans_.clear();
    for (const int v : visible_) {
        std::vector<int>& outside = face(v).outside;
        orphans_.insert(orphans_.end(), outside.begin(), outside.end());
        outside = {};
    }
    std::sort(orphans_.begin(), orphans_.end());
    hand_over(orphans_, fresh_, point);
    ++vertices_;
}

TriangleHull Builder::grow(int max_vertices) {
    TriangleHull out;
    for (;;) {
        int next = kNone;
        double most = 0.0;
        for (int i = 0; i < static_cast<int>(faces_.size()); ++i) {
            if (face(i).alive && face(i).farthest != kNone && face(i).height > most) {
                most = face(i).height;
                next = i;
            }
        }
        if (next == kNone || most <= tolerance_ || vertices_ >= max_vertices) {
            out.cut_off = most * step_;
            break;
        }
        add_point(face(next).farthest, next);
    }
    std::vector<int> renamed(faces_.size(), kNone);
    for (std::size_t i = 0; i < faces_.size(); ++i) {
        if (faces_[i].alive) {
            renamed[i] = static_cast<int>(out.triangles.size());
            out.triangles.push_back(faces_[i].triangle);
        }
    }
    std::vector<int> corners;
    for (SurfaceTriangle& t : out.triangles) {
        for (int& n : t.neighbour) {
            n = renamed[static_cast<std::size_t>(n)];
        }
        corners.insert(corners.end(), t.corner.begin(), t.corner.end());
    }
    std::sort(corners.begin(), corners.end());
    out.vertices = static_cast<int>(std::unique(corners.begin(), corners.end()) - corners.begin());
    return out;
}

}  // namespace

core::Result<TriangleHull> quickhull(std::span<const Vec3d> points,
                                     int max_vertices,
                                     double tolerance) {
    using Hull = core::Result<TriangleHull>;
    if (points.size() < 4) {
        return Hull::failure("hull: fewer than four points");
    }
    Builder builder(points, tolerance);
    std::string reason = builder.begin();
    if (!reason.empty()) {
        return Hull::failure(std::move(reason));
    }
    return builder.grow(max_vertices);
}

}  // namespace zoned::physics
