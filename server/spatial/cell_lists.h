// CellLists: items listed by the cells of a grid in which they lie; made once, in two arrays.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::spatial {

class CellLists {
  public:
    /// `cells_of(item, take)` calls `take(cell)` for each cell of an item, below `cells`. It is
    /// asked twice, to count and to fill. Within a cell items ascend.
    template <class CellsOf>
    void build(std::size_t cells, std::uint32_t items, const CellsOf& cells_of) {
        first_.assign(cells + 1, 0);
        for (std::uint32_t item = 0; item < items; ++item) {
            cells_of(item, [this](std::size_t cell) { ++first_[cell + 1]; });
        }
        for (std::size_t c = 1; c < first_.size(); ++c) {
            first_[c] += first_[c - 1];
        }
        items_.resize(first_.back());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for (std::uint32_t item = 0; item < items; ++item) {
            cells_of(item, [&](std::size_t cell) { items_[next[cell]++] = item; });
        }
    }

    [[nodiscard]] std::span<const std::uint32_t> of(std::size_t cell) const {
        return {items_.data() + first_[cell], items_.data() + first_[cell + 1]};
    }

    [[nodiscard]] std::size_t bytes() const {
        return (first_.capacity() + items_.capacity()) * sizeof(std::uint32_t);
    }

  private:
    std::vector<std::uint32_t> first_;  // by cell, and one more
    std::vector<std::uint32_t> items_;
};

}  // namespace zoned::spatial
