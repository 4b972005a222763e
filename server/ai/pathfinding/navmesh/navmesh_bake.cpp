#include "server/ai/pathfinding/grid/door_cells.h"
#include "server/ai/pathfinding/navmesh/navmesh.h"
#include "server/ai/pathfinding/navmesh/navmesh_layers.h"
#include "server/ai/pathfinding/navmesh/recast_owned.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

constexpr float kContourError = 1.3F;  // as in Recast's demonstration
/// Heights within polygons are sampled every so many cells, and kept to within so much, m.
constexpr float kReliefCells = 4.0F;
constexpr float kReliefError_m = 0.2F;
constexpr int kMinRegion = 8;
constexpr int kMergeRegion = 20;
/// The most floors of a column that Recast links.
constexpr int kMostLayers = RC_NOT_CONNECTED - 1;
constexpr std::array<int, 4> kBesideX{-1, 0, 1, 0};  // in Recast's order of directions
constexpr std::array<int, 4> kBesideZ{0, 1, 0, -1};

/// A floor that is not there, or is alone there, while a door is shut.
struct TurnedFloor {
    std::uint32_t column = 0;
    NavmeshFloor floor;
    std::uint32_t door = 0;
    bool taken = false;  ///< else given

    [[nodiscard]] auto key() const { return std::tuple(column, floor.y, !taken, door); }
};

/// All floors that there are in some state of the doors, by column, with their gates.
struct GatedFloors {
    std::vector<std::uint32_t> first;
    std::vector<NavmeshFloor> floors;
    std::vector<std::uint32_t> gate;
};

}  // namespace

/// From static geometry to polygons, step by step.
class NavmeshBaker {
  public:
    NavmeshBaker(const motion::StaticGeometry& world,
                 const motion::CharacterLimits& limits,
                 const FloorFrame& frame)
        : world_(world),
          limits_(limits),
          frame_(frame) {}

    NavmeshBaker(const NavmeshBaker&) = delete;
    NavmeshBaker& operator=(const NavmeshBaker&) = delete;

    ~NavmeshBaker() {
        // These are not Recast's to free.
        compact_->cells = nullptr;
        compact_->spans = nullptr;
        compact_->areas = nullptr;
    }

    core::Result<Navmesh> run() {
        using R = core::Result<Navmesh>;
        const auto open = navmesh_layers(world_, limits_, frame_);
        if (!open) {
            return R::failure(open.error());
        }
        const float reach = door_reach(limits_, frame_.grid.cell_m());
        for (const std::vector<std::uint32_t>& group : doors_apart(world_, reach)) {
            const auto shut = navmesh_layers(world_.with_shut(group), limits_, frame_);
            if (!shut) {
                return R::failure(shut.error());
            }
            for (const std::uint32_t door : group) {
                compare(*open, *shut, door, grown_door(world_, door, reach));
            }
        }
        put_together(*open);
        if (all_.floors.size() >= (1U << 24U)) {
            return R::failure("more floors than Recast counts");
        }
        if (!make_compact() || !colour_gates()) {
            return R::failure(
                "more floors over each other, or doors beside each other, than "
                "Recast tells apart");
        }
        return polygons();
    }

  private:
    /// Floors that a door takes or gives, near it.
    void compare(const NavmeshLayers& open,
                 const NavmeshLayers& shut,
                 std::uint32_t door,
                 const Aabb& near) {
        const GroundGrid& g = frame_.grid;
        const float right = g.min_x() + static_cast<float>(g.width()) * g.cell_m();
        const float below = g.min_z() + static_cast<float>(g.height()) * g.cell_m();
        if (near.lower.x() > right || near.lower.z() > below || near.upper.x() < g.min_x() ||
            near.upper.z() < g.min_z()) {
            return;
        }
        const Cell first = g.cell({near.lower.x(), near.lower.z()});
        const Cell last = g.cell({near.upper.x(), near.upper.z()});
        for (std::uint32_t z = first.y; z <= last.y; ++z) {
            for (std::uint32_t x = first.x; x <= last.x; ++x) {
                const std::uint32_t c = z * static_cast<std::uint32_t>(g.width()) + x;
                note_missing(open.column(c), shut.column(c), {c, {}, door, true});
                note_missing(shut.column(c), open.column(c), {c, {}, door, false});
            }
        }
    }

    /// Notes the floors of a column that are missing among others; a floor one step higher or lower
    /// is the same.
    void note_missing(std::span<const NavmeshFloor> floors,
                      std::span<const NavmeshFloor> others,
                      TurnedFloor turned) {
        for (const NavmeshFloor& f : floors) {
            const bool there =
                std::any_of(others.begin(), others.end(), [&](const NavmeshFloor& o) {
                    return std::abs(int{o.y} - int{f.y}) <= frame_.climb_steps;
                });
            if (!there) {
                turned.floor = f;
                turned_.push_back(turned);
            }
        }
    }

    void put_together(const NavmeshLayers& open) {
        std::sort(turned_.begin(), turned_.end(), [](const TurnedFloor& a, const TurnedFloor& b) {
            return a.key() < b.key();
        });
        std::size_t next = 0;
        const std::size_t columns = open.first.size() - 1;
        all_.first.reserve(columns + 1);
        all_.first.push_back(0);
        for (std::uint32_t c = 0; c < columns; ++c) {
            const std::span<const NavmeshFloor> there = open.column(c);
            std::size_t o = 0;
            while (o < there.size() || (next < turned_.size() && turned_[next].column == c)) {
                const bool turns = next < turned_.size() && turned_[next].column == c;
                const bool is_open =
                    o < there.size() && (!turns || there[o].y <= turned_[next].floor.y);
                const NavmeshFloor floor = is_open ? there[o++] : turned_[next].floor;
                all_.floors.push_back(floor);
                all_.gate.push_back(gate_of(c, floor, is_open, next));
            }
            all_.first.push_back(static_cast<std::uint32_t>(all_.floors.size()));
        }
    }

    /// The gate of a floor with all doors that turn it, which begin at `next`.
    std::uint32_t gate_of(std::uint32_t column,
                          const NavmeshFloor& floor,
                          bool open,
                          std::size_t& next) {
        Navmesh::Gate gate;
        gate.open = open;
        for (; next < turned_.size() && turned_[next].column == column &&
               turned_[next].floor.y == floor.y;
             ++next) {
            (turned_[next].taken ? gate.takers : gate.givers).push_back(turned_[next].door);
        }
        if (gate == Navmesh::Gate()) {
            return 0;
        }
        const auto [at, is_new] =
            number_of_gate_.try_emplace(gate, static_cast<std::uint32_t>(gates_.size()));
        if (is_new) {
            gates_.push_back(gate);
        }
        return at->second;
    }

    /// Recast's own structure of all floors, linked as rcBuildCompactHeightfield() would.
    bool make_compact() {
        const GroundGrid& g = frame_.grid;
        rcCompactHeightfield& f = *compact_;
        const std::size_t count = all_.floors.size();
        const std::size_t columns = all_.first.size() - 1;
        f.width = g.width();
        f.height = g.height();
        f.spanCount = static_cast<int>(count);
        f.walkableHeight = frame_.height_steps;
        f.walkableClimb = frame_.climb_steps;
        f.cs = g.cell_m();
        f.ch = frame_.step_m;
        f.bmin[0] = g.min_x();
        f.bmin[1] = frame_.low_m;
        f.bmin[2] = g.min_z();
        f.bmax[0] = g.min_x() + g.cell_m() * static_cast<float>(g.width());
        f.bmax[1] = frame_.high_m;
        f.bmax[2] = g.min_z() + g.cell_m() * static_cast<float>(g.height());
        cells_.resize(columns);
        spans_.resize(count);
        regions_.resize(count);
        f.cells = cells_.data();
        f.spans = spans_.data();
        f.areas = regions_.data();
        for (std::size_t c = 0; c < columns; ++c) {
            const std::uint32_t layers = all_.first[c + 1] - all_.first[c];
            if (layers > static_cast<std::uint32_t>(kMostLayers)) {
                return false;
            }
            f.cells[c].index = all_.first[c] & 0xFFFFFFU;
            f.cells[c].count = layers & 0xFFU;
        }
        for (std::size_t i = 0; i < count; ++i) {
            f.spans[i].y = all_.floors[i].y;
            f.spans[i].h = all_.floors[i].room;
            f.spans[i].reg = 0;
            f.spans[i].con = 0;
        }
        for (int z = 0; z < f.height; ++z) {
            for (int x = 0; x < f.width; ++x) {
                link_column(x, z);
            }
        }
        return true;
    }

    void link_column(int x, int z) {
        rcCompactHeightfield& f = *compact_;
        const rcCompactCell& here = f.cells[x + z * f.width];
        for (unsigned i = here.index, end = i + here.count; i < end; ++i) {
            for (std::size_t d = 0; d < 4; ++d) {
                const int nx = x + kBesideX[d];
                const int nz = z + kBesideZ[d];
                int best = RC_NOT_CONNECTED;
                if (nx >= 0 && nz >= 0 && nx < f.width && nz < f.height) {
                    const rcCompactCell& there = f.cells[nx + nz * f.width];
                    const unsigned j = linked(i, there);
                    // Both ends agree, or there is no link.
                    if (j != kNoFloor && linked(j, here) == i) {
                        best = static_cast<int>(j - there.index);
                    }
                }
                rcSetCon(f.spans[i], static_cast<int>(d), best);
            }
        }
    }

    /// The floor of a column beside it that one steps to from a floor: the nearest in height.
    [[nodiscard]] unsigned linked(unsigned from, const rcCompactCell& column) const {
        const rcCompactHeightfield& f = *compact_;
        const rcCompactSpan& a = f.spans[from];
        unsigned best = kNoFloor;
        int least = frame_.climb_steps + 1;
        for (unsigned j = column.index, end = j + column.count; j < end; ++j) {
            const rcCompactSpan& b = f.spans[j];
            const int room = std::min<int>(a.y + a.h, b.y + b.h) - std::max<int>(a.y, b.y);
            const int off = std::abs(int{a.y} - int{b.y});
            if (room >= frame_.height_steps && off < least) {
                least = off;
                best = j;
            }
        }
        return best;
    }

    /// Recast keeps areas apart. It has few different areas, but only adjacent gates need different
    /// ones.
    bool colour_gates() {
        rcCompactHeightfield& f = *compact_;
        std::vector<std::set<std::uint32_t>> beside(gates_.size());
        for (int c = 0; c < f.width * f.height && gates_.size() > 1; ++c) {
            const rcCompactCell& cell = f.cells[c];
            for (unsigned i = cell.index, end = i + cell.count; i < end; ++i) {
                for (int d = 0; d < 4; ++d) {
                    const int link = rcGetCon(f.spans[i], d);
                    if (link == RC_NOT_CONNECTED) {
                        continue;
                    }
                    const auto at = static_cast<std::size_t>(d);
                    const unsigned j = f.cells[c + kBesideX[at] + kBesideZ[at] * f.width].index +
                                       static_cast<unsigned>(link);
                    if (all_.gate[i] != all_.gate[j]) {
                        beside[all_.gate[i]].insert(all_.gate[j]);
                    }
                }
            }
        }
        std::vector<unsigned char> colour(gates_.size(), RC_NULL_AREA);
        colour[0] = RC_WALKABLE_AREA;
        for (std::size_t g = 1; g < gates_.size(); ++g) {
            std::set<unsigned char> used;
            for (const std::uint32_t other : beside[g]) {
                used.insert(colour[other]);
            }
            unsigned char free = 1;
            while (used.count(free) != 0) {
                ++free;
            }
            if (free >= RC_WALKABLE_AREA) {
                return false;
            }
            colour[g] = free;
        }
        for (std::size_t i = 0; i < all_.floors.size(); ++i) {
            f.areas[i] = colour[all_.gate[i]];
        }
        return true;
    }

    core::Result<Navmesh> polygons() {
        using R = core::Result<Navmesh>;
        const bool built = rcBuildDistanceField(&context_, *compact_) &&
                           rcBuildRegions(&context_, *compact_, 0, kMinRegion, kMergeRegion) &&
                           rcBuildContours(&context_, *compact_, kContourError, 0, *contours_) &&
                           rcBuildPolyMesh(&context_, *contours_, Navmesh::kMostCorners, *mesh_);
        if (!built) {
            return R::failure("Recast can't build polygons of this ground");
        }
        std::map<unsigned short, std::uint32_t> gate_of_region;
        for (std::size_t i = 0; i < all_.floors.size(); ++i) {
            gate_of_region.try_emplace(compact_->spans[i].reg, all_.gate[i]);
        }
        Navmesh out;
        out.gates_ = gates_;
        // The body's width is kept to the end of the columns, rounded up, and contours may be off.
        out.rim_m_ =
            (static_cast<float>(frame_.radius_cells) + 2.0F + kContourError) * frame_.grid.cell_m();
        for (int i = 0; i < mesh_->nverts; ++i) {
            const unsigned short* v = mesh_->verts + std::ptrdiff_t{3} * i;
            out.vertices_.emplace_back(
                frame_.grid.min_x() + frame_.grid.cell_m() * static_cast<float>(v[0]),
                frame_.low_m + frame_.step_m * static_cast<float>(v[1]),
                frame_.grid.min_z() + frame_.grid.cell_m() * static_cast<float>(v[2]));
        }
        for (int i = 0; i < mesh_->npolys; ++i) {
            const unsigned short* p = mesh_->polys + std::ptrdiff_t{2} * Navmesh::kMostCorners * i;
            Navmesh::Polygon polygon;
            for (int k = 0; k < Navmesh::kMostCorners && p[k] != RC_MESH_NULL_IDX; ++k) {
                const unsigned short beyond = p[Navmesh::kMostCorners + k];
                polygon.corners[static_cast<std::size_t>(k)] = p[k];
                polygon.neighbours[static_cast<std::size_t>(k)] =
                    (beyond & 0x8000U) != 0 ? Navmesh::kNone : beyond;
                ++polygon.size;
            }
            polygon.gate = gate_of_region[mesh_->regs[i]];
            out.polygons_.push_back(polygon);
        }
        out.finish();
        if (!lay_relief(out)) {
            return R::failure("Recast can't build the heights of this ground");
        }
        return out;
    }

    /// Triangles over the floors of all polygons that are not flat.
    bool lay_relief(Navmesh& out) {
        const float apart = kReliefCells * frame_.grid.cell_m();
        if (out.polygons_.empty()) {
            return true;
        }
        if (!rcBuildPolyMeshDetail(&context_, *mesh_, *compact_, apart, kReliefError_m, *detail_)) {
            return false;
        }
        std::vector<std::uint32_t> first(1, 0);
        for (std::uint32_t p = 0; p < out.polygons_.size(); ++p) {
            if (!is_flat(out, p)) {
                const unsigned* part = detail_->meshes + std::ptrdiff_t{4} * p;
                for (unsigned t = part[2]; t < part[2] + part[3]; ++t) {
                    const unsigned char* corner = detail_->tris + std::ptrdiff_t{4} * t;
                    out.relief_.push_back({detail_at(part[0] + corner[0]),
                                           detail_at(part[0] + corner[1]),
                                           detail_at(part[0] + corner[2])});
                }
            }
            first.push_back(static_cast<std::uint32_t>(out.relief_.size()));
        }
        if (!out.relief_.empty()) {
            out.relief_first_ = std::move(first);
        }
        return true;
    }

    /// True if the corners of a polygon decide all heights over it.
    [[nodiscard]] bool is_flat(const Navmesh& out, std::uint32_t p) const {
        const unsigned* part = detail_->meshes + std::ptrdiff_t{4} * p;
        bool flat = true;
        for (unsigned v = part[0]; v < part[0] + part[1] && flat; ++v) {
            const Vec3 at = detail_at(v);
            flat = std::abs(out.nearest_on(p, at).y() - at.y()) <= frame_.step_m;
        }
        return flat;
    }

    /// Recast puts these a step above the floor.
    [[nodiscard]] Vec3 detail_at(unsigned v) const {
        const float* at = detail_->verts + std::ptrdiff_t{3} * v;
        return {at[0], at[1] - frame_.step_m, at[2]};
    }

    static constexpr unsigned kNoFloor = ~0U;

    const motion::StaticGeometry& world_;
    const motion::CharacterLimits& limits_;
    const FloorFrame& frame_;
    std::vector<TurnedFloor> turned_;
    GatedFloors all_;
    std::vector<Navmesh::Gate> gates_{1};
    std::map<Navmesh::Gate, std::uint32_t> number_of_gate_;
    std::vector<rcCompactCell> cells_;
    std::vector<rcCompactSpan> spans_;
    std::vector<unsigned char> regions_;
    rcContext context_{false};
    RecastFloors compact_{rcAllocCompactHeightfield()};
    RecastContours contours_{rcAllocContourSet()};
    RecastPolygons mesh_{rcAllocPolyMesh()};
    RecastDetail detail_{rcAllocPolyMeshDetail()};
};

std::string Navmesh::defect_of(const motion::StaticGeometry& world,
                               const motion::CharacterLimits& limits,
                               const GroundRect& area,
                               const NavmeshSettings& settings) {
    std::string defect = GroundGrid::defect_of(area, settings.cell_m);
    if (!defect.empty()) {
        return defect;
    }
    if (!(settings.cell_height_m > 0.0F)) {
        return "steps of height need a size above 0 m";
    }
    return frame_defect(floor_frame(world, limits, area, settings.cell_m, settings.cell_height_m));
}

core::Result<Navmesh> Navmesh::bake(const motion::StaticGeometry& world,
                                    const motion::CharacterLimits& limits,
                                    const GroundRect& area,
                                    const NavmeshSettings& settings) {
    const std::string defect = defect_of(world, limits, area, settings);
    if (!defect.empty()) {
        return core::Result<Navmesh>::failure(defect);
    }
    const FloorFrame frame =
        floor_frame(world, limits, area, settings.cell_m, settings.cell_height_m);
    return NavmeshBaker(world, limits, frame).run();
}

}  // namespace zoned::ai::pathfinding
