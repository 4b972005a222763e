#include "shared/wire/entropy/acknowledged.h"

namespace zoned::wire::entropy {

namespace {

/// Of kProbabilityOne: that a packet before the newest one learned was not learned.
constexpr std::uint32_t kSeldom = kProbabilityOne / 64;

}  // namespace

void LearnedPackets::add(PacketNumber number) {
    const PacketNumber gap = number - newest_;
    if (newest_ == 0 || gap > 64) {
        before_ = 0;
    } else {
        before_ = (gap == 64 ? 0 : before_ << gap) | std::uint64_t{1} << (gap - 1);
    }
    newest_ = number;
}

void write_head(RangeEncoder& coder, const KnowledgeHead& head) {
    coder.encode_raw(head.epoch, KnowledgeHead::kEpochBits);
    coder.encode_raw(head.gap, KnowledgeHead::kGapBits);
    for (int i = 0; i < 64 && head.gap != 0; ++i) {
        if ((head.learned >> i & 1u) != 0) {
            coder.encode(0, kProbabilityOne - kSeldom);
        } else {
            coder.encode(kProbabilityOne - kSeldom, kSeldom);
        }
    }
}

KnowledgeHead read_head(RangeDecoder& coder) {
    KnowledgeHead head;
    head.epoch = static_cast<std::uint8_t>(coder.decode_raw(KnowledgeHead::kEpochBits));
    head.gap = coder.decode_raw(KnowledgeHead::kGapBits);
    for (int i = 0; i < 64 && head.gap != 0; ++i) {
        if (coder.peek() < kProbabilityOne - kSeldom) {
            coder.take(0, kProbabilityOne - kSeldom);
            head.learned |= std::uint64_t{1} << i;
        } else {
            coder.take(kProbabilityOne - kSeldom, kSeldom);
        }
    }
    return head;
}

}  // namespace zoned::wire::entropy
