// Record pass: the one walk over a packet's records that encoder and decoder share.
#pragma once

#include "shared/wire/entropy/ports.h"
#include "shared/wire/field_codec.h"
#include "shared/wire/record/course_pass.h"
#include "shared/wire/record/extrapolate.h"
#include "shared/wire/record/record_codec.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace zoned::wire::record {

/// Walks over all records of `frame`: number, tick, zone and, when encoding, records are given; the
/// rest of the frame is filled in, when decoding the records as well; `bits` where it is measured.
template <class Port>
class RecordPass {
  public:
    static constexpr bool kDecodes = Port::kDecodes;

    RecordPass(const RecordFormat& format,
               const RecordKnowledge& knowledge,
               const KnownBaselines& bases,
               Port port,
               PassMemory& memory,
               bool measured,
               RecordFrame& frame)
        : format_(format),
          knowledge_(knowledge),
          bases_(bases),
          models_(knowledge.models()),
          port_(port),
          measured_(measured),
          frame_(frame),
          moving_(memory.moving),
          course_(format, knowledge, bases_, port, memory.neighbours, frame) {}

    /// Encoders only: where the declared fields of records come from.
    void take_declared(const DeclaredSource* source) { source_ = source; }

    /// The fault in declared fields, after run() has failed for them.
    [[nodiscard]] DeclaredFault fault() const { return fault_; }

    /// False when no encoder can have written the bytes read.
    bool run() {
        std::size_t next = 0;
        begin_measuring();
        bases_.moving(frame_.zone,
                      knowledge_.learned().newest(),
                      knowledge_.course().at(0).tick - kMovedLately,
                      moving_);
        for (;;) {
            CodedRecord record;
            const bool more = kDecodes || next < frame_.records.size();
            if (more && !kDecodes) {
                record = frame_.records[next];
            }
            const auto kind = static_cast<CodedKind>(
                symbol(RecordModels::kKind + static_cast<std::size_t>(before_),
                       more && !kDecodes ? kind_of(record) : kEnd));
            if (kind == kEnd) {
                return true;
            }
            if (kind >= kKinds || next == kMostRecords || !code(kind, record)) {
                return false;
            }
            if constexpr (kDecodes) {
                frame_.records.push_back(record);
            } else {
                frame_.records[next] = record;
            }
            before_ = kind;
            ++next;
        }
    }

  private:
    enum CodedKind : std::uint8_t {
        kKnown,  ///< there is a base
        kNew,    ///< nothing is known that would help
        kRemove,
        kEnd,
        kMoving,  ///< known, and one of those that moved lately
        kKinds,
    };

    [[nodiscard]] const CodedRecord* baseline_of(EntityId entity) const {
        return bases_.find(entity, frame_.zone, knowledge_.learned().newest());
    }

    [[nodiscard]] CodedKind kind_of(const CodedRecord& record) const {
        if (record.remove) {
            return kRemove;
        }
        const CodedRecord* base = baseline_of(record.entity);
        const bool known = base != nullptr && base->type == record.type &&
                           base->upright == record.upright && base->tick <= record.tick;
        if (!known) {
            return kNew;
        }
        return std::binary_search(moving_.begin(), moving_.end(), record.entity) ? kMoving : kKnown;
    }

    bool code(CodedKind kind, CodedRecord& record) {
        if (kind == kMoving ? !code_moving(record) : !code_entity(record)) {
            return false;
        }
        record.remove = kind == kRemove;
        if (record.remove) {
            measure(kRecordHeadPart);
            return true;
        }
        const bool known = kind == kKnown || kind == kMoving;
        const CodedRecord* base = known ? baseline_of(record.entity) : nullptr;
        if (known && base == nullptr) {
            return false;
        }
        const auto age = static_cast<Tick>(magnitude(
            RecordModels::kAge, 0, static_cast<std::uint32_t>(frame_.tick - record.tick)));
        if (age > kOldestTicks) {
            return false;
        }
        record.tick = frame_.tick - age;
        record.lod =
            static_cast<std::uint8_t>(symbol(RecordModels::kLod + lod_before_, record.lod));
        if (record.lod >= kLods) {
            return false;
        }
        lod_before_ = record.lod;
        if (base != nullptr) {
            record.type = base->type;
            record.upright = base->upright;
            if (record.tick < base->tick) {
                return false;
            }
        } else {
            record.upright = bit(RecordModels::kUpright, record.upright);
            record.type = static_cast<TypeIndex>(port_.raw(record.type, 16));
        }
        measure(kRecordHeadPart);
        return code_state(record, base);
    }

    /// The next of those that moved lately, but for some that do not move on.
    bool code_moving(CodedRecord& record) {
        while (next_moving_ < moving_.size()) {
            const EntityId entity = moving_[next_moving_++];
            if (entity.value <= entity_before_) {
                continue;
            }
            if (bit(RecordModels::kMovesOn + course_.pace_of(entity), entity == record.entity)) {
                record.entity = entity;
                entity_before_ = entity.value;
                return true;
            }
        }
        return false;
    }

    bool code_entity(CodedRecord& record) {
        const std::uint32_t gap = record.entity.value - entity_before_ - 1;
        const std::uint32_t coded =
            magnitude(RecordModels::kGap, 0, std::min<std::uint32_t>(gap, entropy::kMaxResidual));
        std::uint32_t whole = coded;
        if (coded == entropy::kMaxResidual) {
            whole = port_.raw(gap, 16);
            whole |= port_.raw(gap >> 16, 16) << 16;
        }
        const std::uint64_t value = std::uint64_t{entity_before_} + 1 + whole;
        if (value > 0xFFFFFFFFu) {
            return false;
        }
        entity_before_ = static_cast<std::uint32_t>(value);
        record.entity = EntityId(entity_before_);
        return true;
    }

    bool code_state(CodedRecord& record, const CodedRecord* base) {
        const FieldLayout& layout = format_.levels[record.lod].layout;
        begin_state(record, base);
        Columns columns{};
        if constexpr (!kDecodes) {
            columns = columns_of(record.state);
        }
        Columns out{};
        for (std::size_t f = 0; f < kFields.size(); ++f) {
            const Field& field = kFields[f];
            if (is_present(field.presence, static_cast<Motion>(out[0]), record.upright) &&
                !code_field(f, layout[field.range], columns, out)) {
                return false;
            }
            if (field.range == Range::kMotion) {
                course_.begin(record, base, static_cast<Motion>(out[0]));
            }
            measure(f);
        }
        if constexpr (kDecodes) {
            if (!is_consistent(out, record.upright, layout)) {
                return false;
            }
            record.state = state_of(out);
        }
        course_.end(record);
        learn_velocity(out);
        nearby_ = record;
        return code_declared_fields(record, base);
    }

    /// The declared fields that changed after the base, or that are not initial, as raw bits.
    bool code_declared_fields(CodedRecord& record, const CodedRecord* base) {
        const FieldSchema* schema = schema_of(format_.fields, record.type);
        record.declared = 0;
        if (schema == nullptr) {
            return true;
        }
        DeclaredUpdate update;
        DeclaredBits bits{};
        update.whole = base == nullptr;
        if constexpr (!kDecodes) {
            ZONED_ASSERT(source_ != nullptr, "an encoder is given the declared fields");
            const DeclaredValues values = source_->declared_of(record.entity);
            std::copy(values.words.begin(), values.words.end(), update.words.begin());
            update.mask = update.whole ? changed_from_initial(*schema, values.words)
                                       : changed_after(base->tick, values.changed);
        }
        if (!bit(RecordModels::kSameDeclared, update.mask == 0)) {
            fault_ = code_declared(
                [this](std::uint32_t value, int width) { return port_.raw(value, width); },
                *schema,
                update.mask,
                update.words,
                &bits);
            if (kDecodes && fault_ == DeclaredFault::kNone && update.whole &&
                !is_whole(*schema, update)) {
                fault_ = DeclaredFault::kForm;
            }
        }
        measure(kDeclaredPart);
        if (measured_) {
            frame_.declared_bits.push_back(bits);
            record.declared = static_cast<std::uint32_t>(frame_.declared_bits.size());
        }
        if constexpr (kDecodes) {
            frame_.declared.push_back(update);
            record.declared = static_cast<std::uint32_t>(frame_.declared.size());
        }
        return fault_ == DeclaredFault::kNone;
    }

    static FieldMask changed_after(Tick tick, std::span<const Tick> changed) {
        FieldMask mask = 0;
        for (std::size_t i = 0; i < changed.size(); ++i) {
            mask |= changed[i] > tick ? FieldMask{1} << i : 0U;
        }
        return mask;
    }

    void begin_state(const CodedRecord& record, const CodedRecord* base) {
        motion_before_ = static_cast<std::size_t>(kMotions);
        elapsed_s_ = 0.0;
        steps_ = &format_.levels[record.lod].quantization;
        if (base == nullptr) {
            expected_ = beside(nearby_, record.lod, format_);
            reach_ = kFromNothing;
            return;
        }
        const Tick ticks = record.tick - base->tick;
        expected_ = extrapolate(*base, record.tick, record.lod, format_);
        reach_ = ticks <= 2 ? 0 : ticks <= 8 ? 1 : ticks <= 32 ? 2 : 3;
        motion_before_ = static_cast<std::size_t>(expected_[0]);
        elapsed_s_ = static_cast<double>(ticks) * static_cast<double>(format_.tick_s);
    }

    bool code_field(std::size_t f, const RangeLayout& range, const Columns& columns, Columns& out) {
        const Field& field = kFields[f];
        const std::size_t c = field.first;
        if (course_.on() && is_of_course(field.range)) {
            code_on_course(field, range, columns, out);
            return !course_.failed();
        }
        switch (field.range) {
            case Range::kMotion:
                out[c] = symbol(RecordModels::kMotion + motion_before_, columns[c]);
                return out[c] < kMotions;
            case Range::kLeftOut:
                code_left_out(c, columns, out);
                return true;
            case Range::kAppearance:
                if (bit(RecordModels::kSameAppearance, columns[c] == expected_[c])) {
                    out[c] = expected_[c];
                } else {
                    out[c] = static_cast<std::int32_t>(
                        port_.raw(static_cast<std::uint32_t>(columns[c]), 16));
                }
                return true;
            default:
                break;
        }
        float off_before = -1.0F;
        for (std::size_t i = c; i < c + field.components; ++i) {
            const std::int32_t expected =
                std::clamp(expected_of(field.range, i, out), range.minimum, range.maximum);
            const std::int32_t off =
                residual(f, off_before, difference(columns[i], expected, range));
            std::int32_t value = expected + off;
            if (range.wraps) {
                value = static_cast<std::int32_t>(static_cast<std::uint32_t>(value) &
                                                  low_mask(range.full_bits));
            }
            if (value < range.minimum || value > range.maximum) {
                return false;
            }
            out[i] = value;
            off_before = static_cast<float>(std::abs(off));
        }
        return true;
    }

    static bool is_of_course(Range range) {
        return range == Range::kHorizontal || range == Range::kVertical ||
               range == Range::kLeftOut || range == Range::kSmallestThree;
    }

    void code_on_course(const Field& field,
                        const RangeLayout& range,
                        const Columns& columns,
                        Columns& out) {
        const std::size_t c = field.first;
        std::copy_n(columns.begin() + c, field.components, out.begin() + c);
        if (field.range == Range::kSmallestThree) {
            course_.code_turn(
                out[kLeftOutColumn], std::span<std::int32_t, 3>(out.begin() + c, 3), range);
        } else if (field.range != Range::kLeftOut) {  // which comes with the others
            for (std::size_t i = c; i < c + field.components; ++i) {
                out[i] = course_.code_place(i, columns[i], range);
            }
        }
    }

    void code_left_out(std::size_t c, const Columns& columns, Columns& out) {
        if (bit(RecordModels::kSameLeftOut, columns[c] == expected_[c])) {
            out[c] = expected_[c];
            return;
        }
        out[c] = static_cast<std::int32_t>(port_.raw(static_cast<std::uint32_t>(columns[c]), 2));
        // Components of another chart say nothing about these.
        const Field& three = kFields[kSmallestThree];
        std::fill_n(expected_.begin() + three.first, three.components, 0);
    }

    /// A velocity also follows the error of the position, which is known by then.
    [[nodiscard]] std::int32_t expected_of(Range range,
                                           std::size_t column,
                                           const Columns& out) const {
        if (range != Range::kVelocity || elapsed_s_ <= 0.0) {
            return expected_[column];
        }
        const std::size_t place = column - kVelocityAfterPosition;
        const double share = knowledge_.velocity_share(place == kUpColumn);
        const double more =
            share * rate_off(place, out) / static_cast<double>(steps_->velocity_step_mps);
        return expected_[column] +
               static_cast<std::int32_t>(std::floor(std::clamp(more, -kMostMore, kMostMore) + 0.5));
    }

    /// Error of the position per second of extrapolation, m/s.
    [[nodiscard]] double rate_off(std::size_t place, const Columns& out) const {
        return static_cast<double>(out[place] - expected_[place]) *
               static_cast<double>(steps_->position_step_m) / elapsed_s_;
    }

    void learn_velocity(const Columns& out) {
        const bool moves = static_cast<Motion>(out[0]) >= Motion::kLinear &&
                           motion_before_ >= static_cast<std::size_t>(Motion::kLinear);
        if (reach_ == kFromNothing || elapsed_s_ <= 0.0 || !moves) {
            return;
        }
        for (std::size_t place = 1; place <= 3; ++place) {
            const std::size_t column = place + kVelocityAfterPosition;
            const double target = static_cast<double>(out[column] - expected_[column]) *
                                  static_cast<double>(steps_->velocity_step_mps);
            frame_.velocity[place == kUpColumn ? 1 : 0].add({rate_off(place, out)}, target, 1.0);
        }
    }

    static std::int32_t difference(std::int32_t value,
                                   std::int32_t expected,
                                   const RangeLayout& range) {
        const auto d = static_cast<std::uint32_t>(value) - static_cast<std::uint32_t>(expected);
        return range.wraps ? sign_extend(d & low_mask(range.full_bits), range.full_bits)
                           : static_cast<std::int32_t>(d);
    }

    // ---------------------------------------------------------------- measuring bits

    void begin_measuring() {
        if (measured_) {
            measured_bits_ = whole_bits();
        }
    }

    /// The bits coded since the last call belong to this part of the record.
    void measure(std::size_t part) {
        if (!measured_) {
            return;
        }
        if (part == kRecordHeadPart) {
            frame_.bits.push_back({});
        }
        const std::uint64_t bits = whole_bits();
        frame_.bits.back()[part] = static_cast<std::uint16_t>(bits - measured_bits_);
        measured_bits_ = bits;
    }

    [[nodiscard]] std::uint64_t whole_bits() const {
        return static_cast<std::uint64_t>(port_.coder.bits() + 0.5);
    }

    // ---------------------------------------------------------------- decisions

    bool bit(std::size_t which, bool value) {
        const bool result = port_.bit(models_.bits[which], value);
        note(RecordModels::kFirstBit + which, 0, result ? 1 : 0);
        return result;
    }

    int symbol(std::size_t which, int value) {
        const int result = port_.symbol(models_.symbols[which], value);
        note(RecordModels::kFirstSymbol + which, 0, result);
        return result;
    }

    std::uint32_t magnitude(std::size_t what, std::size_t reach, std::uint32_t value) {
        const int scale = entropy::scale_class(models_.expected[what][reach]);
        const int symbol =
            port_.symbol(models_.residuals[what].of(scale), entropy::magnitude_of(value).symbol);
        note(what * entropy::kScaleClasses + static_cast<std::size_t>(scale), reach, symbol);
        return port_.magnitude(value, symbol);
    }

    /// `off_before`: magnitude of the component before, negative: this is the first.
    std::int32_t residual(std::size_t f, float off_before, std::int32_t value) {
        const float mean = models_.expected[f][reach_];
        const int scale =
            entropy::scale_class(off_before < 0.0F ? mean : 0.6F * mean + 0.4F * off_before);
        int symbol = 0;
        const std::int32_t result =
            entropy::code_residual(port_, models_.residuals[f].of(scale), value, symbol);
        note(f * entropy::kScaleClasses + static_cast<std::size_t>(scale), reach_, symbol);
        return result;
    }

    void note(std::size_t model, std::size_t reach, int symbol) {
        frame_.model_updates.push_back({static_cast<std::uint16_t>(model),
                                        static_cast<std::uint8_t>(reach),
                                        static_cast<std::uint8_t>(symbol)});
    }

    // Columns of the field table: position x, z, y are 1, 2, 3, velocities follow in the same
    // order.
    static constexpr std::size_t kUpColumn = 3;
    static constexpr std::size_t kVelocityAfterPosition = 3;
    static constexpr std::size_t kSmallestThree = 13;
    static constexpr std::size_t kLeftOutColumn = 13;
    static constexpr Tick kMovedLately = 12;
    static constexpr double kMostMore = 1 << 22;  // steps

    const RecordFormat& format_;
    const RecordKnowledge& knowledge_;
    KnownBaselines bases_;
    const RecordModels& models_;
    Port port_;
    bool measured_;
    std::uint64_t measured_bits_ = 0;
    RecordFrame& frame_;
    std::vector<EntityId>& moving_;  // lately
    std::size_t next_moving_ = 0;    // the first that was not asked for
    CoursePass<Port> course_;
    const DeclaredSource* source_ = nullptr;
    DeclaredFault fault_ = DeclaredFault::kNone;
    CodedKind before_ = kKnown;
    std::uint32_t entity_before_ = 0;
    std::size_t lod_before_ = 0;
    CodedRecord nearby_;  // the last record coded: new entities are likely to be near it
    // Of the state being coded.
    Columns expected_{};
    const Quantization* steps_ = nullptr;
    std::size_t reach_ = kFromNothing;
    std::size_t motion_before_ = 0;
    double elapsed_s_ = 0.0;
};

}  // namespace zoned::wire::record
