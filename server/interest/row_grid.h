// RowGrid: the points of one moment in the x-z plane, sorted into strips and within each by
// columns.
#pragma once

#include "server/spatial/box_lanes.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::interest {

/// Points and their radii by key (0 .. size - 1). A point without a positive radius is no point.
struct RowGridPoints {
    std::span<const float> x;  ///< m, finite where the radius is positive
    std::span<const float> z;  ///< likewise
    std::span<const float> radius_m;
};

/// Who asks for all points but one near a place.
struct RowGridQuery {
    float x = 0.0F;  ///< m, finite
    float z = 0.0F;
    float radius_m = 0.0F;  ///< > 0
    std::uint32_t own = 0;  ///< key of the point that is not meant
};

/// A grid of long cells for many queries at once. Of each strip that its circle touches a query
/// reads one run of points, as long as the circle is wide there, eight at a time.
///
/// A loop over a run ends where the processor does not expect it, and what follows has to wait for
/// that. So the runs of many queries are written down first, as one list of groups of eight points,
/// and then the list is worked off without a branch: half the time. Building is a counting sort of
/// the keys alone, because these stay in the nearer cache; places follow them in order.
class RowGrid {
  public:
    /// Indexes all points for queries of about `radius_m` > 0.
    void build(const RowGridPoints& points, float radius_m);

    /// Writes for each query the keys of all points within min(its radius, their radius), closed,
    /// in the arithmetic of hears(), one query after the other, from keys[from] on; ends[i] is
    /// where those of query i end. Keys beyond what it needs are written over. Neighbours in
    /// `queries` should be neighbours in the plane.
    void match(std::span<const RowGridQuery> queries,
               std::size_t from,
               std::vector<std::uint32_t>& keys,
               std::span<std::uint32_t> ends);

    /// What divides the plane; the outermost strips and columns reach on without an end, so that it
    /// decides how much a query reads, and nothing else.
    struct RowGridCells {
        std::uint32_t strips = 1;
        std::uint32_t columns = 1;
        float last_strip = 0.0F;
        float last_column = 0.0F;
        float min_x = 0.0F;
        float min_z = 0.0F;
        float columns_per_m = 1.0F;
        float strips_per_m = 1.0F;
        float strip_m = 1.0F;
        float slack_m = 0.0F;  ///< by how much roundings may move a point across a border

        [[nodiscard]] std::uint32_t strip(float z) const {
            return place((z - min_z) * strips_per_m, last_strip);
        }

        [[nodiscard]] std::uint32_t column(float x) const {
            return place((x - min_x) * columns_per_m, last_column);
        }

        /// Monotonic, so that no rounding parts a point from a query that holds it; 0 for what is
        /// not a number.
        static std::uint32_t place(float at, float last) {
            const float above = at > 0.0F ? at : 0.0F;
            const float within = above < last ? above : last;
            return static_cast<std::uint32_t>(static_cast<std::int32_t>(within));
        }
    };

    [[nodiscard]] const RowGridCells& cells() const { return cells_; }

  private:
    class List;

    /// PointsOfInterest of eight slots: one line of the cache.
    struct alignas(64) RowGridBlock {
        std::array<float, spatial::kLanes> x;
        std::array<float, spatial::kLanes> z;
    };

    void divide(const RowGridPoints& points, float radius_m);
    void count(const RowGridPoints& points);
    void order(const RowGridPoints& points);
    template <bool kFlat>
    std::size_t work_off(std::size_t listed,
                         const RowGridQuery* queries,
                         std::size_t found,
                         std::uint32_t* keys,
                         std::uint32_t* ends) const;

    std::vector<std::uint32_t> begins_;  // of each cell, strip by strip, and one past the end
    std::vector<std::uint32_t> next_;    // by cell, scratch of build()
    std::vector<std::uint32_t> cell_;    // by key, scratch of build()
    std::vector<std::uint32_t> keys_;    // by slot, as are the next three
    std::vector<RowGridBlock> blocks_;
    std::vector<float> radius_;          // only where they differ
    std::vector<std::uint32_t> groups_;  // first slots of eight, scratch of match()
    std::vector<std::uint32_t> askers_;  // the query of each group
    float smallest_radius_ = 0.0F;
    float largest_radius_ = 0.0F;
    RowGridCells cells_;
};

}  // namespace zoned::interest
