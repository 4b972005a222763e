#include "shared/wire/record/record_codec.h"

#include "shared/wire/record/record_pass.h"

#include <utility>

namespace zoned::wire::record {

namespace {

std::shared_ptr<RecordFrame> new_frame(entropy::FramePool<RecordFrame>& frames,
                                       entropy::PacketNumber number,
                                       Tick tick,
                                       ZoneId zone) {
    std::shared_ptr<RecordFrame> frame = frames.take();
    frame->number = number;
    frame->tick = tick;
    frame->zone = zone;
    return frame;
}

}  // namespace

RecordEncoder::RecordEncoder(const RecordFormat& format, std::uint8_t epoch)
    : format_(format),
      acknowledged_(format, epoch) {
}

std::shared_ptr<const RecordFrame> RecordEncoder::encode(entropy::PacketNumber number,
                                                         Tick tick,
                                                         ZoneId zone,
                                                         std::span<const CodedRecord> records,
                                                         std::vector<std::uint8_t>& out,
                                                         bool measured,
                                                         const DeclaredSource* declared) {
    ZONED_ASSERT(records.size() <= kMostRecords, "more records than a packet holds");
    const entropy::KnowledgeHead head = acknowledged_.begin(number);
    std::shared_ptr<RecordFrame> frame = new_frame(frames_, number, tick, zone);
    frame->records.assign(records.begin(), records.end());
    std::sort(frame->records.begin(),
              frame->records.end(),
              [](const CodedRecord& a, const CodedRecord& b) { return a.entity < b.entity; });
    entropy::RangeEncoder coder(out, raw_);
    entropy::write_head(coder, head);
    RecordPass<entropy::EncodePort> pass(format_,
                                         acknowledged_.knowledge(),
                                         {acknowledged_.common(), {}},
                                         {coder},
                                         memory_,
                                         measured,
                                         *frame);
    pass.take_declared(declared);
    pass.run();
    coder.finish();
    return frame;
}

RecordDecoder::RecordDecoder(const RecordFormat& format) : format_(format), acknowledged_(format) {
}

core::Result<std::shared_ptr<const RecordFrame>> RecordDecoder::decode(
    entropy::PacketNumber number,
    Tick tick,
    ZoneId zone,
    std::span<const std::uint8_t> bytes,
    bool measured) {
    using Decoded = core::Result<std::shared_ptr<const RecordFrame>>;
    entropy::RangeDecoder coder(bytes);
    const entropy::KnowledgeHead head = entropy::read_head(coder);
    const char* why = "";
    const auto known = acknowledged_.knowledge_for(number, head, why);
    if (known.knowledge == nullptr) {
        return Decoded::failure(why);
    }
    std::shared_ptr<RecordFrame> frame = new_frame(frames_, number, tick, zone);
    RecordPass<entropy::DecodePort> pass(format_,
                                         *known.knowledge,
                                         {*known.common, known.not_common},
                                         {coder},
                                         memory_,
                                         measured,
                                         *frame);
    const bool sound = pass.run();
    if (pass.fault() != DeclaredFault::kNone) {
        return Decoded::failure(kDeclaredFaultTexts[static_cast<std::size_t>(pass.fault())]);
    }
    if (!sound || !coder.complete()) {
        return Decoded::failure("malformed records");
    }
    acknowledged_.keep(frame);
    return std::shared_ptr<const RecordFrame>(std::move(frame));
}

}  // namespace zoned::wire::record
