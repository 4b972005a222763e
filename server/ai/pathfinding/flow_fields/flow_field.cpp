#include "server/ai/pathfinding/flow_fields/flow_field.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <array>
#include <bit>

namespace zoned::ai::pathfinding {

namespace {

constexpr unsigned kStraightHops = 4;

using StepsByNeighbourhood = std::array<std::uint8_t, 512>;

/// The steps on from a place, as bits, that may lead to a best path. The first index is the hop
/// back to the place from which it was reached (kArrived: none). The second holds the nine cells
/// around and at it (bit 3 (dy + 1) + dx + 1 is set where a cell is passable). A step is left out
/// if the place behind reaches its cell for less without it. These are all cells beside and behind,
/// except those that an obstacle hides from the place behind. A diagonal step after a straight one
/// is also left out where the place behind can take the diagonal first, for the same cost.
///
/// Nothing is lost, by whichever of several best paths a place is reached. Straight steps on a best
/// path are never left out, for then it would not be a best one. Where a diagonal step is left out,
/// the place that the diagonal from behind leads to has a straight step to the same cell.
constexpr std::array<StepsByNeighbourhood, 9> steps_by_hop() {
    std::array<StepsByNeighbourhood, 9> table{};
    for (unsigned n = 0; n < 512; ++n) {
        const auto passable = [n](int dx, int dy) {
            return (n >> static_cast<unsigned>(3 * (dy + 1) + dx + 1) & 1U) != 0;
        };
        for (unsigned back = 0; back < 9; ++back) {
            const int bx = kHopX[back];
            const int by = kHopY[back];
            for (unsigned h = 0; h < 8; ++h) {
                const int dx = kHopX[h];
                const int dy = kHopY[h];
                const int ahead = -(dx * bx + dy * by);  // of where it came from, if above 0
                const bool behind_straight = bx == 0 || by == 0;
                const bool aside = behind_straight && (dx * by != 0 || dy * bx != 0);
                // Relative to the place behind: the cells that the step passes.
                const bool hidden = aside && !passable(bx != 0 ? bx : dx, by != 0 ? by : dy);
                const bool natural = behind_straight ? ahead > 0 && !aside : ahead > 0;
                if (passable(dx, dy) && passable(dx, 0) && passable(0, dy) &&
                    (back == kArrived || natural || (hidden && ahead >= 0))) {
                    table[back][n] |= static_cast<std::uint8_t>(1U << h);
                }
            }
        }
    }
    return table;
}

constexpr std::array<StepsByNeighbourhood, 9> kSteps = steps_by_hop();

/// The bits of three places from `first` on.
std::uint32_t three_bits(const std::uint64_t* words, Place first) {
    const std::uint64_t* w = words + (first >> 6U);
    const std::uint32_t shift = first & 63U;
    const std::uint64_t low = w[0] >> shift;
    return static_cast<std::uint32_t>(shift > 61 ? low | w[1] << (64 - shift) : low) & 7U;
}

}  // namespace

void FlowField::build(const GridMap& map, Cell goal) {
    begin(map, goal);
    advance(map, ~0U);
}

void FlowField::begin(const GridMap& map, Cell goal) {
    make_room(map, map.passable_cells());
    std::ranges::fill(cost_.all(), kNoCost);
    std::ranges::fill(hop_.all(), kNoHop);
    start(map, std::span(&goal, 1));
}

void FlowField::build(const GridMap& map, Cell goal, const Window& window) {
    build(map, std::span(&goal, 1), window);
}

void FlowField::build(const GridMap& map, std::span<const Cell> goals, const Window& window) {
    for (const Cell goal : goals) {
        ZONED_ASSERT(goal.x >= window.left && goal.x <= window.right && goal.y >= window.top &&
                         goal.y <= window.bottom,
                     "a goal outside the window");
    }
    const auto cells = static_cast<std::size_t>(window.right - window.left + 1) *
                       static_cast<std::size_t>(window.bottom - window.top + 1);
    make_room(map, std::min<std::size_t>(map.passable_cells(), cells));
    close_window(map, window);
    start(map, goals);
    advance(map, ~0U);
}

void FlowField::close_window(const GridMap& map, const Window& window) {
    // Around the rectangle all is reached for nothing already: no path leads out.
    const Place corner = map.place({static_cast<std::uint16_t>(window.left),
                                    static_cast<std::uint16_t>(window.top)}) -
                         map.stride() - 1;
    const auto width = static_cast<std::uint32_t>(window.right - window.left + 3);
    const auto height = static_cast<std::uint32_t>(window.bottom - window.top + 3);
    for (std::uint32_t y = 0; y < height; ++y) {
        const std::size_t row = corner + y * map.stride();
        const bool edge = y == 0 || y + 1 == height;
        std::ranges::fill(cost_.all().subspan(row, width), edge ? 0 : kNoCost);
        cost_[row] = 0;
        cost_[row + width - 1] = 0;
        std::ranges::fill(hop_.all().subspan(row, width), kNoHop);
    }
}

void FlowField::make_room(const GridMap& map, std::size_t reached) {
    ZONED_ASSERT(map.passable_cells() <= kMostPassable, "a map whose paths may be too long");
    if (cost_.size() != map.places()) {
        cost_ = core::ZeroPages<Cost>(map.places());
        hop_ = core::ZeroPages<Hop>(map.places());
    }
    // One more than a bucket can hold: an entry without change is written behind the last one.
    if (buckets_[0].places.size() < reached + 1) {
        for (Bucket& b : buckets_) {
            b.places = core::ZeroPages<Place>(reached + 1);
        }
    }
}

void FlowField::start(const GridMap& map, std::span<const Cell> goals) {
    for (Bucket& b : buckets_) {
        b.size = 0;
    }
    first_cost_ = 0;
    next_ = 0;
    longest_ = 0;
    for (const Cell goal : goals) {
        ZONED_ASSERT(map.contains(goal), "a goal off the map");
        const Place first = map.place(goal);
        if (map.passable(first)) {
            cost_[first] = 0;
            hop_[first] = kArrived;
            buckets_[0].places[buckets_[0].size++] = first;
        }
    }
}

bool FlowField::advance(const GridMap& map, std::uint32_t cells) {
    while (cells != 0) {
        if (next_ == buckets_[0].size) {
            if (buckets_[1].size == 0 && buckets_[2].size == 0) {
                return true;
            }
            std::rotate(buckets_.begin(), buckets_.begin() + 1, buckets_.end());
            buckets_.back().size = 0;
            first_cost_ += kStraight;
            next_ = 0;
        }
        const std::size_t count = std::min<std::size_t>(cells, buckets_[0].size - next_);
        spread(map, count);
        cells -= static_cast<std::uint32_t>(count);
    }
    return false;
}

void FlowField::spread(const GridMap& map, std::size_t count) {
    const auto stride = static_cast<std::int32_t>(map.stride());
    const std::array<std::int32_t, 8> offsets{
        1, -1, stride, -stride, stride + 1, -stride - 1, 1 - stride, stride - 1};
    const std::uint64_t* const words = map.row_bits().data();
    const Place* const from = buckets_[0].places.all().data() + next_;
    Place* const next = buckets_[1].places.all().data();
    Place* const after = buckets_[2].places.all().data();
    std::size_t next_size = buckets_[1].size;
    std::size_t after_size = buckets_[2].size;
    const Cost next_end = first_cost_ + 2 * kStraight;
    const Cost after_end = first_cost_ + 3 * kStraight;
    Cost* const cost = cost_.all().data();
    Hop* const hop = hop_.all().data();
    Cost longest = longest_;
    for (std::size_t i = 0; i < count; ++i) {
        const Place at = from[i];
        const Cost here = cost[at];
        if (here < first_cost_) {
            continue;  // settled in an earlier bucket
        }
        longest = std::max(longest, here);
        const std::uint32_t around = three_bits(words, at - map.stride() - 1) |
                                     three_bits(words, at - 1) << 3U |
                                     three_bits(words, at + map.stride() - 1) << 6U;
        for (std::uint32_t steps = kSteps[hop[at]][around]; steps != 0; steps &= steps - 1) {
            const auto h = static_cast<unsigned>(std::countr_zero(steps));
            const auto to = static_cast<Place>(static_cast<std::int32_t>(at) + offsets[h]);
            const Cost there = here + (h < kStraightHops ? kStraight : kDiagonal);
            const Cost before = cost[to];
            if (there < before) {
                cost[to] = there;
                hop[to] = static_cast<Hop>(h ^ 1U);
                // Into its bucket, unless it is there already.
                if (there < next_end) {
                    next[next_size] = to;
                    next_size += before >= next_end ? 1 : 0;
                } else {
                    after[after_size] = to;
                    after_size += before >= after_end ? 1 : 0;
                }
            }
        }
    }
    next_ += count;
    buckets_[1].size = next_size;
    buckets_[2].size = after_size;
    longest_ = longest;
}

std::size_t FlowField::bytes() const {
    return cost_.size() * sizeof(Cost) + hop_.size() * sizeof(Hop) +
           kBuckets * buckets_[0].places.size() * sizeof(Place);
}

}  // namespace zoned::ai::pathfinding
