#include "server/physics/soft/builders/mesh_simplifier.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <queue>
#include <set>
#include <tuple>
#include <utility>

namespace zoned::physics::soft {

namespace {

/// A distance off the surface counts as ten times as long as one along it.
constexpr double kOffSurface = 100.0;

/// Triangles as slender as this are made only of those that were so already; an equilateral one
/// has 1.
constexpr double kSlender = 0.2;

/// Cosine of the largest turn of a triangle.
constexpr double kMostTurn = 0.2;

class EdgeCollapse {
  public:
    EdgeCollapse(std::span<const Vec3> vertices,
                 std::span<const SoftFace> faces,
                 const std::vector<bool>& stays)
        : faces_(faces.begin(), faces.end()),
          there_(faces.size(), true),
          around_(vertices.size()),
          area_(vertices.size(), 0.0),
          quadric_(vertices.size(), Eigen::Matrix4d::Zero()),
          stays_(stays),
          rim_(vertices.size(), false),
          version_(vertices.size(), 0),
          onto_(vertices.size()),
          waiting_(vertices.size()),
          left_(vertices.size()) {
        // About a point nearby the quadrics keep their digits.
        for (std::uint32_t v = 0; v < vertices.size(); ++v) {
            place_.push_back((vertices[v] - vertices[0]).cast<double>());
            onto_[v] = v;
        }
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            add_face(f);
        }
        find_rims();
        for (std::uint32_t v = 0; v < vertices.size(); ++v) {
            stays_[v] = stays_[v] || is_pinched(v);
        }
        for (std::uint32_t v = 0; v < vertices.size(); ++v) {
            push_edges(v);
        }
    }

    void run(std::size_t most) {
        Candidate last{};  // none goes from a vertex to itself
        while (left_ > most && !queue_.empty()) {
            const Candidate next = queue_.top();
            queue_.pop();
            // One that waited at both its ends comes twice, one after the other.
            if (next == std::exchange(last, next) || onto_[next.from] != next.from ||
                onto_[next.to] != next.to || next.version != version_of(next.from, next.to)) {
                continue;
            }
            if (may_go(next.from, next.to)) {
                collapse(next.from, next.to);
            } else {
                waiting_[next.from].push_back(next);
                waiting_[next.to].push_back(next);
            }
        }
    }

    [[nodiscard]] SimplifiedMesh result() {
        SimplifiedMesh out;
        std::vector<std::uint32_t> number(onto_.size());
        for (std::uint32_t v = 0; v < onto_.size(); ++v) {
            if (onto_[v] == v) {
                number[v] = static_cast<std::uint32_t>(out.kept.size());
                out.kept.push_back(v);
            }
        }
        for (std::uint32_t v = 0; v < onto_.size(); ++v) {
            std::uint32_t root = v;
            while (onto_[root] != root) {
                root = onto_[root];
            }
            onto_[v] = root;  // shortens the chains of those that come later
            out.into.push_back(number[root]);
        }
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            if (there_[f]) {
                const SoftFace& c = faces_[f];
                out.faces.push_back({number[c[0]], number[c[1]], number[c[2]]});
            }
        }
        return out;
    }

  private:
    struct Candidate {
        double cost;  ///< m4
        std::uint32_t from, to;
        std::uint32_t version;

        bool operator==(const Candidate&) const = default;

        bool operator<(const Candidate& other) const {  // the top of a queue is its largest
            return std::tie(other.cost, other.from, other.to, other.version) <
                   std::tie(cost, from, to, version);
        }
    };

    [[nodiscard]] Vec3d cross_of(const SoftFace& f) const {
        return (place_[f[1]] - place_[f[0]]).cross(place_[f[2]] - place_[f[0]]);
    }

    /// Squared distances from a plane, as often as `weight` says.
    void add_plane(std::uint32_t v, const Vec3d& normal, double weight) {
        Eigen::Vector4d plane;
        plane << normal, -normal.dot(place_[v]);
        quadric_[v] += weight * plane * plane.transpose();
    }

    void add_face(std::uint32_t f) {
        const Vec3d cross = cross_of(faces_[f]);
        const double third = cross.norm() / 6.0;
        for (const std::uint32_t v : faces_[f]) {
            around_[v].push_back(f);
            area_[v] += third;
            add_plane(v, cross.normalized(), third);
        }
    }

    /// Planes upright on the rim keep its corners.
    void find_rims() {
        for (const SoftFace& f : faces_) {
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t a = f[i];
                const std::uint32_t b = f[(i + 1) % 3];
                if (faces_at(a, b).second == 1) {
                    const Vec3d along = place_[b] - place_[a];
                    const Vec3d upright = along.cross(cross_of(f)).normalized();
                    for (const std::uint32_t v : {a, b}) {
                        rim_[v] = true;
                        add_plane(v, upright, along.squaredNorm());
                    }
                }
            }
        }
    }

    /// The faces at an edge, and how many: at most two.
    [[nodiscard]] std::pair<std::array<std::uint32_t, 2>, std::size_t> faces_at(
        std::uint32_t a,
        std::uint32_t b) const {
        std::pair<std::array<std::uint32_t, 2>, std::size_t> out{};
        const bool fewer = around_[a].size() <= around_[b].size();
        const std::uint32_t other = fewer ? b : a;
        for (const std::uint32_t f : around_[fewer ? a : b]) {
            if (std::find(faces_[f].begin(), faces_[f].end(), other) != faces_[f].end()) {
                out.first[out.second++] = f;
                if (out.second == 2) {
                    break;
                }
            }
        }
        return out;
    }

    [[nodiscard]] std::vector<std::uint32_t> neighbours(std::uint32_t v) const {
        std::vector<std::uint32_t> out;
        for (const std::uint32_t f : around_[v]) {
            for (const std::uint32_t c : faces_[f]) {
                if (c != v) {
                    out.push_back(c);
                }
            }
        }
        std::sort(out.begin(), out.end());
        out.erase(std::unique(out.begin(), out.end()), out.end());
        return out;
    }

    /// Whether the surface meets itself in this vertex alone: its faces are more than one fan.
    [[nodiscard]] bool is_pinched(std::uint32_t v) const {
        // A closed fan has as many neighbours as faces, an open one has one more.
        const std::size_t fans_open = neighbours(v).size() - around_[v].size();
        if (around_[v].empty() || fans_open > 1) {
            return true;
        }
        std::vector<std::uint32_t> fan{around_[v].front()};
        std::set<std::uint32_t> seen(fan.begin(), fan.end());
        for (std::size_t i = 0; i < fan.size(); ++i) {
            for (const std::uint32_t c : faces_[fan[i]]) {
                const auto [faces, count] = faces_at(v, c);
                for (std::size_t k = 0; c != v && k < count; ++k) {
                    if (seen.insert(faces[k]).second) {
                        fan.push_back(faces[k]);
                    }
                }
            }
        }
        return fan.size() != around_[v].size();
    }

    [[nodiscard]] std::uint32_t version_of(std::uint32_t a, std::uint32_t b) const {
        return version_[a] + version_[b];
    }

    void push(std::uint32_t from, std::uint32_t to) {
        if (stays_[from] || (rim_[from] && !rim_[to])) {
            return;
        }
        Eigen::Vector4d at;
        at << place_[to], 1.0;
        const double off = at.dot((quadric_[from] + quadric_[to]) * at);
        const double cost = area_[from] * (place_[to] - place_[from]).squaredNorm() +
                            kOffSurface * std::max(off, 0.0);
        queue_.push({cost, from, to, version_of(from, to)});
    }

    /// Both ways; those of lower neighbours come with these.
    void push_edges(std::uint32_t v, bool all = false) {
        for (const std::uint32_t n : neighbours(v)) {
            if (all || n > v) {
                push(v, n);
                push(n, v);
            }
        }
    }

    [[nodiscard]] bool may_go(std::uint32_t from, std::uint32_t to) const {
        const auto [faces, count] = faces_at(from, to);
        if (rim_[from] && rim_[to] && count == 2) {
            return false;  // its ends would pinch the surface
        }
        const std::vector<std::uint32_t> a = neighbours(from);
        const std::vector<std::uint32_t> b = neighbours(to);
        std::vector<std::uint32_t> common;
        std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
        return count > 0 && common.size() == count && leaves_faces(from, to, common) &&
               std::all_of(around_[from].begin(), around_[from].end(), [&](std::uint32_t f) {
                   return may_move(f, from, to);
               });
    }

    /// Whether edges from `to` that two faces shared with `from` still have a face.
    [[nodiscard]] bool leaves_faces(std::uint32_t from,
                                    std::uint32_t to,
                                    const std::vector<std::uint32_t>& apexes) const {
        return std::all_of(apexes.begin(), apexes.end(), [&](std::uint32_t apex) {
            return faces_at(from, apex).second + faces_at(to, apex).second > 2;
        });
    }

    /// Whether a face may have `to` in place of `from`.
    [[nodiscard]] bool may_move(std::uint32_t f, std::uint32_t from, std::uint32_t to) const {
        SoftFace face = faces_[f];
        if (std::find(face.begin(), face.end(), to) != face.end()) {
            return true;  // goes with the edge
        }
        const double before = slenderness(face);
        const Vec3d normal = cross_of(face).normalized();
        std::replace(face.begin(), face.end(), from, to);
        for (const std::uint32_t other : around_[to]) {
            if (std::is_permutation(face.begin(), face.end(), faces_[other].begin())) {
                return false;  // there already
            }
        }
        return slenderness(face) >= std::min(before, kSlender) &&
               cross_of(face).normalized().dot(normal) >= kMostTurn;
    }

    [[nodiscard]] double slenderness(const SoftFace& f) const {
        const double sides = (place_[f[1]] - place_[f[0]]).squaredNorm() +
                             (place_[f[2]] - place_[f[1]]).squaredNorm() +
                             (place_[f[0]] - place_[f[2]]).squaredNorm();
        return 2.0 * std::sqrt(3.0) * cross_of(f).norm() / sides;
    }

    void collapse(std::uint32_t from, std::uint32_t to) {
        const std::vector<std::uint32_t> ring = neighbours(from);
        for (const std::uint32_t f : around_[from]) {
            SoftFace& face = faces_[f];
            if (std::find(face.begin(), face.end(), to) != face.end()) {
                there_[f] = false;
                for (const std::uint32_t c : face) {
                    if (c != from) {
                        std::erase(around_[c], f);
                    }
                }
            } else {
                std::replace(face.begin(), face.end(), from, to);
                around_[to].push_back(f);
            }
        }
        around_[from].clear();
        onto_[from] = to;
        area_[to] += area_[from];
        quadric_[to] += quadric_[from];
        ++version_[to];
        --left_;
        push_edges(to, true);
        for (const std::uint32_t v : ring) {  // they may be free now
            for (const Candidate& candidate : std::exchange(waiting_[v], {})) {
                queue_.push(candidate);
            }
        }
    }

    std::vector<Vec3d> place_;
    std::vector<SoftFace> faces_;
    std::vector<bool> there_;                         // of each face
    std::vector<std::vector<std::uint32_t>> around_;  // faces of each vertex
    std::vector<double> area_;                        // for which a vertex stands, m2
    std::vector<Eigen::Matrix4d> quadric_;
    std::vector<bool> stays_;
    std::vector<bool> rim_;
    std::vector<std::uint32_t> version_;
    std::vector<std::uint32_t> onto_;
    std::vector<std::vector<Candidate>> waiting_;  // could not go as things were
    std::priority_queue<Candidate> queue_;
    std::size_t left_;
};

}  // namespace

SimplifiedMesh simplify_mesh(std::span<const Vec3> vertices,
                             std::span<const SoftFace> faces,
                             const std::vector<bool>& stays,
                             std::size_t most) {
    EdgeCollapse collapse(vertices, faces, stays);
    collapse.run(most);
    return collapse.result();
}

}  // namespace zoned::physics::soft
