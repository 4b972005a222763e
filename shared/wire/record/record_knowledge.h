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

/// Whether a publication carries no velocity and is not at rest.
[[nodiscard]] inline bool moves(const CodedRecord& record) {
    return !record.remove && !record.state.at_rest &&
           record.state.order == motion::PredictorOrder::kStatic;
}

/// The publications in learned packets, by entity. States of knowledge that differ by some packets
/// share them, so each stays until no state can ask for it any more.
class RecordBaselines {
  public:
    /// Newest publication in packets learned up to `newest`; null where the entity is unknown in
    /// that zone.
    [[nodiscard]] const CodedRecord* find(EntityId entity,
                                          ZoneId zone,
                                          entropy::PacketNumber newest) const;

    /// Appends the entities whose newest publication up to packet `newest` is of `since` or later
    /// and moves(); ascending.
    void moving(ZoneId zone,
                entropy::PacketNumber newest,
                Tick since,
                std::vector<EntityId>& out) const;

    void learning(const RecordFrame& frame);

    /// Earlier values of `newest` will not be used any more.
    void forget_before(entropy::PacketNumber oldest);

    /// Publications that are kept.
    [[nodiscard]] std::size_t size() const { return versions_.size() - free_.size(); }

    /// As they lie: the next slot that is free follows from earlier packets.
    template <class Archive>
    void serialize(Archive& archive) {
        archive(entries_, versions_, free_, superseding_, ticks_, moved_tick_);
        if constexpr (Archive::kReads) {
            if (!is_sound()) {
                archive.fail("bases name others that there are not");
            }
        }
    }

    /// The publications of one entity, from the newest on.
    class Cursor;

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
    void forget_ticks(entropy::PacketNumber oldest);

    std::vector<BaselineEntry> entries_;  // ascending by entity
    std::vector<BaselineVersion> versions_;
    std::vector<Slot> free_;  // in versions_
    std::vector<Superseding> superseding_;
    std::vector<CoursePacket> ticks_;  // the last packet of each tick, ascending
    Tick moved_tick_ = -1;             // newest of a publication that moves()
};

class RecordBaselines::Cursor {
  public:
    /// At the newest.
    Cursor(const RecordBaselines& bases, EntityId entity);

    [[nodiscard]] bool at_end() const { return slot_ == kNone; }

    [[nodiscard]] entropy::PacketNumber number() const { return bases_.versions_[slot_].number; }

    [[nodiscard]] ZoneId zone() const { return bases_.versions_[slot_].zone; }

    [[nodiscard]] const CodedRecord& record() const { return bases_.versions_[slot_].record; }

    void older() { slot_ = bases_.versions_[slot_].older; }

  private:
    const RecordBaselines& bases_;
    Slot slot_;
};

/// The bases of one state of knowledge: the shared ones, and packets that only this state has
/// learned.
struct KnownBaselines {
    const RecordBaselines& common;
    std::span<const std::shared_ptr<const RecordFrame>> frames;  ///< ascending

    [[nodiscard]] const CodedRecord* find(EntityId entity,
                                          ZoneId zone,
                                          entropy::PacketNumber newest) const;

    /// As RecordBaselines::moving(), in place of what is in `out`.
    void moving(ZoneId zone,
                entropy::PacketNumber newest,
                Tick since,
                std::vector<EntityId>& out) const;

    /// For each of `upto`, descending, the publication of a known entity that was the newest up to
    /// that packet. Nothing is looked at from before a publication that does not move or is plain,
    /// nor from before a removal or another zone: the oldest that may be looked at stands for it.
    void find_course(EntityId entity,
                     ZoneId zone,
                     std::span<const entropy::PacketNumber> upto,
                     std::span<const CodedRecord*> out) const;
};

/// Models by what they are for. Those of residuals come first: one per field of the field table and
/// class of expectation.
struct RecordModels {
    enum Symbols : std::uint8_t {
        kKind,        // one per kind of the record before
        kLod = 5,     // one per level before
        kMotion = 9,  // one per motion before, and one for those without
        kSymbols = 16
    };

    static constexpr std::size_t kLeads = 8;
    static constexpr std::size_t kPaces = 64;

    enum Bits : std::uint8_t {
        kUpright,
        kSameAppearance,
        kSameLeftOut,
        kSameDeclared,
        kSameLeftOutOnCourse,  // one per lead of the greatest component over the others
        kMovesOn = kSameLeftOutOnCourse + kLeads,  // one per pace: how the entity moved of late
        kPlain = kMovesOn + kPaces,                // after small errors, after large ones
        kBits = kPlain + 2
    };

    /// Behind the fields: gaps between entities, ages of publications, and on courses places along
    /// the ground, heights and orientations.
    static constexpr std::size_t kGap = kFields.size();
    static constexpr std::size_t kAge = kGap + 1;
    static constexpr std::size_t kCourseAlong = kAge + 1;
    static constexpr std::size_t kCourseUp = kCourseAlong + 1;
    static constexpr std::size_t kCourseTurn = kCourseUp + 1;
    static constexpr std::size_t kMagnitudes = kCourseTurn + 1;
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
    archive(frame.velocity, frame.course, frame.bits);
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

    [[nodiscard]] const CourseKnowledge& course() const { return course_; }

    /// Share of a position error, per second of extrapolation, that is an error of velocity.
    [[nodiscard]] double velocity_share(bool upwards) const {
        return velocity_[upwards ? 1 : 0].weights()[0];
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(models_, velocity_, course_, learned_);
    }

  private:
    RecordModels models_;
    std::array<entropy::LeastSquares<1>, 2> velocity_;
    CourseKnowledge course_;
    entropy::LearnedPackets learned_;
};

}  // namespace zoned::wire::record
