#include "server/ai/splines/spline_network.h"

#include "server/ai/splines/lane_numbers.h"
#include "shared/core/assert.h"

#include <algorithm>

namespace zoned::ai::splines {

namespace {

constexpr std::size_t kRacingSamples = 256;

}  // namespace

core::Result<SplineNetwork> SplineNetwork::make(std::span<const NamedSpline> tracks,
                                                std::size_t* at) {
    SplineNetwork net;
    for (std::size_t t = 0; t < tracks.size(); ++t) {
        const NamedSpline& track = tracks[t];
        if (const std::string fault = net.add(track); !fault.empty()) {
            if (at != nullptr) {
                *at = t;
            }
            return core::Result<SplineNetwork>::failure("track '" + track.name + "': " + fault);
        }
    }
    return net;
}

std::string SplineNetwork::add(const NamedSpline& track) {
    tracks_.push_back({track.name,
                       static_cast<LaneId>(lanes_.size()),
                       static_cast<std::uint16_t>(track.def.lanes),
                       track.racing_margin_m.has_value()});
    SplineDef def = track.def;
    for (int way = 0; way < 2; ++way) {
        const core::Result<Spline> middle = Spline::make(def);
        if (!middle) {
            return middle.error();
        }
        if (std::string fault = add_path(*middle, track); !fault.empty()) {
            return fault;
        }
        std::reverse(def.points.begin(), def.points.end());
    }
    return {};
}

std::string SplineNetwork::add_path(const Spline& middle, const NamedSpline& track) {
    const auto number = static_cast<std::uint16_t>(tracks_.size() - 1);
    const auto append = [&](const Spline& of, double offset) -> std::string {
        core::Result<Lane> lane = Lane::make(of, offset, static_cast<double>(track.error_m));
        if (!lane) {
            return lane.error();
        }
        length_m_ += lane->length();
        if (length_m_ > kMost_m || lanes_.size() + 1 >= kNoLane) {
            return "the lanes of all tracks so far, both ways, are longer than 1000 km or more "
                   "than 65534";
        }
        lanes_.push_back({std::move(lane).value(), number});
        return {};
    };
    for (std::uint32_t lane = 0; lane < track.def.lanes; ++lane) {
        if (std::string fault = append(middle, middle.offset_of(lane)); !fault.empty()) {
            return fault;
        }
    }
    if (!track.racing_margin_m) {
        return {};
    }
    const double margin_m = std::min(static_cast<double>(*track.racing_margin_m),
                                     0.5 * static_cast<double>(middle.width()));
    const core::Result<Spline> line =
        track_along(middle, racing_line(middle, kRacingSamples, margin_m));
    return line ? append(*line, 0.0) : line.error();
}

LaneId SplineNetwork::id_of(const LaneChoice& choice) const {
    ZONED_ASSERT(choice.track < tracks_.size(), "a track of the net");
    const NetSpline& track = tracks_[choice.track];
    ZONED_ASSERT(choice.racing_line ? track.races : choice.lane < track.lanes,
                 "a lane of the track");
    const SplineLanes own{track.lanes, track.races};
    LaneChoice in_own = choice;
    in_own.track = 0;
    return static_cast<LaneId>(track.first + lane_number({&own, 1}, in_own));
}

std::string SplineNetwork::name(LaneId id) const {
    const NetSpline& track = tracks_[lanes_[id].track];
    const unsigned per_way = track.lanes + (track.races ? 1U : 0U);
    const unsigned number = id - track.first;
    const unsigned lane = number % per_way;
    std::string text = track.name;
    text += lane == track.lanes
                ? ", racing line"
                : ", lane " + std::to_string(lane) + " of " + std::to_string(track.lanes);
    return number >= per_way ? text + ", backwards" : text;
}

std::size_t SplineNetwork::bytes() const {
    std::size_t bytes = 0;
    for (const NetLane& lane : lanes_) {
        bytes += sizeof(NetLane) + lane.lane.bytes();
    }
    return bytes;
}

}  // namespace zoned::ai::splines
