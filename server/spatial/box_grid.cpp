#include "server/spatial/box_grid.h"

#include "shared/core/assert.h"

namespace zoned::spatial {

namespace {

constexpr std::size_t kFirstCapacity = 256;

}  // namespace

BoxGrid::BoxGrid(float cell_m)
    : keys_(kFirstCapacity, kEmptyKey),
      heads_(kFirstCapacity, kNone),
      mask_(kFirstCapacity - 1) {
    for (int i = 0; i < kLevels; ++i) {
        BoxGridLevel& level = levels_[static_cast<std::size_t>(i)];
        level.cell = std::ldexp(cell_m, i + kFinestExponent);
        level.inv_cell = 1.0F / level.cell;
    }
}

int BoxGrid::level_for(const Aabb& box) const {
    const float side = (box.upper - box.lower).maxCoeff();
    int index = 0;
    while (index + 1 < kLevels && levels_[static_cast<std::size_t>(index)].cell < side) {
        ++index;
    }
    return index;
}

std::size_t BoxGrid::slot_for(std::uint64_t key) {
    for (std::size_t slot = scatter(key) & mask_;; slot = (slot + 1) & mask_) {
        if (keys_[slot] == key) {
            return slot;
        }
        if (keys_[slot] == kEmptyKey) {
            if (2 * (used_ + 1) > keys_.size()) {
                rehash();
                return slot_for(key);
            }
            keys_[slot] = key;
            heads_[slot] = kNone;
            ++used_;
            return slot;
        }
    }
}

/// Drops the cells that became empty; grows only when the cells in use need it, so that bodies that
/// wander through ever new cells cause no allocation in the long run.
void BoxGrid::rehash() {
    std::size_t live = 0;
    for (const std::uint32_t head : heads_) {
        live += head != kNone ? 1 : 0;
    }
    std::size_t capacity = keys_.size();
    while (4 * (live + 1) > capacity || capacity < reserved_cells_) {
        capacity *= 2;
    }
    spare_keys_.assign(capacity, kEmptyKey);
    spare_heads_.assign(capacity, kNone);
    for (std::size_t i = 0; i < keys_.size(); ++i) {
        if (heads_[i] == kNone) {
            continue;
        }
        std::size_t slot = scatter(keys_[i]) & (capacity - 1);
        while (spare_keys_[slot] != kEmptyKey) {
            slot = (slot + 1) & (capacity - 1);
        }
        spare_keys_[slot] = keys_[i];
        spare_heads_[slot] = heads_[i];
    }
    keys_.swap(spare_keys_);
    heads_.swap(spare_heads_);
    mask_ = capacity - 1;
    used_ = live;
}

/// Adds a box to the list of each cell that it covers.
void BoxGrid::link(std::uint32_t row) {
    BoxGridEntry& entry = entries_[row];
    std::uint32_t before = kNone;
    for_each_cell(entry, [&](const BoxGridCell& at) {
        const std::size_t slot = slot_for(key_of(entry.level, at));
        std::uint32_t node = free_node_;
        if (node != kNone) {
            free_node_ = nodes_[node].next;
        } else {
            node = static_cast<std::uint32_t>(nodes_.size());
            nodes_.emplace_back();
        }
        nodes_[node] = {row, heads_[slot], kNone, kNone};
        if (heads_[slot] != kNone) {
            nodes_[heads_[slot]].previous = node;
        }
        heads_[slot] = node;
        (before == kNone ? entry.first_node : nodes_[before].sibling) = node;
        before = node;
    });
}

/// Takes a box out of its cells, which are the ones that link() found, in the same order.
void BoxGrid::unlink(std::uint32_t row) {
    BoxGridEntry& entry = entries_[row];
    std::uint32_t node = entry.first_node;
    for_each_cell(entry, [&](const BoxGridCell& at) {
        const BoxGridNode gone = nodes_[node];
        if (gone.previous != kNone) {
            nodes_[gone.previous].next = gone.next;
        } else {
            heads_[slot_for(key_of(entry.level, at))] = gone.next;
        }
        if (gone.next != kNone) {
            nodes_[gone.next].previous = gone.previous;
        }
        nodes_[node] = {kNone, free_node_, kNone, kNone};
        free_node_ = node;
        node = gone.sibling;
    });
    entry.first_node = kNone;
}

void BoxGrid::reserve(std::size_t boxes) {
    // A box lies in at most eight cells, in three or four on average; rehashing keeps the table at
    // most a quarter full of cells in use.
    nodes_.reserve(8 * boxes);
    for (BoxGridLevel& level : levels_) {
        level.rows.reserve(boxes);
    }
    while (keys_.size() < 16 * boxes) {
        reserved_cells_ = 16 * boxes;
        rehash();
    }
    if (entries_.size() < boxes) {
        entries_.resize(boxes);
    }
    spare_keys_.reserve(keys_.size());
    spare_heads_.reserve(keys_.size());
}

void BoxGrid::insert(std::uint32_t row, const Aabb& box) {
    if (row >= entries_.size()) {
        entries_.resize(row + 1);
    }
    BoxGridEntry& entry = entries_[row];
    ZONED_ASSERT(entry.level < 0, "a box was inserted twice");
    entry.box = box;
    entry.level = level_for(box);
    BoxGridLevel& level = levels_[static_cast<std::size_t>(entry.level)];
    entry.lower = cell_of(level, box.lower);
    entry.upper = cell_of(level, box.upper);
    entry.position = static_cast<std::uint32_t>(level.rows.size());
    level.rows.push_back(row);
    link(row);
    ++size_;
}

void BoxGrid::update_one(std::uint32_t row, const Aabb& box) {
    BoxGridEntry& entry = entries_[row];
    const int level = level_for(box);
    const BoxGridLevel& cells = levels_[static_cast<std::size_t>(level)];
    if (level == entry.level && cell_of(cells, box.lower) == entry.lower &&
        cell_of(cells, box.upper) == entry.upper) {
        entry.box = box;
        return;
    }
    remove(row);
    insert(row, box);
}

void BoxGrid::update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes) {
    for (const std::uint32_t row : rows) {
        ZONED_ASSERT(contains(row), "the box is not in the grid");
        update_one(row, boxes[row]);
    }
}

void BoxGrid::remove(std::uint32_t row) {
    ZONED_ASSERT(contains(row), "the box is not in the grid");
    unlink(row);
    BoxGridEntry& entry = entries_[row];
    BoxGridLevel& level = levels_[static_cast<std::size_t>(entry.level)];
    const std::uint32_t last = level.rows.back();
    level.rows[entry.position] = last;
    entries_[last].position = entry.position;
    level.rows.pop_back();
    entry.level = -1;
    --size_;
}

}  // namespace zoned::spatial
