// SentLog: keeps the contents of the newest packets to one client until their status is known.
#pragma once

#include "shared/core/ids.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace zoned::replication {

/// One record in a packet.
struct SentEntry {
    EntityId entity;
    std::uint32_t stamp = 0;     ///< the subscription or removal that it belongs to
    std::uint32_t version = 0;   ///< of the publication; 0 for a removal
    std::uint32_t keyframe = 0;  ///< serial that the receiver will hold; 0 for deltas and removals
};

enum class DeliveryStatus : std::uint8_t {
    kOpen,
    kLost,  ///< given up for sending again; an acknowledgement may still come
    kAcked,
};

struct SentPacket {
    std::uint64_t sequence = 0;
    Tick tick = 0;
    DeliveryStatus status = DeliveryStatus::kOpen;
    bool counted = false;         ///< as a sample of the path's loss
    bool counted_lost = false;    ///< as one that was lost
    std::uint32_t own_stamp = 0;  ///< the own state that it carried; 0: none
    bool coded = false;           ///< its records were coded for this client alone
    std::vector<SentEntry> entries;
};

/// The newest kCapacity packets. Acknowledgements reach back 33 packets, so nothing older matters.
class SentLog {
  public:
    static constexpr std::uint64_t kCapacity = 64;

    SentLog() : packets_(kCapacity) {}

    /// Begins the entry of a packet; sequences are consecutive. The packet that it displaces must
    /// be resolved.
    SentPacket& add(std::uint64_t sequence, Tick now) {
        SentPacket& packet = packets_[sequence % kCapacity];
        packet.sequence = sequence;
        packet.tick = now;
        packet.status = DeliveryStatus::kOpen;
        packet.counted = false;
        packet.counted_lost = false;
        packet.own_stamp = 0;
        packet.coded = false;
        packet.entries.clear();
        return packet;
    }

    /// nullptr when it was never sent from here or is too old.
    [[nodiscard]] const SentPacket* find(std::uint64_t sequence) const {
        const SentPacket& packet = packets_[sequence % kCapacity];
        return packet.sequence == sequence && sequence != 0 ? &packet : nullptr;
    }

    SentPacket* find(std::uint64_t sequence) {
        return const_cast<SentPacket*>(std::as_const(*this).find(sequence));
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(packets_);
        if constexpr (Archive::kReads) {
            if (packets_.size() != kCapacity) {
                archive.fail("a log holds more or fewer packets than there are places");
                packets_.resize(kCapacity);
            }
        }
    }

  private:
    std::vector<SentPacket> packets_;
};

}  // namespace zoned::replication
