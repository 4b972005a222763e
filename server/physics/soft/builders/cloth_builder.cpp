// Cloth: the lattice that is drawn, or a coarser one that stands for it.
#include "server/physics/soft/builders/builders.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace zoned::physics::soft {

namespace {

core::Result<SoftDef> cloth_refused(const std::string& reason) {
    return core::Result<SoftDef>::failure("cloth: " + reason);
}

/// How many fine nodes each coarse one stands for along a side: sums of its hat function.
std::vector<float> shares(int fine, int factor) {
    std::vector<float> out(static_cast<std::size_t>((fine - 1) / factor + 1), 0.0F);
    for (int i = 0; i < fine; ++i) {
        const auto cell = static_cast<std::size_t>(i / factor);
        const float along = static_cast<float>(i % factor) / static_cast<float>(factor);
        out[cell] += 1.0F - along;
        if (along > 0.0F) {
            out[cell + 1] += along;
        }
    }
    return out;
}

class ClothBuilder {
  public:
    ClothBuilder(const ClothDef& def, int factor)
        : def_(def),
          factor_(factor),
          nx_((def.nx - 1) / factor + 1),
          nz_((def.nz - 1) / factor + 1),
          share_x_(shares(def.nx, factor)),
          share_z_(shares(def.nz, factor)),
          node_mass_(def.density * def.size_x * def.size_z / static_cast<float>(def.nx * def.nz)) {}

    SoftDef build() {
        add_nodes();
        add_springs();
        out_.faces = faces(nx_, nz_);
        if (factor_ > 1) {
            add_vertices();
            out_.drawn_faces = faces(def_.nx, def_.nz);
        }
        return std::move(out_);
    }

  private:
    [[nodiscard]] std::uint32_t index(int i, int j) const {
        return static_cast<std::uint32_t>(j * nx_ + i);
    }

    void add_nodes() {
        for (int j = 0; j < nz_; ++j) {
            for (int i = 0; i < nx_; ++i) {
                SoftNode node;
                node.position =
                    def_.origin +
                    Vec3(def_.size_x * static_cast<float>(i) / static_cast<float>(nx_ - 1),
                         0.0F,
                         def_.size_z * static_cast<float>(j) / static_cast<float>(nz_ - 1));
                node.mass = node_mass_ * share_x_[static_cast<std::size_t>(i)] *
                            share_z_[static_cast<std::size_t>(j)];
                out_.nodes.push_back(node);
            }
        }
        for (const auto& [i, j] : def_.pins) {
            out_.nodes[index(i / factor_, j / factor_)].pinned = true;
        }
    }

    /// A coarse spring stands for `factor` fine ones in a row, as many rows side by side as its
    /// ends stand for: as stiff as one of them where it stands for whole cells.
    void add_family(int di, int dj, float stiffness, SpringKind kind) {
        if (stiffness == 0.0F) {
            return;
        }
        for (int j = 0; j + dj < nz_; ++j) {
            for (int i = std::max(0, -di); i < nx_ && i + di < nx_; ++i) {
                float rows = 1.0F;
                if (dj == 0) {
                    rows = share_z_[static_cast<std::size_t>(j)] / static_cast<float>(factor_);
                } else if (di == 0) {
                    rows = share_x_[static_cast<std::size_t>(i)] / static_cast<float>(factor_);
                }
                SoftSpring s;
                s.a = index(i, j);
                s.b = index(i + di, j + dj);
                s.rest = (out_.nodes[s.b].position - out_.nodes[s.a].position).norm();
                s.stiffness = rows * stiffness;
                s.damping =
                    rows * 2.0F * def_.damping_share * std::sqrt(0.5F * stiffness * node_mass_);
                s.kind = kind;
                out_.springs.push_back(s);
            }
        }
    }

    void add_springs() {
        add_family(1, 0, def_.stiffness, SpringKind::kStructural);
        add_family(0, 1, def_.stiffness, SpringKind::kStructural);
        add_family(1, 1, def_.shear_stiffness, SpringKind::kShear);
        add_family(-1, 1, def_.shear_stiffness, SpringKind::kShear);
        add_family(2, 0, def_.bend_stiffness, SpringKind::kBend);
        add_family(0, 2, def_.bend_stiffness, SpringKind::kBend);
    }

    /// Of a lattice of nx x nz points.
    static std::vector<SoftFace> faces(int nx, int nz) {
        std::vector<SoftFace> out;
        for (int j = 0; j + 1 < nz; ++j) {
            for (int i = 0; i + 1 < nx; ++i) {
                const auto a = static_cast<std::uint32_t>(j * nx + i);
                const std::uint32_t b = a + 1;
                const std::uint32_t c = a + static_cast<std::uint32_t>(nx);
                const std::uint32_t d = c + 1;
                out.push_back({a, c, b});
                out.push_back({b, c, d});
            }
        }
        return out;
    }

    void add_vertices() {
        for (int j = 0; j < def_.nz; ++j) {
            for (int i = 0; i < def_.nx; ++i) {
                const int ci = std::min(i / factor_, nx_ - 2);
                const int cj = std::min(j / factor_, nz_ - 2);
                const float u = static_cast<float>(i - ci * factor_) / static_cast<float>(factor_);
                const float v = static_cast<float>(j - cj * factor_) / static_cast<float>(factor_);
                SoftVertex vertex;
                vertex.node = {
                    index(ci, cj), index(ci + 1, cj), index(ci, cj + 1), index(ci + 1, cj + 1)};
                vertex.weight = {(1.0F - u) * (1.0F - v), u * (1.0F - v), (1.0F - u) * v, u * v};
                out_.vertices.push_back(vertex);
            }
        }
    }

    const ClothDef& def_;
    int factor_;
    int nx_;
    int nz_;
    std::vector<float> share_x_;
    std::vector<float> share_z_;
    float node_mass_;
    SoftDef out_;
};

bool fits(const ClothDef& def, int factor) {
    return (def.nx - 1) % factor == 0 && (def.nz - 1) % factor == 0 &&
           std::all_of(def.pins.begin(), def.pins.end(), [&](const auto& pin) {
               return pin[0] % factor == 0 && pin[1] % factor == 0;
           });
}

int automatic_factor(const ClothDef& def) {
    const int cells = std::min(def.nx, def.nz) - 1;
    for (int factor = std::max(1, cells / kEnoughCells); factor > 1; --factor) {
        if (fits(def, factor)) {
            return factor;
        }
    }
    return 1;
}

}  // namespace

core::Result<SoftDef> build_cloth(const ClothDef& def) {
    if (def.nx < 2 || def.nz < 2 || def.nx > 4096 || def.nz > 4096) {
        return cloth_refused("number of nodes along a side out of range");
    }
    for (std::size_t i = 0; i < def.pins.size(); ++i) {
        const auto& [x, z] = def.pins[i];
        if (x < 0 || z < 0 || x >= def.nx || z >= def.nz) {
            return cloth_refused("pin " + std::to_string(i) + ": no such node");
        }
    }
    if (def.coarsen < 0) {
        return cloth_refused("coarsen is negative");
    }
    const int factor = def.coarsen == 0 ? automatic_factor(def) : def.coarsen;
    if (factor >= std::min(def.nx, def.nz) || !fits(def, factor)) {
        return cloth_refused("the coarser lattice has no node at each corner and pin");
    }
    SoftDef out = ClothBuilder(def, factor).build();
    if (std::string reason = why_unfit(out); !reason.empty()) {
        return cloth_refused(reason);
    }
    return out;
}

}  // namespace zoned::physics::soft
