// PairFinder: a structure that finds overlapping pairs of moving boxes, ours or a peer's.
#pragma once

#include "shared/math/aabb.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace zoned::bench {

using BoxPair = std::pair<std::uint32_t, std::uint32_t>;  // smaller row first

class PairFinder {
  public:
    PairFinder() = default;
    PairFinder(const PairFinder&) = delete;
    PairFinder& operator=(const PairFinder&) = delete;
    virtual ~PairFinder() = default;

    /// The boxes of the rows `moved` now have the values in `boxes`, by row; finds the pairs.
    virtual void step(std::span<const std::uint32_t> moved, std::span<const Aabb> boxes) = 0;
    /// The pairs that the last step found: at least the overlapping pairs with a row that moved.
    [[nodiscard]] virtual std::vector<BoxPair> pairs() const = 0;
};

struct PairMethod {
    std::string method;
    std::string peer;  ///< empty for ours
    std::function<std::unique_ptr<PairFinder>(std::span<const Aabb> boxes)> build;
};

/// The structures of server/spatial; `default` is the one that it chooses itself.
std::vector<PairMethod> spatial_methods();
/// Bullet's dynamic tree (its default) and its sweep and prune, with their pair caches.
std::vector<PairMethod> bullet_pair_methods();

}  // namespace zoned::bench
