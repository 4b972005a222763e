// StockWaitList: which suspended agents wait for what stock, so that who waits costs nothing until
// it is there.
#pragma once

#include "server/ai/agent/agent.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace zoned::ai {

/// Agents that wait for the same are a group, which one look at the stock answers for in a
/// tick; within it they lie by the ticks at which they decide. As long as nothing is new, a tick
/// costs a look at each group of which somebody decides in it, and those alone come up for whom
/// stock has become other than they wait for at a tick at which they decide: as if all of them had
/// looked at each of their decisions.
class StockWaitList {
  public:
    using Slot = std::uint32_t;

    /// What a group has in common.
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

        /// Who may decide at `tick`, in no order: all who do, see decides_at().
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

    /// Slots below `slots` exist, new ones wait for nothing.
    void grow(std::size_t slots);

    /// Leaves the group that it was in.
    void join(Slot slot, EntityId entity, const WaitKey& key);
    void leave(Slot slot);

    /// Asks for what group_of() and leave() read of the slot soon.
    void prefetch(Slot slot) const { __builtin_prefetch(&places_[slot], 1); }

    /// Null: it waits for nothing.
    [[nodiscard]] const WaitGroup* group_of(Slot slot) const {
        return places_[slot].group == kNone ? nullptr : &groups_[places_[slot].group];
    }

    /// In no order that means anything; some may be empty.
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
