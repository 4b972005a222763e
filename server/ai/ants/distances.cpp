#include "server/ai/ants/distances.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <queue>
#include <string>
#include <tuple>
#include <utility>

namespace zoned::ai::pathfinding {

namespace {

using Made = core::Result<Distances>;

std::string size_fault(std::size_t size) {
    return size < 3 || size > Distances::kMostPlaces
               ? std::to_string(size) + " places; there must be from 3 to " +
                     std::to_string(Distances::kMostPlaces)
               : std::string();
}

constexpr std::int64_t kUnreached = INT64_MAX;

/// Dijkstra over arcs that are sorted by their first place.
void reach(std::span<const Distances::Edge> arcs,
           std::span<const std::size_t> begin,
           Place from,
           std::vector<std::int64_t>& path) {
    std::fill(path.begin(), path.end(), kUnreached);
    using Reached = std::pair<std::int64_t, Place>;
    std::priority_queue<Reached, std::vector<Reached>, std::greater<>> open;
    path[from] = 0;
    open.push({0, from});
    while (!open.empty()) {
        const auto [length, at] = open.top();
        open.pop();
        if (length > path[at]) {
            continue;
        }
        for (std::size_t i = begin[at]; i < begin[at + 1]; ++i) {
            const std::int64_t to = length + arcs[i].length;
            if (to < path[arcs[i].b]) {
                path[arcs[i].b] = to;
                open.push({to, arcs[i].b});
            }
        }
    }
}

std::string edge_fault(std::size_t size, std::span<const Distances::Edge> edges) {
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const Distances::Edge& e = edges[i];
        if (e.a >= size || e.b >= size || e.length < 0 || e.length > Distances::kLongest) {
            return "edge " + std::to_string(i) + " from place " + std::to_string(e.a) + " to " +
                   std::to_string(e.b) + " of length " + std::to_string(e.length) +
                   " is not between two places, or its length is not from 0 to " +
                   std::to_string(Distances::kLongest);
        }
    }
    return {};
}

}  // namespace

Made Distances::make(std::size_t size, std::vector<Length> lengths) {
    if (const std::string fault = size_fault(size); !fault.empty()) {
        return Made::failure(fault);
    }
    if (lengths.size() != size * size) {
        return Made::failure(std::to_string(lengths.size()) + " distances for " +
                             std::to_string(size) + " places");
    }
    for (std::size_t a = 0; a < size; ++a) {
        for (std::size_t b = a; b < size; ++b) {
            const Length d = lengths[a * size + b];
            if (d != lengths[b * size + a] || d < 0 || d > kLongest || (a == b && d != 0)) {
                return Made::failure(
                    "the distance from place " + std::to_string(a) + " to " + std::to_string(b) +
                    " is " + std::to_string(d) + ", back " + std::to_string(lengths[b * size + a]) +
                    "; both must be the same, from 0 to " + std::to_string(kLongest));
            }
        }
    }
    return Distances(size, std::move(lengths));
}

Made Distances::of_graph(std::size_t size, std::span<const Edge> edges) {
    std::string fault = size_fault(size);
    fault = fault.empty() ? edge_fault(size, edges) : fault;
    if (!fault.empty()) {
        return Made::failure(fault);
    }
    std::vector<Edge> arcs;
    for (const Edge& e : edges) {
        arcs.push_back(e);
        arcs.push_back({e.b, e.a, e.length});
    }
    std::sort(arcs.begin(), arcs.end(), [](const Edge& p, const Edge& q) {
        return std::tie(p.a, p.b, p.length) < std::tie(q.a, q.b, q.length);
    });
    std::vector<std::size_t> begin(size + 1, 0);
    for (const Edge& arc : arcs) {
        ++begin[arc.a + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Length> lengths(size * size);
    std::vector<std::int64_t> path(size);
    for (Place from = 0; from < size; ++from) {
        reach(arcs, begin, from, path);
        for (Place to = 0; to < size; ++to) {
            if (path[to] > kLongest) {
                return Made::failure("no path, or too long a one, from place " +
                                     std::to_string(from) + " to " + std::to_string(to));
            }
            lengths[from * size + to] = static_cast<Length>(path[to]);
        }
    }
    return make(size, std::move(lengths));
}

std::vector<Neighbour> Distances::nearest(std::size_t count) const {
    std::vector<Place> all(size_);
    std::vector<Neighbour> lists;
    lists.reserve(size_ * count);
    for (Place from = 0; from < size_; ++from) {
        all.clear();
        for (Place to = 0; to < size_; ++to) {
            if (to != from) {
                all.push_back(to);
            }
        }
        const auto middle = all.begin() + static_cast<std::ptrdiff_t>(count);
        std::partial_sort(all.begin(), middle, all.end(), [&](Place a, Place b) {
            return std::pair(between(from, a), a) < std::pair(between(from, b), b);
        });
        for (auto to = all.begin(); to != middle; ++to) {
            lists.push_back({*to, between(from, *to)});
        }
    }
    return lists;
}

std::int64_t Distances::length_of(std::span<const Place> tour) const {
    std::int64_t sum = 0;
    for (std::size_t i = 0; i < tour.size(); ++i) {
        sum += between(tour[i], tour[i + 1 < tour.size() ? i + 1 : 0]);
    }
    return sum;
}

}  // namespace zoned::ai::pathfinding
