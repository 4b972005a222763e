// RowIndex: the row of an entity by its id.
#pragma once

#include "server/world/row_set.h"
#include "shared/core/ids.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::world {

/// A hash table with open addressing and linear probing, at most half full: a look-up touches one
/// cache line, seldom two. Ids are spread by multiplication, so that any stride between them, such
/// as that of a process with many zones, spreads evenly; removal moves back what probed past the
/// removed one (Knuth, The Art of Computer Programming 3, 6.4, "Fibonacci hashing" and Algorithm
/// R).
class RowIndex {
  public:
    /// False, and nothing happens, where the entity is there. `entity` is not zero.
    bool insert(EntityId entity, Row row) {
        if (2 * (size_ + 1) > slots_.size()) {
            grow();
        }
        Slot& slot = slots_[place_of(entity.value)];
        if (slot.entity != 0) {
            return false;
        }
        slot = {entity.value, row};
        ++size_;
        return true;
    }

    /// kNoRow: it is not there.
    [[nodiscard]] Row find(EntityId entity) const {
        if (size_ == 0 || !entity) {
            return kNoRow;
        }
        return slots_[place_of(entity.value)].row;
    }

    /// The entity is there.
    void move(EntityId entity, Row row) { slots_[place_of(entity.value)].row = row; }

    /// The entity is there.
    void erase(EntityId entity) {
        std::size_t gap = place_of(entity.value);
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t at = (gap + 1) & mask; slots_[at].entity != 0; at = (at + 1) & mask) {
            // It may fill the gap unless its home lies behind the gap, on the way to it.
            if (((at - home(slots_[at].entity)) & mask) >= ((at - gap) & mask)) {
                slots_[gap] = slots_[at];
                gap = at;
            }
        }
        slots_[gap] = Slot();
        --size_;
    }

    void clear() {
        slots_.clear();
        size_ = 0;
    }

  private:
    struct Slot {
        std::uint32_t entity = 0;  ///< zero: empty
        Row row = kNoRow;
    };

    static constexpr std::size_t kFewest = 16;

    [[nodiscard]] std::size_t home(std::uint32_t entity) const {
        constexpr std::uint32_t kGoldenRatio = 2654435769U;  // 2^32 / 1.618...
        return (entity * kGoldenRatio) >> shift_;
    }

    /// Where the entity is, or the empty slot where it would be.
    [[nodiscard]] std::size_t place_of(std::uint32_t entity) const {
        std::size_t at = home(entity);
        while (slots_[at].entity != entity && slots_[at].entity != 0) {
            at = (at + 1) & (slots_.size() - 1);
        }
        return at;
    }

    void grow() {
        std::vector<Slot> old(slots_.empty() ? kFewest : 2 * slots_.size());
        old.swap(slots_);
        shift_ = 32U - static_cast<unsigned>(std::countr_zero(slots_.size()));
        for (const Slot& slot : old) {
            if (slot.entity != 0) {
                slots_[place_of(slot.entity)] = slot;
            }
        }
    }

    std::vector<Slot> slots_;  // a power of two of them, or none
    std::size_t size_ = 0;
    unsigned shift_ = 32;
};

}  // namespace zoned::world
