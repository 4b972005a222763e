// UnionFind: disjoint sets of the numbers 0..n-1, joined in pairs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::core {

/// Disjoint sets with path halving; the root of a set is its smallest number, whatever the order of
/// the joins (Tarjan, "Efficiency of a good but not linear set union algorithm", JACM 22, 1975).
class UnionFind {
  public:
    void reserve(std::size_t n) { parent_.reserve(n); }

    /// Sets of one number each.
    void reset(std::size_t n) {
        parent_.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            parent_[i] = static_cast<std::uint32_t>(i);
        }
    }

    /// Resizes to the numbers below n; each new number is its own set.
    void grow(std::size_t n) {
        for (std::size_t i = parent_.size(); i < n; ++i) {
            parent_.push_back(static_cast<std::uint32_t>(i));
        }
    }

    /// Makes the number its own set again; all numbers that hang on it must be reset too.
    void part(std::uint32_t i) { parent_[i] = i; }

    std::uint32_t root(std::uint32_t i) {
        while (parent_[i] != i) {
            parent_[i] = parent_[parent_[i]];
            i = parent_[i];
        }
        return i;
    }

    void join(std::uint32_t a, std::uint32_t b) {
        a = root(a);
        b = root(b);
        parent_[a > b ? a : b] = a > b ? b : a;
    }

    [[nodiscard]] std::size_t bytes() const { return parent_.capacity() * sizeof(std::uint32_t); }

  private:
    std::vector<std::uint32_t> parent_;
};

}  // namespace zoned::core
