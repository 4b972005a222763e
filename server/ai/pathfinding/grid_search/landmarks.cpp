#include "server/ai/pathfinding/grid_search/landmarks.h"

namespace zoned::ai::pathfinding {

namespace {

// The sizes of one part of the work, and its costs in units of about 2 ns.
constexpr std::uint32_t kSpreadCells = 1024;
constexpr std::uint64_t kSpreadUnits = 6;  ///< a cell of a field
constexpr std::uint32_t kPlacesAtOnce = 4096;
constexpr std::uint64_t kWriteUnits = 3;     ///< a place whose distance is written down
constexpr std::uint64_t kDistanceUnits = 2;  ///< one that is counted

}  // namespace

ResumableTask Landmarks::build(const GridMap& map,
                               const Components& components,
                               std::size_t most_bytes) {
    forget();
    path_sum_ = 0.0;
    line_sum_ = 0.0;
    const std::size_t each = std::size_t{map.places()} * sizeof(std::uint16_t);
    count_ = kMost * each <= most_bytes ? kMost : kLanes * each <= most_bytes ? kLanes : 0;
    if (count_ == 0) {
        co_return;
    }
    nearest_.resize(map.places());
    // A cell of the largest component. Other components learning nothing.
    cells_.assign(components.numbers(), 0);
    Place at = 0;
    for (Place p = 0; p < map.places(); ++p) {
        const std::uint32_t of = components.of(p);
        if (of != 0 && ++cells_[of] > cells_[components.of(at)]) {
            at = p;
        }
        if (p % kPlacesAtOnce == 0 && co_await Spent{kDistanceUnits * kPlacesAtOnce}) {
            co_return;
        }
    }
    // Goes from there to the cell farthest from it, and on to the cells farthest from all.
    for (std::size_t i = 0; i <= count_ && at != 0; ++i) {
        const std::size_t held = field_.bytes();
        field_.begin(map, map.cell(at));
        if (co_await Spent{memory_units(map.places() + field_.bytes() - held)}) {
            co_return;
        }
        while (!field_.advance(map, kSpreadCells)) {
            if (co_await Spent{kSpreadUnits * kSpreadCells}) {
                co_return;
            }
        }
        if (i == 1) {
            // Costs of the first one: no path is longer than twice the longest of these.
            constexpr Cost kMostUnits = 65'000;
            unit_ = 2 * field_.longest() / kMostUnits + 1;
        }
        if (i == 1 && far_.size() != count_ * map.places()) {
            far_.assign(count_ * map.places(), 0);
        }
        Cost farthest = 0;
        const Cell from = map.cell(at);
        for (Place p = 0; p < map.places(); ++p) {
            const Cost cost = field_.cost(p);
            if (i != 0) {
                far_[p * count_ + i - 1] =
                    cost == kNoCost ? std::uint16_t{0} : static_cast<std::uint16_t>(cost / unit_);
            }
            if (i == 0 && cost != kNoCost) {
                const Cell to = map.cell(p);
                path_sum_ += static_cast<double>(cost);
                line_sum_ += static_cast<double>(octile(to.x - from.x, to.y - from.y));
            }
            if (cost != kNoCost) {
                nearest_[p] = i <= 1 ? cost : std::min(nearest_[p], cost);
                if (nearest_[p] > farthest) {
                    farthest = nearest_[p];
                    at = p;
                }
            }
            if (p % kPlacesAtOnce == 0 && co_await Spent{kWriteUnits * kPlacesAtOnce}) {
                co_return;
            }
        }
        if (i == 0 && path_sum_ <= (1.0 + kNeedlessShare) * line_sum_) {
            needless_ = true;
            far_ = std::vector<std::uint16_t>();
            break;
        }
    }
    known_ = at != 0 && !needless_;
    // The rest is not needed before the map is another.
    const std::size_t held = bytes() - far_.capacity() * sizeof(std::uint16_t);
    field_ = FlowField();
    nearest_ = std::vector<Cost>();  // empty braces would keep the memory
    cells_ = std::vector<std::uint32_t>();
    co_await Spent{memory_units(held) / 4};
}

std::size_t Landmarks::bytes() const {
    return far_.capacity() * sizeof(std::uint16_t) + nearest_.capacity() * sizeof(Cost) +
           cells_.capacity() * sizeof(std::uint32_t) + field_.bytes();
}

}  // namespace zoned::ai::pathfinding
