// CornerPool: the corners of all paths of a zone, in one array.
#pragma once

#include "server/ai/pathfinding/grid/ground_grid.h"

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::ai::pathfinding {

/// CornerBlock: the position of one path's corners in the pool.
struct CornerBlock {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
};

/// Blocks have sizes of powers of two; each size has a list of free blocks, so nothing is allocated
/// after warm-up. Source: Knuth, The Art of Computer Programming 1, 2.5, without splitting.
template <class T>
class BlockPool {
  public:
    /// Takes room for `count` corners of any content. Spans of other blocks become invalid.
    CornerBlock take(std::uint32_t count) {
        if (count == 0) {
            return {};
        }
        std::vector<std::uint32_t>& free = free_[size_class(count)];
        if (!free.empty()) {
            const CornerBlock block{free.back(), count};
            free.pop_back();
            return block;
        }
        const auto first = static_cast<std::uint32_t>(corners_.size());
        corners_.resize(corners_.size() + std::bit_ceil(count));
        return {first, count};
    }

    void give_back(const CornerBlock& block) {
        if (block.count != 0) {
            free_[size_class(block.count)].push_back(block.first);
        }
    }

    [[nodiscard]] std::span<T> of(const CornerBlock& block) {
        return {corners_.data() + block.first, block.count};
    }

    [[nodiscard]] std::span<const T> of(const CornerBlock& block) const {
        return {corners_.data() + block.first, block.count};
    }

    /// Prefetches the first of them for a caller that will read them soon.
    void fetch(const CornerBlock& block) const {
        constexpr std::uint32_t kLine = 64 / sizeof(T);
        for (std::uint32_t i = 0; i < block.count && i < kLines * kLine; i += kLine) {
            __builtin_prefetch(corners_.data() + block.first + i);
        }
    }

    [[nodiscard]] std::size_t bytes() const {
        std::size_t bytes = corners_.capacity() * sizeof(T);
        for (const auto& f : free_) {
            bytes += f.capacity() * sizeof(std::uint32_t);
        }
        return bytes;
    }

  private:
    static constexpr std::uint32_t kLines = 8;

    static std::size_t size_class(std::uint32_t count) {
        return static_cast<std::size_t>(std::countr_zero(std::bit_ceil(count)));
    }

    std::vector<T> corners_;
    std::array<std::vector<std::uint32_t>, 32> free_;
};

using CornerPool = BlockPool<Spot>;

}  // namespace zoned::ai::pathfinding
