#include "server/ai/pathfinding/grid/components.h"

#include <algorithm>
#include <bit>

namespace zoned::ai::pathfinding {

namespace {

constexpr std::uint32_t kSquareSide = 64;
static_assert(kSquareSide == 64, "a row of a square is a word of the map's bits");

}  // namespace

void Components::label(const GridMap& map) {
    stride_ = map.stride();
    rows_ = map.places() / map.stride();
    across_ = stride_ / kSquareSide;
    const std::size_t squares = std::size_t{across_} * ((rows_ + kSquareSide - 1) / kSquareSide);
    label_.assign(map.places(), 0);
    regions_.assign(squares, 0);
    links_.resize(squares);
    stale_.assign(squares, 0);
    joined_.clear();
    for (std::uint32_t s = 0; s < squares; ++s) {
        label_square(map, s);
    }
    for (std::uint32_t s = 0; s < squares; ++s) {
        link_square(s);
    }
    join_regions();
}

std::uint32_t Components::square_of(Place p) const {
    const std::uint32_t row = p / stride_;
    return row / kSquareSide * across_ + (p - row * stride_) / kSquareSide;
}

void Components::update(const GridMap& map, std::span<const CellChange> changes) {
    if (label_.size() != map.places() || stride_ != map.stride()) {
        label(map);
        return;
    }
    const auto note = [this](std::uint32_t square) {
        if (stale_[square] == 0) {
            stale_[square] = 1;
            stale_squares_.push_back(square);
        }
    };
    stale_squares_.clear();
    beside_.clear();
    for (const CellChange& c : changes) {
        const Place p = map.place(c.cell);
        if (map.passable(p) == (label_[p] != 0)) {
            continue;
        }
        note(square_of(p));
        if (map.passable(p)) {
            for (const Place n : {p - stride_, p + stride_, p - 1, p + 1}) {
                if (label_[n] != 0 && map.passable(n)) {
                    beside_.emplace_back(p, of(n));
                }
            }
        }
    }
    joined_.clear();
    if (stale_squares_.empty()) {
        return;
    }
    for (const std::uint32_t s : stale_squares_) {
        label_square(map, s);
    }
    // Links are kept by the square on the left, and by the one above.
    const std::size_t changed = stale_squares_.size();
    for (std::size_t i = 0; i < changed; ++i) {
        const std::uint32_t s = stale_squares_[i];
        if (s % across_ != 0) {
            note(s - 1);
        }
        if (s >= across_) {
            note(s - across_);
        }
    }
    for (const std::uint32_t s : stale_squares_) {
        link_square(s);
        stale_[s] = 0;
    }
    join_regions();
    // Components that touch the same one now, and were several.
    for (auto& [place, before] : beside_) {
        place = of(place);
    }
    std::sort(beside_.begin(), beside_.end());
    for (std::size_t i = 1; i < beside_.size(); ++i) {
        const auto& [now, before] = beside_[i];
        if (beside_[i - 1].first == now && beside_[i - 1].second != before &&
            (joined_.empty() || joined_.back() != now)) {
            joined_.push_back(now);
        }
    }
}

bool Components::joined_anew(Place p) const {
    return std::binary_search(joined_.begin(), joined_.end(), of(p));
}

void Components::find_runs(const GridMap& map, std::uint32_t square) {
    const std::uint32_t top = square / across_ * kSquareSide;
    const std::uint32_t end = std::min(top + kSquareSide, rows_);
    const std::uint64_t* word = map.row_bits().data() + top * across_ + square % across_;
    runs_.clear();
    joined_runs_.reset(0);
    std::size_t above = 0;
    for (std::uint32_t y = top; y < end; ++y, word += across_) {
        const std::size_t first = runs_.size();
        for (std::uint64_t rest = *word; rest != 0;) {
            // All up to the first gap: adding the lowest bit carries over the run.
            const std::uint64_t run = rest & ~(rest + (rest & -rest));
            rest &= ~run;
            const auto number = static_cast<std::uint32_t>(runs_.size());
            runs_.push_back({run, static_cast<std::uint16_t>(y), 0});
            joined_runs_.grow(runs_.size());
            // Runs of a row ascend: runs above that end before this one are finished.
            for (std::size_t j = above; j < first; ++j) {
                if ((runs_[j].cells & run) != 0) {
                    joined_runs_.join(static_cast<std::uint32_t>(j), number);
                } else if (runs_[j].cells > run) {
                    break;
                }
            }
            while (above < first && runs_[above].cells < (run & -run)) {
                ++above;
            }
        }
        above = first;
    }
}

void Components::label_square(const GridMap& map, std::uint32_t square) {
    find_runs(map, square);
    const std::uint32_t top = square / across_ * kSquareSide;
    const std::uint32_t end = std::min(top + kSquareSide, rows_);
    const std::uint32_t left = square % across_ * kSquareSide;
    for (std::uint32_t y = top; y < end; ++y) {
        std::fill_n(label_.begin() + y * stride_ + left, kSquareSide, Label{0});
    }
    std::uint32_t count = 0;
    for (Run& run : runs_) {
        // Roots come first: theirs is final.
        const Run& root = runs_[joined_runs_.root(static_cast<std::uint32_t>(&run - runs_.data()))];
        run.region = &root == &run ? static_cast<std::uint16_t>(count++) : root.region;
        const auto begin = static_cast<std::uint32_t>(std::countr_zero(run.cells));
        std::fill_n(label_.begin() + run.row * stride_ + left + begin,
                    std::popcount(run.cells),
                    (square << kRegionBits | run.region) + 1);
    }
    regions_[square] = count;
}

void Components::link_square(std::uint32_t square) {
    auto& links = links_[square];
    links.clear();
    const auto touch = [&](Place a, Place b) {
        const std::pair<Label, Label> link(label_[a], label_[b]);
        if (link.first != 0 && link.second != 0 && (links.empty() || links.back() != link)) {
            links.push_back(link);
        }
    };
    const std::uint32_t top = square / across_ * kSquareSide;
    const std::uint32_t end = std::min(top + kSquareSide, rows_);
    const std::uint32_t left = square % across_ * kSquareSide;
    if (square % across_ + 1 < across_) {
        for (std::uint32_t y = top; y < end; ++y) {
            const Place p = y * stride_ + left + kSquareSide - 1;
            touch(p, p + 1);
        }
    }
    if (end < rows_) {
        const Place last = (end - 1) * stride_ + left;
        for (Place p = last; p < last + kSquareSide; ++p) {
            touch(p, p + stride_);
        }
    }
}

void Components::join_regions() {
    first_region_.assign(1, 0);
    for (const std::uint32_t count : regions_) {
        first_region_.push_back(first_region_.back() + count);
    }
    joined_regions_.reset(first_region_.back());
    for (const auto& links : links_) {
        for (const auto& [a, b] : links) {
            joined_regions_.join(region(a), region(b));
        }
    }
    root_.clear();
    for (std::uint32_t r = 0; r < first_region_.back(); ++r) {
        root_.push_back(joined_regions_.root(r));
    }
}

std::size_t Components::bytes() const {
    std::size_t bytes =
        (label_.capacity() + regions_.capacity() + first_region_.capacity() + root_.capacity()) *
            sizeof(std::uint32_t) +
        stale_.capacity() + runs_.capacity() * sizeof(Run) + joined_runs_.bytes() +
        joined_regions_.bytes();
    for (const auto& links : links_) {
        bytes += sizeof(links) + links.capacity() * sizeof(links[0]);
    }
    return bytes;
}

}  // namespace zoned::ai::pathfinding
