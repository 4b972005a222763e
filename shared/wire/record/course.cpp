#include "shared/wire/record/course.h"

#include <algorithm>

namespace zoned::wire::record {

namespace {

// Before anything was learned: entities go on as they did, mostly by their newest velocity, and
// share what is unexpected with those near them.
constexpr std::array<double, kMoveFeatures> kGoesOn = {0.8, 0.2, 1.0, 0.4};
constexpr std::array<double, kTurnFeatures> kTurnsOn = {0.3, 0.7, 0.5};

}  // namespace

CourseKnowledge::CourseKnowledge() {
    for (auto& by_calm : moves_) {
        by_calm.fill(entropy::LeastSquares<kMoveFeatures>(kGoesOn));
    }
    turns_.fill(entropy::LeastSquares<kTurnFeatures>(kTurnsOn));
}

void CourseKnowledge::learning(entropy::PacketNumber number,
                               Tick tick,
                               const std::vector<CourseSums>& sums) {
    if (packets_[0].number == 0 || packets_[0].tick != tick) {
        std::rotate(packets_.begin(), packets_.end() - 1, packets_.end());
    }
    packets_[0] = {number, tick};
    const auto learn = [](auto& squares, const auto& seen) {
        if (seen.any) {
            squares.learning(seen);
            squares.solve();
        }
    };
    for (const CourseSums& seen : sums) {
        for (std::size_t calm = 0; calm < kCalmClasses; ++calm) {
            learn(moves_[0][calm], seen.moves[0][calm]);
            learn(moves_[1][calm], seen.moves[1][calm]);
            learn(turns_[calm], seen.turns[calm]);
        }
    }
}

const CoursePacket& CourseKnowledge::at(std::size_t look) const {
    std::size_t back = kLooks[look];
    while (back > 0 && packets_[back].number == 0) {
        --back;
    }
    return packets_[back];
}

}  // namespace zoned::wire::record
