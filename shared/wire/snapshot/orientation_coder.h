// Orientation coder: codes orientations one after another, each against one that both sides know.
// Reached by no program yet: recordings of orientations alone will use it.
#pragma once

#include "shared/wire/entropy/residual_model.h"
#include "shared/wire/snapshot/rotation.h"

#include <array>
#include <cstdint>

namespace zoned::wire::snapshot {

/// Adaptive: the expected residual follows the ones before, the second and third component's also
/// the components before. Encoder and decoder must see the same orientations in the same order.
class OrientationCoder {
  public:
    explicit OrientationCoder(int orientation_bits);

    /// Only the orientation and left_out of the samples count.
    void encode(entropy::RangeEncoder& coder, const BodySample& base, const BodySample& sample);
    /// Sets orientation and left_out of `sample`; within their ranges whatever the bytes.
    void decode(entropy::RangeDecoder& coder, const BodySample& base, BodySample& sample);

  private:
    template <class Port>
    void code(Port& port, const BodySample& base, BodySample& sample);
    [[nodiscard]] std::size_t same_context(const Rotation& rotation, int left_out) const;

    static constexpr std::size_t kLeads = 8;
    static constexpr std::size_t kScales = 8;

    int bits_;
    float slow_ = 4.0F;   // mean magnitude of late residuals, steps
    float quick_ = 4.0F;  // of the last few
    std::array<entropy::BitModel, kLeads * kScales> same_;
    entropy::SymbolModel which_;                       // of the other components, by magnitude
    std::array<entropy::ResidualModel, 6> residuals_;  // by component, apart where left_out changed
};

}  // namespace zoned::wire::snapshot
