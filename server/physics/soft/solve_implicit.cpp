// Implicit Euler: Baraff and Witkin, "Large Steps in Cloth Simulation" (SIGGRAPH 98). Each substep
// is the minimum of |x - predicted|^2_M / (2 h^2) + E(x) + damping (the variational form of Martin
// et al., "Example-based elastic materials", 2011, section 4), approached by Newton steps; each is
// solved by conjugate gradients preconditioned with the blocks on the diagonal (section 5), pinned
// nodes filtered out (section 5.3). Terms across a compressed spring are left out, so that the
// matrix stays positive definite (Choi and Ko, "Stable but responsive cloth", 2002). A step that
// would raise the function is halved.
#include "server/physics/soft/soft_body.h"
#include "server/physics/soft/volume.h"
#include "shared/core/elementary/elementary.h"

#include <algorithm>
#include <cmath>

namespace zoned::physics::soft {

namespace {

using Vectors = std::vector<Vec3d>;

class Newton {
  public:
    Newton(SoftBody& body, double h) : b_(body), w_(body.implicit), h_(h) {
        const std::size_t n = b_.x.size();
        for (Vectors* column : {&w_.at,
                                &w_.force,
                                &w_.residual,
                                &w_.direction,
                                &w_.image,
                                &w_.change,
                                &w_.scaled,
                                &w_.trial}) {
            column->resize(n);
        }
        w_.inverse_diagonal.resize(n);
        w_.unit.resize(b_.springs.size());
        w_.stiff.resize(b_.springs.size());
        w_.volume_gradient.resize(b_.tetrahedra.size());
        for (std::size_t i = 0; i < n; ++i) {
            w_.at[i] = b_.position(i).cast<double>();
        }
    }

    void run() {
        double value = function(w_.at);
        for (int k = 0; k < b_.solver.newton_iterations; ++k) {
            linearise();
            solve_linear();
            ++w_.newton_steps;
            double share = 1.0;
            double next = value;
            int halved = 0;
            do {
                for (std::size_t i = 0; i < w_.at.size(); ++i) {
                    w_.trial[i] = w_.at[i] + share * w_.change[i];
                }
                next = function(w_.trial);
                share *= 0.5;
            } while (!(next <= value) && ++halved < kMostHalvings);
            if (!(next <= value)) {
                break;  // as low as rounding lets it be
            }
            w_.at.swap(w_.trial);
            value = next;
        }
        for (std::size_t i = 0; i < w_.at.size(); ++i) {
            if (free(i)) {
                b_.x[i].head<3>() = w_.at[i].cast<float>();
            }
        }
    }

  private:
    static constexpr int kMostHalvings = 12;

    [[nodiscard]] bool free(std::size_t i) const { return b_.x[i].w() > 0.0F; }

    [[nodiscard]] double inertia(std::size_t i) const {
        return static_cast<double>(b_.mass[i]) / (h_ * h_);
    }

    [[nodiscard]] Vec3d start(std::size_t i) const { return b_.start[i].head<3>().cast<double>(); }

    [[nodiscard]] double volume(std::size_t i, const Vectors& x) const {
        const SoftTetrahedron& t = b_.tetrahedra[i];
        return (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]).dot(x[t[3]] - x[t[0]]) / 6.0;
    }

    [[nodiscard]] double volume_stiffness(std::size_t i) const {
        return static_cast<double>(b_.material.bulk_modulus) /
               static_cast<double>(b_.rest_volume[i]);
    }

    [[nodiscard]] double gas_volume(const Vectors& x) const {
        const Vec3d& o = x[b_.faces.front()[0]];
        double sum = 0.0;
        for (const SoftFace& f : b_.faces) {
            sum += (x[f[0]] - o).dot((x[f[1]] - o).cross(x[f[2]] - o)) / 6.0;
        }
        return sum;
    }

    /// The energy to be least, J.
    [[nodiscard]] double function(const Vectors& x) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            if (free(i)) {
                sum += 0.5 * inertia(i) *
                       (x[i] - b_.predicted[i].head<3>().cast<double>()).squaredNorm();
            }
        }
        for (std::size_t i = 0; i < b_.springs.size(); ++i) {
            const Spring& s = b_.springs[i];
            if (s.alive) {
                const Vec3d d = x[s.b] - x[s.a];
                const double length = d.norm();
                const double wrong = length - static_cast<double>(s.rest);
                // Damping along the spring as it lies now: its work over the substep.
                const double way = length - (start(s.b) - start(s.a)).norm();
                sum += 0.5 * static_cast<double>(s.stiffness) * wrong * wrong +
                       0.5 * static_cast<double>(s.damping) / h_ * way * way;
            }
        }
        if (b_.material.bulk_modulus > 0.0F) {
            for (std::size_t i = 0; i < b_.tetrahedra.size(); ++i) {
                const double wrong = volume(i, x) - static_cast<double>(b_.rest_volume[i]);
                sum += 0.5 * volume_stiffness(i) * wrong * wrong;
            }
        }
        if (b_.gas > 0.0) {
            const double v = gas_volume(x);
            // No gas fits into nothing: a step that turns the surface inside out is refused.
            sum += v > 0.0 ? static_cast<double>(b_.material.ambient_pressure) * v -
                                 b_.gas * elementary::log(v)
                           : INFINITY;
        }
        return sum;
    }

    /// Forces and the parts of the matrix at `at`.
    void linearise() {
        for (std::size_t i = 0; i < w_.at.size(); ++i) {
            w_.force[i] = inertia(i) * (b_.predicted[i].head<3>().cast<double>() - w_.at[i]);
            w_.inverse_diagonal[i] = inertia(i) * Eigen::Matrix3d::Identity();
        }
        for (std::size_t i = 0; i < b_.springs.size(); ++i) {
            linearise_spring(i);
        }
        linearise_volumes();
        linearise_gas();
        for (std::size_t i = 0; i < w_.at.size(); ++i) {
            w_.inverse_diagonal[i] = w_.inverse_diagonal[i].inverse().eval();
        }
    }

    void linearise_spring(std::size_t i) {
        const Spring& s = b_.springs[i];
        if (!s.alive) {
            return;
        }
        const Vec3d d = w_.at[s.b] - w_.at[s.a];
        const double length = std::max(d.norm(), 1.0e-12);
        const double k = static_cast<double>(s.stiffness);
        const double rest = static_cast<double>(s.rest);
        const double c = static_cast<double>(s.damping) / h_;
        const double before = (start(s.b) - start(s.a)).norm();
        const double tension = k * (length - rest) + c * (length - before);
        const double along = k + c;
        const double across = std::max(0.0, tension / length);
        const Vec3d n = d / length;
        w_.unit[i] = n;
        w_.stiff[i] = Vec3d(along - across, across, length);
        w_.force[s.a] += tension * n;
        w_.force[s.b] -= tension * n;
        const Eigen::Matrix3d block =
            (along - across) * n * n.transpose() + across * Eigen::Matrix3d::Identity();
        w_.inverse_diagonal[s.a] += block;
        w_.inverse_diagonal[s.b] += block;
    }

    void linearise_volumes() {
        if (b_.material.bulk_modulus <= 0.0F) {
            return;
        }
        for (std::size_t i = 0; i < b_.tetrahedra.size(); ++i) {
            const SoftTetrahedron& t = b_.tetrahedra[i];
            auto& g = w_.volume_gradient[i];
            g = tetrahedron_gradient(w_.at[t[0]], w_.at[t[1]], w_.at[t[2]], w_.at[t[3]]);
            const double k = volume_stiffness(i);
            const double wrong = volume(i, w_.at) - static_cast<double>(b_.rest_volume[i]);
            for (std::size_t c = 0; c < 4; ++c) {
                w_.force[t[c]] -= k * wrong * g[c];
                w_.inverse_diagonal[t[c]] += k * g[c] * g[c].transpose();
            }
        }
    }

    void linearise_gas() {
        if (b_.gas <= 0.0) {
            return;
        }
        const Vec3d& o = w_.at[b_.faces.front()[0]];
        w_.gas_gradient.assign(w_.at.size(), Vec3d::Zero());
        for (const SoftFace& f : b_.faces) {
            const Vec3d p = w_.at[f[0]] - o;
            const Vec3d q = w_.at[f[1]] - o;
            const Vec3d r = w_.at[f[2]] - o;
            w_.gas_gradient[f[0]] += q.cross(r) / 6.0;
            w_.gas_gradient[f[1]] += r.cross(p) / 6.0;
            w_.gas_gradient[f[2]] += p.cross(q) / 6.0;
        }
        const double v = gas_volume(w_.at);
        const double excess = b_.gas / v - static_cast<double>(b_.material.ambient_pressure);
        gas_stiffness_ = b_.gas / (v * v);
        for (const std::uint32_t i : b_.surface) {
            w_.force[i] += excess * w_.gas_gradient[i];
            w_.inverse_diagonal[i] +=
                gas_stiffness_ * w_.gas_gradient[i] * w_.gas_gradient[i].transpose();
        }
    }

    /// out = matrix * in, where `in` is zero at pinned nodes.
    void multiply(const Vectors& in, Vectors& out) const {
        for (std::size_t i = 0; i < in.size(); ++i) {
            out[i] = inertia(i) * in[i];
        }
        for (std::size_t i = 0; i < b_.springs.size(); ++i) {
            const Spring& s = b_.springs[i];
            if (s.alive) {
                const Vec3d d = in[s.b] - in[s.a];
                const Vec3d f =
                    w_.stiff[i].x() * w_.unit[i].dot(d) * w_.unit[i] + w_.stiff[i].y() * d;
                out[s.a] -= f;
                out[s.b] += f;
            }
        }
        if (b_.material.bulk_modulus > 0.0F) {
            for (std::size_t i = 0; i < b_.tetrahedra.size(); ++i) {
                const SoftTetrahedron& t = b_.tetrahedra[i];
                const auto& g = w_.volume_gradient[i];
                double sum = 0.0;
                for (std::size_t c = 0; c < 4; ++c) {
                    sum += g[c].dot(in[t[c]]);
                }
                for (std::size_t c = 0; c < 4; ++c) {
                    out[t[c]] += volume_stiffness(i) * sum * g[c];
                }
            }
        }
        if (b_.gas > 0.0) {
            double sum = 0.0;
            for (const std::uint32_t i : b_.surface) {
                sum += w_.gas_gradient[i].dot(in[i]);
            }
            for (const std::uint32_t i : b_.surface) {
                out[i] += gas_stiffness_ * sum * w_.gas_gradient[i];
            }
        }
        for (std::size_t i = 0; i < in.size(); ++i) {
            if (!free(i)) {
                out[i].setZero();
            }
        }
    }

    static double dot(const Vectors& a, const Vectors& b) {
        double sum = 0.0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            sum += a[i].dot(b[i]);
        }
        return sum;
    }

    double precondition() {
        for (std::size_t i = 0; i < w_.residual.size(); ++i) {
            w_.scaled[i] = w_.inverse_diagonal[i] * w_.residual[i];
        }
        return dot(w_.residual, w_.scaled);
    }

    void solve_linear() {
        for (std::size_t i = 0; i < w_.at.size(); ++i) {
            w_.change[i].setZero();
            w_.residual[i] = free(i) ? w_.force[i] : Vec3d::Zero();
        }
        double size = precondition();
        const auto accuracy = static_cast<double>(b_.solver.gradient_accuracy);
        const double enough = size * accuracy * accuracy;
        w_.direction = w_.scaled;
        for (int k = 0; k < b_.solver.gradient_iterations && size > enough && size > 0.0; ++k) {
            ++w_.gradient_passes;
            multiply(w_.direction, w_.image);
            const double step = size / dot(w_.direction, w_.image);
            for (std::size_t i = 0; i < w_.at.size(); ++i) {
                w_.change[i] += step * w_.direction[i];
                w_.residual[i] -= step * w_.image[i];
            }
            const double next = precondition();
            const double keep = next / size;
            size = next;
            for (std::size_t i = 0; i < w_.at.size(); ++i) {
                w_.direction[i] = w_.scaled[i] + keep * w_.direction[i];
            }
        }
    }

    SoftBody& b_;
    ImplicitWork& w_;
    double h_;
    double gas_stiffness_ = 0.0;
};

}  // namespace

void solve_implicit(SoftBody& body, float h) {
    Newton(body, static_cast<double>(h)).run();
}

}  // namespace zoned::physics::soft
