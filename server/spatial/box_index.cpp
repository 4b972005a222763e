#include "server/spatial/box_index.h"

#include "shared/core/assert.h"

namespace zoned::spatial {

BoxIndex::Structure BoxIndex::make(BroadphaseKind kind, const BroadphaseSettings& settings) {
    switch (kind) {
        case BroadphaseKind::kAllPairs:
            return AllPairs();
        case BroadphaseKind::kGrid:
            return BoxGrid(settings.cell_m);
        case BroadphaseKind::kOctree:
            return Octree({settings.max_depth, settings.boxes_per_cell, false});
        case BroadphaseKind::kQuadtree:
            return Octree({settings.max_depth, settings.boxes_per_cell, true});
        case BroadphaseKind::kSortAndSweep:
            return SortAndSweep();
        case BroadphaseKind::kTree:
            return AabbTree();
        case BroadphaseKind::kAutomatic:
            break;
    }
    ZONED_ASSERT(false, "a kind of structure must be chosen");
    return AllPairs();
}

BoxIndex::BoxIndex(BroadphaseKind kind, const BroadphaseSettings& settings)
    : kind_(kind),
      settings_(settings),
      boxes_(make(kind, settings)) {
}

void BoxIndex::change_to(BroadphaseKind kind, std::size_t boxes) {
    Structure fresh = make(kind, settings_);
    std::visit(
        [&](auto& to) {
            to.reserve(boxes);
            std::visit(
                [&](const auto& from) {
                    from.for_each([&](std::uint32_t row, const Aabb& box) { to.insert(row, box); });
                },
                boxes_);
        },
        fresh);
    boxes_ = std::move(fresh);
    kind_ = kind;
}

void BoxIndex::reserve(std::size_t boxes) {
    std::visit([&](auto& s) { s.reserve(boxes); }, boxes_);
}

void BoxIndex::insert(std::uint32_t row, const Aabb& box) {
    std::visit([&](auto& s) { s.insert(row, box); }, boxes_);
}

void BoxIndex::remove(std::uint32_t row) {
    std::visit([&](auto& s) { s.remove(row); }, boxes_);
}

void BoxIndex::update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes) {
    if (!rows.empty()) {
        std::visit([&](auto& s) { s.update(rows, boxes); }, boxes_);
    }
}

std::uint32_t BoxIndex::size() const {
    return std::visit([](const auto& s) { return s.size(); }, boxes_);
}

}  // namespace zoned::spatial
