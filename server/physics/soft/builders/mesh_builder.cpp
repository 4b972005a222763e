#include "server/physics/soft/builders/mesh_builder.h"

#include "server/physics/shapes/mesh.h"
#include "server/physics/shapes/ranges.h"
#include "server/physics/soft/builders/mesh_hanging.h"
#include "server/physics/soft/builders/mesh_simplifier.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace zoned::physics::soft {

namespace {

core::Result<SoftDef> mesh_refused(const std::string& reason) {
    return core::Result<SoftDef>::failure("mesh: " + reason);
}

/// Two nodes, the lower first.
using Link = std::pair<std::uint32_t, std::uint32_t>;

/// One side of an edge: a face that runs along it.
struct FaceSide {
    std::uint32_t low, high;  ///< vertices of the edge
    std::uint32_t face;
    std::uint32_t apex;  ///< vertex of the face that is not on the edge
    bool upward;         ///< runs from low to high
};

/// Sides of one edge follow each other.
std::vector<FaceSide> sides_of(std::span<const SoftFace> faces) {
    std::vector<FaceSide> out;
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        for (std::size_t i = 0; i < 3; ++i) {
            const auto [low, high] = std::minmax(faces[f][i], faces[f][(i + 1) % 3]);
            out.push_back({low, high, f, faces[f][(i + 2) % 3], faces[f][i] == low});
        }
    }
    std::sort(out.begin(), out.end(), [](const FaceSide& a, const FaceSide& b) {
        return std::tie(a.low, a.high, a.face) < std::tie(b.low, b.high, b.face);
    });
    return out;
}

/// Calls visit(sides of one edge) for each; ends at the first that gives false.
template <class Visit>
void for_each_edge(std::span<const FaceSide> sides, Visit&& visit) {
    while (!sides.empty()) {
        std::size_t count = 1;
        while (count < sides.size() && sides[count].low == sides[0].low &&
               sides[count].high == sides[0].high) {
            ++count;
        }
        if (!visit(sides.first(count))) {
            return;
        }
        sides = sides.subspan(count);
    }
}

/// The welded mesh, and where its triangles stand for messages.
struct Welded {
    std::vector<Vec3> vertices;
    std::vector<SoftFace> faces;
    std::span<const std::uint32_t> lines;

    [[nodiscard]] std::string at(std::uint32_t face, const std::string& reason) const {
        return (lines.empty() ? "triangle " + std::to_string(face)
                              : "line " + std::to_string(lines[face])) +
               ": " + reason;
    }
};

std::string why_unfit_numbers(const MeshBodyDef& def) {
    const auto positive = [](float value, float most) {
        return value > 0.0F && value <= most;
    };
    if (!positive(def.mass, kMaxMass)) {
        return "mass not positive or out of range";
    }
    if (!positive(def.stiffness, 1.0e9F) ||
        !(def.bend_stiffness == 0.0F || positive(def.bend_stiffness, 1.0e9F))) {
        return "stiffness not positive or out of range";
    }
    if (def.nodes != 0 && def.nodes < 3) {
        return "nodes: a surface has at least 3";
    }
    if (!def.lines.empty() && 3 * def.lines.size() != def.indices.size()) {
        return "as many lines as triangles are asked for";
    }
    return {};
}

/// Edges of more than two triangles have no side for gas and bodies to press on, and what nothing
/// joins would fall apart while it had one position.
std::string why_unjoined(const Welded& mesh, std::span<const FaceSide> sides) {
    std::string reason;
    std::vector<std::uint32_t> part(mesh.vertices.size());
    std::iota(part.begin(), part.end(), 0U);
    const auto root = [&](std::uint32_t v) {
        while (part[v] != v) {
            v = part[v] = part[part[v]];
        }
        return v;
    };
    for_each_edge(sides, [&](std::span<const FaceSide> edge) {
        if (edge.size() > 2) {
            reason = mesh.at(edge[2].face, "an edge has more than two triangles");
        }
        part[std::max(root(edge[0].low), root(edge[0].high))] =
            std::min(root(edge[0].low), root(edge[0].high));
        return reason.empty();
    });
    for (std::uint32_t f = 0; reason.empty() && f < mesh.faces.size(); ++f) {
        if (root(mesh.faces[f][0]) != root(mesh.faces[0][0])) {
            reason = mesh.at(f, "nothing joins the triangle to the first one: a body is one part");
        }
    }
    return reason;
}

std::string why_not_closed(const Welded& mesh, std::span<const FaceSide> sides) {
    std::string reason;
    for_each_edge(sides, [&](std::span<const FaceSide> edge) {
        if (edge.size() == 1) {
            reason = mesh.at(edge[0].face, "gas needs a closed surface: it has an open edge");
        } else if (edge[0].upward == edge[1].upward) {
            reason = mesh.at(edge[1].face,
                             "gas needs a surface that faces outward: it and its neighbour face in "
                             "opposite directions");
        }
        return reason.empty();
    });
    double volume = 0.0;
    const Vec3d middle = mesh.vertices[0].cast<double>();
    for (const SoftFace& f : mesh.faces) {
        const Vec3d a = mesh.vertices[f[0]].cast<double>() - middle;
        const Vec3d b = mesh.vertices[f[1]].cast<double>() - middle;
        const Vec3d c = mesh.vertices[f[2]].cast<double>() - middle;
        volume += a.dot(b.cross(c)) / 6.0;
    }
    return reason.empty() && volume < 0.0 ? "gas needs a surface that faces outward: all triangles "
                                            "face inward"
                                          : reason;
}

/// For each vertex, whether it is pinned; the mistake where a pin holds none.
core::Result<std::vector<bool>> pinned_of(const MeshBodyDef& def, const Welded& mesh) {
    std::vector<bool> out(mesh.vertices.size(), false);
    for (std::size_t p = 0; p < def.pins.size(); ++p) {
        bool any = false;
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
            const bool held = (mesh.vertices[v] - def.pins[p].centre).norm() <= def.pins[p].radius;
            out[v] = out[v] || held;
            any = any || held;
        }
        if (!any) {
            return core::Result<std::vector<bool>>::failure("pin " + std::to_string(p + 1) +
                                                            " holds no vertex");
        }
    }
    return out;
}

double area_of(const SoftFace& f, std::span<const Vec3> at) {
    const Vec3d a = at[f[0]].cast<double>();
    return 0.5 * (at[f[1]].cast<double>() - a).cross(at[f[2]].cast<double>() - a).norm();
}

class MeshBuilder {
  public:
    MeshBuilder(const MeshBodyDef& def, const Welded& mesh, const std::vector<bool>& pinned)
        : def_(def),
          mesh_(mesh),
          pinned_(pinned),
          mass_(masses()) {}

    core::Result<SoftDef> build() {
        const std::size_t all = mesh_.vertices.size();
        const std::size_t most = def_.nodes == 0 ? all : static_cast<std::size_t>(def_.nodes);
        if (most >= all) {
            for (std::uint32_t v = 0; v < all; ++v) {
                add_node(v, mass_[v]);
            }
            out_.faces = mesh_.faces;
        } else {
            const SimplifiedMesh coarse = simplify_mesh(mesh_.vertices, mesh_.faces, pinned_, most);
            if (coarse.kept.size() > most) {
                return mesh_refused("it cannot be drawn together to " + std::to_string(most) +
                                    " nodes, only to " + std::to_string(coarse.kept.size()) +
                                    ": pins and what joins it stay");
            }
            if (!hang_on(coarse)) {
                return mesh_refused(std::to_string(most) +
                                    " nodes are too few to keep its centre of mass");
            }
        }
        add_springs();
        out_.material.gas_pressure = def_.gas_pressure;
        return std::move(out_);
    }

  private:
    [[nodiscard]] std::vector<double> masses() const {
        std::vector<double> out(mesh_.vertices.size(), 0.0);
        double whole = 0.0;
        for (const SoftFace& f : mesh_.faces) {
            const double a = area_of(f, mesh_.vertices);
            whole += a;
            for (const std::uint32_t v : f) {
                out[v] += a / 3.0;
            }
        }
        for (double& m : out) {
            m *= static_cast<double>(def_.mass) / whole;
        }
        return out;
    }

    void add_node(std::uint32_t vertex, double mass) {
        SoftNode node;
        node.position = mesh_.vertices[vertex];
        node.mass = static_cast<float>(mass);
        node.pinned = pinned_[vertex];
        out_.nodes.push_back(node);
        places_.push_back(node.position);
    }

    /// False where no masses above zero keep the centre of mass.
    bool hang_on(const SimplifiedMesh& coarse) {
        const HungMesh hung = hang_mesh(mesh_.vertices, coarse);
        std::vector<double> mass(coarse.kept.size(), 0.0);
        Vec3d centre = Vec3d::Zero();
        for (std::size_t v = 0; v < mass_.size(); ++v) {
            for (std::size_t k = 0; k < 3; ++k) {
                mass[hung.vertices[v].node[k]] += mass_[v] * hung.mass_shares[v][k];
            }
            centre += mass_[v] * mesh_.vertices[v].cast<double>();
        }
        centre /= std::accumulate(mass_.begin(), mass_.end(), 0.0);
        std::vector<Vec3d> at;
        for (const std::uint32_t v : coarse.kept) {
            at.push_back(mesh_.vertices[v].cast<double>());
        }
        if (!move_centre(at, centre, mass)) {
            return false;
        }
        for (std::size_t n = 0; n < mass.size(); ++n) {
            add_node(coarse.kept[n], mass[n]);
        }
        out_.faces = coarse.faces;
        out_.vertices = hung.vertices;
        out_.drawn_faces = mesh_.faces;
        return true;
    }

    void add_spring(std::uint32_t a, std::uint32_t b, double stiffness, SpringKind kind) {
        SoftSpring s;
        s.a = a;
        s.b = b;
        s.rest = (out_.nodes[b].position - out_.nodes[a].position).norm();
        s.stiffness = static_cast<float>(stiffness);
        const auto drawn = static_cast<double>(mesh_.vertices.size());
        const double mass = static_cast<double>(std::min(out_.nodes[a].mass, out_.nodes[b].mass)) *
                            static_cast<double>(out_.nodes.size()) / drawn;
        s.damping = static_cast<float>(2.0 * static_cast<double>(def_.damping_share) *
                                       std::sqrt(0.5 * stiffness * mass));
        s.kind = kind;
        out_.springs.push_back(s);
    }

    /// Area of the faces at an edge over the square of a length between two nodes.
    [[nodiscard]] double share_of(std::span<const FaceSide> edge, const Link& ends) const {
        double area = 0.0;
        for (const FaceSide& side : edge) {
            area += area_of(out_.faces[side.face], places_);
        }
        return area /
               static_cast<double>((places_[ends.second] - places_[ends.first]).squaredNorm());
    }

    void add_springs() {
        const std::vector<FaceSide> sides = sides_of(out_.faces);
        std::vector<Link> edges;
        for_each_edge(sides, [&](std::span<const FaceSide> edge) {
            const Link& ends = edges.emplace_back(edge[0].low, edge[0].high);
            const auto stiffness = static_cast<double>(def_.stiffness) * share_of(edge, ends);
            add_spring(ends.first, ends.second, stiffness, SpringKind::kStructural);
            return true;
        });
        if (def_.bend_stiffness > 0.0F) {
            add_bend_springs(sides, edges);
        }
    }

    /// Once between two nodes, and none where an edge joins them.
    void add_bend_springs(std::span<const FaceSide> sides, const std::vector<Link>& edges) {
        std::vector<std::pair<Link, double>> across;
        for_each_edge(sides, [&](std::span<const FaceSide> edge) {
            if (edge.size() == 2) {
                const Link ends = std::minmax(edge[0].apex, edge[1].apex);
                // Corners of two triangles folded onto each other have no length between them.
                if ((places_[ends.second] - places_[ends.first]).norm() > 1.0e-6F &&
                    !std::binary_search(edges.begin(), edges.end(), ends)) {
                    across.emplace_back(ends, std::min(1.0, share_of(edge, ends)));
                }
            }
            return true;
        });
        std::sort(across.begin(), across.end());
        for (std::size_t i = 0; i < across.size(); ++i) {
            const auto& [ends, share] = across[i];
            if (i == 0 || ends != across[i - 1].first) {
                add_spring(ends.first,
                           ends.second,
                           static_cast<double>(def_.bend_stiffness) * share,
                           SpringKind::kBend);
            }
        }
    }

    const MeshBodyDef& def_;
    const Welded& mesh_;
    const std::vector<bool>& pinned_;
    std::vector<double> mass_;  // of each vertex, kg
    std::vector<Vec3> places_;  // of the nodes
    SoftDef out_;
};

}  // namespace

core::Result<SoftDef> build_mesh_body(const MeshBodyDef& def) {
    if (std::string reason = why_unfit_numbers(def); !reason.empty()) {
        return mesh_refused(reason);
    }
    const auto built = build_mesh(def.vertices, def.indices, {def.weld});
    if (!built) {
        return core::Result<SoftDef>::failure(built.error());
    }
    const auto& tables = built->mesh->tables();
    const Welded mesh{tables.vertices, tables.corners, def.lines};
    if (built->degenerate > 0) {
        return mesh_refused(mesh.at(built->first_degenerate, "the triangle has no area"));
    }
    if (built->repeated > 0) {
        return mesh_refused(mesh.at(built->first_repeated, "the triangle is there already"));
    }
    if (mesh.vertices.size() > kMostMeshVertices) {
        return mesh_refused(std::to_string(mesh.vertices.size()) + " vertices are more than " +
                            std::to_string(kMostMeshVertices));
    }
    const std::vector<FaceSide> sides = sides_of(mesh.faces);
    std::string reason = why_unjoined(mesh, sides);
    if (reason.empty() && def.gas_pressure > 0.0F) {
        reason = why_not_closed(mesh, sides);
    }
    if (!reason.empty()) {
        return mesh_refused(reason);
    }
    const auto pinned = pinned_of(def, mesh);
    if (!pinned) {
        return mesh_refused(pinned.error());
    }
    auto out = MeshBuilder(def, mesh, *pinned).build();
    if (out) {
        if (std::string why = why_unfit(*out); !why.empty()) {
            return mesh_refused(why);
        }
    }
    return out;
}

}  // namespace zoned::physics::soft
