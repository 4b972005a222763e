#include "server/physics/solver/contact_coloring.h"

#include "server/physics/simd/lanes.h"

#include <algorithm>
#include <bit>

namespace zoned::physics {

void ContactColoring::reserve(std::size_t bodies, std::size_t contacts) {
    taken_.reserve(bodies + 1);
    class_.reserve(contacts);
    order_.reserve(contacts);
    groups_.reserve(contacts);
    stages_.reserve(contacts);
}

void ContactColoring::build(const Bodies& bodies,
                            const ContactGraph& graph,
                            std::span<const std::uint32_t> list,
                            std::size_t slots) {
    taken_.assign(slots, 0);
    class_.resize(list.size());
    order_.resize(list.size());
    groups_.clear();
    stages_.clear();
    first_.fill(0);
    constexpr std::uint32_t kWidth = kMaxManifoldPoints + 1;
    for (std::size_t i = 0; i < list.size(); ++i) {
        const Pair& contact = graph.pair(list[i]);
        const bool a = bodies.simulated(contact.a);
        const bool b = bodies.simulated(contact.b);
        const std::uint32_t slot_a = a ? bodies.solver_slot[contact.a] : 0;
        const std::uint32_t slot_b = b ? bodies.solver_slot[contact.b] : 0;
        const std::uint64_t taken = (a ? taken_[slot_a] : 0) | (b ? taken_[slot_b] : 0);
        const auto color = static_cast<std::uint32_t>(std::countr_one(taken));
        const std::uint64_t bit = color < kColors ? std::uint64_t{1} << color : 0;
        taken_[slot_a] |= a ? bit : 0;
        taken_[slot_b] |= b ? bit : 0;
        const std::uint32_t kind =
            color * kWidth + static_cast<std::uint32_t>(kMaxManifoldPoints) - contact.count;
        class_[i] = static_cast<std::uint16_t>(kind);
        ++first_[kind + 1];
    }
    for (std::size_t k = 0; k < kClasses; ++k) {
        first_[k + 1] += first_[k];
    }
    // Groups end with their colour; those without a colour hold one contact each.
    for (std::uint32_t color = 0; color <= kColors; ++color) {
        const std::uint32_t end = first_[(color + 1) * kWidth];
        const std::uint32_t most = color < kColors ? static_cast<std::uint32_t>(kLanes) : 1U;
        const auto begin = static_cast<std::uint32_t>(groups_.size());
        for (std::uint32_t at = first_[color * kWidth]; at < end; at += most) {
            groups_.push_back({at, std::min(end, at + most)});
        }
        const auto past = static_cast<std::uint32_t>(groups_.size());
        const std::uint32_t stage = color < kColors ? past - begin : 1U;
        for (std::uint32_t at = begin; at < past; at += stage) {
            stages_.push_back({at, at + stage});
        }
    }
    for (std::size_t i = 0; i < list.size(); ++i) {
        order_[first_[class_[i]]++] = list[i];
    }
}

}  // namespace zoned::physics
