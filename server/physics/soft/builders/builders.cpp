#include "server/physics/soft/builders/builders.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace zoned::physics::soft {

namespace {

constexpr int kMostAlong = 4096;  // nodes along one side

core::Result<SoftDef> refused(std::string reason) {
    return core::Result<SoftDef>::failure(std::move(reason));
}

core::Result<SoftDef> checked(SoftDef def, const char* what) {
    if (std::string reason = why_unfit(def); !reason.empty()) {
        return refused(std::string(what) + ": " + reason);
    }
    return def;
}

void link(SoftDef& def, std::uint32_t a, std::uint32_t b, float k, float share, SpringKind kind) {
    SoftSpring s;
    s.a = a;
    s.b = b;
    s.rest = (def.nodes[b].position - def.nodes[a].position).norm();
    s.stiffness = k;
    const float mass = 0.5F * std::min(def.nodes[a].mass, def.nodes[b].mass);
    s.damping = 2.0F * share * std::sqrt(k * mass);
    s.kind = kind;
    def.springs.push_back(s);
}

}  // namespace

core::Result<SoftDef> build_rope(const RopeDef& def) {
    if (def.nodes < 2 || def.nodes > kMostAlong * kMostAlong) {
        return refused("rope: number of nodes out of range");
    }
    SoftDef out;
    const auto n = static_cast<std::uint32_t>(def.nodes);
    for (std::uint32_t i = 0; i < n; ++i) {
        SoftNode node;
        const float share = static_cast<float>(i) / static_cast<float>(n - 1);
        node.position = (1.0F - share) * def.from + share * def.to;
        node.mass = def.mass / static_cast<float>(n);
        node.pinned = (i == 0 && def.pin_from) || (i == n - 1 && def.pin_to);
        out.nodes.push_back(node);
    }
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
        link(out, i, i + 1, def.stiffness, def.damping_share, SpringKind::kStructural);
    }
    for (std::uint32_t i = 0; i + 2 < n && def.bend_stiffness != 0.0F; ++i) {
        link(out, i, i + 2, def.bend_stiffness, def.damping_share, SpringKind::kBend);
    }
    return checked(std::move(out), "rope");
}

namespace {

class JellyBuilder {
  public:
    explicit JellyBuilder(const JellyDef& def) : def_(def) {}

    SoftDef build() {
        add_nodes();
        for_each_node([&](int i, int j, int k) { add_springs(i, j, k); });
        for_each_node([&](int i, int j, int k) {
            if (i + 1 < def_.nodes[0] && j + 1 < def_.nodes[1] && k + 1 < def_.nodes[2]) {
                add_cell(i, j, k);
            }
        });
        if (def_.drawn > 0) {
            add_vertices();
        }
        out_.material.bulk_modulus = def_.bulk_modulus;
        return std::move(out_);
    }

  private:
    template <class Visit>
    void for_each_node(Visit&& visit) {
        for (int k = 0; k < def_.nodes[2]; ++k) {
            for (int j = 0; j < def_.nodes[1]; ++j) {
                for (int i = 0; i < def_.nodes[0]; ++i) {
                    visit(i, j, k);
                }
            }
        }
    }

    [[nodiscard]] std::uint32_t index(int i, int j, int k) const {
        return static_cast<std::uint32_t>((k * def_.nodes[1] + j) * def_.nodes[0] + i);
    }

    void add_nodes() {
        const Vec3 cells(static_cast<float>(def_.nodes[0] - 1),
                         static_cast<float>(def_.nodes[1] - 1),
                         static_cast<float>(def_.nodes[2] - 1));
        const int count = def_.nodes[0] * def_.nodes[1] * def_.nodes[2];
        for_each_node([&](int i, int j, int k) {
            SoftNode node;
            const Vec3 at(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
            node.position = def_.centre + def_.size.cwiseProduct(at.cwiseQuotient(cells) -
                                                                 Vec3(0.5F, 0.5F, 0.5F));
            node.mass = def_.mass / static_cast<float>(count);
            out_.nodes.push_back(node);
        });
    }

    /// To neighbours ahead: three edges and six diagonals of faces.
    void add_springs(int i, int j, int k) {
        constexpr std::array<std::array<int, 3>, 9> kAhead{{{1, 0, 0},
                                                            {0, 1, 0},
                                                            {0, 0, 1},
                                                            {1, 1, 0},
                                                            {-1, 1, 0},
                                                            {1, 0, 1},
                                                            {-1, 0, 1},
                                                            {0, 1, 1},
                                                            {0, -1, 1}}};
        for (std::size_t d = 0; d < kAhead.size(); ++d) {
            const int x = i + kAhead[d][0];
            const int y = j + kAhead[d][1];
            const int z = k + kAhead[d][2];
            if (x >= 0 && y >= 0 && x < def_.nodes[0] && y < def_.nodes[1] && z < def_.nodes[2]) {
                link(out_,
                     index(i, j, k),
                     index(x, y, z),
                     def_.stiffness,
                     def_.damping_share,
                     d < 3 ? SpringKind::kStructural : SpringKind::kShear);
            }
        }
    }

    /// Five tetrahedra; every second cell mirrored, so that neighbours share diagonals.
    void add_cell(int i, int j, int k) {
        const bool odd = (i + j + k) % 2 != 0;
        const auto corner = [&](int bits) {
            const int x = odd ? 1 - (bits & 1) : bits & 1;
            return index(i + x, j + (bits >> 1 & 1), k + (bits >> 2 & 1));
        };
        constexpr std::array<std::array<int, 4>, 5> kParts{
            {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}, {1, 2, 4, 7}}};
        for (const auto& p : kParts) {
            SoftTetrahedron t{corner(p[0]), corner(p[1]), corner(p[2]), corner(p[3])};
            const Vec3 a = out_.nodes[t[0]].position;
            const Vec3 b = out_.nodes[t[1]].position - a;
            const Vec3 c = out_.nodes[t[2]].position - a;
            if (b.cross(c).dot(out_.nodes[t[3]].position - a) < 0.0F) {
                std::swap(t[2], t[3]);
            }
            out_.tetrahedra.push_back(t);
        }
    }

    /// In the tetrahedron whose least barycentric weight is the largest.
    SoftVertex embed(const Vec3& p) const {
        SoftVertex best;
        float inside = -INFINITY;
        for (const SoftTetrahedron& t : out_.tetrahedra) {
            const Vec3 a = out_.nodes[t[0]].position;
            Mat3 edges;
            edges << out_.nodes[t[1]].position - a, out_.nodes[t[2]].position - a,
                out_.nodes[t[3]].position - a;
            const Vec3 w = edges.inverse() * (p - a);
            const float least = std::min(w.minCoeff(), 1.0F - w.sum());
            if (least > inside) {
                inside = least;
                best.node = t;
                best.weight = {1.0F - w.sum(), w.x(), w.y(), w.z()};
            }
        }
        return best;
    }

    void add_vertices() {
        const int n = std::max(def_.drawn, 2);
        for (int side = 0; side < 6; ++side) {
            const int axis = side / 2;
            for (int c = 0; c < n * n; ++c) {
                Vec3 at;
                at[axis] = side % 2 == 0 ? -0.5F : 0.5F;
                at[(axis + 1) % 3] = static_cast<float>(c % n) / static_cast<float>(n - 1) - 0.5F;
                at[(axis + 2) % 3] = static_cast<float>(c / n) / static_cast<float>(n - 1) - 0.5F;
                out_.vertices.push_back(embed(def_.centre + def_.size.cwiseProduct(at)));
            }
        }
    }

    const JellyDef& def_;
    SoftDef out_;
};

/// The middle of an edge of the sphere's triangles, made once.
std::uint32_t middle(std::vector<Vec3>& points,
                     std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t>& made,
                     std::uint32_t a,
                     std::uint32_t b) {
    const auto [it, fresh] =
        made.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(points.size()));
    if (fresh) {
        points.push_back((points[a] + points[b]).normalized());
    }
    return it->second;
}

/// Unit sphere from an icosahedron.
void make_sphere(int splits, std::vector<Vec3>& points, std::vector<SoftFace>& faces) {
    const float g = 0.5F * (1.0F + std::sqrt(5.0F));
    points = {{-1, g, 0},
              {1, g, 0},
              {-1, -g, 0},
              {1, -g, 0},
              {0, -1, g},
              {0, 1, g},
              {0, -1, -g},
              {0, 1, -g},
              {g, 0, -1},
              {g, 0, 1},
              {-g, 0, -1},
              {-g, 0, 1}};
    for (Vec3& p : points) {
        p.normalize();
    }
    faces = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
             {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
             {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    for (int i = 0; i < splits; ++i) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> made;
        std::vector<SoftFace> finer;
        for (const SoftFace& f : faces) {
            const std::uint32_t a = middle(points, made, f[0], f[1]);
            const std::uint32_t b = middle(points, made, f[1], f[2]);
            const std::uint32_t c = middle(points, made, f[2], f[0]);
            finer.insert(finer.end(), {{f[0], a, c}, {f[1], b, a}, {f[2], c, b}, {a, b, c}});
        }
        faces = std::move(finer);
    }
}

}  // namespace

core::Result<SoftDef> build_jelly(const JellyDef& def) {
    for (const int n : def.nodes) {
        if (n < 2 || n > 256) {
            return refused("jelly: number of nodes along a side out of range");
        }
    }
    if (def.drawn < 0 || def.drawn > 256) {
        return refused("jelly: number of drawn vertices out of range");
    }
    return checked(JellyBuilder(def).build(), "jelly");
}

core::Result<SoftDef> build_balloon(const BalloonDef& def) {
    if (def.splits < 0 || def.splits > 6) {
        return refused("balloon: splits out of range");
    }
    std::vector<Vec3> points;
    SoftDef out;
    make_sphere(def.splits, points, out.faces);
    for (const Vec3& p : points) {
        SoftNode node;
        node.position = def.centre + def.radius * p;
        node.mass = def.mass / static_cast<float>(points.size());
        out.nodes.push_back(node);
    }
    for (const SoftFace& f : out.faces) {
        for (std::size_t i = 0; i < 3; ++i) {
            // Each edge once: it runs upwards in one of its two faces.
            if (f[i] < f[(i + 1) % 3]) {
                link(out,
                     f[i],
                     f[(i + 1) % 3],
                     def.stiffness,
                     def.damping_share,
                     SpringKind::kStructural);
            }
        }
    }
    out.material.gas_pressure = def.gas_pressure;
    return checked(std::move(out), "balloon");
}

}  // namespace zoned::physics::soft
