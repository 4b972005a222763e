// Query sinks: collect the answers to a query: the nearest, any, or all that find room.
#pragma once

#include "server/physics/query/query.h"

#include <algorithm>
#include <span>

namespace zoned::physics {

/// Of equal distances the lower id comes first, whatever the order of the search.
inline bool comes_before(const QueryHit& a, const QueryHit& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.body < b.body;
}

// Each sink has take(hit, limit): it returns how far away other hits are still of interest, less
// than zero when none is. Hits may come in any order and more than once.

struct NearestSink {
    QueryHit& best;
    bool found = false;

    float take(const QueryHit& hit, float limit) {
        if (found && !comes_before(hit, best)) {
            return limit;
        }
        best = hit;
        found = true;
        return hit.distance;
    }
};

struct AnySink {
    bool found = false;

    float take(const QueryHit&, float) {
        found = true;
        return -1.0F;
    }
};

/// Keeps the nearest ones as a heap with the farthest on top.
struct AllSink {
    std::span<QueryHit> hits;
    QueryCount count{};

    float take(const QueryHit& hit, float limit) {
        const auto begin = hits.begin();
        const auto end = begin + static_cast<std::ptrdiff_t>(count.written);
        if (std::any_of(begin, end, [&](const QueryHit& h) { return h.body == hit.body; })) {
            return limit;
        }
        if (count.written < hits.size()) {
            hits[count.written++] = hit;
            std::push_heap(begin, end + 1, comes_before);
            return limit;
        }
        count.more = true;
        if (hits.empty()) {
            return -1.0F;
        }
        if (comes_before(hit, hits[0])) {
            std::pop_heap(begin, end, comes_before);
            *(end - 1) = hit;
            std::push_heap(begin, end, comes_before);
        }
        return hits[0].distance;
    }

    QueryCount sorted() {
        std::sort(
            hits.begin(), hits.begin() + static_cast<std::ptrdiff_t>(count.written), comes_before);
        return count;
    }
};

/// Keeps the lowest ids as a heap with the highest on top. Each id comes once.
struct IdSink {
    std::span<BodyId> ids;
    QueryCount count{};

    void take(BodyId id) {
        const auto begin = ids.begin();
        const auto end = begin + static_cast<std::ptrdiff_t>(count.written);
        if (count.written < ids.size()) {
            ids[count.written++] = id;
            std::push_heap(begin, end + 1);
            return;
        }
        count.more = true;
        if (!ids.empty() && id < ids[0]) {
            std::pop_heap(begin, end);
            *(end - 1) = id;
            std::push_heap(begin, end);
        }
    }

    QueryCount sorted() {
        std::sort(ids.begin(), ids.begin() + static_cast<std::ptrdiff_t>(count.written));
        return count;
    }
};

}  // namespace zoned::physics
