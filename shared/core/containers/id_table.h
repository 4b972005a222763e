// IdTable: finds a value by a number that is not zero.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace zoned::core {

/// A hash table with open addressing and linear probing, at most half full: a look-up touches one
/// cache line, seldom two. Keys are spread by multiplication, so that any stride between them, such
/// as that of ids in a process with many zones, spreads evenly; removal moves back what probed past
/// the removed one (Knuth, The Art of Computer Programming 3, 6.4, "Fibonacci hashing" and
/// Algorithm R).
template <class Value>
class IdTable {
  public:
    /// False, and nothing happens, where the key is there. `key` is not zero.
    bool insert(std::uint32_t key, Value value) {
        if (2 * (size_ + 1) > slots_.size()) {
            grow();
        }
        Slot& slot = slots_[place_of(key)];
        if (slot.key != 0) {
            return false;
        }
        slot = {key, std::move(value)};
        ++size_;
        return true;
    }

    /// Null: it is not there. Valid until the table changes.
    [[nodiscard]] const Value* find(std::uint32_t key) const {
        if (size_ == 0 || key == 0) {
            return nullptr;
        }
        const Slot& slot = slots_[place_of(key)];
        return slot.key == 0 ? nullptr : &slot.value;
    }

    [[nodiscard]] Value* find(std::uint32_t key) {
        return const_cast<Value*>(std::as_const(*this).find(key));
    }

    /// Nothing happens where it is not there.
    void erase(std::uint32_t key) {
        if (find(key) == nullptr) {
            return;
        }
        std::size_t gap = place_of(key);
        const std::size_t mask = slots_.size() - 1;
        for (std::size_t at = (gap + 1) & mask; slots_[at].key != 0; at = (at + 1) & mask) {
            // It may fill the gap unless its home lies behind the gap, on the way to it.
            if (((at - home(slots_[at].key)) & mask) >= ((at - gap) & mask)) {
                slots_[gap] = std::move(slots_[at]);
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

    [[nodiscard]] std::size_t size() const { return size_; }

  private:
    struct Slot {
        std::uint32_t key = 0;  ///< zero: empty
        Value value{};
    };

    static constexpr std::size_t kFewest = 16;

    [[nodiscard]] std::size_t home(std::uint32_t key) const {
        constexpr std::uint32_t kGoldenRatio = 2654435769U;  // 2^32 / 1.618...
        return static_cast<std::size_t>(key * kGoldenRatio) >> shift_;
    }

    /// Where the key is, or the empty slot where it would be.
    [[nodiscard]] std::size_t place_of(std::uint32_t key) const {
        std::size_t at = home(key);
        while (slots_[at].key != key && slots_[at].key != 0) {
            at = (at + 1) & (slots_.size() - 1);
        }
        return at;
    }

    void grow() {
        std::vector<Slot> old(slots_.empty() ? kFewest : 2 * slots_.size());
        old.swap(slots_);
        shift_ = 32U - static_cast<unsigned>(std::countr_zero(slots_.size()));
        for (Slot& slot : old) {
            if (slot.key != 0) {
                slots_[place_of(slot.key)] = std::move(slot);
            }
        }
    }

    std::vector<Slot> slots_;  // a power of two of them, or none
    std::size_t size_ = 0;
    unsigned shift_ = 32;
};

}  // namespace zoned::core
