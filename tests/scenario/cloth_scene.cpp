#include "tests/scenario/cloth_scene.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace zoned::scenario {

namespace {

/// Columns of x, y, z; forces family by family along the lattice's rows, which the compiler turns
/// into wide arithmetic.
class Leapfrog {
  public:
    explicit Leapfrog(const Cloth& cloth) : cloth_(cloth), springs_(cloth_springs(cloth)) {
        const auto count = static_cast<std::size_t>(cloth.count());
        for (std::size_t k = 0; k < 3; ++k) {
            x_[k].assign(count, 0.0);
            v_[k].assign(count, 0.0);
            f_[k].assign(count, 0.0);
            row_[k].assign(static_cast<std::size_t>(cloth.nodes), 0.0);
        }
        const double cell = cloth.size / (cloth.nodes - 1);
        for (std::size_t i = 0; i < count; ++i) {
            x_[0][i] = cell * static_cast<double>(i % row_[0].size());
            x_[2][i] = cell * static_cast<double>(i / row_[0].size());
        }
    }

    /// Positions at whole steps, velocities half a step behind; the first one starts them.
    void run(double seconds, std::size_t steps) {
        const double h = seconds / static_cast<double>(steps);
        for (std::size_t s = 0; s < steps; ++s) {
            gather_forces();
            push(s == 0 ? 0.5 * h : h, h);
        }
    }

    [[nodiscard]] std::vector<Vec3d> positions() const {
        std::vector<Vec3d> out;
        for (std::size_t i = 0; i < x_[0].size(); ++i) {
            out.emplace_back(x_[0][i], x_[1][i], x_[2][i]);
        }
        return out;
    }

  private:
    using Columns = std::array<std::vector<double>, 3>;

    void gather_forces() {
        const double m = cloth_.node_mass();
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t i = 0; i < f_[k].size(); ++i) {
                f_[k][i] = -cloth_.drag * m * v_[k][i] - (k == 1 ? cloth_.gravity * m : 0.0);
            }
        }
        for (const ClothSprings& s : springs_) {
            for (int j = 0; j + s.dj < cloth_.nodes; ++j) {
                const int first = std::max(0, -s.di);
                const int end = cloth_.nodes - std::max(0, s.di);
                const int a = j * cloth_.nodes + first;
                add_row(s, a, a + s.dj * cloth_.nodes + s.di, end - first);
            }
        }
    }

    void add_row(const ClothSprings& s, int a, int b, int count) {
        std::array<const double*, 3> xa{};
        std::array<const double*, 3> xb{};
        std::array<const double*, 3> va{};
        std::array<const double*, 3> vb{};
        for (std::size_t k = 0; k < 3; ++k) {
            xa[k] = x_[k].data() + a;
            xb[k] = x_[k].data() + b;
            va[k] = v_[k].data() + a;
            vb[k] = v_[k].data() + b;
        }
        double* __restrict px = row_[0].data();
        double* __restrict py = row_[1].data();
        double* __restrict pz = row_[2].data();
        for (int i = 0; i < count; ++i) {
            const double dx = xb[0][i] - xa[0][i];
            const double dy = xb[1][i] - xa[1][i];
            const double dz = xb[2][i] - xa[2][i];
            const double length = std::sqrt(dx * dx + dy * dy + dz * dz);
            const double speed = ((vb[0][i] - va[0][i]) * dx + (vb[1][i] - va[1][i]) * dy +
                                  (vb[2][i] - va[2][i]) * dz) /
                                 length;
            const double pull = (s.stiffness * (length - s.rest) + s.damping * speed) / length;
            px[i] = pull * dx;
            py[i] = pull * dy;
            pz[i] = pull * dz;
        }
        for (std::size_t k = 0; k < 3; ++k) {
            const double* __restrict p = row_[k].data();
            double* f = f_[k].data();
            for (int i = 0; i < count; ++i) {
                f[a + i] += p[i];
            }
            for (int i = 0; i < count; ++i) {
                f[b + i] -= p[i];
            }
        }
    }

    void push(double kick, double h) {
        const double share = kick / cloth_.node_mass();
        const auto corner = static_cast<std::size_t>(cloth_.nodes - 1);
        for (std::size_t k = 0; k < 3; ++k) {
            f_[k][0] = 0.0;
            f_[k][corner] = 0.0;
            for (std::size_t i = 0; i < f_[k].size(); ++i) {
                v_[k][i] += share * f_[k][i];
                x_[k][i] += h * v_[k][i];
            }
        }
    }

    Cloth cloth_;
    std::vector<ClothSprings> springs_;
    Columns x_, v_, f_, row_;
};

}  // namespace

std::vector<ClothSprings> cloth_springs(const Cloth& cloth) {
    const double cell = cloth.size / (cloth.nodes - 1);
    std::vector<ClothSprings> out;
    const auto add = [&](int di, int dj, double k) {
        out.push_back({di,
                       dj,
                       k,
                       2.0 * cloth.damping_share * std::sqrt(0.5 * k * cloth.node_mass()),
                       cell * std::sqrt(di * di + dj * dj)});
    };
    add(1, 0, cloth.stiffness);
    add(0, 1, cloth.stiffness);
    add(1, 1, 0.5 * cloth.stiffness);
    add(-1, 1, 0.5 * cloth.stiffness);
    add(2, 0, 0.1 * cloth.stiffness);
    add(0, 2, 0.1 * cloth.stiffness);
    return out;
}

std::vector<Vec3d> cloth_reference(const Cloth& cloth, double seconds, double pace) {
    // Twice the sum of a node's stiffness over its mass bounds w^2: 2 (4 + 2 + 0.4) k. Springs do
    // not all point in one direction, so that 16 k instead of 12.8 k leaves room.
    const double highest = std::sqrt(16.0 * cloth.stiffness / cloth.node_mass());
    Leapfrog leapfrog(cloth);
    leapfrog.run(seconds, static_cast<std::size_t>(std::ceil(seconds * highest * pace)));
    return leapfrog.positions();
}

double mean_distance(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += (a[i] - b[i]).norm();
    }
    return sum / static_cast<double>(a.size());
}

}  // namespace zoned::scenario
