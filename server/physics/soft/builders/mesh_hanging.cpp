#include "server/physics/soft/builders/mesh_hanging.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::physics::soft {

namespace {

using Triangle3 = std::array<Vec3d, 3>;

/// Barycentric coordinates of the foot of `p` on the triangle's plane.
Vec3d barycentric(const Triangle3& t, const Vec3d& p) {
    const Vec3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
    const double whole = normal.squaredNorm();
    const double v = (p - t[0]).cross(t[2] - t[0]).dot(normal) / whole;
    const double w = (t[1] - t[0]).cross(p - t[0]).dot(normal) / whole;
    return {1.0 - v - w, v, w};
}

Vec3d point_at(const Triangle3& t, const Vec3d& weights) {
    return weights[0] * t[0] + weights[1] * t[1] + weights[2] * t[2];
}

/// Barycentric coordinates of the triangle's point nearest to `p`: the foot on its plane, or else
/// the nearest point of its edges.
Vec3d nearest(const Triangle3& t, const Vec3d& p) {
    const Vec3d foot = barycentric(t, p);
    if (foot.minCoeff() >= 0.0) {
        return foot;
    }
    Vec3d best = Vec3d::UnitX();
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        const Vec3d along = t[static_cast<std::size_t>(j)] - t[static_cast<std::size_t>(i)];
        const Vec3d from = p - t[static_cast<std::size_t>(i)];
        const double share = std::clamp(from.dot(along) / along.squaredNorm(), 0.0, 1.0);
        const double distance = (from - share * along).squaredNorm();
        if (distance < least) {
            least = distance;
            best.setZero();
            best[i] = 1.0 - share;
            best[j] = share;
        }
    }
    return best;
}

class Hanger {
  public:
    Hanger(std::span<const Vec3> vertices, const SimplifiedMesh& coarse)
        : vertices_(vertices),
          coarse_(coarse),
          around_(coarse.kept.size()) {
        for (std::uint32_t f = 0; f < coarse.faces.size(); ++f) {
            for (const std::uint32_t node : coarse.faces[f]) {
                around_[node].push_back(f);
            }
        }
    }

    HungMesh run() {
        HungMesh out;
        for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
            const std::uint32_t node = coarse_.into[v];
            if (coarse_.kept[node] == v) {
                out.vertices.push_back({{node, node, node, node}, {1.0F, 0.0F, 0.0F, 0.0F}, 0.0F});
                out.mass_shares.push_back({1.0, 0.0, 0.0});
            } else {
                hang(vertices_[v].cast<double>(), faces_near(node), out);
            }
        }
        return out;
    }

  private:
    /// Around the node and its neighbours, ascending.
    [[nodiscard]] std::vector<std::uint32_t> faces_near(std::uint32_t node) const {
        std::vector<std::uint32_t> out;
        for (const std::uint32_t f : around_[node]) {
            for (const std::uint32_t c : coarse_.faces[f]) {
                out.insert(out.end(), around_[c].begin(), around_[c].end());
            }
        }
        std::sort(out.begin(), out.end());
        out.erase(std::unique(out.begin(), out.end()), out.end());
        return out;
    }

    [[nodiscard]] Triangle3 triangle(std::uint32_t face) const {
        Triangle3 out;
        for (std::size_t k = 0; k < 3; ++k) {
            out[k] = vertices_[coarse_.kept[coarse_.faces[face][k]]].cast<double>();
        }
        return out;
    }

    void hang(const Vec3d& place, const std::vector<std::uint32_t>& faces, HungMesh& out) const {
        double least = std::numeric_limits<double>::infinity();
        std::uint32_t face = 0;
        Vec3d share = Vec3d::Zero();
        for (const std::uint32_t f : faces) {
            const Triangle3 t = triangle(f);
            const Vec3d weights = nearest(t, place);
            const double distance = (point_at(t, weights) - place).squaredNorm();
            if (distance < least) {
                least = distance;
                face = f;
                share = weights;
            }
        }
        const Triangle3 t = triangle(face);
        const Vec3d weights = barycentric(t, place);
        const Vec3d normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
        const SoftFace& nodes = coarse_.faces[face];
        SoftVertex vertex;
        vertex.node = {nodes[0], nodes[1], nodes[2], nodes[0]};
        vertex.weight = {static_cast<float>(weights[0]),
                         static_cast<float>(weights[1]),
                         static_cast<float>(weights[2]),
                         0.0F};
        vertex.offset = static_cast<float>(normal.dot(place - t[0]));
        out.vertices.push_back(vertex);
        out.mass_shares.push_back({share[0], share[1], share[2]});
    }

    std::span<const Vec3> vertices_;
    const SimplifiedMesh& coarse_;
    std::vector<std::vector<std::uint32_t>> around_;  // faces of each node
};

}  // namespace

HungMesh hang_mesh(std::span<const Vec3> vertices, const SimplifiedMesh& coarse) {
    return Hanger(vertices, coarse).run();
}

bool move_centre(std::span<const Vec3d> points, const Vec3d& centre, std::vector<double>& masses) {
    double whole = 0.0;
    Vec3d now = Vec3d::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
        whole += masses[i];
        now += masses[i] * points[i];
    }
    now /= whole;
    // Lagrange: each mass changes by the share slope . (point - now), with (sum m r r^T) slope the
    // moment that is missing.
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
        spread += masses[i] * (points[i] - now) * (points[i] - now).transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(spread);
    const Vec3d missing = eigen.eigenvectors().transpose() * (whole * (centre - now));
    Vec3d slope = Vec3d::Zero();
    const double widest = eigen.eigenvalues()[2];
    for (int k = 0; k < 3; ++k) {
        if (eigen.eigenvalues()[k] > 1.0e-9 * widest) {
            slope += missing[k] / eigen.eigenvalues()[k] * eigen.eigenvectors().col(k);
        } else if (std::abs(missing[k]) > 1.0e-6 * std::sqrt(whole * widest)) {
            return false;  // a mesh that is not flat, on points that are
        }
    }
    const auto factor = [&](std::size_t i) {
        return 1.0 + slope.dot(points[i] - now);
    };
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!(factor(i) > 0.1)) {
            return false;
        }
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        masses[i] *= factor(i);
    }
    return true;
}

}  // namespace zoned::physics::soft
