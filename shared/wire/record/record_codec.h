// Record codec: codes a packet's publications for one client in few bits, against publications that
// this client has acknowledged.
#pragma once

#include "shared/core/result.h"
#include "shared/wire/entropy/frame_pool.h"
#include "shared/wire/record/neighbours.h"
#include "shared/wire/record/record_knowledge.h"

#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace zoned::wire::record {

/// The most records of one packet.
inline constexpr std::size_t kMostRecords = 1024;

/// Memory of passes that outlives them.
struct PassMemory {
    Neighbours neighbours;
    std::vector<EntityId> moving;
};

/// Codes records exactly, each against a prediction from its entity's newest acknowledged
/// publication. Position and orientation are moved on; the velocity also uses the error of the
/// position. An adaptive range coder codes the residuals, and the field table gives the fields. Any
/// packet may be lost, doubled or late: predictors and probabilities come from acknowledged packets
/// alone.
class RecordEncoder {
  public:
    /// `epoch`: see KnowledgeEncoder.
    explicit RecordEncoder(const RecordFormat& format, std::uint8_t epoch = 0);

    /// Appends the code of `records` to `out`, packet `number` (ascending from 1) of `tick`.
    /// Records come in any order, one per entity, at most kMostRecords. The result may be dropped,
    /// and another packet of that number encoded, as long as it was not sent(). Allocates nothing
    /// once packets have been as large and as many were in flight. `measured`: also counts the bits
    /// of each record (RecordFrame::bits), equally in encoder and decoder. `declared` is needed
    /// where the type of a record has declared fields.
    std::shared_ptr<const RecordFrame> encode(entropy::PacketNumber number,
                                              Tick tick,
                                              ZoneId zone,
                                              std::span<const CodedRecord> records,
                                              std::vector<std::uint8_t>& out,
                                              bool measured = false,
                                              const DeclaredSource* declared = nullptr);

    void sent(std::shared_ptr<const RecordFrame> frame) { acknowledged_.sent(std::move(frame)); }

    /// The receiver has decoded this packet. Unknown, old and repeated numbers are ignored.
    void acknowledge(entropy::PacketNumber number) { acknowledged_.acknowledge(number); }

    /// The receiver lost its knowledge.
    void start_over() { acknowledged_.start_over(); }

    [[nodiscard]] std::uint8_t epoch() const { return acknowledged_.epoch(); }

    /// Publications that are kept as bases.
    [[nodiscard]] std::size_t known() const { return acknowledged_.common().size(); }

    /// All that later packets depend on.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(acknowledged_);
    }

  private:
    RecordFormat format_;
    entropy::KnowledgeEncoder<RecordKnowledge> acknowledged_;
    entropy::FramePool<RecordFrame> frames_;
    std::vector<std::uint8_t> raw_;  // scratch of the range coder
    PassMemory memory_;
};

class RecordDecoder {
  public:
    explicit RecordDecoder(const RecordFormat& format);

    /// The records of packet `number`, ascending by entity. Bytes are hostile: fails with the
    /// reason, and without any change, when they are malformed or refer to unknown packets. Each
    /// decoded packet must be acknowledged to the encoder, and no other.
    core::Result<std::shared_ptr<const RecordFrame>> decode(entropy::PacketNumber number,
                                                            Tick tick,
                                                            ZoneId zone,
                                                            std::span<const std::uint8_t> bytes,
                                                            bool measured = false);

    /// Publications that are kept as bases.
    [[nodiscard]] std::size_t known() const { return acknowledged_.common().size(); }

  private:
    RecordFormat format_;
    entropy::KnowledgeDecoder<RecordKnowledge> acknowledged_;
    entropy::FramePool<RecordFrame> frames_;
    PassMemory memory_;
};

}  // namespace zoned::wire::record
