// RowSet: a set of rows as bits, which is walked in ascending order and follows rows that move into
// gaps.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::world {

using Row = std::uint32_t;
inline constexpr Row kNoRow = 0xFFFFFFFFu;

/// A walk costs one look per 64 rows and one per member.
class RowSet {
  public:
    static constexpr std::size_t kWordRows = 64;

    /// One more row, at the end.
    void push_back(bool in) {
        if (size_ % kWordRows == 0) {
            words_.push_back(0);
        }
        ++size_;
        put(static_cast<Row>(size_ - 1), in);
    }

    /// Without the row; the last one takes its place.
    void move_last_into(Row row) {
        const Row last = static_cast<Row>(size_ - 1);
        put(row, has(last));
        put(last, false);
        --size_;
        if (size_ % kWordRows == 0) {
            words_.pop_back();
        }
    }

    void put(Row row, bool in) {
        const std::uint64_t bit = std::uint64_t{1} << (row % kWordRows);
        std::uint64_t& word = words_[row / kWordRows];
        word = in ? word | bit : word & ~bit;
    }

    [[nodiscard]] bool has(Row row) const {
        return (words_[row / kWordRows] >> (row % kWordRows) & 1U) != 0;
    }

    /// Rows that exist, in the set or not.
    [[nodiscard]] std::size_t size() const { return size_; }

    [[nodiscard]] std::size_t words() const { return words_.size(); }

    /// Rows 64 * `word` and on, from the lowest bit up.
    [[nodiscard]] std::uint64_t word(std::size_t word) const { return words_[word]; }

    /// The first member from `row` on, or kNoRow.
    [[nodiscard]] Row next(Row row) const {
        if (row >= size_) {
            return kNoRow;
        }
        std::size_t at = row / kWordRows;
        std::uint64_t word = words_[at] & (~std::uint64_t{0} << (row % kWordRows));
        while (word == 0) {
            if (++at == words_.size()) {
                return kNoRow;
            }
            word = words_[at];
        }
        return static_cast<Row>(at * kWordRows + static_cast<std::size_t>(std::countr_zero(word)));
    }

    [[nodiscard]] std::size_t count() const {
        std::size_t members = 0;
        for (const std::uint64_t word : words_) {
            members += static_cast<std::size_t>(std::popcount(word));
        }
        return members;
    }

    void clear() {
        for (std::uint64_t& word : words_) {
            word = 0;
        }
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(size_, words_);
        if constexpr (Archive::kReads) {
            if (words_.size() != (size_ + kWordRows - 1) / kWordRows) {
                archive.fail("a set of rows has another size than it says");
            }
        }
    }

  private:
    std::vector<std::uint64_t> words_;
    std::size_t size_ = 0;
};

/// Calls visit(row) for the members of `set`, ascending. `visit` may put rows in and out: those of
/// the 64 rows that it stands in are visited as they were.
template <class Visit>
void for_each_row(const RowSet& set, Visit&& visit) {
    for (std::size_t w = 0; w < set.words(); ++w) {
        for (std::uint64_t word = set.word(w); word != 0; word &= word - 1) {
            visit(static_cast<Row>(w * RowSet::kWordRows +
                                   static_cast<std::size_t>(std::countr_zero(word))));
        }
    }
}

/// Likewise for rows that are in one of both sets, which hold the same number of rows.
template <class Visit>
void for_each_row(const RowSet& a, const RowSet& b, Visit&& visit) {
    for (std::size_t w = 0; w < a.words(); ++w) {
        for (std::uint64_t word = a.word(w) | b.word(w); word != 0; word &= word - 1) {
            visit(static_cast<Row>(w * RowSet::kWordRows +
                                   static_cast<std::size_t>(std::countr_zero(word))));
        }
    }
}

}  // namespace zoned::world
