#include "server/spatial/all_pairs.h"

#include "shared/core/assert.h"

namespace zoned::spatial {

void AllPairs::reserve(std::size_t boxes) {
    blocks_.reserve(boxes / kLanes + 1);
    if (place_of_.size() < boxes) {
        place_of_.resize(boxes, kNone);
    }
}

void AllPairs::insert(std::uint32_t row, const Aabb& box) {
    if (row >= place_of_.size()) {
        place_of_.resize(row + 1, kNone);
    }
    ZONED_ASSERT(place_of_[row] == kNone, "a box was inserted twice");
    const std::uint32_t place = size_++;
    if (place % kLanes == 0) {
        blocks_.emplace_back();
    }
    PairBlock& block = blocks_.back();
    block.boxes.set(place % kLanes, box);
    block.rows[place % kLanes] = row;
    block.valid |= 1U << (place % kLanes);
    place_of_[row] = place;
}

void AllPairs::remove(std::uint32_t row) {
    ZONED_ASSERT(contains(row), "the box is not there");
    const std::uint32_t place = place_of_[row];
    const std::uint32_t last = --size_;
    PairBlock& from = blocks_[last / kLanes];
    PairBlock& to = blocks_[place / kLanes];
    const std::uint32_t moved = from.rows[last % kLanes];
    to.boxes.set(place % kLanes, from.boxes.get(last % kLanes));
    to.rows[place % kLanes] = moved;
    place_of_[moved] = place;
    place_of_[row] = kNone;
    from.boxes.clear(last % kLanes);
    from.valid &= ~(1U << (last % kLanes));
    if (last % kLanes == 0) {
        blocks_.pop_back();
    }
}

void AllPairs::update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes) {
    for (const std::uint32_t row : rows) {
        ZONED_ASSERT(contains(row), "the box is not there");
        const std::uint32_t place = place_of_[row];
        blocks_[place / kLanes].boxes.set(place % kLanes, boxes[row]);
    }
}

}  // namespace zoned::spatial
