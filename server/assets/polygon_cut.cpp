#include "server/assets/polygon_cut.h"

#include <algorithm>
#include <cmath>

namespace zoned::assets {

namespace {

using Vec2d = Eigen::Vector2d;

/// Twice the area of a polygon times its normal (Newell's method).
Vec3d region_of(std::span<const Vec3> corners) {
    Vec3d sum = Vec3d::Zero();
    const Vec3d origin = corners[0].cast<double>();
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3d a = corners[i].cast<double>() - origin;
        const Vec3d b = corners[(i + 1) % corners.size()].cast<double>() - origin;
        sum += a.cross(b);
    }
    return sum;
}

/// The polygon along the axis that is nearest to its normal, counter-clockwise.
class Outline {
  public:
    explicit Outline(std::span<const Vec3> corners) {
        const Vec3d area = region_of(corners);
        int axis = 0;
        area.cwiseAbs().maxCoeff(&axis);
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        double extent = 0.0;
        double farthest = 0.0;
        for (std::uint32_t i = 0; i < corners.size(); ++i) {
            const Vec3d p = corners[i].cast<double>();
            points_.push_back(area[axis] < 0.0 ? Vec2d(p[v], p[u]) : Vec2d(p[u], p[v]));
            left_.push_back(i);
            farthest = std::max(farthest, p.cwiseAbs().maxCoeff());
            extent = std::max(extent, (points_[i] - points_[0]).norm());
        }
        // Corners are rounded to floats: a straight line may bend by that much.
        slack_ = 4.0 * std::ldexp(1.0, -24) * farthest * extent;
    }

    bool cut(std::vector<std::array<std::uint32_t, 3>>& out) {
        std::size_t at = left_.size() == 4 ? first_of_four() : 0;
        while (left_.size() > 3) {
            const std::size_t ear = find_ear(at);
            if (ear == left_.size()) {
                return false;
            }
            out.push_back({before(ear), left_[ear], after(ear)});
            left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(ear));
            // The next ear is looked for one corner on, so that not all of them meet in one corner.
            at = (ear + 1) % left_.size();
        }
        out.push_back({left_[0], left_[1], left_[2]});
        return turn(left_[0], left_[1], left_[2]) >= -slack_;
    }

  private:
    [[nodiscard]] std::uint32_t before(std::size_t at) const {
        return left_[(at + left_.size() - 1) % left_.size()];
    }

    [[nodiscard]] std::uint32_t after(std::size_t at) const {
        return left_[(at + 1) % left_.size()];
    }

    /// Twice the area, positive when a, b, c run counter-clockwise.
    [[nodiscard]] double turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
        const Vec2d ab = points_[b] - points_[a];
        const Vec2d ac = points_[c] - points_[a];
        return ab.x() * ac.y() - ab.y() * ac.x();
    }

    /// Whether the corner can be cut off: it does not bend inwards, and no other corner lies in the
    /// triangle.
    [[nodiscard]] bool is_ear(std::size_t at, double least) const {
        const std::uint32_t a = before(at);
        const std::uint32_t b = left_[at];
        const std::uint32_t c = after(at);
        if (!(turn(a, b, c) >= least)) {
            return false;
        }
        return std::none_of(left_.begin(), left_.end(), [&](std::uint32_t p) {
            return turn(a, b, p) > slack_ && turn(b, c, p) > slack_ && turn(c, a, p) > slack_;
        });
    }

    /// The first ear from `at` on; one that has no area only when there is no other. All corners
    /// when there is none.
    [[nodiscard]] std::size_t find_ear(std::size_t at) const {
        for (const double least : {slack_, -2.0 * slack_}) {
            for (std::size_t k = 0; k < left_.size(); ++k) {
                const std::size_t ear = (at + k) % left_.size();
                if (is_ear(ear, least)) {
                    return ear;
                }
            }
        }
        return left_.size();
    }

    /// Cutting corner 0 or 2 off goes along the diagonal 1-3, 1 or 3 along 0-2. Squares are all cut
    /// the same way, however they are rounded.
    [[nodiscard]] std::size_t first_of_four() const {
        const double one = (points_[1] - points_[3]).squaredNorm();
        const double other = (points_[0] - points_[2]).squaredNorm();
        return one < 0.999 * other ? 0 : 1;
    }

    std::vector<Vec2d> points_;
    std::vector<std::uint32_t> left_;  // corners that are not cut off yet
    double slack_ = 0.0;               // m2
};

}  // namespace

bool cut_polygon(std::span<const Vec3> corners, std::vector<std::array<std::uint32_t, 3>>& out) {
    if (corners.size() == 3) {
        out.push_back({0, 1, 2});
        return true;
    }
    return Outline(corners).cut(out);
}

}  // namespace zoned::assets
