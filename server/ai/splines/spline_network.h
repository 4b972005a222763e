// SplineNetwork: all splines of a world with their lanes, in both directions.
#pragma once

#include "server/ai/splines/lane.h"
#include "server/ai/splines/racing_line.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::splines {

/// NamedSpline: a spline as the world's configuration has it.
struct NamedSpline {
    std::string name;
    SplineDef def;
    float error_m = 0.25F;                   ///< error of followers, > 0
    std::optional<float> racing_margin_m{};  ///< margin of its racing line, if it has one; only for
                                             ///< closed splines
};

/// LaneChoice: names a lane of a spline.
struct LaneChoice {
    std::uint16_t track = 0;
    std::uint16_t lane = 0;    ///< from the left, seen in the direction of travel
    bool racing_line = false;  ///< the racing line in place of a lane; the spline must have one
    bool backwards = false;
};

/// World coordinates, x and z, m. Never changes; shared by all zones.
class SplineNetwork {
  public:
    /// The most length of the lanes of all splines together, in both directions, m.
    static constexpr double kMost_m = 1e6;

    /// Errors name the spline. They are those of Spline::make, or the total length is too large.
    /// `at`, if given, gets the number of that spline.
    static core::Result<SplineNetwork> make(std::span<const NamedSpline> tracks,
                                            std::size_t* at = nullptr);

    [[nodiscard]] std::size_t lanes() const { return lanes_.size(); }

    [[nodiscard]] const Lane& lane(LaneId id) const { return lanes_[id].lane; }

    /// The number of a choice whose spline, lane and racing line exist.
    [[nodiscard]] LaneId id_of(const LaneChoice& choice) const;

    /// "NAME, lane 2 of 3, backwards" for people.
    [[nodiscard]] std::string name(LaneId id) const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    struct NetLane {
        Lane lane;
        std::uint16_t track;
    };

    struct NetSpline {
        std::string name;
        LaneId first;  ///< its lanes forwards, its racing line, and the same backwards
        std::uint16_t lanes;
        bool races;
    };

    [[nodiscard]] std::string add(const NamedSpline& track);
    [[nodiscard]] std::string add_path(const Spline& middle, const NamedSpline& track);

    std::vector<NetSpline> tracks_;
    std::vector<NetLane> lanes_;
    double length_m_ = 0.0;
};

}  // namespace zoned::ai::splines
