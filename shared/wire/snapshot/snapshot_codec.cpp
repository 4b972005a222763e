#include "shared/wire/snapshot/snapshot_codec.h"

#include "shared/wire/snapshot/snapshot_pass.h"

#include <optional>

namespace zoned::wire::snapshot {

namespace {

constexpr int kGapBits = 8;
constexpr FrameNumber kLongestGap = (1u << kGapBits) - 1;
constexpr int kEpochBits = 2;
/// Of kProbabilityOne: that a snapshot before the newest one learned was not learned.
constexpr std::uint32_t kSeldom = entropy::kProbabilityOne / 64;

/// What a packet says of the knowledge that it was coded with.
struct Head {
    std::uint8_t epoch = 0;
    FrameNumber gap = 0;  ///< to the newest snapshot learned; 0: none
    std::uint64_t learned = 0;
};

void write_head(entropy::RangeEncoder& coder, const Head& head) {
    coder.encode_raw(head.epoch, kEpochBits);
    coder.encode_raw(head.gap, kGapBits);
    for (int i = 0; i < 64 && head.gap != 0; ++i) {
        if ((head.learned >> i & 1u) != 0) {
            coder.encode(0, entropy::kProbabilityOne - kSeldom);
        } else {
            coder.encode(entropy::kProbabilityOne - kSeldom, kSeldom);
        }
    }
}

Head read_head(entropy::RangeDecoder& coder) {
    Head head;
    head.epoch = static_cast<std::uint8_t>(coder.decode_raw(kEpochBits));
    head.gap = coder.decode_raw(kGapBits);
    for (int i = 0; i < 64 && head.gap != 0; ++i) {
        if (coder.peek() < entropy::kProbabilityOne - kSeldom) {
            coder.take(0, entropy::kProbabilityOne - kSeldom);
            head.learned |= std::uint64_t{1} << i;
        } else {
            coder.take(entropy::kProbabilityOne - kSeldom, kSeldom);
        }
    }
    return head;
}

/// A snapshot that nothing was learned from but itself.
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
      knowledge_(format) {
}

void SnapshotEncoder::share(FrameNumber number, const Snapshot& samples) {
    knowledge_.learn(plain_frame(format_, number, samples, knowledge_.frame(0)));
}

void SnapshotEncoder::encode(FrameNumber number,
                             const Snapshot& samples,
                             std::vector<std::uint8_t>& out) {
    ZONED_ASSERT(samples.size() == format_.bodies, "a snapshot has all bodies");
    ZONED_ASSERT(sent_.empty() || number > sent_.back().frame->number, "numbers ascend");
    learn_acknowledged();
    if (knowledge_.newest() != 0 && number - knowledge_.newest() > kLongestGap) {
        start_over();
    }
    std::shared_ptr<CodedFrame> frame = frames_.take();
    frame->number = number;
    frame->samples = samples;
    entropy::RangeEncoder coder(out);
    const FrameNumber newest = knowledge_.newest();
    write_head(coder, {epoch_, newest == 0 ? 0 : number - newest, knowledge_.learned()});
    EncodePort port(coder, knowledge_.models());
    SnapshotPass<EncodePort>(format_, knowledge_, neighbours_, port, *frame).run();
    coder.finish();
    sent_.push_back({std::move(frame), newest, epoch_, false});
    if (sent_.size() > kUnderWay) {
        sent_.pop_front();
    }
}

void SnapshotEncoder::acknowledge(FrameNumber number) {
    const auto it =
        std::lower_bound(sent_.begin(), sent_.end(), number, [](const Sent& sent, FrameNumber n) {
            return sent.frame->number < n;
        });
    if (it != sent_.end() && it->frame->number == number) {
        it->acknowledged = true;
    }
}

/// Snapshots are learned in ascending order; one whose turn has passed is never learned. The
/// receiver may have missed every packet since it decoded the newest acknowledged one, so what was
/// learned since that one's reference must be within reach of a packet's head.
void SnapshotEncoder::learn_acknowledged() {
    std::size_t done = 0;
    for (std::size_t i = 0; i < sent_.size(); ++i) {
        const Sent& sent = sent_[i];
        if (!sent.acknowledged) {
            continue;
        }
        done = i + 1;
        const FrameNumber number = sent.frame->number;
        if (sent.epoch != epoch_ || number <= knowledge_.newest()) {
            continue;
        }
        if (number - sent.reference > 64 && sent.reference != knowledge_.newest()) {
            start_over();
            return;
        }
        knowledge_.learn(sent.frame);
    }
    sent_.erase(sent_.begin(), sent_.begin() + static_cast<std::ptrdiff_t>(done));
}

void SnapshotEncoder::start_over() {
    knowledge_ = Knowledge(format_);
    epoch_ = static_cast<std::uint8_t>((epoch_ + 1) % (1 << kEpochBits));
    sent_.clear();
}

// ---------------------------------------------------------------- decoder

SnapshotDecoder::SnapshotDecoder(const SnapshotFormat& format)
    : format_(format),
      known_{Knowledge(format)} {
}

void SnapshotDecoder::share(FrameNumber number, const Snapshot& samples) {
    Knowledge& newest = known_.back();
    newest.learn(plain_frame(format_, number, samples, newest.frame(0)));
    newest_ = number;
}

core::Result<const Snapshot*> SnapshotDecoder::decode(FrameNumber number,
                                                      std::span<const std::uint8_t> bytes) {
    using Decoded = core::Result<const Snapshot*>;
    entropy::RangeDecoder coder(bytes);
    const Head head = read_head(coder);
    if (head.gap >= number) {
        return Decoded::failure("refers to a snapshot before the first");
    }
    if (find_received(number) != received_.end()) {
        return Decoded::failure("was received before");
    }
    // The encoder has started over? A packet from before it did so may come later.
    const bool fresh = head.epoch != epoch_ && head.gap == 0 && number > newest_;
    if (head.epoch != epoch_ && !fresh) {
        return Decoded::failure("belongs to knowledge that was given up");
    }
    std::optional<Knowledge> nothing;
    const Knowledge* knowledge =
        fresh ? &nothing.emplace(format_)
              : knowledge_at(head.gap == 0 ? 0 : number - head.gap, head.learned);
    if (knowledge == nullptr) {
        return Decoded::failure("refers to snapshots that are not known");
    }
    std::shared_ptr<CodedFrame> frame = frames_.take();
    frame->number = number;
    DecodePort port(coder, knowledge->models());
    SnapshotPass<DecodePort>(format_, *knowledge, neighbours_, port, *frame).run();
    if (!coder.complete()) {
        return Decoded::failure("malformed snapshot");
    }
    if (fresh) {
        epoch_ = head.epoch;
        received_.clear();
        known_.assign(1, *nothing);
    }
    return keep(std::move(frame));
}

std::deque<FramePointer>::iterator SnapshotDecoder::find_received(FrameNumber number) {
    const auto at = std::lower_bound(
        received_.begin(), received_.end(), number, [](const FramePointer& frame, FrameNumber n) {
            return frame->number < n;
        });
    return at != received_.end() && (*at)->number == number ? at : received_.end();
}

const Snapshot* SnapshotDecoder::keep(std::shared_ptr<CodedFrame> frame) {
    newest_ = std::max(newest_, frame->number);
    const auto at = std::upper_bound(
        received_.begin(),
        received_.end(),
        frame->number,
        [](FrameNumber n, const FramePointer& other) { return n < other->number; });
    const Snapshot* samples = &frame->samples;
    received_.insert(at, std::move(frame));
    if (received_.size() > kReceived) {
        received_.pop_front();
    }
    return samples;
}

/// Brings what was known when an earlier snapshot was newest up to `newest`; null where something
/// that the encoder learned is missing here.
const Knowledge* SnapshotDecoder::knowledge_at(FrameNumber newest, std::uint64_t learned) {
    auto from = known_.end();
    while (from != known_.begin() && std::prev(from)->newest() > newest) {
        --from;
    }
    if (from == known_.begin()) {
        return nullptr;
    }
    const Knowledge& before = *std::prev(from);
    if (before.newest() == newest) {
        return before.learned() == learned || newest == 0 ? &before : nullptr;
    }
    Knowledge now = before;
    for (const auto& frame : received_) {
        const FrameNumber n = frame->number;
        const bool wanted = n == newest || (n < newest && newest - n <= 64 &&
                                            (learned >> (newest - n - 1) & 1u) != 0);
        if (n > before.newest() && n <= newest && wanted) {
            now.learn(frame);
        }
    }
    if (now.newest() != newest || now.learned() != learned) {
        return nullptr;
    }
    const auto at = known_.insert(from, std::move(now));
    if (known_.size() <= kReordered) {
        return &*at;
    }
    const bool oldest = at == known_.begin();
    known_.pop_front();
    return oldest ? nullptr : &*std::find_if(known_.begin(), known_.end(), [&](const Knowledge& k) {
        return k.newest() == newest;
    });
}

}  // namespace zoned::wire::snapshot
