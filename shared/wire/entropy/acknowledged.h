// Acknowledged knowledge: encoder and decoder learning the same packets in the same order, from
// acknowledgements alone, whatever the network does.
#pragma once

#include "shared/core/assert.h"
#include "shared/wire/entropy/range_coder.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace zoned::wire::entropy {

/// Numbers of packets count from 1; 0 is none.
using PacketNumber = std::uint32_t;

/// Which packets were learned: the newest and those of the 64 before it.
class LearnedPackets {
  public:
    /// Numbers ascend.
    void add(PacketNumber number);

    [[nodiscard]] PacketNumber newest() const { return newest_; }

    /// Bit i: newest() - 1 - i was learned.
    [[nodiscard]] std::uint64_t before() const { return before_; }

  private:
    PacketNumber newest_ = 0;
    std::uint64_t before_ = 0;
};

/// What a packet says of the knowledge that it was coded with.
struct KnowledgeHead {
    static constexpr int kGapBits = 8;
    static constexpr PacketNumber kLongestGap = (1u << kGapBits) - 1;
    static constexpr int kEpochBits = 2;

    std::uint8_t epoch = 0;     ///< counts how often the encoder began anew
    PacketNumber gap = 0;       ///< back to the newest packet learned; 0: none
    std::uint64_t learned = 0;  ///< LearnedPackets::before()
};

/// 10 bits and, where most of the packets before were learned, or none, a few more.
void write_head(RangeEncoder& coder, const KnowledgeHead& head);
KnowledgeHead read_head(RangeDecoder& coder);

/// For a Knowledge whose states share nothing.
struct NothingInCommon {
    template <class Frame>
    void learning(const Frame& /*frame*/) {}

    void forget_before(PacketNumber /*oldest*/) {}
};

/// A Knowledge is a state of knowledge. It has the types Frame (what a packet told and taught, with
/// its `number`), Format and Common, is made from a Format, copied, and has
/// learning(shared_ptr<const Frame>) and learned(). Whoever has learned the same frames in the same
/// order knows the same, bit for bit. States of knowledge that differ by some packets may keep what
/// they share in one Common: it is default-made, copied, and has learning(const Frame&) and
/// forget_before(n): no state before that whose newest packet is n will be asked for any more.
///
/// The encoder's side. Packets are learned in ascending order when they are acknowledged; one whose
/// turn has passed is never learned.
template <class Knowledge>
class KnowledgeEncoder {
  public:
    using Frame = typename Knowledge::Frame;
    using Format = typename Knowledge::Format;
    using Common = typename Knowledge::Common;

    /// Packets under way that can still be acknowledged.
    static constexpr std::size_t kUnderWay = 64;

    /// `epoch`: another one than that of an encoder whose packets the receiver may have had before.
    explicit KnowledgeEncoder(const Format& format, std::uint8_t epoch = 0)
        : format_(format),
          knowledge_(format),
          epoch_(static_cast<std::uint8_t>(epoch % (1 << KnowledgeHead::kEpochBits))) {}

    /// Learns what was acknowledged, and says what packet `number` is coded with: knowledge().
    KnowledgeHead begin(PacketNumber number) {
        ZONED_ASSERT(sent_.empty() || number > sent_.back().frame->number, "numbers ascend");
        learn_acknowledged();
        if (newest() != 0 && number - newest() > KnowledgeHead::kLongestGap) {
            start_over();
        }
        return {epoch_, newest() == 0 ? 0 : number - newest(), knowledge_.learned().before()};
    }

    [[nodiscard]] const Knowledge& knowledge() const { return knowledge_; }

    [[nodiscard]] const Common& common() const { return common_; }

    /// What the packet that began told.
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

    /// Forgets everything: the receiver does not know what was acknowledged.
    void start_over() {
        knowledge_ = Knowledge(format_);
        common_ = Common();
        epoch_ = static_cast<std::uint8_t>((epoch_ + 1) % (1 << KnowledgeHead::kEpochBits));
        sent_.clear();
    }

    /// The receiver knows this otherwise; before the first begin().
    void share(std::shared_ptr<const Frame> frame) {
        common_.learning(*frame);
        knowledge_.learning(std::move(frame));
    }

  private:
    struct SentFrame {
        std::shared_ptr<const Frame> frame;
        PacketNumber reference = 0;  // newest that the receiver knew when it decoded this one
        std::uint8_t epoch = 0;
        bool acknowledged = false;
    };

    [[nodiscard]] PacketNumber newest() const { return knowledge_.learned().newest(); }

    /// The receiver may have missed every packet since it decoded the newest acknowledged one, so
    /// what was learned since that one's reference must be within reach of a packet's head.
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
            if (number - sent.reference > 64 && sent.reference != newest()) {
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
    std::vector<SentFrame> sent_;  // ascending
};

/// The decoder's side. Use: knowledge_for() a packet's head, decode, keep() what came of it; a
/// packet that was not kept must not be acknowledged.
template <class Knowledge>
class KnowledgeDecoder {
  public:
    using Frame = typename Knowledge::Frame;
    using Format = typename Knowledge::Format;
    using Common = typename Knowledge::Common;
    using FramePointer = std::shared_ptr<const Frame>;

    /// A state, with what it has in common with others and the frames that it has learned,
    /// ascending, and that these have not; null: none. Valid until the next call.
    struct KnownState {
        const Knowledge* knowledge = nullptr;
        const Common* common = nullptr;
        std::span<const FramePointer> not_common;
    };

    explicit KnowledgeDecoder(const Format& format) : format_(format), known_{Knowledge(format)} {}

    /// What packet `number` was coded with; none, and why, where that is not known (any more).
    /// Nothing is changed before keep(): what the packet says of it need not be true.
    KnownState knowledge_for(PacketNumber number, const KnowledgeHead& head, const char*& why) {
        fresh_.reset();
        derived_.reset();
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
            known_.assign(1, std::move(fresh_->knowledge));
            common_ = Common();
            fresh_.reset();
        }
        if (derived_) {
            keep_derived();
        }
        newest_ = std::max(newest_, frame->number);
        const auto at = std::upper_bound(
            received_.begin(),
            received_.end(),
            frame->number,
            [](PacketNumber n, const FramePointer& other) { return n < other->number; });
        received_.insert(at, std::move(frame));
        if (received_.size() > kReceived) {
            received_.pop_front();
        }
    }

    /// What the newest packet learned was coded after.
    [[nodiscard]] const Knowledge& newest() const { return known_.back(); }

    /// See KnowledgeEncoder::share().
    void share(FramePointer frame) {
        newest_ = frame->number;
        common_.learning(*frame);
        known_.back().learning(std::move(frame));
    }

    [[nodiscard]] const Common& common() const { return common_; }

  private:
    /// What an epoch begins with whose first packet is being decoded.
    struct Fresh {
        std::uint8_t epoch = 0;
        Knowledge knowledge;
        Common common;
    };

    static constexpr std::size_t kReceived = 128;
    /// Packets may overtake each other by so many states of knowledge.
    static constexpr std::size_t kReordered = 16;

    [[nodiscard]] bool received(PacketNumber number) const {
        return std::any_of(received_.begin(), received_.end(), [number](const FramePointer& f) {
            return f->number == number;
        });
    }

    /// Brings what was known when an earlier packet was newest up to `newest`; null where something
    /// that the encoder learned is missing here.
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
        derived_ = before;
        for (const FramePointer& frame : received_) {
            if (wanted(frame->number)) {
                derived_->learning(frame);
                derived_from_.push_back(frame);
            }
        }
        return &*derived_;
    }

    void keep_derived() {
        for (const FramePointer& frame : derived_from_) {
            common_.learning(*frame);
        }
        auto at = known_.end();
        while (at != known_.begin() &&
               std::prev(at)->learned().newest() > derived_->learned().newest()) {
            --at;
        }
        known_.insert(at, std::move(*derived_));
        derived_.reset();
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
    std::optional<Knowledge> derived_;        // what the packet being decoded was coded with ...
    std::vector<FramePointer> derived_from_;  // ... and these, which no state before it has learned
    std::deque<FramePointer> received_;       // ascending
    std::deque<Knowledge> known_;             // ascending by newest learned
    Common common_;                           // of these
};

}  // namespace zoned::wire::entropy
