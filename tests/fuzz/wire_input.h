// Wire input: the readers that the first byte of an input of the wire-format fuzzer chooses.
#pragma once

#include "tests/unit/wire/wire_samples.h"
#include "shared/wire/packet.h"
#include "shared/wire/publication.h"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace zoned::wire::fuzz {

using Input = std::span<const std::uint8_t>;
using Bytes = std::vector<std::uint8_t>;

inline bool same_bytes(Input a, Input b) {
    return std::ranges::equal(a, b);
}

/// The declared fields of all types of that choice: a few, or as many as a type may have.
inline const FieldSchema& fields_for(std::uint8_t choice) {
    static const auto few = testing::sample_fields();
    static const auto most = testing::most_fields();
    return (choice & 4) != 0 ? *most : *few;
}

inline Quantization quantization_for(std::uint8_t choice) {
    Quantization q;
    if ((choice & 1) != 0) {
        q.position_step_m = 1.0F;
        q.horizontal_extent_m = 100.0F;
        q.vertical_extent_m = 10.0F;
        q.orientation_bits = 5;
        q.yaw_bits = 5;
        q.max_speed_mps = 8.0F;
        q.velocity_step_mps = 0.5F;
        q.lod_shift[1] = {2, 0};
    }
    return q;
}

/// Keyframes against which deltas are read: one of each kind of entity.
inline QuantizedState keyframe_for(bool upright, const Quantization& q) {
    motion::KinematicState s;
    s.position = Vec3(12.5F, 3.0F, -20.0F);
    s.velocity = Vec3(3.0F, 0.0F, -4.0F);
    s.orientation = upright ? Quat(0.8F, 0.0F, 0.6F, 0.0F) : Quat(0.5F, -0.5F, 0.1F, 0.7F);
    s.angular_velocity = Vec3(0.5F, 1.0F, -1.5F);
    return quantize(s, motion::PredictorOrder::kLinear, upright, false, 7, q);
}

}  // namespace zoned::wire::fuzz
