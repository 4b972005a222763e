#include "server/ai/crowd/assignment.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <limits>
#include <tuple>

namespace zoned::ai::steering {

namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();

}  // namespace

std::span<const std::uint32_t> Assignment::solve(std::span<const double> cost,
                                                 std::size_t rows,
                                                 std::size_t slots) {
    ZONED_ASSERT(cost.size() == rows * slots, "a cost for each pair");
    slot_of_.assign(rows, kNoSlot);
    row_of_.assign(slots, kNoSlot);
    if (rows == 0 || slots == 0) {
        return slot_of_;
    }
    if (std::max(rows, slots) > kMostExact) {
        solve_greedily(cost, rows, slots);
    } else if (rows <= slots) {
        solve_exactly(cost, rows, slots);
    } else {
        // All slots find a row: the same with both exchanged.
        turned_.resize(cost.size());
        for (std::size_t r = 0; r < rows; ++r) {
            for (std::size_t s = 0; s < slots; ++s) {
                turned_[s * rows + r] = cost[r * slots + s];
            }
        }
        std::swap(slot_of_, row_of_);
        solve_exactly(turned_, slots, rows);
        std::swap(slot_of_, row_of_);
    }
    return slot_of_;
}

void Assignment::solve_exactly(std::span<const double> cost, std::size_t rows, std::size_t slots) {
    row_price_.assign(rows, 0.0);
    slot_price_.assign(slots, 0.0);
    path_.resize(slots);
    from_.resize(slots);
    done_.resize(slots);
    for (std::size_t row = 0; row < rows; ++row) {
        augment(cost, row, slots);
    }
}

/// Dijkstra over slots from `row` to the nearest free slot, by costs less prices; then all along
/// the path move on by one.
void Assignment::augment(std::span<const double> cost, std::size_t row, std::size_t slots) {
    std::fill(done_.begin(), done_.end(), std::uint8_t{0});
    std::fill(path_.begin(), path_.end(), kFar);
    std::fill(from_.begin(), from_.end(), kNoSlot);
    auto at = static_cast<std::uint32_t>(row);
    std::uint32_t through = kNoSlot;
    double reached = 0.0;
    std::uint32_t found = kNoSlot;
    while (found == kNoSlot) {
        std::uint32_t next = kNoSlot;
        for (std::uint32_t s = 0; s < slots; ++s) {
            if (done_[s] != 0) {
                continue;
            }
            const double path = reached + cost[at * slots + s] - row_price_[at] - slot_price_[s];
            if (path < path_[s]) {
                path_[s] = path;
                from_[s] = through;
            }
            next = next == kNoSlot || path_[s] < path_[next] ? s : next;
        }
        done_[next] = 1;
        reached = path_[next];
        through = next;
        if (row_of_[next] == kNoSlot) {
            found = next;
        } else {
            at = row_of_[next];
        }
    }
    row_price_[row] += reached;
    for (std::size_t s = 0; s < slots; ++s) {
        if (done_[s] != 0 && s != found) {
            slot_price_[s] -= reached - path_[s];
            row_price_[row_of_[s]] += reached - path_[s];
        }
    }
    for (std::uint32_t s = found; s != kNoSlot; s = from_[s]) {
        const std::uint32_t before = from_[s];
        const std::uint32_t who =
            before == kNoSlot ? static_cast<std::uint32_t>(row) : row_of_[before];
        row_of_[s] = who;
        slot_of_[who] = s;
    }
}

void Assignment::solve_greedily(std::span<const double> cost, std::size_t rows, std::size_t slots) {
    pairs_.clear();
    for (std::uint32_t r = 0; r < rows; ++r) {
        for (std::uint32_t s = 0; s < slots; ++s) {
            pairs_.push_back({cost[r * slots + s], r, s});
        }
    }
    std::sort(pairs_.begin(), pairs_.end(), [](const AssignedPair& a, const AssignedPair& b) {
        return std::tie(a.cost, a.row, a.slot) < std::tie(b.cost, b.row, b.slot);
    });
    for (const AssignedPair& p : pairs_) {
        if (slot_of_[p.row] == kNoSlot && row_of_[p.slot] == kNoSlot) {
            slot_of_[p.row] = p.slot;
            row_of_[p.slot] = p.row;
        }
    }
}

}  // namespace zoned::ai::steering
