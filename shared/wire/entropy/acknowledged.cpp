#include "shared/wire/entropy/acknowledged.h"

#include "shared/wire/entropy/symbol_model.h"

#include <array>

namespace zoned::wire::entropy {

namespace {

/// Learned packets come in runs, with a loss now and then. Packets before the epoch were never
/// learned, nor are packets without coded records.
class LearnedModels {
  public:
    template <class Code>
    bool code(Code&& with) {
        BitModel& model = after_[before_ ? 1 : 0];
        before_ = with(model);
        model.learning(before_);
        return before_;
    }

  private:
    std::array<BitModel, 2> after_{BitModel(1u << 14), BitModel(63u << 10)};  // no, yes
    bool before_ = true;
};

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
    LearnedModels models;
    for (int i = 0; i < 64 && head.gap != 0; ++i) {
        models.code([&](const BitModel& model) {
            const bool learned = (head.learned >> i & 1u) != 0;
            model.encode(coder, learned);
            return learned;
        });
    }
}

KnowledgeHead read_head(RangeDecoder& coder) {
    KnowledgeHead head;
    head.epoch = static_cast<std::uint8_t>(coder.decode_raw(KnowledgeHead::kEpochBits));
    head.gap = coder.decode_raw(KnowledgeHead::kGapBits);
    LearnedModels models;
    for (int i = 0; i < 64 && head.gap != 0; ++i) {
        const bool learned =
            models.code([&](const BitModel& model) { return model.decode(coder); });
        head.learned |= std::uint64_t{learned ? 1u : 0u} << i;
    }
    return head;
}

}  // namespace zoned::wire::entropy
