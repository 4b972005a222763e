// Snapshot pass: the one walk over a snapshot's bodies that encoder and decoder share.
// Reached by no program yet: it belongs to the snapshot codec.
#pragma once

#include "shared/wire/entropy/ports.h"
#include "shared/wire/snapshot/knowledge.h"
#include "shared/wire/snapshot/neighbours.h"
#include "shared/wire/snapshot/rotation.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace zoned::wire::snapshot {

/// Walks over all bodies. `frame.number` and, when encoding, `frame.samples` are given; the rest of
/// the frame is filled in, when decoding the samples as well.
template <class Port>
class SnapshotPass {
  public:
    static constexpr bool kDecodes = Port::kDecodes;

    SnapshotPass(const SnapshotFormat& format,
                 const Knowledge& knowledge,
                 Neighbours& neighbours,
                 Port port,
                 CodedFrame& frame)
        : format_(format),
          knowledge_(knowledge),
          neighbours_(neighbours),
          models_(knowledge.models()),
          port_(port),
          frame_(frame),
          t0_(knowledge.frame(0)),
          t1_(knowledge.frame(1)),
          t2_(knowledge.frame(2)),
          t3_(knowledge.frame(3)),
          t6_(knowledge.frame(6)) {
        gap_ = static_cast<double>(frame.number - t0_.number);
        lag_1_ = gap_ * inverse(t0_.number - t1_.number);
        lag_2_ = gap_ * inverse(t1_.number - t2_.number);
        lag_to_3_ = gap_ * inverse(t0_.number - t3_.number);
        per_frame_ = static_cast<float>(inverse(frame.number - t0_.number));
        steps_per_rad_ =
            0.25 * std::numbers::sqrt2 * static_cast<double>((1 << format.orientation_bits) - 1);
    }

    void run() {
        begin();
        for (std::uint32_t block = 0; block < format_.bodies; block += kBlock) {
            const std::uint32_t end = std::min(block + kBlock, format_.bodies);
            code_block(block, end);
        }
    }

  private:
    static constexpr std::uint32_t kBlock = 16;
    static constexpr FrameNumber kAwakeFrames = 12;
    // Shares of the velocity at two lags for a body that moves on as before. The least squares
    // learn better shares; motion residuals are relative to these, which never change.
    static constexpr double kNewest = 0.8;
    static constexpr double kOlder = 0.2;
    static constexpr double kNewestTurn = 0.3;
    static constexpr double kOlderTurn = 0.7;
    static constexpr double kFarthest = 1 << 23;  // steps
    static constexpr double kLongestTurn = 4.0;   // rad

    void begin() {
        neighbours_.clear();
        if constexpr (kDecodes) {
            frame_.samples = t0_.samples;
        }
        frame_.changed_at = t0_.changed_at;
        frame_.moved_index.assign(format_.bodies, kNotMoved);
        find_awake();
    }

    /// The bodies of each block that changed lately.
    void find_awake() {
        for (std::uint32_t from = 0; from < format_.bodies; from += kBlock) {
            const std::uint32_t to = std::min(from + kBlock, format_.bodies);
            std::uint32_t mask = 0;
            for (std::uint32_t body = from; body < to; ++body) {
                const bool is =
                    t0_.changed_at[body] != 0 && t0_.number - t0_.changed_at[body] <= kAwakeFrames;
                mask |= (is ? 1u : 0u) << (body - from);
            }
            frame_.awake.push_back(static_cast<std::uint16_t>(mask));
        }
    }

    void code_block(std::uint32_t from, std::uint32_t to) {
        const std::uint32_t all = (1u << (to - from)) - 1;
        const std::uint32_t awake = frame_.awake[from / kBlock];
        std::uint32_t coded = awake;
        if (awake != all) {
            bool others = false;
            if constexpr (!kDecodes) {
                for (std::uint32_t body = from; body < to; ++body) {
                    others |= (awake >> (body - from) & 1u) == 0 && changes(body);
                }
            }
            const int count = std::min(std::popcount(awake), 3);
            others = bit(Models::kChangeContexts + static_cast<std::size_t>(count), others);
            coded = others ? all : awake;
        }
        for (; coded != 0; coded &= coded - 1) {
            const int i = std::countr_zero(coded);
            code_body(from + static_cast<std::uint32_t>(i), (awake >> i & 1u) != 0);
        }
    }

    [[nodiscard]] bool changes(std::uint32_t body) const {
        return !(frame_.samples[body] == t0_.samples[body]);
    }

    void code_body(std::uint32_t body, bool awake) {
        const bool changed = bit(change_context(body), !kDecodes && changes(body));
        if (!changed) {
            return;
        }
        frame_.changed_at[body] = frame_.number;
        BodySample& sample = frame_.samples[body];
        const BodySample& before = t0_.samples[body];
        sample.mark = static_cast<std::uint8_t>(
            bit(Models::kChangeContexts + Models::kBlockContexts + before.mark + (awake ? 2 : 0),
                sample.mark != 0));
        MotionResidual motion_residual;
        const bool alone = neighbours_.empty();
        const MotionResidual near = alone ? MotionResidual{} : neighbours_.near(before.position);
        code_position(body, near, alone, motion_residual);
        frame_.moved_index[body] = static_cast<std::uint16_t>(frame_.moved.size());
        Moved& moved = frame_.moved.emplace_back();
        code_orientation(body, near, alone, motion_residual, moved);
        neighbours_.note(before.position, motion_residual);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            moved.error[axis] = motion_residual.error[axis] * per_frame_;
        }
        moved.turn_error = motion_residual.turn_error * per_frame_;
    }

    [[nodiscard]] std::size_t change_context(std::uint32_t body) const {
        const BodySample& a = t0_.samples[body];
        const BodySample& b = t6_.samples[body];
        std::uint32_t speed = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            speed += static_cast<std::uint32_t>(std::abs(a.position[axis] - b.position[axis]));
        }
        const auto speed_class = static_cast<std::size_t>(std::min<int>(7, std::bit_width(speed)));
        const std::size_t moved =
            (a == t1_.samples[body] ? 0 : 1) + (a == t3_.samples[body] ? 0 : 2) + (a == b ? 0 : 4);
        return moved + 8 * a.mark + 16 * speed_class;
    }

    void code_position(std::uint32_t body,
                       const MotionResidual& near,
                       bool alone,
                       MotionResidual& motion_residual) {
        const auto& p0 = t0_.samples[body].position;
        const auto& p1 = t1_.samples[body].position;
        const auto& p2 = t2_.samples[body].position;
        std::array<float, 3> own{};
        for (const CodedFrame* f : {&t0_, &t1_, &t2_}) {
            const std::array<float, 3>& error = f->moved_of(body).error;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                own[axis] += error[axis];
            }
        }
        const auto gap = static_cast<float>(gap_);
        for (float& o : own) {
            o *= gap / 3.0F;
        }
        const float own_mean = (own[0] + own[1] + own[2]) / 3.0F;
        const float near_mean = (near.error[0] + near.error[1] + near.error[2]) / 3.0F;
        const std::size_t calm = calm_class(own_mean);
        float in_body = 0.0F;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::array<double, kMoveFeatures> features = {lag_1_ * (p0[axis] - p1[axis]),
                                                                lag_2_ * (p1[axis] - p2[axis]),
                                                                near.moved[axis],
                                                                near.carried[axis]};
            const bool vertical = axis == 2;
            const double continued = kNewest * features[0] + kOlder * features[1];
            const double moves =
                within(knowledge_.move(vertical, calm).predict(features), kFarthest, continued);
            float scale = alone ? 0.85F * own[axis] + 0.15F * own_mean
                                : 0.35F * own[axis] + 0.15F * own_mean + 0.3F * near.error[axis] +
                                      0.2F * near_mean;
            if (axis > 0) {
                scale = 0.8F * scale + 0.2F * in_body / static_cast<float>(axis);
            }
            std::int32_t& value = frame_.samples[body].position[axis];
            const std::int32_t predicted =
                rounded(p0[axis] + moves, format_.minimum[axis], format_.maximum[axis]);
            value = predicted + residual(vertical ? Models::kVertical : Models::kHorizontal,
                                         scale,
                                         value - predicted);
            value = std::clamp(value, format_.minimum[axis], format_.maximum[axis]);
            const double real = value - p0[axis];
            motion_residual.moved[axis] = static_cast<float>(real - continued);
            motion_residual.error[axis] = static_cast<float>(std::abs(real - moves));
            in_body += motion_residual.error[axis];
            if (teaches(body)) {
                frame_.moves[vertical ? 1 : 0][calm].add(features, real, weight_of(scale));
            }
        }
    }

    void code_orientation(std::uint32_t body,
                          const MotionResidual& near,
                          bool alone,
                          MotionResidual& motion_residual,
                          Moved& moved) {
        const int bits = format_.orientation_bits;
        const Rotation q0 = t0_.rotation_of_body(body, bits);
        const Turn w1 = turn_between(t1_.rotation_of_body(body, bits), q0);
        const Turn w3 = turn_between(t3_.rotation_of_body(body, bits), q0);
        const float own = static_cast<float>(gap_ / 3.0) *
                          (t0_.moved_of(body).turn_error + t1_.moved_of(body).turn_error +
                           t2_.moved_of(body).turn_error);
        const std::size_t calm = calm_class(own * static_cast<float>(steps_per_rad_));
        std::array<std::array<double, kTurnFeatures>, 3> features;
        std::array<double, 3> continued;
        Turn turn;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            continued[axis] = kNewestTurn * lag_1_ * w1[axis] + kOlderTurn * lag_to_3_ * w3[axis];
            features[axis] = {lag_1_ * w1[axis],
                              lag_to_3_ * w3[axis],
                              alone ? 0.0 : near.turn[axis] - continued[axis]};
            turn[axis] = static_cast<float>(
                within(knowledge_.turn(calm).predict(features[axis]), kLongestTurn, 0.0));
        }
        const Rotation predicted = turned(q0, turn);
        BodySample& sample = frame_.samples[body];
        code_left_out(predicted, sample);
        const std::array<std::int16_t, 3> expected =
            quantize_rotation(predicted, sample.left_out, format_.orientation_bits);
        const float base = static_cast<float>(steps_per_rad_) *
                           (alone ? own : 0.5F * own + 0.5F * near.turn_error);
        const std::int32_t most = (1 << format_.orientation_bits) - 1;
        float in_body = 0.0F;
        for (std::size_t i = 0; i < 3; ++i) {
            const float scale =
                i == 0 ? base : 0.8F * base + 0.2F * in_body / static_cast<float>(i);
            const std::int32_t off =
                residual(Models::kOrientation, scale, sample.orientation[i] - expected[i]);
            sample.orientation[i] =
                static_cast<std::int16_t>(std::clamp(expected[i] + off, 0, most));
            in_body += static_cast<float>(std::abs(off));
        }
        moved.rotation = rotation_of(sample, bits);
        const Turn real = turn_between(q0, moved.rotation);
        motion_residual.turn = real;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            motion_residual.turned[axis] = static_cast<float>(real[axis] - continued[axis]);
            motion_residual.turn_error +=
                static_cast<float>(std::abs(real[axis] - turn[axis]) / 3.0F);
            if (teaches(body)) {
                frame_.turns[calm].add(features[axis], real[axis], weight_of(base));
            }
        }
    }

    void code_left_out(const Rotation& predicted, BodySample& sample) {
        const int greatest = greatest_component(predicted);
        const auto lead = std::min<std::size_t>(
            7, static_cast<std::size_t>(30.0F * lead_of(predicted, greatest)));
        const bool other =
            bit(Models::kChangeContexts + Models::kBlockContexts + Models::kMarkContexts + lead,
                sample.left_out != greatest);
        if (other) {
            sample.left_out = static_cast<std::uint8_t>(port_.raw(sample.left_out, 2));
        } else {
            sample.left_out = static_cast<std::uint8_t>(greatest);
        }
    }

    /// One body in two is enough to learn from; the other half's turn comes next.
    [[nodiscard]] bool teaches(std::uint32_t body) const { return (body + frame_.number) % 2 == 0; }

    bool bit(std::size_t model, bool value) {
        const bool result = port_.bit(models_.bits[model], value);
        frame_.model_updates.push_back(
            {static_cast<std::uint16_t>(model), static_cast<std::uint8_t>(result ? 1 : 0)});
        return result;
    }

    std::int32_t residual(Models::Residuals what, float scale, std::int32_t value) {
        const int scale_class = entropy::scale_class(scale);
        int symbol = 0;
        const std::int32_t result =
            entropy::code_residual(port_, models_.residuals[what].of(scale_class), value, symbol);
        frame_.model_updates.push_back(
            {static_cast<std::uint16_t>(Models::kBits + what * entropy::kScaleClasses +
                                        scale_class),
             static_cast<std::uint8_t>(symbol)});
        return result;
    }

    static std::size_t calm_class(float steps) {
        return std::min<std::size_t>(kCalmClasses - 1,
                                     static_cast<std::size_t>(entropy::scale_class(steps)) / 2);
    }

    /// Weight of a sample of that expected error: the inverse of its variance.
    static double weight_of(float expected) {
        const float variance = 1.0F + expected * expected;
        return 1.0F / variance;
    }

    /// `value`, replaced where it is no number or too large for any body.
    static double within(double value, double most, double otherwise) {
        return std::abs(value) <= most ? value : otherwise;
    }

    static double inverse(FrameNumber frames) {
        return frames == 0 ? 0.0 : 1.0 / static_cast<double>(frames);
    }

    static std::int32_t rounded(double value, std::int32_t least, std::int32_t most) {
        if (!(value > least)) {
            return least;
        }
        return value < most ? static_cast<std::int32_t>(std::floor(value + 0.5)) : most;
    }

    const SnapshotFormat& format_;
    const Knowledge& knowledge_;
    Neighbours& neighbours_;
    const Models& models_;
    Port port_;
    CodedFrame& frame_;
    const CodedFrame& t0_;
    const CodedFrame& t1_;
    const CodedFrame& t2_;
    const CodedFrame& t3_;
    const CodedFrame& t6_;
    double gap_ = 1.0;  // frames since the reference
    // Factor from the difference of two snapshots to the displacement until now at the same
    // velocity.
    double lag_1_ = 0.0;
    double lag_2_ = 0.0;
    double lag_to_3_ = 0.0;
    float per_frame_ = 0.0F;
    double steps_per_rad_ = 1.0;
};

}  // namespace zoned::wire::snapshot
