// build: hot loops
#include "server/ai/ants/tour.h"

#include <algorithm>
#include <array>

namespace zoned::ai::pathfinding {

namespace {

constexpr std::size_t kLongestPiece = 3;  ///< places that Or-opt moves

}  // namespace

void Tour::set(std::span<const Place> order) {
    for (std::size_t i = 0; i < order.size(); ++i) {
        put(i, order[i]);
    }
}

void Tour::look_again(Place p) {
    if (queued_[p] == 0) {
        queued_[p] = 1;
        queue_.push_back(p);
    }
}

/// Of the two ways around, the shorter one: the tour is the same, read backwards.
void Tour::reverse(Place first, Place last) {
    const std::size_t n = order_.size();
    std::size_t i = at_[first];
    std::size_t j = at_[last];
    std::size_t inside = places_after(first, last) + 1;
    if (2 * inside > n) {
        std::swap(i, j);
        i = i + 1 < n ? i + 1 : 0;
        j = j > 0 ? j - 1 : n - 1;
        inside = n - inside;
    }
    for (std::size_t k = inside / 2; k > 0; --k) {
        const Place p = order_[i];
        put(i, order_[j]);
        put(j, p);
        i = i + 1 < n ? i + 1 : 0;
        j = j > 0 ? j - 1 : n - 1;
    }
}

void Tour::move(Place first, std::size_t count, Place left, bool turned) {
    const std::size_t n = order_.size();
    std::array<Place, kLongestPiece> piece{};
    std::size_t i = at_[first];
    for (std::size_t k = 0; k < count; ++k) {
        piece[k] = order_[i + k < n ? i + k : i + k - n];
    }
    if (turned) {
        std::reverse(piece.begin(), piece.begin() + static_cast<std::ptrdiff_t>(count));
    }
    // Those between the piece and its new place make room, on the side where they are fewer.
    const std::size_t onwards = places_after(first, left) + 1 - count;
    const std::size_t back = n - count - onwards;
    if (onwards <= back) {
        for (std::size_t k = 0; k < onwards; ++k) {
            put(i, order_[i + count < n ? i + count : i + count - n]);
            i = i + 1 < n ? i + 1 : 0;
        }
    } else {
        i = i + count - 1 < n ? i + count - 1 : i + count - 1 - n;
        for (std::size_t k = 0; k < back; ++k) {
            put(i, order_[i >= count ? i - count : i + n - count]);
            i = i > 0 ? i - 1 : n - 1;
        }
        i = i + 1 >= count ? i + 1 - count : i + 1 + n - count;
    }
    for (std::size_t k = 0; k < count; ++k) {
        put(i, piece[k]);
        i = i + 1 < n ? i + 1 : 0;
    }
}

/// Edges a-next and b-next (or both before) become a-b and next-next.
std::int64_t Tour::try_two_opt(const Near& near, Place a) {
    const Distances& d = near.distances;
    for (const bool onwards : {true, false}) {
        const Place a1 = onwards ? after(a) : before(a);
        const Length own = d.between(a, a1);
        for (const auto& [b, joined] : near.of(a)) {
            if (joined >= own) {
                break;
            }
            const Place b1 = onwards ? after(b) : before(b);
            const Length gain = own + d.between(b, b1) - joined - d.between(a1, b1);
            if (gain > 0) {
                if (onwards) {
                    reverse(a1, b);
                } else {
                    reverse(a, b1);
                }
                for (const Place p : {a, a1, b, b1}) {
                    look_again(p);
                }
                return gain;
            }
        }
    }
    return 0;
}

/// The path from `first` on to `last` goes to where `first` (or `last`, if not forward) is next to
/// a near neighbour.
std::int64_t Tour::try_insertions(const Near& near,
                                  Place first,
                                  Place last,
                                  std::size_t count,
                                  bool forward) {
    const Distances& d = near.distances;
    const Place left = before(first);
    const Place right = after(last);
    const Length freed = d.between(left, first) + d.between(last, right) - d.between(left, right);
    const Place end = forward ? first : last;    // next to the neighbour
    const Place other = forward ? last : first;  // next to one beside the neighbour
    for (const auto& [b, joined] : near.of(end)) {
        if (joined >= freed) {
            break;
        }
        if (places_after(first, b) < count) {
            continue;  // on the way itself
        }
        for (const bool beyond : {true, false}) {
            const Place c = beyond ? after(b) : before(b);
            if (places_after(first, c) < count) {
                continue;
            }
            const Length gain = freed - joined - d.between(other, c) + d.between(b, c);
            if (gain > 0) {
                // Between b and c in the order of the tour, with `end` beside b.
                move(first, count, beyond ? b : c, beyond != forward);
                for (const Place p : {left, right, first, last, b, c}) {
                    look_again(p);
                }
                return gain;
            }
        }
    }
    return 0;
}

std::int64_t Tour::try_or_opt(const Near& near, Place a) {
    Place onwards = a;
    Place back = a;
    for (std::size_t count = 1; count <= kLongestPiece && count + 2 < order_.size(); ++count) {
        // `a` at either end of the piece is what comes next to its neighbour.
        std::int64_t gain = try_insertions(near, a, onwards, count, true);
        if (gain == 0 && count > 1) {
            gain = try_insertions(near, back, a, count, false);
        }
        if (gain > 0) {
            return gain;
        }
        onwards = after(onwards);
        back = before(back);
    }
    return 0;
}

std::int64_t Tour::improve(const Distances& distances,
                           std::span<const Neighbour> nearest,
                           std::size_t per_place,
                           LocalSearch search) {
    std::int64_t gained = 0;
    if (search == LocalSearch::kNone) {
        return gained;
    }
    const Near near{distances, nearest, per_place};
    queue_.assign(order_.begin(), order_.end());
    std::fill(queued_.begin(), queued_.end(), std::uint8_t{1});
    while (!queue_.empty()) {
        const Place a = queue_.back();
        queue_.pop_back();
        queued_[a] = 0;
        std::int64_t gain = try_two_opt(near, a);
        if (gain == 0 && search == LocalSearch::kOrOpt) {
            gain = try_or_opt(near, a);
        }
        if (gain > 0) {
            look_again(a);
            gained += gain;
        }
    }
    return gained;
}

}  // namespace zoned::ai::pathfinding
