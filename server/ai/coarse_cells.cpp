#include "server/ai/coarse_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::ai {

namespace {

/// Who brakes or turns is looked at once that is over, or after so many ticks.
constexpr float kBent = 8.0F;

/// Of cells, not of metres; far away and what is no number it is as good as any.
std::int32_t line_of(float coordinate) {
    const float line = std::floor(coordinate / CoarseCells::kCell_m);
    return std::abs(line) < 1e9F ? static_cast<std::int32_t>(line) : 0;
}

/// The way along `direction` from `from` to where it leaves [low, high], which lies ahead, m.
float way_out(float from, float direction, float low, float high) {
    if (direction == 0.0F) {
        return std::numeric_limits<float>::infinity();
    }
    return ((direction > 0.0F ? high : low) - from) / direction;
}

}  // namespace

CoarseCells::Cell CoarseCells::cell_at(const Vec2& at) {
    const auto x = static_cast<std::uint32_t>(line_of(at.x())) % kSide;
    const auto z = static_cast<std::uint32_t>(line_of(at.y())) % kSide;
    return z * kSide + x;
}

Tick CoarseCells::left_at(const Leg& leg, const Vec2& at, const Vec2& half_size, float dt) {
    const float bent = std::ceil(leg.bend_s / dt);
    const float step_m = leg.speed * dt;
    if (!(step_m > 0.0F)) {
        const bool slides_out = cell_at(leg.from) != cell_at(at);
        return slides_out ? leg.since + 1 + static_cast<Tick>(std::min(bent, kBent)) : kNever;
    }
    float way = std::numeric_limits<float>::infinity();
    for (int axis = 0; axis < 2; ++axis) {
        const float from = leg.from[axis];
        const float direction = leg.direction[axis];
        const float low = std::floor(at[axis] / kCell_m) * kCell_m;
        way = std::min(way, way_out(from, direction, low, low + kCell_m));
        if (std::abs(at[axis]) <= half_size[axis]) {
            way = std::min(way, way_out(from, direction, -half_size[axis], half_size[axis]));
        }
    }
    const float ticks = std::max(std::ceil(way / step_m), std::min(bent, kBent));
    return leg.since + 1 + static_cast<Tick>(std::clamp(ticks, 0.0F, 1e9F));
}

void CoarseCells::grow(std::size_t slots) {
    if (slots > nodes_.size()) {
        nodes_.resize(slots);
    }
}

void CoarseCells::put(Slot slot, Cell cell) {
    if (nodes_[slot].cell == cell) {
        return;
    }
    take(slot);
    Node& node = nodes_[slot];
    node = {cell, heads_[cell], kNone};
    if (node.next != kNone) {
        nodes_[node.next].previous = slot;
    }
    heads_[cell] = slot;
}

void CoarseCells::take(Slot slot) {
    Node& node = nodes_[slot];
    if (node.cell == kNone) {
        return;
    }
    if (node.next != kNone) {
        nodes_[node.next].previous = node.previous;
    }
    (node.previous != kNone ? nodes_[node.previous].next : heads_[node.cell]) = node.next;
    node = Node{};
}

void CoarseCells::within(std::span<const Vec2> places, float radius_m, std::vector<Cell>& out) {
    out.clear();
    for (const Vec2& place : places) {
        const float reach = std::min(radius_m, 0.5F * kCell_m * static_cast<float>(kSide));
        const std::int32_t x1 = line_of(place.x() + reach);
        const std::int32_t z1 = line_of(place.y() + reach);
        for (std::int32_t z = line_of(place.y() - reach); z <= z1; ++z) {
            for (std::int32_t x = line_of(place.x() - reach); x <= x1; ++x) {
                const Vec2 low(static_cast<float>(x) * kCell_m, static_cast<float>(z) * kCell_m);
                const Vec2 nearest = place.cwiseMax(low).cwiseMin((low.array() + kCell_m).matrix());
                if ((nearest - place).squaredNorm() <= radius_m * radius_m) {
                    out.push_back(static_cast<std::uint32_t>(z) % kSide * kSide +
                                  static_cast<std::uint32_t>(x) % kSide);
                }
            }
        }
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
}

}  // namespace zoned::ai
