// StockWaitList: which suspended agents wait for which stock. A waiting agent costs nothing until
// the stock is there.
#pragma once

#include "server/ai/agent/agent.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace zoned::ai {

/// Agents that wait for the same stock form a group, and one check of the stock per tick answers
/// for all of it. Within a group agents are sorted by the ticks at which they decide. Without
/// changes a tick costs one check for each group with a decision in it. It calls up only agents
/// whose stock differs from what they wait for at a tick of their decision. The result is the same
/// as if all had checked at each of their decisions.
class StockWaitList {
  public:
    using Slot = std::uint32_t;

    /// The properties that a group shares.
    struct WaitKey {
        std::uint16_t brain = 0;
        std::uint16_t leaf = 0;
        std::uint16_t current_action = 0;
        StockWait wait;
        Tick period = 1;  ///< of its decisions, ticks

        friend bool operator==(const WaitKey&, const WaitKey&) = default;
    };

    struct WaitMember {
        EntityId entity;
        Slot slot = 0;
    };

    class WaitGroup {
      public:
        explicit WaitGroup(const WaitKey& key);

        [[nodiscard]] const WaitKey& key() const { return key_; }

        /// Agents that may decide at `tick`, in no order. All that do are among them, see
        /// decides_at().
        [[nodiscard]] std::span<const WaitMember> near(Tick tick) const {
            return phases_[static_cast<std::size_t>(tick % key_.period) % phases_.size()];
        }

        [[nodiscard]] bool decides_at(EntityId entity, Tick tick) const {
            return static_cast<Tick>(entity.value) % key_.period == tick % key_.period;
        }

      private:
        friend class StockWaitList;

        WaitKey key_;
        std::vector<std::vector<WaitMember>> phases_;
    };

    /// Makes the slots below `slots` exist; new ones wait for nothing.
    void grow(std::size_t slots);

    /// Leaves the agent's former group, and joins another.
    void join(Slot slot, EntityId entity, const WaitKey& key);
    void leave(Slot slot);

    /// Prefetches the data that group_of() and leave() read of the slot.
    void prefetch(Slot slot) const { __builtin_prefetch(&places_[slot], 1); }

    /// Null: it waits for nothing.
    [[nodiscard]] const WaitGroup* group_of(Slot slot) const {
        return places_[slot].group == kNone ? nullptr : &groups_[places_[slot].group];
    }

    /// In arbitrary order; some may be empty.
    [[nodiscard]] std::span<const WaitGroup> groups() const { return groups_; }

  private:
    static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

    struct WaitPlace {
        std::uint32_t group = kNone;
        std::uint32_t phase = 0;
        std::uint32_t index = 0;
    };

    struct HashOfKey {
        std::size_t operator()(const WaitKey& key) const;
    };

    std::vector<WaitPlace> places_;  // by slot
    std::vector<WaitGroup> groups_;
    std::unordered_map<WaitKey, std::uint32_t, HashOfKey> by_key_;
};

}  // namespace zoned::ai
