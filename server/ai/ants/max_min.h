// MaxMin: a MAX-MIN ant system, which looks for the shortest closed tour through all places.
#pragma once

#include "server/ai/ants/distances.h"
#include "server/ai/ants/tour.h"
#include "shared/core/rng.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

struct MaxMinSettings {
    LocalSearch local = LocalSearch::kOrOpt;
    std::uint32_t ants =
        0;  ///< tours of an iteration; 0: 25, without local search half as many as places
    float evaporation = 0.0F;    ///< share of the trails, 0 to 1; 0: 0.2, without local search 0.02
    std::uint32_t nearness = 2;  ///< power of 1 / distance, up to 8
    std::uint32_t neighbours = 0;  ///< that are looked at first; 0: 20, without local search 15
    std::uint64_t seed = 1;
};

/// Stuetzle and Hoos, "MAX-MIN Ant System", Future Generation Computer Systems 16, 2000: the
/// iteration's best tour, or now and then the best since trails were laid anew, gets pheromone;
/// trails stay between limits that follow from the best tour; they are laid anew where the search
/// stands still. PheromoneTrails are kept for near neighbours only; an ant that has visited all of
/// them goes to the nearest place that it has not (Skinderowicz, "Improving ant colony optimization
/// efficiency for solving large TSP instances", Applied Soft Computing 120, 2022, section 3).
/// Deterministic by seed; no allocation after construction.
class MaxMin {
  public:
    /// `distances` must outlive this.
    MaxMin(const Distances& distances, const MaxMinSettings& settings);

    /// Iterates until so many tours were made in all, or one is no longer than `target`; whether
    /// one is.
    bool run(std::uint64_t most_tours, std::int64_t target = 0);

    [[nodiscard]] std::span<const Place> best() const { return best_; }

    [[nodiscard]] std::int64_t best_length() const { return best_length_; }

    /// Made so far: the measure of work.
    [[nodiscard]] std::uint64_t tours() const { return tours_; }

    /// How often trails were laid anew.
    [[nodiscard]] std::uint32_t restarts() const { return restarts_; }

  private:
    void iterate();
    void walk();
    Place next_of(Place from);
    Place nearest_open(Place from) const;
    void lay_anew();
    void set_limits(std::int64_t length);
    void deposit(std::span<const Place> tour, std::int64_t length);
    void deposit_on(Place from, Place to, float amount);
    void weigh();
    [[nodiscard]] bool deposits_best() const;

    const Distances& distances_;
    MaxMinSettings settings_;
    std::size_t near_ = 0;            // neighbours of each place
    std::vector<Neighbour> nearest_;  // near_ of each
    std::vector<Place> near_place_;   // the same without lengths
    std::vector<float> nearness_;     // by neighbour
    std::vector<float> trail_;
    std::vector<float> weight_;  // trail times nearness
    std::vector<float> share_;   // scratch of one choice
    std::vector<float> open_;    // 1: not visited yet
    std::vector<Place> walked_;
    Tour tour_;
    core::Rng rng_;
    std::vector<Place> iteration_best_, since_restart_, best_;
    std::int64_t iteration_length_ = 0;
    std::int64_t since_restart_length_ = 0;
    std::int64_t best_length_ = INT64_MAX;
    float most_trail_ = 1.0F;
    float least_trail_ = 0.0F;
    double root_ = 0.0;  // of the chance to make the best tour again
    std::uint64_t tours_ = 0;
    std::uint32_t since_better_ = 0;   // iterations
    std::uint32_t in_this_start_ = 0;  // iterations
    std::uint32_t restarts_ = 0;
};

}  // namespace zoned::ai::pathfinding
