// Disjoint sets: numbers that are joined two by two, and which of them hang together.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace zoned::core {

/// The root of a set, with path halving (Tarjan, "Efficiency of a good but not linear set union
/// algorithm", JACM 22, 1975). `parent(i)` is a reference to the number that i hangs on, which is
/// no larger; a root hangs on itself.
template <class Parent>
std::uint32_t root_of_set(const Parent& parent, std::uint32_t at) {
    while (parent(at) != at) {
        parent(at) = parent(parent(at));
        at = parent(at);
    }
    return at;
}

/// The smaller root becomes that of both sets.
template <class Parent>
void join_sets(const Parent& parent, std::uint32_t a, std::uint32_t b) {
    a = root_of_set(parent, a);
    b = root_of_set(parent, b);
    parent(std::max(a, b)) = parent(std::min(a, b));
}

/// `parent` of the functions above, kept in an array.
inline auto parents_in(std::span<std::uint32_t> parents) {
    return [parents](std::uint32_t i) -> std::uint32_t& {
        return parents[i];
    };
}

/// Sets over 0..n-1.
class DisjointSets {
  public:
    void reserve(std::size_t n) { parent_.reserve(n); }

    /// Each number is a set of its own.
    void reset(std::size_t n) {
        parent_.resize(n);
        std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
    }

    std::uint32_t root(std::uint32_t i) { return root_of_set(parents_in(parent_), i); }

    void join(std::uint32_t a, std::uint32_t b) { join_sets(parents_in(parent_), a, b); }

  private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace zoned::core
