// Tour: a closed tour that local search shortens.
#pragma once

#include "server/ai/ants/distances.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// What an improvement may change.
enum class LocalSearch : std::uint8_t {
    kNone,
    kTwoOpt,  ///< two edges
    kOrOpt,   ///< or three: up to three places move to another place of the tour
};

/// PointsOfInterest in the order of a tour, and the place of each in it.
class Tour {
  public:
    explicit Tour(std::size_t size) : order_(size), at_(size), queued_(size, 0) {
        queue_.reserve(size);
    }

    /// `order` holds each place once.
    void set(std::span<const Place> order);

    [[nodiscard]] std::span<const Place> order() const { return order_; }

    [[nodiscard]] std::size_t size() const { return order_.size(); }

    [[nodiscard]] Place after(Place p) const {
        const std::size_t i = at_[p] + 1U;
        return order_[i < order_.size() ? i : 0];
    }

    [[nodiscard]] Place before(Place p) const {
        const std::size_t i = at_[p];
        return order_[i > 0 ? i - 1 : order_.size() - 1];
    }

    /// Shortens the tour until no change of that kind among near neighbours does (nearest:
    /// `per_place` of each place, as Distances::nearest gives them); by how much. With neighbour
    /// lists and don't-look bits (Bentley, "Fast algorithms for geometric traveling salesman
    /// problems", ORSA Journal on Computing 4, 1992; Or-opt: Or, 1976, as there), first
    /// improvement, places in the order of the tour.
    std::int64_t improve(const Distances& distances,
                         std::span<const Neighbour> nearest,
                         std::size_t per_place,
                         LocalSearch search);

  private:
    struct Near {
        const Distances& distances;
        std::span<const Neighbour> nearest;
        std::size_t per_place;

        /// Nearest first.
        [[nodiscard]] std::span<const Neighbour> of(Place p) const {
            return nearest.subspan(p * per_place, per_place);
        }
    };

    std::int64_t try_two_opt(const Near& near, Place a);
    std::int64_t try_or_opt(const Near& near, Place a);
    std::int64_t try_insertions(const Near& near,
                                Place first,
                                Place last,
                                std::size_t count,
                                bool forward);

    /// How many places after `from` along the tour, 0 to size() - 1.
    [[nodiscard]] std::size_t places_after(Place from, Place p) const {
        const std::size_t i = at_[p];
        const std::size_t j = at_[from];
        return i >= j ? i - j : i + order_.size() - j;
    }

    /// Turns the path from `first` to `last` (onwards) around.
    void reverse(Place first, Place last);
    /// Moves the path of `count` places from `first` on to between `left` and the place after it,
    /// which are not on it; `turned`: the other way round.
    void move(Place first, std::size_t count, Place left, bool turned);
    void look_again(Place p);

    void put(std::size_t i, Place p) {
        order_[i] = p;
        at_[p] = static_cast<std::uint32_t>(i);
    }

    std::vector<Place> order_;
    std::vector<std::uint32_t> at_;
    std::vector<Place> queue_;  // places that may have an improvement
    std::vector<std::uint8_t> queued_;
};

}  // namespace zoned::ai::pathfinding
