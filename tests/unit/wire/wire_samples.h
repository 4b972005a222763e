// Samples: random and typical states that the tests of the wire share.
#pragma once

#include "shared/core/rng.h"
#include "shared/wire/declared/declared_codec.h"
#include "shared/wire/quantize.h"

#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace zoned::wire::testing {

/// Uniform on the unit sphere of quaternions (Marsaglia, "Choosing a point from the surface of a
/// sphere", 1972, by rejection in four dimensions).
inline Quat random_rotation(core::Rng& rng) {
    for (;;) {
        Eigen::Vector4f v(rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1), rng.range(-1, 1));
        const float n = v.norm();
        if (n > 0.1F && n <= 1.0F) {
            v /= n;
            return {v[0], v[1], v[2], v[3]};
        }
    }
}

inline Vec3 random_vector(core::Rng& rng, float extent) {
    return {rng.range(-extent, extent), rng.range(-extent, extent), rng.range(-extent, extent)};
}

/// Magnitudes over several decades, so that all size classes occur.
inline float random_scale(core::Rng& rng, float most) {
    return most * std::pow(10.0F, -4.0F * rng.unit());
}

inline motion::KinematicState random_motion(core::Rng& rng, const Quantization& q) {
    motion::KinematicState s;
    s.position = random_vector(rng, random_scale(rng, q.horizontal_extent_m));
    s.velocity = random_vector(rng, random_scale(rng, q.max_speed_mps));
    s.acceleration = random_vector(rng, random_scale(rng, kMaxAccelerationMps2));
    s.angular_velocity = random_vector(rng, random_scale(rng, kMaxAngularSpeedRps));
    s.turn = random_vector(rng, random_scale(rng, kMaxAngularSpeedRps));
    // Above the position, where it is clamped to it, and without end as well.
    s.floor = rng.below(8) == 0 ? -std::numeric_limits<float>::infinity()
                                : s.position.y() - random_scale(rng, 100.0F) + 1.0F;
    s.orientation = random_rotation(rng);
    return s;
}

inline QuantizedState random_quantized(core::Rng& rng, bool upright, const Quantization& q) {
    const auto order = static_cast<motion::PredictorOrder>(rng.below(motion::kPredictorOrders));
    motion::KinematicState s = random_motion(rng, q);
    const bool at_rest = rng.below(2) != 0;
    if (at_rest) {
        s.velocity.setZero();
        s.angular_velocity.setZero();
    }
    const auto appearance = static_cast<std::uint16_t>((rng.next() >> 16) >> rng.below(17));
    return quantize(s, order, upright, at_rest, appearance, q);
}

/// A field of each kind, as section 5a of proto/WIRE.md has them.
inline std::shared_ptr<const FieldSchema> sample_fields() {
    std::vector<DeclaredField> fields(5);
    fields[0].name = "health";
    fields[0].most = 100;
    fields[0].initial[0] = 100;
    fields[1].name = "charge";
    fields[1].minimum = -10.0;
    fields[1].quantum = 0.00002;
    fields[1].most = 1'000'000;
    fields[2].name = "mood";
    fields[2].kind = DeclaredKind::kEnum;
    fields[2].values = {"calm", "wary", "angry"};
    fields[3].name = "ready";
    fields[3].kind = DeclaredKind::kBool;
    fields[4].name = "title";
    fields[4].kind = DeclaredKind::kText;
    return *FieldSchema::make(std::move(fields));
}

inline std::shared_ptr<const FieldSchema> health_alone() {
    std::vector<DeclaredField> fields(1);
    fields[0].name = "health";
    fields[0].most = 100;
    fields[0].initial[0] = 100;
    return *FieldSchema::make(std::move(fields));
}

/// As many fields as a type may have, among them numbers of 24 bits and texts.
inline std::shared_ptr<const FieldSchema> most_fields() {
    std::vector<DeclaredField> fields(kMostDeclared);
    for (std::size_t i = 0; i < fields.size(); ++i) {
        fields[i].name = "field_" + std::to_string(i);
        fields[i].most = i % 3 == 0 ? kMostFieldSteps : 1U << i % 16;
        fields[i].kind = i % 8 == 7 ? DeclaredKind::kText : DeclaredKind::kNumber;
    }
    return *FieldSchema::make(std::move(fields));
}

/// Another value for one field of an entity.
inline void change_field(core::Rng& rng,
                         const DeclaredField& field,
                         std::span<std::uint32_t> words) {
    if (field.kind != DeclaredKind::kText) {
        words[field.word] = rng.below(field.most + 1);
        return;
    }
    std::string text;
    for (std::uint32_t n = rng.below(12); n > 0; --n) {
        text += rng.below(4) == 0 ? std::string("\xC3\xA9") : std::string(1, 'a');
    }
    put_value(field, std::string_view(text), words_of(field, words));
}

/// A few Quantizations: the default, a coarse one, the finest that check() lets pass.
inline std::array<Quantization, 3> quantizations() {
    Quantization coarse;
    coarse.position_step_m = 1.0F;
    coarse.velocity_step_mps = 1.0F;
    coarse.acceleration_step_mps2 = 10.0F;
    coarse.angular_velocity_step_rps = 10.0F;
    coarse.orientation_bits = 5;
    coarse.yaw_bits = 5;
    coarse.horizontal_extent_m = 64.0F;
    coarse.vertical_extent_m = 1.0F;
    coarse.max_speed_mps = 3.0F;
    Quantization fine;
    fine.position_step_m = 0.0005F;
    fine.velocity_step_mps = 0.0001F;
    fine.acceleration_step_mps2 = 0.0002F;
    fine.angular_velocity_step_rps = 0.00004F;
    fine.orientation_bits = 15;
    fine.yaw_bits = 16;
    return {Quantization{}, coarse, fine};
}

/// Damaged forms of `bytes`: kind 0 cuts them off somewhere, 1 changes one byte, else noise of up
/// to 300 bytes.
inline std::vector<std::uint8_t> spoiled(const std::vector<std::uint8_t>& bytes,
                                         int kind,
                                         core::Rng& rng) {
    std::vector<std::uint8_t> changed = bytes;
    const auto size = static_cast<std::uint32_t>(bytes.size());
    if (kind == 0) {
        changed.resize(rng.below(size + 1));
    } else if (kind == 1 && size > 0) {
        changed[rng.below(size)] ^= static_cast<std::uint8_t>(1 + rng.below(255));
    } else {
        changed.resize(rng.below(300));
        for (std::uint8_t& byte : changed) {
            byte = static_cast<std::uint8_t>(rng.below(256));
        }
    }
    return changed;
}

}  // namespace zoned::wire::testing
