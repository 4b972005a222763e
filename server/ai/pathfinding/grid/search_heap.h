// SearchHeap: the open nodes of a search over a graph, not yet expanded, cheapest first.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace zoned::ai::pathfinding {

/// SearchHeap differs from OpenList, whose costs are whole numbers and whose ties follow the calls.
/// Here costs may be fractions, and ties go to the smaller `node`. So a path does not depend on the
/// order in which links were looked at. A node that became cheaper is pushed again; the search
/// skips its older entry. `Entry` has a `key` and a `node`.
template <class Entry>
class SearchHeap {
  public:
    void clear() { entries_.clear(); }

    [[nodiscard]] bool empty() const { return entries_.empty(); }

    void push(const Entry& entry) {
        entries_.push_back(entry);
        std::push_heap(entries_.begin(), entries_.end(), later);
    }

    /// Takes out the first entry; the heap must not be empty.
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
