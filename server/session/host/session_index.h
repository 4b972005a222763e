// SessionIndex: finds a session by a number that its datagrams or its zone carry.
#pragma once

#include "shared/core/assert.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace zoned::session {

struct Session;

/// A hash table with linear probing and deletion without marks (Knuth, The Art of Computer
/// Programming 3, section 6.4, algorithms L and R). Each datagram is looked up once each way, so a
/// look-up is one line of memory, and a Fibonacci hash keeps consecutive keys apart (the same,
/// before algorithm C). No client chooses a key that is in the table. 0 is no key.
class SessionIndex {
  public:
    /// nullptr: there is none.
    [[nodiscard]] Session* find(std::uint32_t key) const {
        for (std::size_t at = home(key);; at = (at + 1) & mask_) {
            if (slots_[at].key == key) {
                return slots_[at].session;
            }
            if (slots_[at].key == 0) {
                return nullptr;
            }
        }
    }

    /// `key` is not 0, and new.
    void insert(std::uint32_t key, Session& session) {
        ZONED_ASSERT(key != 0 && find(key) == nullptr, "a session is found by a key of its own");
        if (2 * ++count_ > slots_.size()) {
            grow();
        }
        put({key, &session});
    }

    void erase(std::uint32_t key) {
        std::size_t hole = home(key);
        while (slots_[hole].key != key) {
            if (slots_[hole].key == 0) {
                return;
            }
            hole = (hole + 1) & mask_;
        }
        --count_;
        // What stands behind the hole moves up where its way from home leads across it.
        for (std::size_t at = (hole + 1) & mask_; slots_[at].key != 0; at = (at + 1) & mask_) {
            const std::size_t from_home = (at - home(slots_[at].key)) & mask_;
            if (from_home >= ((at - hole) & mask_)) {
                slots_[hole] = slots_[at];
                hole = at;
            }
        }
        slots_[hole] = {};
    }

    [[nodiscard]] std::size_t size() const { return count_; }

  private:
    struct SessionSlot {
        std::uint32_t key = 0;  // 0: empty
        Session* session = nullptr;
    };

    [[nodiscard]] std::size_t home(std::uint32_t key) const {
        return static_cast<std::size_t>(key * 0x9E3779B1U) >> shift_;
    }

    void put(const SessionSlot& slot) {
        std::size_t at = home(slot.key);
        while (slots_[at].key != 0) {
            at = (at + 1) & mask_;
        }
        slots_[at] = slot;
    }

    void grow() {
        std::vector<SessionSlot> before(2 * slots_.size());
        before.swap(slots_);
        mask_ = slots_.size() - 1;
        --shift_;
        for (const SessionSlot& slot : before) {
            if (slot.key != 0) {
                put(slot);
            }
        }
    }

    std::vector<SessionSlot> slots_ = std::vector<SessionSlot>(16);  // at most half are full
    std::size_t mask_ = 15;
    unsigned shift_ = 28;  // 32 less the bits of mask_
    std::size_t count_ = 0;
};

}  // namespace zoned::session
