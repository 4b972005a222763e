#include "server/config/world/spline_config.h"

#include "server/ai/splines/lane_numbers.h"
#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "server/config/text/config_numbers.h"
#include "server/config/world/terrain.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

namespace zoned::config {

namespace {

using ai::splines::LaneChoice;
using ai::splines::LaneId;
using ai::splines::NamedSpline;
using ai::splines::SplineLanes;
using ai::splines::SplineNetwork;
using proto::config::Config;

int find_track(const Config& config, const std::string& name) {
    for (int t = 0; t < config.track_size(); ++t) {
        if (config.track(t).name() == name) {
            return t;
        }
    }
    return -1;
}

std::vector<SplineLanes> lanes_of(const Config& config) {
    std::vector<SplineLanes> out;
    for (const proto::config::Track& track : config.track()) {
        out.push_back({static_cast<std::uint16_t>(track.lanes()), track.has_racing_line()});
    }
    return out;
}

NamedSpline track_of(const proto::config::Track& track) {
    NamedSpline out;
    out.name = track.name();
    for (const proto::config::Point& point : track.point()) {
        out.def.points.emplace_back(narrow(point.x_m()), narrow(point.z_m()));
    }
    out.def.curve = track.curve() == proto::config::Track::B_SPLINE
                        ? ai::splines::Curve::kBSpline
                        : ai::splines::Curve::kCatmullRom;
    out.def.closed = track.closed();
    out.def.width_m = narrow(track.width_m());
    out.def.lanes = track.lanes();
    out.error_m = narrow(track.error_m());
    if (track.has_racing_line()) {
        out.racing_margin_m = narrow(track.racing_line().margin_m());
    }
    return out;
}

void check_track(const Config& config, int index, Diagnostics& diagnostics) {
    const proto::config::Track& track = config.track(index);
    const std::string path = join_path("", "track", index);
    const auto& world = config.world();
    for (int p = 0; p < track.point_size(); ++p) {
        const auto& point = track.point(p);
        if (!(point.x_m() >= world.min_x_m() && point.x_m() <= world.max_x_m() &&
              point.z_m() >= world.min_z_m() && point.z_m() <= world.max_z_m())) {
            diagnostics.add(join_path(path, "point", p), "lies outside the world");
            return;
        }
    }
    if (track.has_racing_line() && !track.closed()) {
        diagnostics.add(path + ".racing_line", "is of closed tracks alone");
    } else if (track.racing_line().margin_m() > 0.5 * track.width_m()) {
        diagnostics.add(path + ".racing_line", "its margin_m is more than half of width_m");
    }
}

/// Calls visit(state or action) for all of a brain.
template <class Visit>
void for_each_action(const std::vector<ai::BrainState>& states, Visit&& visit) {
    for (const ai::BrainState& state : states) {
        visit(state);
        for_each_action(state.inside, visit);
        for_each_action(state.actions, visit);
    }
}

/// Collects the mistakes of one lane and its followers.
class LaneSurvey {
  public:
    LaneSurvey(const Settings& settings, const SplineNetwork& net)
        : net_(net),
          terrain_(settings.boxes, settings.ground_height_m, settings.surfaces) {
        for (const proto::config::Track& track : settings.config->track()) {
            const SplineLanes has{static_cast<std::uint16_t>(track.lanes()),
                                  track.has_racing_line()};
            for (unsigned k = 0; k < 2 * has.each_way(); ++k) {
                const bool races = k % has.each_way() == has.lanes;
                width_m_.push_back(races ? narrow(track.width_m())
                                         : narrow(track.width_m()) / static_cast<float>(has.lanes));
            }
        }
    }

    void look(const world::EntityType& type, const ai::BrainState& state, LaneId id) {
        const motion::CharacterLimits& body = type.character;
        const double speed = static_cast<double>(body.speed * state.speed_factor *
                                                 (state.sprint ? body.sprint_factor : 1.0F));
        const auto& lane = net_.lane(id);
        const std::string who = "type '" + type.name + "' on track " + net_.name(id) + ": ";
        const double needed = speed * speed * lane.most_curved();
        if (body.acceleration > 0.0F && needed > static_cast<double>(body.acceleration)) {
            add(who +
                text_of("a bend with a radius of %.3g m takes %.3g m/s2 at its speed, it has %.3g: "
                        "it will leave its lane there",
                        1.0 / lane.most_curved(),
                        needed,
                        static_cast<double>(body.acceleration)));
        }
        if (2.0F * body.radius > width_m_[id]) {
            add(who + text_of("%.3g m wide on a lane of %.3g m",
                              2.0 * static_cast<double>(body.radius),
                              static_cast<double>(width_m_[id])));
        }
        statics(body, lane, who);
    }

    [[nodiscard]] std::vector<std::string> run() && { return std::move(warnings_); }

  private:
    static constexpr double kLook_m = 0.5;

    /// Reports the first obstacle on a lane: a step between two samples too high for the follower,
    /// or no room for its body.
    void statics(const motion::CharacterLimits& body,
                 const ai::splines::Lane& lane,
                 const std::string& who) {
        const auto looks = static_cast<int>(std::ceil(lane.length() / kLook_m));
        float before = 0.0F;
        for (int k = 0; k <= looks; ++k) {
            const double s = lane.length() * k / looks;
            const Vec2d at = lane.at(s).at;
            const auto x = static_cast<float>(at.x());
            const auto z = static_cast<float>(at.y());
            const float ground = terrain_.height(x, z);
            const float climb = std::max(body.step_up, static_cast<float>(kLook_m) * kSteepest);
            const bool steps = k > 0 && std::abs(ground - before) > climb;
            before = ground;
            if (steps || !room(body, x, z, ground)) {
                add(who + text_of("something stands in its way at %.1f, %.1f (%.1f m along it)",
                                  at.x(),
                                  at.y(),
                                  s));
                return;
            }
        }
    }

    /// Room for a body that stands there, but for its feet: slopes and steps reach into these.
    [[nodiscard]] bool room(const motion::CharacterLimits& body, float x, float z, float ground) {
        const float low = ground + std::max(body.step_up, 2.0F * body.radius) + 0.05F;
        const float high = ground + 2.0F * (body.radius + body.half_segment) - 0.05F;
        const float half = 0.7F * body.radius;
        return high <= low ||
               terrain_.clear({Vec3(x - half, low, z - half), Vec3(x + half, high, z + half)});
    }

    void add(const std::string& warning) {
        if (std::find(warnings_.begin(), warnings_.end(), warning) == warnings_.end()) {
            warnings_.push_back(warning);
        }
    }

    static constexpr float kSteepest = 1.2F;  ///< as suspended agents take grounds to be

    const SplineNetwork& net_;
    Terrain terrain_;
    std::vector<float> width_m_;  // by lane
    std::vector<std::string> warnings_;
};

}  // namespace

std::shared_ptr<const SplineNetwork> build_tracks(const Config& config, Diagnostics& diagnostics) {
    std::set<std::string> names;
    std::vector<NamedSpline> tracks;
    const std::size_t before = diagnostics.size();
    for (int t = 0; t < config.track_size(); ++t) {
        const std::string path = join_path("", "track", t);
        const proto::config::Track& track = config.track(t);
        if (check_name(track.name(), "track", path, diagnostics) &&
            !names.insert(track.name()).second) {
            diagnostics.add(path + ".name", "'" + track.name() + "' is the name of another track");
        }
        check_track(config, t, diagnostics);
        tracks.push_back(track_of(track));
        std::optional<std::size_t> point;
        const auto curve = ai::splines::Spline::make(tracks.back().def, &point);
        if (!curve) {
            diagnostics.add(point ? join_path(path, "point", static_cast<int>(*point)) : path,
                            curve.error());
        }
    }
    if (tracks.empty() || diagnostics.size() > before) {
        return nullptr;
    }
    std::size_t wrong = 0;
    auto net = SplineNetwork::make(tracks, &wrong);
    if (!net) {
        diagnostics.add(join_path("", "track", static_cast<int>(wrong)), net.error());
        return nullptr;
    }
    return std::make_shared<const SplineNetwork>(std::move(net).value());
}

ai::FollowDef expand_follow(const Config& config, const proto::config::FollowTrack& follow) {
    ai::FollowDef out;
    const std::vector<SplineLanes> lanes = lanes_of(config);
    for (const proto::config::TrackChoice& choice : follow.choice()) {
        const int track = find_track(config, choice.track());
        ai::LaneDraw draw;
        draw.weight = narrow(choice.weight());
        if (track >= 0) {
            const auto t = static_cast<std::uint16_t>(track);
            const bool all = !choice.has_lane() && !choice.racing_line();
            draw.first = ai::splines::lane_number(lanes,
                                                  {t,
                                                   static_cast<std::uint16_t>(choice.lane()),
                                                   choice.racing_line(),
                                                   choice.backwards()});
            draw.count = all ? lanes[t].lanes : std::uint16_t{1};
        }
        out.draws.push_back(draw);
    }
    out.blend_m = narrow(follow.blend_m());
    out.change_every_m = narrow(follow.change_every_m());
    return out;
}

void check_follow(const Config& config,
                  const proto::config::FollowTrack& follow,
                  const std::string& path,
                  Diagnostics& diagnostics) {
    if (follow.choice_size() == 0) {
        diagnostics.add(path, "says no track to follow: `choice` is not set");
        return;
    }
    double weights = 0.0;
    for (int c = 0; c < follow.choice_size(); ++c) {
        const proto::config::TrackChoice& choice = follow.choice(c);
        const std::string here = join_path(path, "choice", c);
        weights += choice.weight();
        const int track = find_track(config, choice.track());
        if (track < 0) {
            diagnostics.add(here + ".track",
                            choice.has_track() ? "there is no track named '" + choice.track() + "'"
                                               : "says no track");
            continue;
        }
        const proto::config::Track& of = config.track(track);
        if (choice.racing_line() && choice.has_lane()) {
            diagnostics.add(here + ".lane", "takes either a lane or the racing line");
        } else if (choice.racing_line() && !of.has_racing_line()) {
            diagnostics.add(here + ".racing_line",
                            "track '" + choice.track() + "' has no racing line");
        } else if (choice.has_lane() && choice.lane() >= of.lanes()) {
            diagnostics.add(here + ".lane",
                            text_of("there are %g lanes, of which the first is 0", of.lanes()));
        }
    }
    if (!(weights > 0.0)) {
        diagnostics.add(path, "no choice has a weight above 0");
    }
}

std::vector<std::string> track_warnings(const Settings& settings) {
    const SplineNetwork* net = settings.ai.points_of_interest.tracks.get();
    if (net == nullptr) {
        return {};
    }
    LaneSurvey survey(settings, *net);
    for (const world::EntityType& type : settings.types) {
        if (type.brain == 0) {
            continue;
        }
        for_each_action(settings.ai.brains[type.brain - 1U].states,
                        [&](const ai::BrainState& state) {
                            if (!state.follow) {
                                return;
                            }
                            for (const ai::LaneDraw& draw : state.follow->draws) {
                                for (std::uint16_t k = 0; k < draw.count; ++k) {
                                    survey.look(type, state, static_cast<LaneId>(draw.first + k));
                                }
                            }
                        });
    }
    return std::move(survey).run();
}

}  // namespace zoned::config
