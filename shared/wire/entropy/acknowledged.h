// Acknowledged knowledge: encoder and decoder learn the same packets in the same order, from
// acknowledgements alone, on any network.
#pragma once

#include "shared/core/assert.h"
#include "shared/wire/entropy/range_coder.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace zoned::wire::entropy {

/// Numbers of packets count from 1; 0 is none.
using PacketNumber = std::uint32_t;

/// The set of learned packets: the newest and any of the 64 before it.
class LearnedPackets {
  public:
    /// Numbers ascend.
    void add(PacketNumber number);

    [[nodiscard]] PacketNumber newest() const { return newest_; }

    /// Bit i: newest() - 1 - i was learned.
    [[nodiscard]] std::uint64_t before() const { return before_; }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(newest_, before_);
    }

  private:
    PacketNumber newest_ = 0;
    std::uint64_t before_ = 0;
};

/// A packet's head: identifies the knowledge that the packet was coded with.
struct KnowledgeHead {
    static constexpr int kGapBits = 8;
    static constexpr PacketNumber kLongestGap = (1u << kGapBits) - 1;
    static constexpr int kEpochBits = 2;

    std::uint8_t epoch = 0;     ///< counts how often the encoder began anew
    PacketNumber gap = 0;       ///< back to the newest packet learned; 0: none
    std::uint64_t learned = 0;  ///< LearnedPackets::before()
};

/// Takes 10 bits and a few more, where most or none of the earlier packets were learned.
void write_head(RangeEncoder& coder, const KnowledgeHead& head);
KnowledgeHead read_head(RangeDecoder& coder);

/// A Knowledge is a state of knowledge. It has the types Frame (contents and lessons of a packet,
/// with its `number`), Format and Common, is made from a Format, copied, and has
/// learning(shared_ptr<const Frame>) and learned(). Two sides that learned the same frames in the
/// same order know the same, bit for bit. States of knowledge that differ by some packets may keep
/// their shared part in one Common. A Common is default-made, copied, and has learning(const
/// Frame&) and forget_before(n): no state older than the one with newest packet n will be used any
/// more.
///
/// The encoder's side. Packets are learned in ascending order when they are acknowledged. A packet
/// acknowledged out of order, after a later one, is never learned.
template <class Knowledge>
class KnowledgeEncoder {
  public:
    using Frame = typename Knowledge::Frame;
    using Format = typename Knowledge::Format;
    using Common = typename Knowledge::Common;

    /// Most packets in flight that can still be acknowledged.
    static constexpr std::size_t kUnderWay = 64;

    /// `epoch` must differ from the epoch of any encoder whose packets the receiver may have
    /// received before.
    explicit KnowledgeEncoder(const Format& format, std::uint8_t epoch = 0)
        : format_(format),
          knowledge_(format),
          epoch_(static_cast<std::uint8_t>(epoch % (1 << KnowledgeHead::kEpochBits))) {}

    /// Learns the acknowledged packets and begins packet `number`, which is coded with knowledge().
    KnowledgeHead begin(PacketNumber number) {
        ZONED_ASSERT(sent_.empty() || number > sent_.back().frame->number, "numbers ascend");
        learn_acknowledged();
        if (newest() != 0 && number - newest() > KnowledgeHead::kLongestGap) {
            start_over();
        }
        began_ = began_ == 0 ? number : began_;
        return {epoch_, newest() == 0 ? 0 : number - newest(), knowledge_.learned().before()};
    }

    [[nodiscard]] const Knowledge& knowledge() const { return knowledge_; }

    [[nodiscard]] const Common& common() const { return common_; }

    /// Notes the contents of the packet that began.
    void sent(std::shared_ptr<const Frame> frame) {
        sent_.push_back({std::move(frame), newest(), epoch_, false});
        if (sent_.size() > kUnderWay) {
            sent_.erase(sent_.begin());
        }
    }

    /// The receiver has decoded this packet. Unknown, old and repeated numbers are ignored.
    void acknowledge(PacketNumber number) {
        const auto it = std::lower_bound(
            sent_.begin(), sent_.end(), number, [](const SentFrame& sent, PacketNumber n) {
                return sent.frame->number < n;
            });
        if (it != sent_.end() && it->frame->number == number) {
            it->acknowledged = true;
        }
    }

    [[nodiscard]] std::uint8_t epoch() const { return epoch_; }

    /// Forgets everything: the receiver has lost the acknowledged packets.
    void start_over() {
        knowledge_ = Knowledge(format_);
        common_ = Common();
        began_ = 0;
        epoch_ = static_cast<std::uint8_t>((epoch_ + 1) % (1 << KnowledgeHead::kEpochBits));
        sent_.clear();
    }

    /// The knowledge and the packets that are under way; the format is there already.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(knowledge_, common_, epoch_, began_, sent_);
        if constexpr (Archive::kReads) {
            for (std::size_t i = 1; i < sent_.size(); ++i) {
                if (sent_[i - 1].frame->number >= sent_[i].frame->number) {
                    archive.fail("packets under way are in no order");
                    return;
                }
            }
        }
    }

  private:
    struct SentFrame {
        std::shared_ptr<const Frame> frame;
        PacketNumber reference = 0;  // newest that the receiver knew when it decoded this one
        std::uint8_t epoch = 0;
        bool acknowledged = false;

        template <class Archive>
        void serialize(Archive& archive) {
            if constexpr (Archive::kReads) {
                auto read = std::make_shared<Frame>();
                archive(*read);
                frame = std::move(read);
            } else {
                archive(*frame);
            }
            archive(reference, epoch, acknowledged);
        }
    };

    [[nodiscard]] PacketNumber newest() const { return knowledge_.learned().newest(); }

    /// The receiver may have missed every packet since the newest acknowledged one. So all packets
    /// learned since that one's reference must be within reach of a packet's head.
    void learn_acknowledged() {
        std::size_t done = 0;
        for (std::size_t i = 0; i < sent_.size(); ++i) {
            const SentFrame& sent = sent_[i];
            if (!sent.acknowledged) {
                continue;
            }
            done = i + 1;
            const PacketNumber number = sent.frame->number;
            if (sent.epoch != epoch_ || number <= newest()) {
                continue;
            }
            // One that was coded with nothing learned: all that was is of this epoch.
            const PacketNumber since = sent.reference != 0 ? sent.reference : began_ - 1;
            if (number - since > 64 && sent.reference != newest()) {
                start_over();
                return;
            }
            knowledge_.learning(sent.frame);
            common_.learning(*sent.frame);
        }
        sent_.erase(sent_.begin(), sent_.begin() + static_cast<std::ptrdiff_t>(done));
        common_.forget_before(newest());
    }

    Format format_;
    Knowledge knowledge_;
    Common common_;
    std::uint8_t epoch_;
    PacketNumber began_ = 0;       // first of the epoch; 0: none yet
    std::vector<SentFrame> sent_;  // ascending
};

/// The decoder's side. Use: knowledge_for() a packet's head, decode, keep() the result. A packet
/// that was not kept must not be acknowledged.
template <class Knowledge>
class KnowledgeDecoder {
  public:
    using Frame = typename Knowledge::Frame;
    using Format = typename Knowledge::Format;
    using Common = typename Knowledge::Common;
    using FramePointer = std::shared_ptr<const Frame>;

    /// A state, with the Common that it shares and the frames that it alone has learned, ascending;
    /// null: no state. Valid until the next call.
    struct KnownState {
        const Knowledge* knowledge = nullptr;
        const Common* common = nullptr;
        std::span<const FramePointer> not_common;
    };

    explicit KnowledgeDecoder(const Format& format) : format_(format) {
        known_.emplace_back(format);
    }

    /// The knowledge that packet `number` was coded with. None, with the reason, where that is not
    /// known (any more). Nothing changes before keep(): the packet's head may be false.
    KnownState knowledge_for(PacketNumber number, const KnowledgeHead& head, const char*& why) {
        fresh_.reset();
        derived_.clear();
        derived_from_.clear();
        if (head.gap >= number) {
            why = "refers to a packet before the first";
            return {};
        }
        if (received(number)) {
            why = "was received before";
            return {};
        }
        if (head.epoch != epoch_) {
            // The encoder has started over? A packet from before it did so may come later.
            if (head.gap != 0 || number <= newest_) {
                why = "belongs to knowledge that was given up";
                return {};
            }
            const Fresh& fresh = fresh_.emplace(Fresh{head.epoch, Knowledge(format_), {}});
            return {&fresh.knowledge, &fresh.common, {}};
        }
        const Knowledge* knowledge =
            knowledge_at(head.gap == 0 ? 0 : number - head.gap, head.learned);
        if (knowledge == nullptr) {
            why = "refers to packets that are not known";
            return {};
        }
        return {knowledge, &common_, derived_from_};
    }

    void keep(FramePointer frame) {
        if (fresh_) {
            epoch_ = fresh_->epoch;
            received_.clear();
            known_.clear();
            known_.push_back(std::move(fresh_->knowledge));
            common_ = Common();
            fresh_.reset();
        }
        if (!derived_.empty()) {
            keep_derived();
        }
        newest_ = std::max(newest_, frame->number);
        received_.insert(place_of(frame->number), std::move(frame));
        if (received_.size() > kReceived) {
            received_.erase(received_.begin());
        }
    }

    [[nodiscard]] const Common& common() const { return common_; }

  private:
    /// First state of an epoch whose first packet is being decoded.
    struct Fresh {
        std::uint8_t epoch = 0;
        Knowledge knowledge;
        Common common;
    };

    static constexpr std::size_t kReceived = 128;
    /// Number of states of knowledge by which packets may overtake each other.
    static constexpr std::size_t kReordered = 16;

    /// Of the first frame received that has this number or a later one.
    [[nodiscard]] auto place_of(PacketNumber number) const {
        return std::ranges::lower_bound(received_, number, {}, &Frame::number);
    }

    [[nodiscard]] bool received(PacketNumber number) const {
        const auto at = place_of(number);
        return at != received_.end() && (*at)->number == number;
    }

    /// Brings an earlier state of knowledge up to `newest`; null where a packet that the encoder
    /// learned is missing here.
    const Knowledge* knowledge_at(PacketNumber newest, std::uint64_t learned) {
        auto from = known_.end();
        while (from != known_.begin() && std::prev(from)->learned().newest() > newest) {
            --from;
        }
        if (from == known_.begin()) {
            return nullptr;
        }
        const Knowledge& before = *std::prev(from);
        const PacketNumber since = before.learned().newest();
        if (since == newest) {
            return before.learned().before() == learned || newest == 0 ? &before : nullptr;
        }
        const auto wanted = [&](PacketNumber n) {
            return n > since && (n == newest || (n < newest && newest - n <= 64 &&
                                                 (learned >> (newest - n - 1) & 1u) != 0));
        };
        LearnedPackets would = before.learned();
        for (const FramePointer& frame : received_) {
            if (wanted(frame->number)) {
                would.add(frame->number);
            }
        }
        if (would.newest() != newest || would.before() != learned) {
            return nullptr;
        }
        const bool oldest = known_.size() == kReordered && std::prev(from) == known_.begin() &&
                            from != known_.end();
        if (oldest) {
            return nullptr;
        }
        Knowledge& derived = derived_.emplace_back(before);
        for (const FramePointer& frame : received_) {
            if (wanted(frame->number)) {
                derived.learning(frame);
                derived_from_.push_back(frame);
            }
        }
        return &derived;
    }

    void keep_derived() {
        for (const FramePointer& frame : derived_from_) {
            common_.learning(*frame);
        }
        auto at = known_.end();
        while (at != known_.begin() &&
               std::prev(at)->learned().newest() > derived_.front().learned().newest()) {
            --at;
        }
        known_.splice(at, derived_);
        derived_from_.clear();
        if (known_.size() > kReordered) {
            known_.pop_front();
            common_.forget_before(known_.front().learned().newest());
        }
    }

    Format format_;
    std::uint8_t epoch_ = 0;
    PacketNumber newest_ = 0;  // received
    std::optional<Fresh> fresh_;
    std::list<Knowledge> derived_;  // none or one: the state for the packet being decoded ...
    std::vector<FramePointer>
        derived_from_;                    // ... and its frames that no earlier state has learned
    std::vector<FramePointer> received_;  // ascending
    std::list<Knowledge> known_;          // ascending by newest learned
    Common common_;                       // of these
};

}  // namespace zoned::wire::entropy
