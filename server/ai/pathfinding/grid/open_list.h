// OpenList: the open nodes of a search, reached but not yet expanded, cheapest first.
#pragma once

#include "server/ai/pathfinding/grid/cost.h"
#include "shared/core/containers/zero_pages.h"

#include <cstdint>
#include <vector>

namespace zoned::ai::pathfinding {

/// A heap of four children to a node, with the position of each entry, so that an entry can become
/// cheaper. It never holds more than one entry for each node. Source: Johnson, "Priority queues
/// with update and finding minimum spanning trees", Information Processing Letters 4, 1975. Equal
/// keys come out in an order that depends on the calls alone.
class OpenList {
  public:
    /// From now on nodes are smaller than `nodes`; empties the list.
    void resize(std::uint32_t nodes) {
        heap_.clear();
        heap_.reserve(nodes);
        at_ = core::ZeroPages<std::uint32_t>(nodes);
    }

    [[nodiscard]] bool empty() const { return heap_.empty(); }

    void clear() { heap_.clear(); }

    /// Adds the node, or makes it cheaper; a key that is not smaller changes nothing.
    void push(std::uint32_t node, std::uint64_t key) {
        std::uint32_t i = at_[node];
        if (!contains(node)) {
            i = static_cast<std::uint32_t>(heap_.size());
            heap_.push_back({key, node});
        } else if (key >= heap_[i].key) {
            return;
        }
        rise({key, node}, i);
    }

    /// The position of a node without an entry may be anything: its entry would name it. Source:
    /// Briggs and Torczon, "An efficient representation for sparse sets", LOPLAS 2, 1993.
    [[nodiscard]] bool contains(std::uint32_t node) const {
        return at_[node] < heap_.size() && heap_[at_[node]].node == node;
    }

    /// Takes out the node with the smallest key; the list must not be empty.
    std::uint32_t pop() {
        const std::uint32_t node = heap_.front().node;
        const OpenEntry last = heap_.back();
        heap_.pop_back();
        if (!heap_.empty()) {
            sink(last);
        }
        return node;
    }

  private:
    struct OpenEntry {
        std::uint64_t key;
        std::uint32_t node;
    };

    void rise(const OpenEntry& e, std::uint32_t i) {
        while (i != 0) {
            const std::uint32_t above = (i - 1) / 4;
            if (heap_[above].key <= e.key) {
                break;
            }
            heap_[i] = heap_[above];
            at_[heap_[i].node] = i;
            i = above;
        }
        heap_[i] = e;
        at_[e.node] = i;
    }

    void sink(const OpenEntry& e) {
        const auto size = static_cast<std::uint32_t>(heap_.size());
        std::uint32_t i = 0;
        while (true) {
            const std::uint32_t first = 4 * i + 1;
            if (first >= size) {
                break;
            }
            std::uint32_t best = first;
            const std::uint32_t end = first + 4 < size ? first + 4 : size;
            for (std::uint32_t c = first + 1; c < end; ++c) {
                best = heap_[c].key < heap_[best].key ? c : best;
            }
            if (e.key <= heap_[best].key) {
                break;
            }
            heap_[i] = heap_[best];
            at_[heap_[i].node] = i;
            i = best;
        }
        heap_[i] = e;
        at_[e.node] = i;
    }

    std::vector<OpenEntry> heap_;
    core::ZeroPages<std::uint32_t> at_;  // by node: its position in heap_, where it has one
};

/// SearchSpace: a search's data about each node. A new search forgets them without touching all of
/// them.
class SearchSpace {
  public:
    void resize(std::uint32_t nodes) {
        known_ = core::ZeroPages<KnownNode>(nodes);
        open.resize(nodes);
        search_ = 0;
    }

    /// Starts a new search.
    void begin() {
        open.clear();
        if (++search_ == 0) {
            known_ = core::ZeroPages<KnownNode>(known_.size());
            search_ = 1;
        }
    }

    /// kNoCost for a node that was not reached.
    [[nodiscard]] Cost cost(std::uint32_t node) const {
        return known_[node].search == search_ ? known_[node].cost : kNoCost;
    }

    /// The node before it on its path; the node must have been reached.
    [[nodiscard]] std::uint32_t from(std::uint32_t node) const { return known_[node].from; }

    void reach(std::uint32_t node, Cost cost, std::uint32_t from, std::uint32_t tag = 0) {
        known_[node] = {search_, cost, from, tag};
    }

    /// Free data of the search about a node that was reached.
    std::uint32_t& tag(std::uint32_t node) { return known_[node].tag; }

    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(known_.size()); }

    OpenList open;

  private:
    struct KnownNode {
        std::uint32_t search = 0;
        Cost cost = 0;
        std::uint32_t from = 0;
        std::uint32_t tag = 0;
    };

    core::ZeroPages<KnownNode> known_;
    std::uint32_t search_ = 0;
};

}  // namespace zoned::ai::pathfinding
