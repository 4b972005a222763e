#include "shared/wire/snapshot/knowledge.h"

#include <algorithm>
#include <utility>

namespace zoned::wire::snapshot {

namespace {

// Before anything was learned: bodies go on as they did, mostly by their newest velocity, and share
// the motion residuals of the bodies near them.
constexpr std::array<double, kMoveFeatures> kGoesOn = {0.8, 0.2, 1.0, 0.4};
constexpr std::array<double, kTurnFeatures> kTurnsOn = {0.3, 0.7, 0.5};

/// Position of bodies before their first snapshot.
FramePointer origin(const SnapshotFormat& format) {
    auto frame = std::make_shared<CodedFrame>();
    BodySample sample;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        sample.position[axis] = std::clamp(0, format.minimum[axis], format.maximum[axis]);
        sample.orientation[axis] = static_cast<std::int16_t>(1 << (format.orientation_bits - 1));
    }
    frame->samples.assign(format.bodies, sample);
    frame->changed_at.assign(format.bodies, 0);
    frame->moved_index.assign(format.bodies, kNotMoved);
    return frame;
}

}  // namespace

void Models::learning(const std::vector<ModelUpdate>& model_updates) {
    for (const ModelUpdate& lesson : model_updates) {
        if (lesson.model < kBits) {
            bits[lesson.model].learning(lesson.symbol != 0);
        } else {
            const std::size_t model = lesson.model - kBits;
            residuals[model / entropy::kScaleClasses]
                .of(static_cast<int>(model % entropy::kScaleClasses))
                .learning(lesson.symbol);
        }
    }
}

Knowledge::Knowledge(const SnapshotFormat& format) {
    frames_[0] = origin(format);
    for (auto& by_calm : moves_) {
        by_calm.fill(entropy::LeastSquares<kMoveFeatures>(kGoesOn));
    }
    turns_.fill(entropy::LeastSquares<kTurnFeatures>(kTurnsOn));
    // A resting body goes on resting.
    for (std::size_t i = 0; i < Models::kChangeContexts + Models::kBlockContexts; ++i) {
        models_.bits[i] = entropy::BitModel(1u << 12);
    }
}

void Knowledge::learning(FramePointer frame) {
    models_.learning(frame->model_updates);
    const auto learn_sums = [](auto& squares, const auto& seen) {
        if (seen.any) {
            squares.learning(seen);
            squares.solve();
        }
    };
    for (std::size_t calm = 0; calm < kCalmClasses; ++calm) {
        learn_sums(moves_[0][calm], frame->moves[0][calm]);
        learn_sums(moves_[1][calm], frame->moves[1][calm]);
        learn_sums(turns_[calm], frame->turns[calm]);
    }
    learned_.add(frame->number);
    std::rotate(frames_.begin(), frames_.end() - 1, frames_.end());
    frames_[0] = std::move(frame);
}

}  // namespace zoned::wire::snapshot
