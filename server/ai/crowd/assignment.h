// Assignment: pairs agents with places so that the total distance is least.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::steering {

inline constexpr std::uint32_t kNoSlot = ~0U;

class Assignment {
  public:
    /// With at most this many rows and slots the sum of costs is least. With more, the cheapest
    /// pair is taken first, then the cheapest of the rest; ties go by row, then slot.
    static constexpr std::size_t kMostExact = 128;

    /// `cost` holds for each row its (finite) cost of each of `slots` slots, row by row. Each row
    /// gets a slot of its own; with more rows than slots some get kNoSlot. The method is the
    /// Hungarian one with shortest augmenting paths, O(n^3): Jonker and Volgenant, "A shortest
    /// augmenting path algorithm for dense and sparse linear assignment problems", Computing 38,
    /// 1987. Does not allocate for sizes met before.
    std::span<const std::uint32_t> solve(std::span<const double> cost,
                                         std::size_t rows,
                                         std::size_t slots);

  private:
    void solve_exactly(std::span<const double> cost, std::size_t rows, std::size_t slots);
    void augment(std::span<const double> cost, std::size_t row, std::size_t slots);
    void solve_greedily(std::span<const double> cost, std::size_t rows, std::size_t slots);

    struct AssignedPair {
        double cost;
        std::uint32_t row, slot;
    };

    std::vector<std::uint32_t> slot_of_;
    std::vector<std::uint32_t> row_of_;  // by slot
    std::vector<double> row_price_, slot_price_, path_;
    std::vector<std::uint32_t> from_;  // slot before, on the shortest path
    std::vector<std::uint8_t> done_;
    std::vector<double> turned_;  // costs with rows and slots exchanged
    std::vector<AssignedPair> pairs_;
};

}  // namespace zoned::ai::steering
