#include "server/spatial/sort_and_sweep.h"

#include "shared/core/assert.h"

namespace zoned::spatial {

namespace {

/// So many boxes may wait unsorted, and a part of all besides.
constexpr std::uint32_t kPatience = 64;
/// Another axis must be that much better before boxes are sorted along it.
constexpr double kBetterAxis = 2.0;

}  // namespace

void SortAndSweep::reserve(std::size_t boxes) {
    // The sorted blocks, one that is half full, and those that wait with their gaps.
    const std::size_t blocks = boxes / kLanes + boxes / 16 + 2 * kPatience / kLanes + 4;
    blocks_.reserve(blocks);
    first_lower_.reserve(blocks);
    reach_.reserve(blocks);
    order_.reserve(boxes);
    boxes_.reserve(boxes);
    if (place_of_.size() < boxes) {
        place_of_.resize(boxes, kNone);
        boxes_.resize(boxes);
    }
}

/// Puts a box behind all others, where it waits to be sorted.
void SortAndSweep::append(std::uint32_t row) {
    const std::uint32_t place = end_++;
    if (place % kLanes == 0) {
        blocks_.emplace_back();
    }
    SweepBlock& block = blocks_.back();
    block.boxes.set(place % kLanes, boxes_[row]);
    block.rows[place % kLanes] = row;
    block.valid |= 1U << (place % kLanes);
    place_of_[row] = place;
    ++size_;
    ++restless_;
}

/// Leaves a gap where the box was.
void SortAndSweep::drop(std::uint32_t row) {
    const std::uint32_t place = place_of_[row];
    blocks_[place / kLanes].valid &= ~(1U << (place % kLanes));
    blocks_[place / kLanes].boxes.clear(place % kLanes);
    place_of_[row] = kNone;
    --size_;
    ++restless_;
}

void SortAndSweep::insert(std::uint32_t row, const Aabb& box) {
    if (row >= place_of_.size()) {
        place_of_.resize(row + 1, kNone);
        boxes_.resize(row + 1);
    }
    ZONED_ASSERT(place_of_[row] == kNone, "a box was inserted twice");
    boxes_[row] = box;
    append(row);
    if (restless_ > kPatience + size_ / 16) {
        settle();
    }
}

void SortAndSweep::remove(std::uint32_t row) {
    ZONED_ASSERT(contains(row), "the box is not there");
    drop(row);
    if (restless_ > kPatience + size_ / 16) {
        settle();
    }
}

void SortAndSweep::update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes) {
    const bool few = rows.size() < size_ / 64;
    for (const std::uint32_t row : rows) {
        ZONED_ASSERT(contains(row), "the box is not there");
        boxes_[row] = boxes[row];
        if (few) {
            drop(row);
            append(row);
        }
    }
    if (!rows.empty() && (!few || restless_ > kPatience + size_ / 16)) {
        settle();
    }
}

void SortAndSweep::choose_axis() {
    Vec3d sum = Vec3d::Zero();
    Vec3d squares = Vec3d::Zero();
    for (const SweepBlock& block : blocks_) {
        for_each_lane(block.valid, [&](std::size_t lane) {
            const Aabb& box = boxes_[block.rows[lane]];
            const Vec3d middle = 0.5 * (box.lower + box.upper).cast<double>();
            sum += middle;
            squares += middle.cwiseProduct(middle);
        });
    }
    const Vec3d mean = sum / std::max<std::uint32_t>(size_, 1);
    const Vec3d spread = squares - sum.cwiseProduct(mean);
    int widest = 0;
    spread.maxCoeff(&widest);
    if (spread[widest] > kBetterAxis * spread[axis_]) {
        axis_ = widest;
    }
}

/// Insertion sort for a list nearly in order; else the library's.
void SortAndSweep::sort_order() {
    std::size_t shifts = 0;
    const std::size_t patience = 8 * order_.size() + 64;
    for (std::size_t i = 1; i < order_.size(); ++i) {
        const SweepKey key = order_[i];
        std::size_t k = i;
        for (; k > 0 && key < order_[k - 1]; --k) {
            order_[k] = order_[k - 1];
        }
        order_[k] = key;
        shifts += i - k;
        if (shifts > patience) {
            std::sort(order_.begin(), order_.end());
            return;
        }
    }
}

void SortAndSweep::write_blocks() {
    blocks_.clear();
    first_lower_.clear();
    reach_.clear();
    float reach = -BoxLanes::kFar;
    for (std::size_t i = 0; i < order_.size(); i += kLanes) {
        SweepBlock& block = blocks_.emplace_back();
        const std::size_t n = std::min(kLanes, order_.size() - i);
        for (std::size_t lane = 0; lane < n; ++lane) {
            const std::uint32_t row = order_[i + lane].row;
            block.boxes.set(lane, boxes_[row]);
            block.rows[lane] = row;
            place_of_[row] = static_cast<std::uint32_t>(i + lane);
            reach = std::max(reach, boxes_[row].upper[axis_]);
        }
        block.valid = (1U << n) - 1;
        first_lower_.push_back(order_[i].lower);
        reach_.push_back(reach);
    }
    // Boxes that come later start a block of their own.
    end_ = static_cast<std::uint32_t>(blocks_.size() * kLanes);
    restless_ = 0;
}

/// Sorts all boxes.
void SortAndSweep::settle() {
    choose_axis();
    order_.clear();
    for (const SweepBlock& block : blocks_) {
        for_each_lane(block.valid, [&](std::size_t lane) {
            const std::uint32_t row = block.rows[lane];
            order_.push_back({boxes_[row].lower[axis_], row});
        });
    }
    sort_order();
    write_blocks();
}

}  // namespace zoned::spatial
