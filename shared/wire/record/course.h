// Courses: what is learned from the motion of entities whose records carry no velocity.
#pragma once

#include "shared/core/ids.h"
#include "shared/wire/entropy/acknowledged.h"
#include "shared/wire/entropy/least_squares.h"
#include "shared/wire/entropy/residual_model.h"

#include <array>
#include <cstddef>
#include <vector>

namespace zoned::wire::record {

inline constexpr std::size_t kMoveFeatures = 4;
inline constexpr std::size_t kTurnFeatures = 3;
/// Predictors are apart by how calm an entity has been: the calm are measured over longer times.
inline constexpr std::size_t kCalmClasses = 8;

/// The lessons of one packet about courses.
struct CourseSums {
    /// Along the ground, upwards.
    std::array<std::array<entropy::NormalSums<kMoveFeatures>, kCalmClasses>, 2> moves;
    std::array<entropy::NormalSums<kTurnFeatures>, kCalmClasses> turns;
};

/// A learned packet, the last of its tick.
struct CoursePacket {
    entropy::PacketNumber number = 0;  ///< 0: none
    Tick tick = 0;
};

/// The packets and weights by which courses are predicted.
class CourseKnowledge {
  public:
    static constexpr std::size_t kPackets = 7;
    /// The packets back from the newest at which courses are looked at.
    static constexpr std::array<std::size_t, 5> kLooks = {0, 1, 2, 3, 6};

    CourseKnowledge();

    void learning(entropy::PacketNumber number, Tick tick, const std::vector<CourseSums>& sums);

    /// The packet of look `look`, or the oldest there is.
    [[nodiscard]] const CoursePacket& at(std::size_t look) const;

    [[nodiscard]] const entropy::LeastSquares<kMoveFeatures>& move(bool upwards,
                                                                   std::size_t calm) const {
        return moves_[upwards ? 1 : 0][calm];
    }

    [[nodiscard]] const entropy::LeastSquares<kTurnFeatures>& turn(std::size_t calm) const {
        return turns_[calm];
    }

    template <class Archive>
    void serialize(Archive& archive) {
        archive(packets_, moves_, turns_);
    }

  private:
    std::array<CoursePacket, kPackets> packets_;  // newest first
    std::array<std::array<entropy::LeastSquares<kMoveFeatures>, kCalmClasses>, 2> moves_;
    std::array<entropy::LeastSquares<kTurnFeatures>, kCalmClasses> turns_;
};

}  // namespace zoned::wire::record
