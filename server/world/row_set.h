// RowSet: a set of rows as bits, which is walked in ascending order and follows rows that move into
// gaps.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::world {

using Row = std::uint32_t;
inline constexpr Row kNoRow = 0xFFFFFFFFu;

/// A walk costs one look per member and one per 4,096 rows, so that the rows of a large world that
/// are not in the set cost nothing to speak of.
class RowSet {
  public:
    static constexpr std::size_t kWordRows = 64;

    /// One more row, at the end.
    void push_back(bool in) {
        if (size_ % kWordRows == 0) {
            if (words_.size() % kWordRows == 0) {
                summary_.push_back(0);
            }
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
            if (words_.size() % kWordRows == 0) {
                summary_.pop_back();
            }
        }
    }

    void put(Row row, bool in) {
        const std::size_t at = row / kWordRows;
        const std::uint64_t bit = std::uint64_t{1} << (row % kWordRows);
        std::uint64_t& word = words_[at];
        count_ += static_cast<std::size_t>(in) - static_cast<std::size_t>((word & bit) != 0);
        word = in ? word | bit : word & ~bit;
        const std::uint64_t its = std::uint64_t{1} << (at % kWordRows);
        std::uint64_t& summary = summary_[at / kWordRows];
        summary = word != 0 ? summary | its : summary & ~its;
    }

    [[nodiscard]] bool has(Row row) const {
        return (words_[row / kWordRows] >> (row % kWordRows) & 1U) != 0;
    }

    /// Rows that exist, in the set or not.
    [[nodiscard]] std::size_t size() const { return size_; }

    [[nodiscard]] std::size_t words() const { return words_.size(); }

    /// Rows 64 * `word` and on, from the lowest bit up.
    [[nodiscard]] std::uint64_t word(std::size_t word) const { return words_[word]; }

    /// The first word from `word` on that holds a member, or words().
    [[nodiscard]] std::size_t next_word(std::size_t word) const {
        if (word >= words_.size()) {
            return words_.size();
        }
        std::size_t at = word / kWordRows;
        std::uint64_t summary = summary_[at] & (~std::uint64_t{0} << (word % kWordRows));
        while (summary == 0) {
            if (++at == summary_.size()) {
                return words_.size();
            }
            summary = summary_[at];
        }
        return at * kWordRows + static_cast<std::size_t>(std::countr_zero(summary));
    }

    /// The first member from `row` on, or kNoRow.
    [[nodiscard]] Row next(Row row) const {
        if (row >= size_) {
            return kNoRow;
        }
        std::size_t at = row / kWordRows;
        std::uint64_t word = words_[at] & (~std::uint64_t{0} << (row % kWordRows));
        if (word == 0) {
            at = next_word(at + 1);
            if (at == words_.size()) {
                return kNoRow;
            }
            word = words_[at];
        }
        return static_cast<Row>(at * kWordRows + static_cast<std::size_t>(std::countr_zero(word)));
    }

    /// Members.
    [[nodiscard]] std::size_t count() const { return count_; }

    /// Costs what the set holds.
    void clear() {
        for (std::size_t w = next_word(0); w < words_.size(); w = next_word(w + 1)) {
            words_[w] = 0;
        }
        for (std::uint64_t& summary : summary_) {
            summary = 0;
        }
        count_ = 0;
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(size_, words_);
        if constexpr (Archive::kReads) {
            if (words_.size() != (size_ + kWordRows - 1) / kWordRows) {
                archive.fail("a set of rows has another size than it says");
            }
            summarize();
        }
    }

  private:
    void summarize() {
        summary_.assign((words_.size() + kWordRows - 1) / kWordRows, 0);
        count_ = 0;
        for (std::size_t w = 0; w < words_.size(); ++w) {
            count_ += static_cast<std::size_t>(std::popcount(words_[w]));
            summary_[w / kWordRows] |= static_cast<std::uint64_t>(words_[w] != 0)
                                       << (w % kWordRows);
        }
    }

    std::vector<std::uint64_t> words_;
    std::vector<std::uint64_t> summary_;  // a bit for each word: it holds a member
    std::size_t size_ = 0;
    std::size_t count_ = 0;
};

/// Calls visit(row) for the members of `set`, ascending. `visit` may put rows in and out: those of
/// the 64 rows that it stands in are visited as they were.
template <class Visit>
void for_each_row(const RowSet& set, Visit&& visit) {
    for (std::size_t w = set.next_word(0); w < set.words(); w = set.next_word(w + 1)) {
        for (std::uint64_t word = set.word(w); word != 0; word &= word - 1) {
            visit(static_cast<Row>(w * RowSet::kWordRows +
                                   static_cast<std::size_t>(std::countr_zero(word))));
        }
    }
}

/// Likewise for rows that are in one of both sets, which hold the same number of rows.
template <class Visit>
void for_each_row(const RowSet& a, const RowSet& b, Visit&& visit) {
    const auto next = [&](std::size_t from) {
        return std::min(a.next_word(from), b.next_word(from));
    };
    for (std::size_t w = next(0); w < a.words(); w = next(w + 1)) {
        for (std::uint64_t word = a.word(w) | b.word(w); word != 0; word &= word - 1) {
            visit(static_cast<Row>(w * RowSet::kWordRows +
                                   static_cast<std::size_t>(std::countr_zero(word))));
        }
    }
}

}  // namespace zoned::world
