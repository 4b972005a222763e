#include "shared/wire/snapshot/snapshot_codec.h"

#include "shared/wire/snapshot/snapshot_pass.h"

#include <utility>

namespace zoned::wire::snapshot {

namespace {

/// A snapshot that only serves as a reference.
std::shared_ptr<CodedFrame> plain_frame(const SnapshotFormat& format,
                                        FrameNumber number,
                                        const Snapshot& samples,
                                        const CodedFrame& before) {
    auto frame = std::make_shared<CodedFrame>();
    frame->number = number;
    frame->samples = samples;
    frame->changed_at = before.changed_at;
    frame->moved_index.assign(format.bodies, kNotMoved);
    for (std::uint32_t body = 0; body < format.bodies; ++body) {
        if (!(samples[body] == before.samples[body])) {
            frame->changed_at[body] = number;
        }
    }
    return frame;
}

}  // namespace

// ---------------------------------------------------------------- encoder

SnapshotEncoder::SnapshotEncoder(const SnapshotFormat& format)
    : format_(format),
      acknowledged_(format) {
    ZONED_ASSERT(format.bodies < kNotMoved, "bodies have indices of 16 bits");
}

void SnapshotEncoder::share(FrameNumber number, const Snapshot& samples) {
    acknowledged_.share(plain_frame(format_, number, samples, acknowledged_.knowledge().frame(0)));
}

void SnapshotEncoder::encode(FrameNumber number,
                             const Snapshot& samples,
                             std::vector<std::uint8_t>& out) {
    ZONED_ASSERT(samples.size() == format_.bodies, "a snapshot has all bodies");
    const entropy::KnowledgeHead head = acknowledged_.begin(number);
    const Knowledge& knowledge = acknowledged_.knowledge();
    std::shared_ptr<CodedFrame> frame = frames_.take();
    frame->number = number;
    frame->samples = samples;
    entropy::RangeEncoder coder(out, raw_);
    entropy::write_head(coder, head);
    SnapshotPass<entropy::EncodePort>(format_, knowledge, neighbours_, {coder}, *frame).run();
    coder.finish();
    acknowledged_.sent(std::move(frame));
}

void SnapshotEncoder::acknowledge(FrameNumber number) {
    acknowledged_.acknowledge(number);
}

// ---------------------------------------------------------------- decoder

SnapshotDecoder::SnapshotDecoder(const SnapshotFormat& format)
    : format_(format),
      acknowledged_(format) {
    ZONED_ASSERT(format.bodies < kNotMoved, "bodies have indices of 16 bits");
}

void SnapshotDecoder::share(FrameNumber number, const Snapshot& samples) {
    acknowledged_.share(plain_frame(format_, number, samples, acknowledged_.newest().frame(0)));
}

core::Result<const Snapshot*> SnapshotDecoder::decode(FrameNumber number,
                                                      std::span<const std::uint8_t> bytes) {
    using Decoded = core::Result<const Snapshot*>;
    entropy::RangeDecoder coder(bytes);
    const entropy::KnowledgeHead head = entropy::read_head(coder);
    const char* why = "";
    const Knowledge* knowledge = acknowledged_.knowledge_for(number, head, why).knowledge;
    if (knowledge == nullptr) {
        return Decoded::failure(why);
    }
    std::shared_ptr<CodedFrame> frame = frames_.take();
    frame->number = number;
    SnapshotPass<entropy::DecodePort>(format_, *knowledge, neighbours_, {coder}, *frame).run();
    if (!coder.complete()) {
        return Decoded::failure("malformed snapshot");
    }
    const Snapshot* samples = &frame->samples;
    acknowledged_.keep(std::move(frame));
    return samples;
}

}  // namespace zoned::wire::snapshot
