// Distances: how far it is from each of some places to each other.
#pragma once

#include "shared/core/result.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

using Place = std::uint32_t;
using Length = std::int32_t;

/// A place near another, and how far it is.
struct Neighbour {
    Place place;
    Length length;
};

/// Symmetric distances between `size` places, row by row, and the nearest neighbours of each.
class Distances {
  public:
    static constexpr std::size_t kMostPlaces = 5000;  ///< 100 MB
    static constexpr Length kLongest = 100'000'000;   ///< of one distance: sums of all fit 64 bits

    /// `lengths`: size x size numbers from 0 to kLongest, symmetric, 0 from a place to itself.
    /// Errors name the first two places that are wrong. 3 <= size <= kMostPlaces.
    static core::Result<Distances> make(std::size_t size, std::vector<Length> lengths);

    /// The shortest paths in an undirected graph; an error names a place that others do not reach.
    struct Edge {
        Place a, b;
        Length length;
    };

    static core::Result<Distances> of_graph(std::size_t size, std::span<const Edge> edges);

    [[nodiscard]] std::size_t size() const { return size_; }

    [[nodiscard]] Length between(Place a, Place b) const { return lengths_[a * size_ + b]; }

    /// To all places, by number.
    [[nodiscard]] std::span<const Length> from(Place p) const {
        return {lengths_.data() + p * size_, size_};
    }

    /// The nearest `count` others of each place, nearest first, ties by number: size x count.
    [[nodiscard]] std::vector<Neighbour> nearest(std::size_t count) const;

    /// Of a closed tour.
    [[nodiscard]] std::int64_t length_of(std::span<const Place> tour) const;

  private:
    Distances(std::size_t size, std::vector<Length> lengths)
        : size_(size),
          lengths_(std::move(lengths)) {}

    std::size_t size_;
    std::vector<Length> lengths_;
};

}  // namespace zoned::ai::pathfinding
