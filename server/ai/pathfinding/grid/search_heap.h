// SearchHeap: what a search over a graph has reached and not yet looked at, cheapest first.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace zoned::ai::pathfinding {

/// Stands beside OpenList, whose costs are whole numbers and whose ties are as the calls were. Here
/// costs may be fractions, and ties go to the smaller `node`, so that a path does not depend on the
/// order in which links were looked at. A node that became cheaper is pushed again: the search
/// passes over its older entry. `Entry` has a `key` and a `node`.
template <class Entry>
class SearchHeap {
  public:
    void clear() { entries_.clear(); }

    [[nodiscard]] bool empty() const { return entries_.empty(); }

    void push(const Entry& entry) {
        entries_.push_back(entry);
        std::push_heap(entries_.begin(), entries_.end(), later);
    }

    /// Takes out the first entry; there is one.
    Entry pop() {
        std::pop_heap(entries_.begin(), entries_.end(), later);
        const Entry first = entries_.back();
        entries_.pop_back();
        return first;
    }

    [[nodiscard]] std::size_t bytes() const { return entries_.capacity() * sizeof(Entry); }

  private:
    static constexpr auto later = [](const Entry& a, const Entry& b) {
        return a.key > b.key || (a.key == b.key && a.node > b.node);
    };

    std::vector<Entry> entries_;
};

}  // namespace zoned::ai::pathfinding
