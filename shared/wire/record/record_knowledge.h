// Record knowledge: the publications that both sides provably share, and the probabilities learned
// from coding them.
#pragma once

#include "shared/wire/entropy/residual_model.h"
#include "shared/wire/record/coded_record.h"

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace zoned::wire::record {

/// The publications in learned packets, by entity. States of knowledge that differ by some packets
/// share them, so each stays until no state can ask for it any more.
class RecordBaselines {
  public:
    /// Newest publication in packets learned up to `newest`; null where the entity is unknown in
    /// that zone.
    [[nodiscard]] const CodedRecord* find(EntityId entity,
                                          ZoneId zone,
                                          entropy::PacketNumber newest) const;

    void learning(const RecordFrame& frame);

    /// Earlier values of `newest` will not be used any more.
    void forget_before(entropy::PacketNumber oldest);

    /// Publications that are kept.
    [[nodiscard]] std::size_t size() const { return versions_.size() - free_.size(); }

    /// As they lie: the next slot that is free follows from earlier packets.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(entries_, versions_, free_, superseding_);
        if constexpr (Archive::kReads) {
            if (!is_sound()) {
                archive.fail("bases name others that there are not");
            }
        }
    }

  private:
    using Slot = std::uint32_t;
    static constexpr Slot kNone = 0xFFFFFFFF;

    struct BaselineVersion {
        entropy::PacketNumber number = 0;
        ZoneId zone;
        Slot older = kNone;  // of the same entity
        CodedRecord record;
    };

    struct BaselineEntry {
        EntityId entity;
        Slot newest = kNone;
    };

    /// A publication that makes older ones, or itself, forgettable.
    struct Superseding {
        entropy::PacketNumber number = 0;
        EntityId entity;
    };

    /// Whether all slots are there, and each leads to older ones only.
    [[nodiscard]] bool is_sound() const;
    [[nodiscard]] std::vector<BaselineEntry>::const_iterator lower_bound(EntityId entity) const;
    [[nodiscard]] Slot version_at(Slot newest_of_entity, entropy::PacketNumber newest) const;
    Slot keep(const RecordFrame& frame, const CodedRecord& record, Slot older);
    void drop(Slot& first);
    void forget(EntityId entity, entropy::PacketNumber oldest);

    std::vector<BaselineEntry> entries_;  // ascending by entity
    std::vector<BaselineVersion> versions_;
    std::vector<Slot> free_;  // in versions_
    std::vector<Superseding> superseding_;
};

/// The bases of one state of knowledge: the shared ones, and packets that only this state has
/// learned.
struct KnownBaselines {
    const RecordBaselines& common;
    std::span<const std::shared_ptr<const RecordFrame>> frames;  ///< ascending

    [[nodiscard]] const CodedRecord* find(EntityId entity,
                                          ZoneId zone,
                                          entropy::PacketNumber newest) const;
};

/// Models by what they are for. Those of residuals come first: one per field of the field table and
/// class of expectation.
struct RecordModels {
    enum Symbols : std::uint8_t {
        kKind,        // one per kind of the record before
        kLod = 4,     // one per level before
        kMotion = 8,  // one per motion before, and one for those without
        kSymbols = 15
    };

    enum Bits : std::uint8_t {
        kUpright,
        kSameAppearance,
        kSameLeftOut,
        kSameDeclared,
        kBits
    };

    /// Behind the fields: gaps between entities, and ages of publications.
    static constexpr std::size_t kGap = kFields.size();
    static constexpr std::size_t kAge = kGap + 1;
    static constexpr std::size_t kMagnitudes = kAge + 1;
    static constexpr std::size_t kFirstSymbol = kMagnitudes * entropy::kScaleClasses;
    static constexpr std::size_t kFirstBit = kFirstSymbol + kSymbols;

    std::array<entropy::ResidualModel, kMagnitudes> residuals;
    std::array<entropy::SymbolModel, kSymbols> symbols;
    std::array<entropy::BitModel, kBits> bits;
    /// Mean magnitude of late residuals.
    std::array<std::array<float, kReaches>, kMagnitudes> expected;

    RecordModels();
    void learning(const std::vector<RecordModelUpdate>& model_updates);

    template <class Archive>
    void serialize(Archive& archive) {
        archive(residuals, symbols, bits, expected);
    }
};

/// Whether a frame that was read names levels, motions, models and symbols that there are.
[[nodiscard]] bool is_sound(const RecordFrame& frame);

template <class Archive>
void serialize(Archive& archive, RecordFrame& frame) {
    archive(frame.number, frame.tick, frame.zone, frame.records, frame.model_updates);
    archive(frame.velocity, frame.bits);
    if constexpr (Archive::kReads) {
        if (!is_sound(frame)) {
            archive.fail("a packet under way holds what no packet holds");
        }
    }
}

class RecordKnowledge {
  public:
    using Frame = RecordFrame;
    using Format = RecordFormat;
    using Common = RecordBaselines;

    explicit RecordKnowledge(const RecordFormat& format);

    void learning(const std::shared_ptr<const RecordFrame>& frame);

    [[nodiscard]] const entropy::LearnedPackets& learned() const { return learned_; }

    [[nodiscard]] const RecordModels& models() const { return models_; }

    /// Share of a position error, per second of extrapolation, that is an error of velocity.
    [[nodiscard]] double velocity_share(bool upwards) const {
        return velocity_[upwards ? 1 : 0].weights()[0];
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(models_, velocity_, learned_);
    }

  private:
    RecordModels models_;
    std::array<entropy::LeastSquares<1>, 2> velocity_;
    entropy::LearnedPackets learned_;
};

}  // namespace zoned::wire::record
