#include "shared/wire/snapshot/orientation_coder.h"

#include "shared/wire/entropy/ports.h"

#include <algorithm>
#include <cmath>

namespace zoned::wire::snapshot {

namespace {

/// Weights of recent residuals: the means over 16 and over 4 orientations.
constexpr float kSlow = 1.0F / 16.0F;
constexpr float kQuick = 1.0F / 4.0F;
/// A captured jump must not spoil the expectation for long, steps.
constexpr float kMostNoted = 100.0F;

/// Rank of the component among those without `but`, by magnitude in `r`: 0 is the greatest.
int rank_of(const Rotation& r, int component, int but) {
    const std::array<float, 4> all = {std::abs(r.w), std::abs(r.x), std::abs(r.y), std::abs(r.z)};
    int rank = 0;
    for (int i = 0; i < 4; ++i) {
        const float other = all[static_cast<std::size_t>(i)];
        const float own = all[static_cast<std::size_t>(component)];
        rank +=
            i != but && i != component && (other > own || (other == own && i < component)) ? 1 : 0;
    }
    return rank;
}

/// The component of that rank.
int component_of(const Rotation& r, int rank, int but) {
    for (int i = 0; i < 4; ++i) {
        if (i != but && rank_of(r, i, but) == rank) {
            return i;
        }
    }
    return but == 0 ? 1 : 0;  // no encoder writes such a rank
}

}  // namespace

OrientationCoder::OrientationCoder(int orientation_bits) : bits_(orientation_bits) {
}

std::size_t OrientationCoder::same_context(const Rotation& rotation, int left_out) const {
    // A captured orientation may have another component left out than its greatest.
    const float lead = std::max(0.0F, lead_of(rotation, left_out));
    const auto lead_class = std::min(kLeads - 1, static_cast<std::size_t>(30.0F * lead));
    const auto scale =
        std::min(kScales - 1, static_cast<std::size_t>(entropy::scale_class(slow_)) / 2);
    return kScales * lead_class + scale;
}

template <class Port>
void OrientationCoder::code(Port& port, const BodySample& base, BodySample& sample) {
    const Rotation rotation = rotation_of(base, bits_);
    entropy::BitModel& same = same_[same_context(rotation, base.left_out)];
    const bool other = port.bit(same, sample.left_out != base.left_out);
    same.learning(other);
    if (other) {
        const int rank =
            port.symbol(which_, other ? rank_of(rotation, sample.left_out, base.left_out) : 0);
        which_.learning(rank);
        sample.left_out = static_cast<std::uint8_t>(component_of(rotation, rank, base.left_out));
    } else {
        sample.left_out = base.left_out;
    }
    const std::array<std::int16_t, 3> expected =
        quantize_rotation(rotation, sample.left_out, bits_);
    const float outside = 0.8F * slow_ + 0.2F * quick_;
    float sum = 0.0F;
    for (std::size_t i = 0; i < 3; ++i) {
        const float scale = i == 0 ? outside : 0.2F * outside + 0.8F * sum / static_cast<float>(i);
        entropy::SymbolModel& model =
            residuals_[i + (other ? 3 : 0)].of(entropy::scale_class(scale));
        const std::int32_t residual = sample.orientation[i] - expected[i];
        int symbol = 0;
        const std::int32_t value =
            expected[i] + entropy::code_residual(port, model, residual, symbol);
        model.learning(symbol);
        sample.orientation[i] = static_cast<std::int16_t>(std::clamp(value, 0, (1 << bits_) - 1));
        sum += static_cast<float>(std::abs(value - expected[i]));
    }
    const float mean = std::min(sum / 3.0F, kMostNoted);
    slow_ += kSlow * (mean - slow_);
    quick_ += kQuick * (mean - quick_);
}

void OrientationCoder::encode(entropy::RangeEncoder& coder,
                              const BodySample& base,
                              const BodySample& sample) {
    entropy::EncodePort port{coder};
    BodySample copy = sample;
    code(port, base, copy);
}

void OrientationCoder::decode(entropy::RangeDecoder& coder,
                              const BodySample& base,
                              BodySample& sample) {
    entropy::DecodePort port{coder};
    code(port, base, sample);
}

}  // namespace zoned::wire::snapshot
