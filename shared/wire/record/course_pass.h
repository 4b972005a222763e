// Course pass: the part of a record pass that codes where entities are whose records carry no
// velocity, from where they were in earlier packets and from the motion of those beside them.
#pragma once

#include "shared/wire/entropy/ports.h"
#include "shared/wire/record/neighbours.h"
#include "shared/wire/record/record_knowledge.h"
#include "shared/wire/record/rotation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace zoned::wire::record {

/// Use: begin() a record; where it is on(), code_place() of each axis and, of tumbling entities,
/// code_turn(); end() any record.
template <class Port>
class CoursePass {
  public:
    CoursePass(const RecordFormat& format,
               const RecordKnowledge& knowledge,
               const KnownBaselines& bases,
               Port port,
               Neighbours& neighbours,
               RecordFrame& frame)
        : format_(format),
          course_(knowledge.course()),
          models_(knowledge.models()),
          bases_(bases),
          port_(port),
          neighbours_(neighbours),
          frame_(frame) {
        neighbours_.clear();
        for (std::size_t look = 0; look < kLooks; ++look) {
            packets_[look] = course_.at(look);
        }
    }

    /// Whether the record that began is predicted by the entity's course.
    [[nodiscard]] bool on() const { return on_; }

    /// Whether a value beyond its range was read.
    [[nodiscard]] bool failed() const { return failed_; }

    /// How an entity that moved lately has moved, a context of whether it moves on.
    [[nodiscard]] std::size_t pace_of(EntityId entity) {
        look_up(entity);
        std::uint32_t steps = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            steps += static_cast<std::uint32_t>(
                std::abs(seen_[0]->state.position[axis] - seen_.back()->state.position[axis]));
        }
        const std::size_t changed = (seen_[1] == seen_[0] ? 0U : 1U) +
                                    (seen_[3] == seen_[0] ? 0U : 2U) +
                                    (seen_[4] == seen_[0] ? 0U : 4U);
        return changed +
               8 * std::min<std::size_t>(7, static_cast<std::size_t>(std::bit_width(steps)));
    }

    void begin(const CodedRecord& record, const CodedRecord* base, Motion motion) {
        on_ = base != nullptr && base->state.order == motion::PredictorOrder::kStatic &&
              (motion == Motion::kStatic || (motion == Motion::kAtRest && moves(*base)));
        if (!on_) {
            return;
        }
        look_back(record);
        residual_ = MotionResidual{};
        error_ = {};
        alone_ = neighbours_.empty();
        near_ = alone_ ? MotionResidual{} : neighbours_.near(here());
        in_record_ = 0.0F;
        expect_errors();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            expect_move(axis);
        }
        const std::size_t model = RecordModels::kPlain + (own_mean_ < kLargeError ? 0U : 1U);
        plain_ = port_.bit(models_.bits[model], !Port::kDecodes && is_surprise(record.state));
        note(RecordModels::kFirstBit + model, plain_ ? 1 : 0);
    }

    /// Columns 1, 2, 3 of the field table, in this order: x, z, y. A value within the range.
    std::int32_t code_place(std::size_t column, std::int32_t value, const RangeLayout& range) {
        const std::size_t axis = column == 1 ? 0 : column == 2 ? 2 : 1;
        const bool upwards = axis == 1;
        if (plain_) {
            value = raw(value, range);
            error_[axis] = static_cast<float>(std::abs(value - place(0, axis) - moves_[axis]));
            return value;
        }
        float scale = alone_ ? 0.85F * own_[axis] + 0.15F * own_mean_
                             : 0.35F * own_[axis] + 0.15F * own_mean_ +
                                   (0.3F * near_.error[axis] + 0.2F * near_mean_) * from_finest_;
        if (column > 1) {
            scale = 0.8F * scale + 0.2F * in_record_ / static_cast<float>(column - 1);
        }
        const std::int32_t predicted = rounded(place(0, axis) + moves_[axis], range);
        const std::int32_t off =
            residual(upwards ? RecordModels::kCourseUp : RecordModels::kCourseAlong,
                     scale,
                     value - predicted);
        value = within(predicted + off, range);
        const double real = value - place(0, axis);
        residual_.moved[axis] = static_cast<float>(real - continued_[axis]) / from_finest_;
        error_[axis] = static_cast<float>(std::abs(real - moves_[axis]));
        residual_.error[axis] = error_[axis] / from_finest_;
        in_record_ += error_[axis];
        if (teaches()) {
            sums().moves[upwards ? 1 : 0][calm_].add(features_[axis], real, weight_of(scale));
        }
        return value;
    }

    /// `left_out` and `three`: the value, then what was coded. Tumbling entities only.
    void code_turn(std::int32_t& left_out,
                   std::span<std::int32_t, 3> three,
                   const RangeLayout& range) {
        if (plain_) {
            left_out =
                static_cast<std::int32_t>(port_.raw(static_cast<std::uint32_t>(left_out), 2));
            for (std::int32_t& component : three) {
                component = raw(component, range);
            }
            return;
        }
        const Turn turn_1 = turn_between(rotations_[1], rotations_[0]);
        const Turn turn_3 = turn_between(rotations_[3], rotations_[0]);
        std::array<std::array<double, kTurnFeatures>, 3> features;
        std::array<double, 3> continued;
        Turn turn;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            continued[axis] = kNewestTurn * lag_1_ * static_cast<double>(turn_1[axis]) +
                              kOlderTurn * lag_to_3_ * static_cast<double>(turn_3[axis]);
            features[axis] = {
                lag_1_ * static_cast<double>(turn_1[axis]),
                lag_to_3_ * static_cast<double>(turn_3[axis]),
                alone_ ? 0.0 : static_cast<double>(near_.turn[axis]) - continued[axis]};
            turn[axis] = static_cast<float>(
                within(course_.turn(calm_turn_).predict(features[axis]), kLongestTurn, 0.0));
        }
        const Rotation predicted = turned(rotations_[0], turn);
        code_left_out(predicted, left_out);
        const std::array<std::int32_t, 3> expected =
            smallest_three(predicted, left_out, range.maximum);
        const float base =
            steps_per_rad_ * (alone_ ? own_turn_ : 0.5F * own_turn_ + 0.5F * near_.turn_error);
        float in_record = 0.0F;
        for (std::size_t i = 0; i < 3; ++i) {
            const float scale =
                i == 0 ? base : 0.8F * base + 0.2F * in_record / static_cast<float>(i);
            const std::int32_t off =
                residual(RecordModels::kCourseTurn, scale, three[i] - expected[i]);
            three[i] = within(expected[i] + off, range);
            in_record += static_cast<float>(std::abs(off));
        }
        note_turn(features, continued, turn, left_out, three, weight_of(base));
    }

    /// Notes the errors of the prediction in the record, by which the next one is expected.
    void end(CodedRecord& record) {
        record.error = {};
        record.turn_error = 0.0F;
        record.plain = on_ && plain_;
        if (!on_) {
            return;
        }
        if (!plain_) {
            neighbours_.note(here(), residual_);
        }
        for (std::size_t axis = 0; axis < 3; ++axis) {
            record.error[axis] = error_[axis] * per_tick_;
        }
        record.turn_error = residual_.turn_error * per_tick_;
        on_ = false;
    }

  private:
    static constexpr std::size_t kLooks = CourseKnowledge::kLooks.size();
    // Shares of the velocity at two lags for an entity that moves on as before. The least squares
    // learn better shares; motion residuals are relative to these, which never change.
    static constexpr double kNewest = 0.8;
    static constexpr double kOlder = 0.2;
    static constexpr double kNewestTurn = 0.3;
    static constexpr double kOlderTurn = 0.7;
    static constexpr double kFarthest = 1 << 23;  // steps
    static constexpr double kLongestTurn = 4.0;   // rad
    static constexpr int kSmallBits = 2;          // what a residual takes beside its own bits
    static constexpr int kEscapeBits = 5;         // one beyond the symbols
    static constexpr float kLargeError = entropy::kEscapeFrom;

    void expect_move(std::size_t axis) {
        std::array<double, kMoveFeatures>& features = features_[axis];
        features = {lag_1_ * (place(0, axis) - place(1, axis)),
                    lag_2_ * (place(1, axis) - place(2, axis)),
                    static_cast<double>(near_.moved[axis] * from_finest_),
                    static_cast<double>(near_.carried[axis] * from_finest_)};
        continued_[axis] = kNewest * features[0] + kOlder * features[1];
        moves_[axis] =
            within(course_.move(axis == 1, calm_).predict(features), kFarthest, continued_[axis]);
    }

    /// Whether the residuals of the place take more bits than the place.
    [[nodiscard]] bool is_surprise(const QuantizedState& state) const {
        const FieldLayout& layout = format_.levels[lod_].layout;
        int more = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const RangeLayout& range = layout[axis == 1 ? Range::kVertical : Range::kHorizontal];
            const std::int32_t off =
                state.position[axis] - rounded(place(0, axis) + moves_[axis], range);
            const auto size = static_cast<std::uint32_t>(std::abs(off));
            more += static_cast<int>(std::bit_width(size)) +
                    (size < entropy::kEscapeFrom ? kSmallBits : kEscapeBits) - range.full_bits;
        }
        return more > 0;
    }

    std::int32_t raw(std::int32_t value, const RangeLayout& range) {
        // In two parts, since few raw bits are coded at a time.
        const int low_bits = std::min(range.full_bits, 12);
        const auto from = static_cast<std::uint32_t>(value - range.minimum);
        std::uint32_t read = port_.raw(from & ((1U << low_bits) - 1), low_bits);
        read |= port_.raw(from >> low_bits, range.full_bits - low_bits) << low_bits;
        const auto span = static_cast<std::uint32_t>(range.maximum - range.minimum);
        failed_ = failed_ || read > span;
        return range.minimum + static_cast<std::int32_t>(std::min(read, span));
    }

    std::int32_t within(std::int32_t value, const RangeLayout& range) {
        const std::int32_t inside = std::clamp(value, range.minimum, range.maximum);
        failed_ = failed_ || inside != value;
        return inside;
    }

    /// An entity that turned otherwise then was where it was a look later.
    void look_up(EntityId entity) {
        std::array<entropy::PacketNumber, kLooks> numbers;
        for (std::size_t look = 0; look < kLooks; ++look) {
            numbers[look] = packets_[look].number;
        }
        bases_.find_course(entity, frame_.zone, numbers, seen_);
        for (std::size_t look = 1; look < kLooks; ++look) {
            if (seen_[look]->upright != seen_[0]->upright) {
                seen_[look] = seen_[look - 1];
            }
        }
    }

    /// Where the entity was in earlier packets, in steps of the record's level.
    void look_back(const CodedRecord& record) {
        lod_ = record.lod;
        entity_ = record.entity;
        look_up(record.entity);
        const Quantization& to = format_.levels[lod_].quantization;
        for (std::size_t look = 0; look < kLooks; ++look) {
            const LevelFormat& from = format_.levels[seen_[look]->lod];
            scale_[look] =
                static_cast<double>(from.quantization.position_step_m / to.position_step_m);
            if (!seen_[look]->upright) {
                rotations_[look] = rotation_of(seen_[look]->state, from.limits.orientation);
            }
        }
        from_finest_ = format_.levels[0].quantization.position_step_m / to.position_step_m;
        steps_per_rad_ = 0.5F * std::numbers::sqrt2_v<float> *
                         static_cast<float>(format_.levels[lod_].limits.orientation);
        const auto ticks = [&](std::size_t newer, std::size_t older) {
            return static_cast<double>(packets_[newer].tick - packets_[older].tick);
        };
        gap_ = std::max(0.0, static_cast<double>(record.tick - packets_[0].tick));
        lag_1_ = gap_ * inverse(ticks(0, 1));
        lag_2_ = gap_ * inverse(ticks(1, 2));
        lag_to_3_ = gap_ * inverse(ticks(0, 3));
        per_tick_ = static_cast<float>(inverse(gap_));
    }

    /// The errors of this entity's late predictions.
    void expect_errors() {
        own_ = {};
        own_turn_ = 0.0F;
        for (std::size_t look = 0; look < 3; ++look) {
            if (seen_[look] != seen_[look + 1]) {
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    own_[axis] += seen_[look]->error[axis] * static_cast<float>(scale_[look]);
                }
                own_turn_ += seen_[look]->turn_error;
            }
        }
        const auto share = static_cast<float>(gap_ / 3.0);
        for (float& own : own_) {
            own *= share;
        }
        own_turn_ *= share;
        own_mean_ = (own_[0] + own_[1] + own_[2]) / 3.0F;
        near_mean_ = (near_.error[0] + near_.error[1] + near_.error[2]) / 3.0F;
        calm_ = calm_class(own_mean_);
        calm_turn_ = calm_class(own_turn_ * steps_per_rad_);
    }

    [[nodiscard]] double place(std::size_t look, std::size_t axis) const {
        return scale_[look] * seen_[look]->state.position[axis];
    }

    /// Where the entity was, in steps of the finest level.
    [[nodiscard]] std::array<std::int32_t, 3> here() const {
        std::array<std::int32_t, 3> at;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            at[axis] =
                static_cast<std::int32_t>(place(0, axis) / static_cast<double>(from_finest_));
        }
        return at;
    }

    void code_left_out(const Rotation& predicted, std::int32_t& left_out) {
        const int greatest = greatest_component(predicted);
        const auto lead =
            std::min<std::size_t>(RecordModels::kLeads - 1,
                                  static_cast<std::size_t>(30.0F * lead_of(predicted, greatest)));
        const std::size_t model = RecordModels::kSameLeftOutOnCourse + lead;
        const bool same = port_.bit(models_.bits[model], left_out == greatest);
        note(RecordModels::kFirstBit + model, same ? 1 : 0);
        left_out =
            same ? greatest
                 : static_cast<std::int32_t>(port_.raw(static_cast<std::uint32_t>(left_out), 2));
    }

    void note_turn(const std::array<std::array<double, kTurnFeatures>, 3>& features,
                   const std::array<double, 3>& continued,
                   const Turn& turn,
                   std::int32_t left_out,
                   std::span<const std::int32_t, 3> three,
                   double weight) {
        QuantizedState state;
        state.orientation_largest = left_out;
        std::copy(three.begin(), three.end(), state.orientation.begin());
        const Turn real = turn_between(rotations_[0],
                                       rotation_of(state, format_.levels[lod_].limits.orientation));
        residual_.turn = real;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            residual_.turned[axis] =
                static_cast<float>(static_cast<double>(real[axis]) - continued[axis]);
            residual_.turn_error += std::abs(real[axis] - turn[axis]) / 3.0F;
            if (teaches()) {
                sums().turns[calm_turn_].add(
                    features[axis], static_cast<double>(real[axis]), weight);
            }
        }
    }

    /// One entity in two is enough to learn from; the other half's turn comes next.
    [[nodiscard]] bool teaches() const {
        return (entity_.value + static_cast<std::uint32_t>(frame_.tick)) % 2 == 0;
    }

    CourseSums& sums() {
        if (frame_.course.empty()) {
            frame_.course.emplace_back();
        }
        return frame_.course.front();
    }

    std::int32_t residual(std::size_t what, float scale, std::int32_t value) {
        const int scale_class = entropy::scale_class(scale);
        int symbol = 0;
        const std::int32_t result =
            entropy::code_residual(port_, models_.residuals[what].of(scale_class), value, symbol);
        note(what * entropy::kScaleClasses + static_cast<std::size_t>(scale_class), symbol);
        return result;
    }

    void note(std::size_t model, int symbol) {
        frame_.model_updates.push_back(
            {static_cast<std::uint16_t>(model), 0, static_cast<std::uint8_t>(symbol)});
    }

    static std::size_t calm_class(float steps) {
        return std::min<std::size_t>(kCalmClasses - 1,
                                     static_cast<std::size_t>(entropy::scale_class(steps)) / 2);
    }

    /// Weight of a sample of that expected error: the inverse of its variance.
    static double weight_of(float expected) {
        const float variance = 1.0F + expected * expected;
        return static_cast<double>(1.0F / variance);
    }

    /// `value`, replaced where it is no number or too large for any entity.
    static double within(double value, double most, double otherwise) {
        return std::abs(value) <= most ? value : otherwise;
    }

    static double inverse(double ticks) { return ticks > 0.0 ? 1.0 / ticks : 0.0; }

    static std::int32_t rounded(double value, const RangeLayout& range) {
        if (!(value > range.minimum)) {
            return range.minimum;
        }
        return value < range.maximum ? static_cast<std::int32_t>(std::floor(value + 0.5))
                                     : range.maximum;
    }

    const RecordFormat& format_;
    const CourseKnowledge& course_;
    const RecordModels& models_;
    const KnownBaselines& bases_;
    Port port_;
    Neighbours& neighbours_;
    RecordFrame& frame_;
    std::array<CoursePacket, kLooks> packets_;
    bool on_ = false;
    bool failed_ = false;
    // Of the record being coded.
    EntityId entity_;
    std::uint8_t lod_ = 0;
    std::array<const CodedRecord*, kLooks> seen_{};  // in the packets
    std::array<double, kLooks> scale_{};             // of their steps in those of the record
    std::array<Rotation, kLooks> rotations_;
    float from_finest_ = 1.0F;  // steps of the record in one of the finest level
    float steps_per_rad_ = 1.0F;
    double gap_ = 1.0;  // ticks since the newest packet
    // Factor from the difference of two packets to the displacement until now at the same velocity.
    double lag_1_ = 0.0;
    double lag_2_ = 0.0;
    double lag_to_3_ = 0.0;
    float per_tick_ = 0.0F;
    bool alone_ = true;
    bool plain_ = false;
    std::array<std::array<double, kMoveFeatures>, 3> features_{};
    std::array<double, 3> continued_{};  // displacement as before, steps
    std::array<double, 3> moves_{};      // displacement expected, steps
    MotionResidual near_;
    MotionResidual residual_;
    std::array<float, 3> error_{};  // steps of the record
    std::array<float, 3> own_{};    // steps of the record
    float own_turn_ = 0.0F;         // rad
    float own_mean_ = 0.0F;
    float near_mean_ = 0.0F;
    float in_record_ = 0.0F;
    std::size_t calm_ = 0;
    std::size_t calm_turn_ = 0;
};

}  // namespace zoned::wire::record
