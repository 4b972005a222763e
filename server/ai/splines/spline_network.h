// SplineNetwork: all tracks of a world with their lanes, both ways.
#pragma once

#include "server/ai/splines/lane.h"
#include "server/ai/splines/racing_line.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace zoned::ai::splines {

/// A track as a world has it.
struct NamedSpline {
    std::string name;
    SplineDef def;
    float error_m = 0.25F;                   ///< of followers, > 0
    std::optional<float> racing_margin_m{};  ///< it has a racing line; closed ones alone
};

/// Which lane of a track.
struct LaneChoice {
    std::uint16_t track = 0;
    std::uint16_t lane = 0;    ///< from the left, seen along the way that is taken
    bool racing_line = false;  ///< in place of a lane; the track has one
    bool backwards = false;
};

/// World coordinates, x and z, m. Never changes; shared by all zones.
class SplineNetwork {
  public:
    /// Lanes of all tracks together, both ways, m.
    static constexpr double kMost_m = 1e6;

    /// Errors name the track, and are those of Spline::make, or that all together are too long.
    /// `at`, if given: the number of that track.
    static core::Result<SplineNetwork> make(std::span<const NamedSpline> tracks,
                                            std::size_t* at = nullptr);

    [[nodiscard]] std::size_t lanes() const { return lanes_.size(); }

    [[nodiscard]] const Lane& lane(LaneId id) const { return lanes_[id].lane; }

    /// Of a choice whose track, lane and racing line there are.
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
