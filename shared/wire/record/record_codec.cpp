#include "shared/wire/record/record_codec.h"

#include "shared/wire/record/record_pass.h"

#include <utility>

namespace zoned::wire::record {

RecordEncoder::RecordEncoder(const RecordFormat& format, std::uint8_t epoch)
    : format_(format),
      acknowledged_(format, epoch) {
}

std::shared_ptr<const RecordFrame> RecordEncoder::encode(entropy::PacketNumber number,
                                                         Tick tick,
                                                         ZoneId zone,
                                                         std::vector<CodedRecord> records,
                                                         std::vector<std::uint8_t>& out) {
    ZONED_ASSERT(records.size() <= kMostRecords, "more records than a packet holds");
    std::sort(records.begin(), records.end(), [](const CodedRecord& a, const CodedRecord& b) {
        return a.entity < b.entity;
    });
    const entropy::KnowledgeHead head = acknowledged_.begin(number);
    auto frame = std::make_shared<RecordFrame>();
    frame->number = number;
    frame->tick = tick;
    frame->zone = zone;
    frame->records = std::move(records);
    entropy::RangeEncoder coder(out);
    entropy::write_head(coder, head);
    RecordPass<entropy::EncodePort>(format_, acknowledged_.knowledge(), {coder}, *frame).run();
    coder.finish();
    return frame;
}

RecordDecoder::RecordDecoder(const RecordFormat& format) : format_(format), acknowledged_(format) {
}

core::Result<std::shared_ptr<const RecordFrame>> RecordDecoder::decode(
    entropy::PacketNumber number,
    Tick tick,
    ZoneId zone,
    std::span<const std::uint8_t> bytes) {
    using Decoded = core::Result<std::shared_ptr<const RecordFrame>>;
    entropy::RangeDecoder coder(bytes);
    const entropy::KnowledgeHead head = entropy::read_head(coder);
    const char* why = "";
    const RecordKnowledge* knowledge = acknowledged_.knowledge_for(number, head, why);
    if (knowledge == nullptr) {
        return Decoded::failure(why);
    }
    auto frame = std::make_shared<RecordFrame>();
    frame->number = number;
    frame->tick = tick;
    frame->zone = zone;
    const bool sound = RecordPass<entropy::DecodePort>(format_, *knowledge, {coder}, *frame).run();
    if (!sound || !coder.complete()) {
        return Decoded::failure("malformed records");
    }
    acknowledged_.keep(frame);
    return std::shared_ptr<const RecordFrame>(std::move(frame));
}

}  // namespace zoned::wire::record
