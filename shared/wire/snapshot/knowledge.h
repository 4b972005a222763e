// Knowledge: the acknowledged snapshots that both sides provably share, and the models trained on
// them.
// Reached by no program yet: it belongs to the snapshot codec.
#pragma once

#include "shared/wire/entropy/acknowledged.h"
#include "shared/wire/entropy/frame_pool.h"
#include "shared/wire/entropy/least_squares.h"
#include "shared/wire/entropy/residual_model.h"
#include "shared/wire/snapshot/rotation.h"

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace zoned::wire::snapshot {

/// A snapshot travels in one packet.
using FrameNumber = entropy::PacketNumber;

/// History of a body that a snapshot changed; all zero for other bodies.
struct Moved {
    std::array<float, 3> error{};  ///< steps per frame since the reference: magnitude of the
                                   ///< prediction's error
    float turn_error = 0.0F;       ///< rad per frame, likewise, mean over the axes
    Rotation rotation;
};

inline constexpr std::uint16_t kNotMoved = 0xFFFF;

/// A decision that was coded and with which model: learned when both sides share the snapshot.
struct ModelUpdate {
    std::uint16_t model = 0;
    std::uint8_t symbol = 0;
};

inline constexpr std::size_t kMoveFeatures = 4;
inline constexpr std::size_t kTurnFeatures = 3;
/// Predictors are apart by how calm a body has been: the calm are measured over longer times.
inline constexpr std::size_t kCalmClasses = 8;

/// A snapshot as it was coded. Never changes afterwards.
struct CodedFrame {
    FrameNumber number = 0;
    Snapshot samples;
    std::vector<FrameNumber> changed_at;     ///< when each body last differed from its reference
    std::vector<std::uint16_t> moved_index;  ///< in `moved`, or kNotMoved
    std::vector<Moved> moved;
    std::vector<std::uint16_t> awake;  ///< bodies that changed lately, 16 to a mask
    std::vector<ModelUpdate> model_updates;
    std::array<std::array<entropy::NormalSums<kMoveFeatures>, kCalmClasses>, 2> moves;
    std::array<entropy::NormalSums<kTurnFeatures>, kCalmClasses> turns;

    /// All but the columns that have a value per body, which are written anew anyway.
    void clear() {
        moved.clear();
        awake.clear();
        model_updates.clear();
        moves = {};
        turns = {};
    }

    [[nodiscard]] const Moved& moved_of(std::uint32_t body) const {
        static constexpr Moved kStill;
        const std::uint16_t index = moved_index[body];
        return index == kNotMoved ? kStill : moved[index];
    }

    [[nodiscard]] Rotation rotation_of_body(std::uint32_t body, int orientation_bits) const {
        const std::uint16_t index = moved_index[body];
        return index == kNotMoved ? rotation_of(samples[body], orientation_bits)
                                  : moved[index].rotation;
    }
};

using FramePointer = std::shared_ptr<const CodedFrame>;

/// Probability models by what they are for.
struct Models {
    static constexpr std::size_t kChangeContexts = 256;
    static constexpr std::size_t kBlockContexts = 4;
    static constexpr std::size_t kMarkContexts = 4;
    static constexpr std::size_t kLeadContexts = 8;
    static constexpr std::size_t kBits =
        kChangeContexts + kBlockContexts + kMarkContexts + kLeadContexts;

    enum Residuals : std::uint8_t {
        kHorizontal,
        kVertical,
        kOrientation,
        kResiduals
    };

    std::array<entropy::BitModel, kBits> bits;
    std::array<entropy::ResidualModel, kResiduals> residuals;

    void learning(const std::vector<ModelUpdate>& model_updates);
};

/// Grows by one acknowledged snapshot at a time, in ascending order. Two sides that learned the
/// same snapshots know the same, bit for bit.
class Knowledge {
  public:
    using Frame = CodedFrame;
    using Format = SnapshotFormat;
    using Common = entropy::NothingInCommon;

    static constexpr std::size_t kRemembered = 7;

    explicit Knowledge(const SnapshotFormat& format);

    void learning(FramePointer frame);

    /// The snapshot `back` before the newest, or the oldest kept. At first that is the initial
    /// state of the bodies.
    [[nodiscard]] const CodedFrame& frame(std::size_t back) const {
        while (!frames_[back]) {
            --back;
        }
        return *frames_[back];
    }

    [[nodiscard]] const Models& models() const { return models_; }

    /// `vertical`: along the third axis.
    [[nodiscard]] const entropy::LeastSquares<kMoveFeatures>& move(bool vertical,
                                                                   std::size_t calm) const {
        return moves_[vertical ? 1 : 0][calm];
    }

    [[nodiscard]] const entropy::LeastSquares<kTurnFeatures>& turn(std::size_t calm) const {
        return turns_[calm];
    }

    [[nodiscard]] const entropy::LearnedPackets& learned() const { return learned_; }

  private:
    std::array<FramePointer, kRemembered> frames_;
    Models models_;
    std::array<std::array<entropy::LeastSquares<kMoveFeatures>, kCalmClasses>, 2> moves_;
    std::array<entropy::LeastSquares<kTurnFeatures>, kCalmClasses> turns_;
    entropy::LearnedPackets learned_;
};

}  // namespace zoned::wire::snapshot
