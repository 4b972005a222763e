// How the tree of boxes takes many moved boxes at once, and how it is built afresh.
#include "server/spatial/aabb_tree.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <limits>

namespace zoned::spatial {

namespace {

/// A tree whose surfaces have grown by this much since it was built is built again.
constexpr double kWorn = 0.5;
/// Nodes are built with room for a box or two more.
constexpr double kFill = 0.75;
constexpr std::size_t kBins = 16;

/// How many boxes a node of a level can hold below it.
std::size_t capacity_of(int level) {
    return std::size_t{1} << (3 * (level + 1));
}

float middle_of(const Aabb& box, int axis) {
    return box.lower[axis] + box.upper[axis];
}

/// Splits a range of boxes into those whose middle lies below `bound` and the others.
struct Cut {
    int axis = 0;
    float origin = 0.0F;
    float scale = 0.0F;  ///< bins per metre
    std::size_t bin = 0;

    [[nodiscard]] std::size_t bin_of(const Aabb& box) const {
        const float b = (middle_of(box, axis) - origin) * scale;
        return std::min(static_cast<std::size_t>(b), kBins - 1);
    }
};

struct Bin {
    Aabb box;
    std::size_t count = 0;

    void add(const Aabb& other, std::size_t n) {
        if (n > 0) {
            box = count > 0 ? merged(box, other) : other;
            count += n;
        }
    }
};

/// The cheapest cut by the surface area heuristic that leaves between `least` and `most` boxes on
/// the left (Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007). False
/// when no cut between bins does.
template <class Entries>
bool find_cut(const Entries& entries, std::size_t least, std::size_t most, Cut& cut) {
    Vec3 lowest = Vec3::Constant(std::numeric_limits<float>::infinity());
    Vec3 highest = -lowest;
    for (const auto& entry : entries) {
        const Vec3 middle = entry.box.lower + entry.box.upper;
        lowest = lowest.cwiseMin(middle);
        highest = highest.cwiseMax(middle);
    }
    const float extent = (highest - lowest).maxCoeff(&cut.axis);
    cut.origin = lowest[cut.axis];
    cut.scale = static_cast<float>(kBins) / extent;
    if (!(extent > 0.0F) || !std::isfinite(cut.scale)) {
        return false;
    }
    std::array<Bin, kBins> bins;
    for (const auto& entry : entries) {
        bins[cut.bin_of(entry.box)].add(entry.box, 1);
    }
    std::array<Bin, kBins> from;  // all from the i-th bin on
    Bin right;
    for (std::size_t i = kBins; i-- > 0;) {
        right.add(bins[i].box, bins[i].count);
        from[i] = right;
    }
    float best = std::numeric_limits<float>::infinity();
    Bin left;
    for (std::size_t i = 1; i < kBins; ++i) {
        left.add(bins[i - 1].box, bins[i - 1].count);
        if (left.count < least || left.count > most) {
            continue;
        }
        const float cost = half_area(left.box) * static_cast<float>(left.count) +
                           half_area(from[i].box) * static_cast<float>(from[i].count);
        if (cost < best) {
            best = cost;
            cut.bin = i;
        }
    }
    return best < std::numeric_limits<float>::infinity();
}

}  // namespace

void AabbTree::mark_dirty(std::uint32_t index) {
    AabbTreeNode& node = nodes_[index];
    if (!node.dirty) {
        node.dirty = true;
        dirty_[node.level].push_back(index);
    }
}

/// Fits the boxes above the dirty nodes, level by level, so that each is looked at once.
void AabbTree::refit_dirty() {
    for (auto& list : dirty_) {
        for (const std::uint32_t index : list) {
            AabbTreeNode& node = nodes_[index];
            node.dirty = false;
            const std::uint32_t parent = node.parent;
            if (parent == kNone) {
                continue;
            }
            AabbTreeNode& above = nodes_[parent / kLanes];
            const Aabb box = node.boxes.bounds();
            const Aabb old = above.boxes.get(parent % kLanes);
            if (box.lower != old.lower || box.upper != old.upper) {
                above.boxes.set(parent % kLanes, box);
                stretch_ += static_cast<double>(half_area(box)) - half_area(old);
                mark_dirty(parent / kLanes);
            }
        }
        list.clear();
    }
}

void AabbTree::update(std::span<const std::uint32_t> rows, std::span<const Aabb> boxes) {
    left_.clear();
    for (const std::uint32_t row : rows) {
        ZONED_ASSERT(contains(row), "the box is not in the tree");
        const std::uint32_t slot = slot_of_[row];
        const std::uint32_t index = slot / kLanes;
        const std::uint32_t parent = nodes_[index].parent;
        const Aabb& box = boxes[row];
        if (parent != kNone) {
            const Aabb home = nodes_[parent / kLanes].boxes.get(parent % kLanes);
            if (!home.contains(0.5F * (box.lower + box.upper))) {
                left_.push_back(row);
            }
        }
        nodes_[index].boxes.set(slot % kLanes, box);
        mark_dirty(index);
    }
    refit_dirty();
    const bool scattered = left_.size() > kLanes && 4 * left_.size() > size_;
    if (!scattered) {
        for (const std::uint32_t row : left_) {
            remove_unchecked(row);
            insert_unchecked(row, boxes[row]);
        }
        changes_ -= static_cast<std::uint32_t>(left_.size());
    }
    if (scattered || stretch_ > kWorn * built_cost_ || changes_ > std::max(built_size_, 64U)) {
        rebuild();
    }
}

void AabbTree::rebuild() {
    scratch_.clear();
    // In the order of rows, whatever the tree was like before.
    for_each([&](std::uint32_t row, const Aabb& box) { scratch_.push_back({box, row}); });
    nodes_.clear();
    free_nodes_.clear();
    root_ = kNone;
    int level = 0;
    while (static_cast<double>(scratch_.size()) > kFill * static_cast<double>(capacity_of(level)) &&
           scratch_.size() > kLanes) {
        ++level;
    }
    if (!scratch_.empty()) {
        root_ = build(scratch_, level);
    }
    built_size_ = size_;
    built_cost_ = cost();
    stretch_ = 0.0;
    changes_ = 0;
}

std::uint32_t AabbTree::build(std::span<AabbTreeEntry> entries, int level) {
    const std::uint32_t index = new_node(level);
    if (level == 0) {
        for (const AabbTreeEntry& entry : entries) {
            append(index, entry);
        }
        return index;
    }
    const double wanted = kFill * static_cast<double>(capacity_of(level - 1));
    const auto slots = static_cast<std::size_t>(static_cast<double>(entries.size()) / wanted) + 1;
    build_children(
        index, entries, std::clamp(slots, std::min<std::size_t>(2, entries.size()), kLanes));
    return index;
}

/// Parts the entries among `slots` children of a node, which hold them for certain.
void AabbTree::build_children(std::uint32_t index,
                              std::span<AabbTreeEntry> entries,
                              std::size_t slots) {
    const int level = nodes_[index].level - 1;
    if (slots == 1) {
        const std::uint32_t child = build(entries, level);
        append(index, {nodes_[child].boxes.bounds(), child});
        return;
    }
    const std::size_t n = entries.size();
    const std::size_t slots_left = slots / 2;
    const std::size_t slots_right = slots - slots_left;
    const std::size_t room = capacity_of(level);
    // Either side gets at least half of its due share, and no more than it can hold.
    const std::size_t due = n * slots_left / slots;
    std::size_t least =
        std::max(std::max<std::size_t>(due / 2, slots_left), n - std::min(n, slots_right * room));
    std::size_t most = std::min(n - std::max((n - due) / 2, slots_right), slots_left * room);
    Cut cut;
    std::size_t left = std::clamp(due, least, most);
    if (find_cut(entries, least, most, cut)) {
        const auto middle =
            std::partition(entries.begin(), entries.end(), [&](const AabbTreeEntry& e) {
                return cut.bin_of(e.box) < cut.bin;
            });
        left = static_cast<std::size_t>(middle - entries.begin());
    } else {
        std::nth_element(entries.begin(),
                         entries.begin() + static_cast<std::ptrdiff_t>(left),
                         entries.end(),
                         [&](const AabbTreeEntry& a, const AabbTreeEntry& b) {
                             const float ma = middle_of(a.box, cut.axis);
                             const float mb = middle_of(b.box, cut.axis);
                             return ma != mb ? ma < mb : a.child < b.child;
                         });
    }
    build_children(index, entries.first(left), slots_left);
    build_children(index, entries.subspan(left), slots_right);
}

}  // namespace zoned::spatial
