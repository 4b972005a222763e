// AgentEventQueue: the tick of the next event of each of many slots.
#pragma once

#include "server/ai/agent/agent.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace zoned::ai {

/// A calendar queue whose days are ticks. (Brown, "Calendar Queues: A Fast O(1) Priority Queue
/// Implementation for the Simulation Event Set Problem", CACM 31, 1988, section 2.) A tick takes
/// the events of its day, and leaves the events of later years. Each slot has at most one event, so
/// days are lists through the slots. Only new slots allocate memory.
class AgentEventQueue {
  public:
    using Slot = std::uint32_t;

    /// Makes the slots below `slots` exist; new ones have no event.
    void grow(std::size_t slots) {
        nodes_.resize(std::max(nodes_.size(), slots));
        if (heads_.empty() && slots > 0) {
            heads_.assign(kDays, kNone);
        }
    }

    /// Replaces the slot's event; kNever: no event.
    void schedule(Slot slot, Tick at) {
        cancel(slot);
        if (at == kNever) {
            return;
        }
        // An event in the past happens in the next tick that asks.
        const std::uint32_t day = day_of(std::max(at, asked_ + 1));
        QueueNode& node = nodes_[slot];
        node = {at, heads_[day], kFirst | day};
        if (node.next != kNone) {
            nodes_[node.next].previous = slot;
        }
        heads_[day] = slot;
    }

    void cancel(Slot slot) {
        QueueNode& node = nodes_[slot];
        if (node.at == kNever) {
            return;
        }
        if (node.next != kNone) {
            nodes_[node.next].previous = node.previous;
        }
        if ((node.previous & kFirst) != 0) {
            heads_[node.previous & ~kFirst] = node.next;
        } else {
            nodes_[node.previous].next = node.next;
        }
        node.at = kNever;
    }

    /// Prefetches the data that schedule() and cancel() read of the slot.
    void prefetch(Slot slot) const { __builtin_prefetch(&nodes_[slot], 1); }

    /// Prefetches the slots beside this one in its day. Prefetch the slot itself earlier.
    void prefetch_neighbours(Slot slot) const {
        const QueueNode& node = nodes_[slot];
        if (node.at == kNever) {
            return;
        }
        if (node.next != kNone) {
            __builtin_prefetch(&nodes_[node.next], 1);
        }
        if ((node.previous & kFirst) == 0) {
            __builtin_prefetch(&nodes_[node.previous], 1);
        }
    }

    /// kNever: no event.
    [[nodiscard]] Tick at(Slot slot) const { return nodes_[slot].at; }

    /// Removes the events due at `now`, and calls visit(slot, at) for each, in no order. `visit`
    /// may schedule events after `now`. Ticks ascend from call to call.
    template <class Visit>
    void take_due(Tick now, Visit&& visit) {
        const Tick first = std::max(asked_ + 1, now - static_cast<Tick>(kDays) + 1);
        asked_ = std::max(asked_, now);
        if (heads_.empty()) {
            return;
        }
        for (Tick day = first; day <= now; ++day) {
            for (Slot slot = heads_[day_of(day)]; slot != kNone;) {
                const QueueNode node = nodes_[slot];
                if (node.at <= now) {
                    cancel(slot);
                    visit(slot, node.at);
                }
                slot = node.next;
            }
        }
    }

  private:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
    static constexpr std::uint32_t kFirst = 0x80000000U;  ///< a day's first; its number follows
    static constexpr std::size_t kDays = 4096;            ///< a power of two

    struct QueueNode {
        Tick at = kNever;
        Slot next = kNone;
        std::uint32_t previous = kNone;
    };

    static std::uint32_t day_of(Tick at) {
        return static_cast<std::uint32_t>(static_cast<std::uint64_t>(at) % kDays);
    }

    std::vector<QueueNode> nodes_;  // by slot
    std::vector<Slot> heads_;       // by day; made with the first slot
    Tick asked_ = -1;
};

}  // namespace zoned::ai
