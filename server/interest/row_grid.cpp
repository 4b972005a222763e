// build: hot loops
#include "server/interest/row_grid.h"

#include "server/interest/compress_lanes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace zoned::interest {

namespace {

using spatial::Array8;
using Groups8 = Eigen::Array<std::uint32_t, 8, 1>;

constexpr auto kStripLanes = static_cast<std::uint32_t>(spatial::kLanes);
/// Points that are looked at to guess where the others are.
constexpr std::size_t kSample = 1024;
constexpr double kPointsPerCell = 2.0;
constexpr std::uint32_t kMost = 4096;  // strips, and columns
/// Groups that are listed before they are worked off: what they say stays in the nearest cache.
constexpr std::size_t kListed = 512;

}  // namespace

/// Where some of the points are: one that is far from all others, or a few, should not coarsen the
/// cells. What lies beyond is in the outermost strips and columns.
///
/// Thinner strips follow the circle better and cost a run each: a query that n points are near has
/// 2 k + 1 runs for k strips per radius and reads about n (1 + 0.7 / k) points, an eighth of which
/// costs a third as much as a run; least where k^2 is n / 80.
void RowGrid::divide(const RowGridPoints& points, float radius_m) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    float x0 = kInfinity, x1 = -kInfinity, z0 = kInfinity, z1 = -kInfinity;
    const std::size_t stride = std::max<std::size_t>(1, points.x.size() / kSample);
    for (std::size_t key = 0; key < points.x.size(); key += stride) {
        if (points.radius_m[key] > 0.0F) {
            x0 = std::min(x0, points.x[key]);
            x1 = std::max(x1, points.x[key]);
            z0 = std::min(z0, points.z[key]);
            z1 = std::max(z1, points.z[key]);
        }
    }
    if (!(x0 <= x1)) {
        x0 = x1 = z0 = z1 = 0.0F;
    }
    const double radius = radius_m;
    const double width = std::max(0.01 * radius, static_cast<double>(x1) - x0);
    const double depth = std::max(0.01 * radius, static_cast<double>(z1) - z0);
    const auto size = static_cast<double>(points.x.size());
    const double near = size * std::min(1.0, std::numbers::pi * radius * radius / (width * depth));
    const double per_radius = std::clamp(std::sqrt(near / 80.0), 0.5, 16.0);
    const auto most = static_cast<double>(kMost);
    const double strips = std::clamp(std::floor(depth * per_radius / (1.001 * radius)), 1.0, most);
    const double columns = std::clamp(std::ceil(size / (strips * kPointsPerCell)), 1.0, most);
    cells_.strips = static_cast<std::uint32_t>(strips);
    cells_.columns = static_cast<std::uint32_t>(columns);
    cells_.last_strip = static_cast<float>(strips - 1.0);
    cells_.last_column = static_cast<float>(columns - 1.0);
    cells_.min_x = x0;
    cells_.min_z = z0;
    cells_.strips_per_m = static_cast<float>(strips / depth);
    cells_.columns_per_m = static_cast<float>(columns / width);
    cells_.strip_m = static_cast<float>(depth / strips);
    cells_.slack_m = static_cast<float>(4e-6 * (std::max(std::abs(z0), std::abs(z1)) + depth));
}

/// Cell of each key and how many points each cell holds; the last cell takes what is no point.
void RowGrid::count(const RowGridPoints& points) {
    const std::size_t size = points.x.size();
    const auto cells = static_cast<std::int32_t>(cells_.strips * cells_.columns);
    cell_.resize(size);
    const float* const x = points.x.data();
    const float* const z = points.z.data();
    const float* const radius = points.radius_m.data();
    std::uint32_t* const cell = cell_.data();
    const float min_x = cells_.min_x, min_z = cells_.min_z;
    const float per_x = cells_.columns_per_m, per_z = cells_.strips_per_m;
    const float last_x = cells_.last_column, last_z = cells_.last_strip;
    const auto wide = static_cast<std::uint32_t>(cells_.columns);
    for (std::size_t i = 0; i < size; ++i) {
        const std::uint32_t c = RowGridCells::place((x[i] - min_x) * per_x, last_x);
        const std::uint32_t s = RowGridCells::place((z[i] - min_z) * per_z, last_z);
        const std::uint32_t at = s * wide + c;
        cell[i] = radius[i] > 0.0F ? at : static_cast<std::uint32_t>(cells);
    }
    next_.assign(static_cast<std::size_t>(cells) + 1, 0);
    std::uint32_t* const next = next_.data();
    for (std::size_t i = 0; i < size; ++i) {
        ++next[cell[i]];
    }
    // Positive floats are in the order of their bits, which are compared eight at a time.
    auto smallest = std::bit_cast<std::int32_t>(std::numeric_limits<float>::infinity());
    const std::int32_t most = smallest;
    std::int32_t largest = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const auto bits = std::bit_cast<std::int32_t>(radius[i]);
        smallest = std::min(smallest, bits > 0 ? bits : most);
        largest = std::max(largest, bits);
    }
    smallest_radius_ = std::bit_cast<float>(smallest);
    largest_radius_ = std::bit_cast<float>(largest);
}

void RowGrid::order(const RowGridPoints& points) {
    const std::size_t size = points.x.size();
    begins_.resize(next_.size());
    std::uint32_t before = 0;
    for (std::size_t c = 0; c < next_.size(); ++c) {
        begins_[c] = before;
        before += next_[c];
        next_[c] = begins_[c];
    }
    keys_.resize(size + 2 * kStripLanes);
    std::fill(keys_.begin() + static_cast<std::ptrdiff_t>(size), keys_.end(), 0);
    for (std::size_t key = 0; key < size; ++key) {
        keys_[next_[cell_[key]]++] = static_cast<std::uint32_t>(key);
    }
    // A query may read some slots more than it means.
    const std::size_t points_here = begins_.back();
    blocks_.resize(points_here / kStripLanes + 2);
    for (std::size_t slot = 0; slot < points_here; slot += kStripLanes) {
        RowGridBlock& block = blocks_[slot / kStripLanes];
        for (std::size_t i = 0; i < kStripLanes; ++i) {
            const std::uint32_t key = keys_[slot + i];
            block.x[i] = points.x[key];
            block.z[i] = points.z[key];
        }
    }
    for (std::size_t slot = points_here; slot < blocks_.size() * kStripLanes; ++slot) {
        blocks_[slot / kStripLanes].x[slot % kStripLanes] = std::numeric_limits<float>::quiet_NaN();
    }
    if (smallest_radius_ < largest_radius_) {
        radius_.resize(blocks_.size() * kStripLanes);
        for (std::size_t slot = 0; slot < points_here; ++slot) {
            radius_[slot] = points.radius_m[keys_[slot]];
        }
    }
}

void RowGrid::build(const RowGridPoints& points, float radius_m) {
    divide(points, radius_m);
    count(points);
    order(points);
}

/// Writes down which groups of eight hold all points near queries. Without a branch that depends
/// on where these are.
class RowGrid::List {
  public:
    explicit List(RowGrid& strips)
        : cells_(strips.cells_),
          largest_radius_(strips.largest_radius_),
          begins_(strips.begins_.data()),
          groups_(strips.groups_.data()),
          askers_(strips.askers_.data()) {}

    /// Appends those of a query, at least one. Eight strips at a time, and as many for each query
    /// of a radius.
    [[gnu::always_inline]] void add(const RowGridQuery& query, std::uint32_t number) {
        const RowGridCells& c = cells_;
        // The differences of places are rounded: a point may count as within the radius that lies
        // a rounding outside of it, in the next cell.
        const float reach = std::min(query.radius_m, largest_radius_) * 1.0001F +
                            2e-6F * std::max(std::abs(query.x), std::abs(query.z)) + c.slack_m;
        const auto bottom = static_cast<float>(c.strip(query.z - reach));
        const auto top = static_cast<float>(c.strip(query.z + reach));
        const auto count = static_cast<std::uint32_t>(
            std::min(2.0F * reach * c.strips_per_m + 2.0F, c.last_strip + 1.0F));
        const float middle = (query.x - c.min_x) * c.columns_per_m;
        const std::size_t before = listed;
        done_ = 0;
        for (std::uint32_t k = 0; k < count; k += kStripLanes) {
            // Above the top it is the same strip again, of which nothing is left.
            const Array8 s = (count_up_ + (bottom + static_cast<float>(k))).min(top);
            Array8 below = s * c.strip_m + (c.min_z - query.z);
            Array8 above = -c.strip_m - below;
            if (bottom <= 0.0F || top >= c.last_strip) {  // the outermost have no end
                below = (s <= 0.0F).select(0.0F, below);
                above = (s >= c.last_strip).select(0.0F, above);
            }
            const Array8 apart = (below.max(above) - c.slack_m).max(0.0F);
            const Array8 half = (reach * reach - apart * apart).max(0.0F).sqrt();
            add_runs(s,
                     middle,
                     half * c.columns_per_m + kColumnSlack,
                     std::min(count - k, kStripLanes),
                     number);
        }
        if (listed == before) {
            add_run(done_, 1, number);
        }
    }

    std::size_t listed = 0;

  private:
    using Int8 = Eigen::Array<std::int32_t, 8, 1>;

    /// Of roundings in columns, up to kMost of them.
    static constexpr float kColumnSlack = 0.01F;

    [[gnu::always_inline]] void add_runs(const Array8& strip,
                                         float middle,
                                         const Array8& half,
                                         std::uint32_t strips,
                                         std::uint32_t number) {
        const RowGridCells& c = cells_;
        // Casts of what is a value already: of an expression they are done one by one.
        const Array8 left = (middle - half).max(0.0F).min(c.last_column);
        const Array8 right = (middle + half).max(0.0F).min(c.last_column);
        const Int8 line = strip.cast<std::int32_t>();
        const Int8 first = left.cast<std::int32_t>();
        const Int8 last = right.cast<std::int32_t>();
        const Int8 row = line * static_cast<std::int32_t>(c.columns);
        const Int8 from = row + first;
        const Int8 to = row + last;
        for (std::uint32_t i = 0; i < strips; ++i) {
            const std::uint32_t begin = std::max(done_, begins_[from[i]] / kStripLanes);
            // Zero where nothing is left; a branch would be guessed wrong.
            const std::uint32_t end = (begins_[to[i] + 1] + kStripLanes - 1) / kStripLanes;
            const auto past = static_cast<std::int32_t>(end - begin);
            const auto groups = static_cast<std::uint32_t>(past & ~(past >> 31));
            add_run(begin, groups, number);
            done_ = begin + groups;
        }
    }

    /// Writes more than it needs, so that short runs are all alike.
    [[gnu::always_inline]] void add_run(std::uint32_t first,
                                        std::uint32_t groups,
                                        std::uint32_t number) {
        Groups8 slots = group_up_ + first;
        for (std::size_t k = listed;; k += 2 * kStripLanes) {
            Eigen::Map<Groups8>(groups_ + k) = slots;
            Eigen::Map<Groups8>(groups_ + k + 8) = slots + 8;
            Eigen::Map<Groups8>(askers_ + k) = Groups8::Constant(number);
            Eigen::Map<Groups8>(askers_ + k + 8) = Groups8::Constant(number);
            if (k + 2 * kStripLanes >= listed + groups) {
                break;
            }
            slots += 16;
        }
        listed += groups;
    }

    const RowGridCells cells_;  // by value: nothing that is written could change it
    const float largest_radius_;
    const std::uint32_t* const begins_;
    std::uint32_t* const groups_;
    std::uint32_t* const askers_;
    const Array8 count_up_ = {0, 1, 2, 3, 4, 5, 6, 7};
    const Groups8 group_up_ = {0, 1, 2, 3, 4, 5, 6, 7};
    std::uint32_t done_ = 0;
};

template <bool kFlat>
std::size_t RowGrid::work_off(std::size_t listed,
                              const RowGridQuery* queries,
                              std::size_t found,
                              std::uint32_t* keys,
                              std::uint32_t* ends) const {
    const std::uint32_t* const groups = groups_.data();
    const std::uint32_t* const askers = askers_.data();
    const RowGridBlock* const blocks = blocks_.data();
    const std::uint32_t* const all = keys_.data();
    for (std::size_t i = 0; i < listed; ++i) {
        const std::size_t slot = static_cast<std::size_t>(groups[i]) * kStripLanes;
        const RowGridBlock& block = blocks[groups[i]];
        const RowGridQuery& query = queries[askers[i]];
        const Array8 dx = Eigen::Map<const Array8>(block.x.data()) - query.x;
        const Array8 dz = Eigen::Map<const Array8>(block.z.data()) - query.z;
        std::uint32_t mask = 0;
        if constexpr (kFlat) {
            const float r = std::min(query.radius_m, largest_radius_);
            const Array8 square = Array8::Constant(r * r);
            mask = spatial::lanes_at_most(dx * dx + dz * dz, square);
        } else {
            const Array8 r = Eigen::Map<const Array8>(radius_.data() + slot).min(query.radius_m);
            mask = spatial::lanes_at_most(dx * dx + dz * dz, r * r);
        }
        mask &= ~lanes_equal(all + slot, query.own);
        compress_store(all + slot, mask, keys + found);
        found += static_cast<std::size_t>(std::popcount(mask));
        ends[askers[i]] = static_cast<std::uint32_t>(found);
    }
    return found;
}

void RowGrid::match(std::span<const RowGridQuery> queries,
                    std::size_t from,
                    std::vector<std::uint32_t>& keys,
                    std::span<std::uint32_t> ends) {
    const std::size_t most = kListed + blocks_.size() + cells_.strips + 4 * kStripLanes;
    groups_.resize(most);
    askers_.resize(most);
    std::size_t found = from;
    for (std::size_t first = 0; first < queries.size();) {
        List list(*this);
        std::size_t last = first;
        float largest = 0.0F;
        while (last < queries.size() && list.listed < kListed) {
            largest = std::max(largest, queries[last].radius_m);
            list.add(queries[last], static_cast<std::uint32_t>(last - first));
            ++last;
        }
        const std::size_t room = (list.listed + 1) * kStripLanes;
        if (keys.size() < found + room) {
            keys.resize(2 * found + room);
        }
        const RowGridQuery* const asked = &queries[first];
        const bool flat = largest <= smallest_radius_ || smallest_radius_ == largest_radius_;
        found = flat ? work_off<true>(list.listed, asked, found, keys.data(), &ends[first])
                     : work_off<false>(list.listed, asked, found, keys.data(), &ends[first]);
        first = last;
    }
}

}  // namespace zoned::interest
