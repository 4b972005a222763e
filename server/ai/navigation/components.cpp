#include "server/ai/navigation/grid_map.h"

#include <algorithm>
#include <array>

namespace zoned::ai::navigation {

namespace {

/// So many changes at once are labelled anew.
constexpr std::size_t kManyChanges = 256;
/// And where more of the map than one so-manieth was flooded.
constexpr std::uint32_t kLargeShare = 8;

std::array<Place, 4> beside(const GridMap& map, Place p) {
    return {p - map.stride(), p + map.stride(), p - 1, p + 1};
}

}  // namespace

void Components::update(const GridMap& map, std::span<const CellChange> changes) {
    if (changes.size() > kManyChanges || label_.size() != map.places()) {
        label(map);
        return;
    }
    for (const CellChange& c : changes) {
        const Place p = map.place(c.cell);
        if (map.passable(p) && label_[p] == 0) {
            open(map, p);
        }
    }
    if (mark_.size() != map.places() || first_mark_ > ~0U - 8 * kManyChanges) {
        mark_.assign(map.places(), 0);
        first_mark_ = 1;
    }
    flood_count_ = 0;
    flooded_ = 0;
    for (const CellChange& c : changes) {
        const Place p = map.place(c.cell);
        if (!map.passable(p) && label_[p] != 0) {
            label_[p] = 0;
            for (const Place n : beside(map, p)) {
                if (map.passable(n) && mark_[n] < first_mark_) {
                    add_flood(n);
                }
            }
        }
    }
    const bool done = split(map);
    first_mark_ += flood_count_;
    if (!done) {
        label(map);
    }
}

void Components::open(const GridMap& map, Place p) {
    const auto number = static_cast<std::uint32_t>(runs_.size());
    runs_.push_back({p, p + 1, number});
    label_[p] = number + 1;
    for (const Place n : beside(map, p)) {
        if (label_[n] != 0 && map.passable(n)) {
            join(number, label_[n] - 1);
        }
    }
}

void Components::add_flood(Place p) {
    if (flood_count_ == floods_.size()) {
        floods_.emplace_back();
    }
    Flood& f = floods_[flood_count_];
    f.cells.assign(1, p);
    f.looked_at = 0;
    f.joined = flood_count_;
    f.label = of(p);
    f.shut = false;
    mark_[p] = first_mark_ + flood_count_;
    ++flood_count_;
}

std::uint32_t Components::flood_root(std::uint32_t flood) const {
    while (floods_[flood].joined != flood) {
        flood = floods_[flood].joined;
    }
    return flood;
}

void Components::spread(const GridMap& map, std::uint32_t flood) {
    Flood& f = floods_[flood];
    for (const Place n : beside(map, f.cells[f.looked_at])) {
        if (!map.passable(n)) {
            continue;
        }
        if (mark_[n] < first_mark_) {
            mark_[n] = first_mark_ + flood;
            f.cells.push_back(n);
            ++flooded_;
        } else {
            const std::uint32_t a = flood_root(mark_[n] - first_mark_);
            const std::uint32_t b = flood_root(flood);
            floods_[std::max(a, b)].joined = std::min(a, b);
        }
    }
    ++f.looked_at;
}

/// Whether the floods of a component are more than one still; those that are shut in get a number
/// of their own.
bool Components::part(std::uint32_t label) {
    std::uint32_t open_roots = 0;
    for (std::uint32_t i = 0; i < flood_count_; ++i) {
        if (floods_[i].label != label || floods_[i].shut || flood_root(i) != i) {
            continue;
        }
        bool shut = true;
        for (std::uint32_t j = i; j < flood_count_ && shut; ++j) {
            shut = flood_root(j) != i || floods_[j].looked_at == floods_[j].cells.size();
        }
        if (!shut) {
            ++open_roots;
            continue;
        }
        const auto number = static_cast<std::uint32_t>(runs_.size());
        runs_.push_back({floods_[i].cells[0], floods_[i].cells[0] + 1, number});
        for (std::uint32_t j = i; j < flood_count_; ++j) {
            if (flood_root(j) == i) {
                floods_[j].shut = true;
                for (const Place p : floods_[j].cells) {
                    label_[p] = number + 1;
                }
            }
        }
    }
    return open_roots > 1;
}

/// False where it was given up.
bool Components::split(const GridMap& map) {
    for (std::uint32_t first = 0; first < flood_count_; ++first) {
        const std::uint32_t label = floods_[first].label;
        const bool earlier = std::any_of(floods_.begin(),
                                         floods_.begin() + first,
                                         [label](const Flood& f) { return f.label == label; });
        while (!earlier && part(label)) {
            for (std::uint32_t i = first; i < flood_count_; ++i) {
                Flood& f = floods_[i];
                if (f.label == label && !f.shut && f.looked_at < f.cells.size()) {
                    spread(map, i);
                }
            }
            if (flooded_ > map.passable_cells() / kLargeShare) {
                return false;
            }
        }
    }
    return true;
}

}  // namespace zoned::ai::navigation
