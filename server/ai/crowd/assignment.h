// Assignment: who takes which place, so that all together have the shortest distance.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::steering {

inline constexpr std::uint32_t kNoSlot = ~0U;

class Assignment {
  public:
    /// Up to so many of both the sum of costs is least; among more, the cheapest pair goes first,
    /// then the cheapest of those left, ties by row, then slot.
    static constexpr std::size_t kMostExact = 128;

    /// `cost` holds for each row its cost (finite) of each of `slots` slots, row by row. Each row
    /// gets another slot; with more rows than slots some get kNoSlot. By the Hungarian method with
    /// shortest augmenting paths (Jonker and Volgenant, "A shortest augmenting path algorithm for
    /// dense and sparse linear assignment problems", Computing 38, 1987), O(n^3). No allocation
    /// where there are no more than before.
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
