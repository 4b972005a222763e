#include "server/ai/pathfinding/flow_fields/crowd_flow_field.h"

#include "shared/core/assert.h"

#include <algorithm>
#include <array>

namespace zoned::ai::pathfinding {

namespace {

constexpr Hop kHops = 8;
constexpr Hop kFirstDiagonal = 4;

/// Indexed as in hopped().
constexpr std::array<int, kHops> kAcross{1, -1, 0, 0, 1, -1, 1, -1};
constexpr std::array<int, kHops> kDown{0, 0, 1, -1, 1, -1, -1, 1};

Place beside(Place p, Hop hop, std::uint32_t stride) {
    return static_cast<Place>(static_cast<std::int64_t>(p) + kAcross[hop] +
                              static_cast<std::int64_t>(kDown[hop]) * stride);
}

/// True if a step leads there: passable, and no corner is cut.
bool open_step(const GridMap& map, Place p, Hop hop) {
    const auto stride = static_cast<std::int64_t>(map.stride());
    const auto at = static_cast<std::int64_t>(p);
    return map.passable(beside(p, hop, map.stride())) &&
           (hop < kFirstDiagonal || (map.passable(static_cast<Place>(at + kAcross[hop])) &&
                                     map.passable(static_cast<Place>(at + kDown[hop] * stride))));
}

CrowdFlowField::Cost step_cost(std::span<const Crowding> crowding, Place p, Place q, Hop hop) {
    const CrowdFlowField::Cost length = hop < kFirstDiagonal ? kStraight : kDiagonal;
    return length * (2U * kPerStep + crowding[p] + crowding[q]);
}

/// Opposite steps differ in their last bit.
Hop back(Hop hop) {
    return static_cast<Hop>(hop ^ 1U);
}

}  // namespace

void CrowdFlowField::begin_build(const GridMap& map, Cell goal) {
    ZONED_ASSERT(map.contains(goal), "a goal off the map");
    stride_ = map.stride();
    goal_ = map.place(goal);
    cost_.assign(map.places(), kNoPath);
    hop_.assign(map.places(), kNoHop);
    open_.clear();
    work_ = 0;
    phase_ = RepairPhase::kSpread;
    if (map.passable(goal_)) {
        cost_[goal_] = 0;
        hop_[goal_] = kArrived;
        open_.push({0, goal_});
    }
}

void CrowdFlowField::build(const GridMap& map, std::span<const Crowding> crowding, Cell goal) {
    ZONED_ASSERT(crowding.size() == map.places(), "crowding of each place");
    begin_build(map, goal);
    while (!advance(map, crowding, map.places())) {
    }
}

bool CrowdFlowField::spread(const GridMap& map,
                            std::span<const Crowding> crowding,
                            std::size_t most) {
    for (std::size_t settled = 0; !open_.empty();) {
        const ReachedCell at = open_.pop();
        if (cost_[at.node] != at.key) {
            continue;
        }
        ++work_;
        for (Hop hop = 0; hop < kHops; ++hop) {
            if (!open_step(map, at.node, hop)) {
                continue;
            }
            const Place to = beside(at.node, hop, stride_);
            const Cost cost = at.key + step_cost(crowding, at.node, to, hop);
            if (cost < cost_[to]) {
                cost_[to] = cost;
                hop_[to] = back(hop);
                open_.push({cost, to});
            } else if (cost == cost_[to] && back(hop) < hop_[to]) {
                hop_[to] = back(hop);  // the same among equals, whatever was there before
            }
        }
        if (++settled >= most) {
            return open_.empty();
        }
    }
    return true;
}

void CrowdFlowField::forget(Place p) {
    cost_[p] = kNoPath;
    hop_[p] = kNoHop;
    forgotten_.push_back(p);
}

void CrowdFlowField::find_again(const GridMap& map, std::span<const Crowding> crowding, Place p) {
    if (p == goal_ && map.passable(p)) {
        cost_[p] = 0;
        hop_[p] = kArrived;
    } else if (map.passable(p)) {
        for (Hop hop = 0; hop < kHops; ++hop) {
            const Place q = beside(p, hop, stride_);
            if (cost_[q] == kNoPath || !open_step(map, p, hop)) {
                continue;
            }
            const Cost cost = cost_[q] + step_cost(crowding, p, q, hop);
            if (cost < cost_[p]) {
                cost_[p] = cost;
                hop_[p] = hop;
            }
        }
    }
    if (cost_[p] != kNoPath) {
        open_.push({cost_[p], p});
    }
}

/// Steps into and out of a cell, and past its corner, are steps of the nine around it.
void CrowdFlowField::forget_around(const GridMap& map, Place changed) {
    if (cost_[changed] != kNoPath || map.passable(changed)) {
        forget(changed);
    }
    for (Hop hop = 0; hop < kHops; ++hop) {
        const Place q = beside(changed, hop, stride_);
        if (cost_[q] != kNoPath) {
            forget(q);
        }
    }
}

/// Whatever led through it.
void CrowdFlowField::forget_before(Place p) {
    for (Hop hop = 0; hop < kHops; ++hop) {
        const Place q = beside(p, hop, stride_);
        if (cost_[q] != kNoPath && hop_[q] == back(hop)) {
            forget(q);
        }
    }
}

void CrowdFlowField::begin_update(std::span<const Place> changed) {
    ZONED_ASSERT(goal_ != kNoPlace, "a field is built before it is updated");
    changed_.assign(changed.begin(), changed.end());
    forgotten_.clear();
    open_.clear();
    work_ = 0;
    phase_ = RepairPhase::kForget;
    next_ = 0;
    changes_ = 0;
}

bool CrowdFlowField::advance(const GridMap& map,
                             std::span<const Crowding> crowding,
                             std::size_t most) {
    std::size_t left = most;
    while (phase_ == RepairPhase::kForget && left > 0) {
        --left;
        if (changes_ < changed_.size()) {
            forget_around(map, changed_[changes_++]);
        } else if (next_ < forgotten_.size()) {
            forget_before(forgotten_[next_++]);
        } else {
            phase_ = RepairPhase::kFindAgain;
            next_ = 0;
        }
    }
    while (phase_ == RepairPhase::kFindAgain && left > 0) {
        --left;
        if (next_ < forgotten_.size()) {
            find_again(map, crowding, forgotten_[next_++]);
        } else {
            phase_ = RepairPhase::kSpread;
        }
    }
    return phase_ == RepairPhase::kSpread && left > 0 && spread(map, crowding, left);
}

void CrowdFlowField::update(const GridMap& map,
                            std::span<const Crowding> crowding,
                            std::span<const Place> changed) {
    ZONED_ASSERT(cost_.size() == map.places(), "a field is built before it is updated");
    begin_update(changed);
    while (!advance(map, crowding, map.places())) {
    }
}

std::size_t CrowdFlowField::bytes() const {
    return cost_.capacity() * sizeof(Cost) + hop_.capacity() * sizeof(Hop) + open_.bytes() +
           (changed_.capacity() + forgotten_.capacity()) * sizeof(Place);
}

}  // namespace zoned::ai::pathfinding
