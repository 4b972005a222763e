#include "server/ai/steering/spline_following.h"

#include "server/ai/agent/offscreen_grid.h"
#include "server/ai/splines/lane_change.h"
#include "server/ai/steering/path_following.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace zoned::ai {

namespace {

using splines::Lane;
using splines::LaneId;

/// Shares of error_m, see follow_spline().
constexpr double kChordShare = 0.5;
constexpr double kTurnShare = 0.25;
constexpr double kStepShare = 0.15;
/// An agent this near to the spline begins to follow it, m.
constexpr double kBoardM = 1.5;
/// A follower pushed off farther than this walks back as to any goal, m.
constexpr double kPushedOffM = 8.0;
/// A follower that can come no nearer than this joins the spline from there, m.
constexpr double kAsNearM = 8.0;
/// The spline is searched this far before and behind the last place, m.
constexpr double kReachM = 30.0;
/// A segment lasts at least this many ticks.
constexpr double kLeastTicks = 4.0;
/// A change of lanes is cut into at least this many segments.
constexpr double kChangeSegments = 8.0;
/// A follower whose timetable needs less than this share of its speed gets a new timetable.
constexpr double kLeastShare = 0.8;
/// The share of full speed that timetables may use; the rest makes up for losses.
constexpr double kTimetableShare = 0.98;
/// Times a direction is looked for that allows for the turn into it.
constexpr int kTurnTries = 3;
/// Under a rubber band a segment lasts no longer than this, s: the speed follows the band.
constexpr double kBandedS = 1.0;
/// For blends: the agent heads for a place this far ahead, s, and at least so many m.
constexpr double kAheadS = 1.0;
constexpr double kAheadM = 2.0;

/// SplineView: the splines of one state. They are in world coordinates, agents in those of a zone.
class SplineView {
  public:
    SplineView(const FollowDef& def, const Surroundings& around)
        : def_(def),
          net_(*around.ai.points_of_interest.tracks()),
          origin_(around.ai.points_of_interest.origin()) {}

    [[nodiscard]] Vec2d world(const Vec2& at) const { return at.cast<double>() + origin_; }

    [[nodiscard]] Vec2 local(const Vec2d& at) const { return (at - origin_).cast<float>(); }

    [[nodiscard]] const Lane& lane(LaneId id) const { return net_.lane(id); }

    [[nodiscard]] const FollowDef& def() const { return def_; }

    /// Calls visit(lane, weight) for each that may be drawn.
    template <class Visit>
    void for_each(Visit&& visit) const {
        for (const LaneDraw& draw : def_.draws) {
            for (std::uint16_t k = 0; k < draw.count; ++k) {
                visit(static_cast<LaneId>(draw.first + k),
                      static_cast<double>(draw.weight) / static_cast<double>(draw.count));
            }
        }
    }

    /// Draws one of the lanes for which `may(lane)` holds; kNoLane where there is none. Draws one
    /// number.
    template <class May>
    LaneId draw(core::Rng& rng, May&& may) const {
        double sum = 0.0;
        for_each([&](LaneId id, double weight) { sum += may(id) ? weight : 0.0; });
        double left = static_cast<double>(rng.range(0.0F, 1.0F)) * sum;
        LaneId drawn = splines::kNoLane;
        for_each([&](LaneId id, double weight) {
            if (weight > 0.0 && left >= 0.0 && may(id)) {
                drawn = id;
                left -= weight;
            }
        });
        return drawn;
    }

  private:
    const FollowDef& def_;
    const splines::SplineNetwork& net_;
    Vec2d origin_;
};

const motion::CharacterLimits& body_of(const Surroundings& around) {
    return around.ai.types[around.ai.entities.type[around.self]].character;
}

/// The top speed of a body that does not hold back, m/s.
double top_speed_of(const BrainState& state, const Surroundings& around) {
    const motion::CharacterLimits& body = body_of(around);
    return static_cast<double>(body.speed) *
           static_cast<double>(state.sprint ? body.sprint_factor : 1.0F);
}

/// The speed of the timetable, m/s.
double timetable_speed(const Agent& agent, const BrainState& state, const Surroundings& around) {
    return top_speed_of(state, around) *
           std::min(static_cast<double>(state.speed_factor * agent.band), kTimetableShare);
}

/// From the end of the last tick to where the timetable has the end of the segment, s.
double time_to_due(const Agent& agent, const Surroundings& around) {
    const Tick ticks = agent.track.due - (around.ai.now - 1);
    return static_cast<double>(ticks) * static_cast<double>(around.ai.dt) +
           static_cast<double>(agent.track.due_s);
}

void set_due(Agent& agent, double from_now_s, const Surroundings& around) {
    const double dt = static_cast<double>(around.ai.dt);
    const double ticks = std::floor(from_now_s / dt);
    agent.track.due = around.ai.now - 1 + static_cast<Tick>(ticks);
    agent.track.due_s = static_cast<float>(from_now_s - ticks * dt);
}

bool changes_lanes(const Agent& agent) {
    return agent.track.from != splines::kNoLane;
}

splines::LaneChange change_of(const Agent& agent, const SplineView& view) {
    const SplineWalk& walk = agent.track;
    return {{&view.lane(walk.from).curve(), static_cast<double>(walk.from_s), 0.0},
            {&view.lane(walk.lane).curve(), static_cast<double>(walk.s), 0.0},
            static_cast<double>(view.def().blend_m)};
}

/// The place that the timetable has for the agent, `more` m after the end of its segment: world
/// coordinates.
Vec2d place_after(const Agent& agent, const SplineView& view, double more) {
    const SplineWalk& walk = agent.track;
    return changes_lanes(agent)
               ? change_of(agent, view).at(static_cast<double>(walk.changed) + more).at
               : view.lane(walk.lane).at(static_cast<double>(walk.s) + more).at;
}

/// From where its body is.
void board(Agent& agent,
           const Lane& lane,
           double s,
           const SplineView& view,
           const Surroundings& around) {
    SplineWalk& walk = agent.track;
    walk.s = static_cast<float>(lane.on_lane(s));
    walk.from = splines::kNoLane;
    walk.to_change = view.def().change_every_m;
    agent.corner = kOnTrack;
    set_due(agent, 0.0, around);
}

/// Sets a target on the spline, to which it walks as to any goal.
void head_for_place(Agent& agent, std::uint8_t corner, const Vec2d& at, const SplineView& view) {
    const Vec2 place = view.local(at);
    agent.corner = corner;
    agent.target = Vec3(place.x(), agent.home.y(), place.y());
}

/// Changes to another lane beside the present one, if the agent draws one.
void draw_change(Agent& agent, const SplineView& view) {
    SplineWalk& walk = agent.track;
    walk.to_change = view.def().change_every_m;
    const double blend = static_cast<double>(view.def().blend_m);
    const Lane& own = view.lane(walk.lane);
    const auto room = [blend](const Lane& lane, double s) {
        return lane.closed() || s + blend < lane.length();
    };
    if (!room(own, static_cast<double>(walk.s))) {
        return;
    }
    const splines::SplinePoint here = own.at(static_cast<double>(walk.s));
    const LaneId drawn = view.draw(agent.rng, [&](LaneId id) {
        if (id == walk.lane) {
            return true;
        }
        const Lane& lane = view.lane(id);
        const Lane::NearestOnLane near = lane.nearest(here.at);
        return near.distance_m <= 0.5 * blend && room(lane, near.s) &&
               lane.at(near.s).ahead.dot(here.ahead) > 0.5;
    });
    if (drawn == walk.lane || drawn == splines::kNoLane) {
        return;
    }
    walk.from = walk.lane;
    walk.from_s = walk.s;
    walk.lane = drawn;
    walk.s = static_cast<float>(view.lane(drawn).nearest(here.at).s);
    walk.changed = 0.0F;
}

/// At the end of an open lane: goes on to another one that begins there. False: none does.
bool go_on_to_next(Agent& agent, const Vec2d& end, const SplineView& view) {
    const double join = std::max(static_cast<double>(view.def().blend_m), 1.0);
    const LaneId next = view.draw(agent.rng, [&](LaneId id) {
        const Lane& lane = view.lane(id);
        return (lane.closed() ? lane.nearest(end).distance_m : (lane.at(0.0).at - end).norm()) <=
               join;
    });
    if (next == splines::kNoLane) {
        return false;
    }
    const Lane& lane = view.lane(next);
    agent.track.lane = next;
    agent.track.s = static_cast<float>(lane.closed() ? lane.nearest(end).s : 0.0);
    return true;
}

/// The limits of a segment that starts at the end of the last one.
splines::SegmentLimits limits_of(const Lane& lane,
                                 double speed,
                                 bool banded,
                                 const Surroundings& around) {
    const double error = lane.error_m();
    const double acceleration = static_cast<double>(body_of(around).acceleration);
    const double step_m = speed * static_cast<double>(around.ai.dt);
    splines::SegmentLimits limits;
    limits.off_m = kChordShare * error;
    // From segment to segment the heading turns by at most the turn of two segments. A velocity
    // that turns by an angle t changes by v t, which leads v^2 t^2 / 2a aside.
    limits.turn = 0.5 * kStepShare * error / step_m;
    if (acceleration > 0.0) {
        limits.turn =
            std::min(limits.turn, 0.5 * std::sqrt(2.0 * kTurnShare * error * acceleration) / speed);
    }
    limits.most_m = static_cast<double>(OffscreenGrid::kPiece_m);
    if (banded) {
        limits.most_m = std::min(limits.most_m, kBandedS * speed);
    }
    return limits;
}

/// The length of the next segment, m; at least so long that it lasts some ticks.
double next_segment_m(const Agent& agent,
                      const BrainState& state,
                      const SplineView& view,
                      double speed,
                      const Surroundings& around) {
    const SplineWalk& walk = agent.track;
    const Lane& lane = view.lane(walk.lane);
    const double at_least =
        std::max(Lane::kLeast_m, kLeastTicks * speed * static_cast<double>(around.ai.dt));
    const double s = static_cast<double>(walk.s);
    const bool banded = state.rubber_band && (agent.prey || agent.band != 1.0F);
    if (!changes_lanes(agent)) {
        const double left = lane.closed() ? lane.length() : lane.length() - s;
        double most = std::max(lane.segment_m(s, limits_of(lane, speed, banded, around)), at_least);
        if (view.def().change_every_m > 0.0F) {
            most = std::min(most, std::max(static_cast<double>(walk.to_change), at_least));
        }
        return std::min(most, left);
    }
    const double changed = static_cast<double>(walk.changed);
    const double blend = static_cast<double>(view.def().blend_m);
    const Lane& from = view.lane(walk.from);
    const double segment =
        std::min({blend / kChangeSegments,
                  lane.segment_m(s + changed, limits_of(lane, speed, banded, around)),
                  from.segment_m(static_cast<double>(walk.from_s) + changed,
                                 limits_of(from, speed, banded, around))});
    return std::min(std::max(segment, at_least), blend - changed);
}

/// The timetable's place moves on by `path`.
void advance(Agent& agent, const SplineView& view, double path) {
    SplineWalk& walk = agent.track;
    const Lane& lane = view.lane(walk.lane);
    walk.to_change -= static_cast<float>(path);
    if (!changes_lanes(agent)) {
        walk.s = static_cast<float>(lane.on_lane(static_cast<double>(walk.s) + path));
        return;
    }
    walk.changed += static_cast<float>(path);
    if (walk.changed >= view.def().blend_m * (1.0F - 1e-5F)) {
        walk.s = static_cast<float>(
            lane.on_lane(static_cast<double>(walk.s) + static_cast<double>(walk.changed)));
        walk.from = splines::kNoLane;
    }
}

/// The segment from its present position to `goal` in `time_s`, at most at `most` m/s. The turn
/// into the segment leads aside and costs distance; the segment's direction and speed allow for
/// that.
PathSegment segment_in_time(const Vec2& goal,
                            double time_s,
                            float most,
                            const Agent& agent,
                            const Surroundings& around) {
    const Vec2 velocity = velocity_at(agent.segment, around.ai.now - 1, around.ai.dt);
    const auto time = static_cast<float>(time_s);
    Vec2 from = around.at;
    PathSegment segment;
    for (int attempt = 0; attempt < kTurnTries; ++attempt) {
        const Vec2 path = goal - from;
        const float length = path.norm();
        if (!(length > 1e-4F)) {
            break;
        }
        segment = segment_from(around.at,
                               velocity,
                               path / length,
                               std::min(length / time, most),
                               body_of(around).acceleration,
                               around.ai.now - 1);
        from = segment.from;
    }
    segment.length = std::max((goal - segment.from).norm(), 1e-3F);
    segment.goal = goal;
    return segment;
}

/// True if the agent is near the end of its segment; else it joins the spline again from where it
/// is. False: it is too far off.
bool find_point_of_interest(Agent& agent, const SplineView& view, const Surroundings& around) {
    const auto on_it = [](float distance) {
        return static_cast<double>(distance) <= kBoardM;
    };
    // The place is the goal of its segment, if the segment still has that goal.
    if (on_it((agent.segment.goal - around.at).norm()) ||
        on_it((view.local(place_after(agent, view, 0.0)) - around.at).norm())) {
        return true;
    }
    const Vec2d here = view.world(around.at);
    const Lane& lane = view.lane(agent.track.lane);
    const Lane::NearestOnLane near =
        lane.nearest(here, static_cast<double>(agent.track.s), kReachM);
    if (near.distance_m > kPushedOffM) {
        head_for_place(agent, kJoins, lane.at(near.s).at, view);
        return false;
    }
    board(agent, lane, near.s, view, around);
    return true;
}

/// Sets the next segment, from the place that the timetable has for the end of the last one.
void set_next_segment(Agent& agent,
                      const BrainState& state,
                      const SplineView& view,
                      const Surroundings& around) {
    const double top = top_speed_of(state, around);
    const double speed = timetable_speed(agent, state, around);
    const double path = next_segment_m(agent, state, view, speed, around);
    const Vec2 goal = view.local(place_after(agent, view, path));
    const double straight = static_cast<double>((goal - around.at).norm());
    double time = time_to_due(agent, around) + path / speed;
    // A new timetable, for an agent that was held up or has just joined from beside the spline.
    if (!(straight > kLeastShare * speed * time) || !(straight < top * time + 0.5 * kBoardM)) {
        time = std::max(straight / speed, static_cast<double>(around.ai.dt));
    }
    advance(agent, view, path);
    set_due(agent, time, around);
    agent.segment = segment_in_time(goal, time, static_cast<float>(top), agent, around);
    aim_along(agent,
              Pace{agent.segment.speed / static_cast<float>(top), state.sprint},
              agent.segment.direction);
    agent.on_path = false;
    agent.again_at = kNever;
}

}  // namespace

void begin_spline(Agent& agent, const BrainState& state, const Surroundings& around) {
    ZONED_ASSERT(state.follow && around.ai.points_of_interest.tracks() != nullptr,
                 "who follows tracks has some to follow");
    const SplineView view(*state.follow, around);
    agent.track = SplineWalk{};
    agent.track.lane = view.draw(agent.rng, [](LaneId) { return true; });
    const Lane& lane = view.lane(agent.track.lane);
    const Lane::NearestOnLane near = lane.nearest(view.world(around.at));
    agent.track.s = static_cast<float>(near.s);
    head_for_place(agent, kJoins, lane.at(near.s).at, view);
}

bool follow_spline(Agent& agent, const BrainState& state, const Surroundings& around) {
    const SplineView view(*state.follow, around);
    if (agent.corner == kTrackEnds || !(timetable_speed(agent, state, around) > 0.0)) {
        return false;
    }
    if (agent.corner == kJoins) {
        const Lane& lane = view.lane(agent.track.lane);
        const Lane::NearestOnLane near = lane.nearest(view.world(around.at));
        if (near.distance_m > (around.there ? kAsNearM : kBoardM)) {
            return false;
        }
        board(agent, lane, near.s, view, around);
    } else if (!find_point_of_interest(agent, view, around)) {
        return false;
    }
    if (!changes_lanes(agent)) {
        if (view.def().change_every_m > 0.0F && !(agent.track.to_change > 0.0F)) {
            draw_change(agent, view);
        }
        const Lane& lane = view.lane(agent.track.lane);
        if (!lane.closed() &&
            static_cast<double>(agent.track.s) > lane.length() - 1e-3 * Lane::kLeast_m) {
            const Vec2d end = lane.at(lane.length()).at;
            if (!go_on_to_next(agent, end, view)) {
                head_for_place(agent, kTrackEnds, end, view);
                return false;
            }
        }
    }
    set_next_segment(agent, state, view, around);
    return true;
}

DesiredVelocity track_velocity(Agent& agent, const BrainState& state, const Surroundings& around) {
    const Vec2 target(agent.target.x(), agent.target.z());
    DesiredVelocity desired;
    desired.has_goal = true;
    desired.seeks = true;
    desired.goal = target;
    desired.direction = target - around.at;
    if (agent.corner == kTrackEnds) {
        return desired.direction.norm() > 2.0F * kArriveM ? desired : DesiredVelocity();
    }
    const SplineView view(*state.follow, around);
    const Lane& lane = view.lane(agent.track.lane);
    const Lane::NearestOnLane near =
        lane.nearest(view.world(around.at), static_cast<double>(agent.track.s), kReachM);
    if (agent.timed && around.there) {
        desired = DesiredVelocity();
        desired.far = true;  // a path may open
        return desired;
    }
    if (agent.timed || near.distance_m > kPushedOffM) {
        return desired;
    }
    agent.track.s = static_cast<float>(near.s);
    const double ahead = std::max(kAheadM, kAheadS * timetable_speed(agent, state, around));
    desired.seeks = false;
    desired.goal = view.local(lane.at(near.s + ahead).at);
    desired.direction = desired.goal - around.at;
    return desired;
}

float ahead_on_track(const Agent& agent, const Vec2& player, const Surroundings& around) {
    constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
    const PointsOfInterest& all = around.ai.points_of_interest;
    const SplinePlace place = spline_place(agent, all);
    if (agent.corner != kOnTrack || place.lane == splines::kNoLane) {
        return kNowhere;
    }
    const Lane& lane = all.tracks()->lane(place.lane);
    const Lane::NearestOnLane there = lane.nearest_by_chords(player.cast<double>() + all.origin());
    if (!(there.distance_m <= kPushedOffM)) {
        return kNowhere;
    }
    const double left =
        std::max(0.0, time_to_due(agent, around)) * static_cast<double>(agent.segment.speed);
    const double ahead = there.s - place.s + left;
    return static_cast<float>(lane.closed() ? std::remainder(ahead, lane.length()) : ahead);
}

SplinePlace spline_place(const Agent& agent, const PointsOfInterest& points_of_interest) {
    const SplineWalk& walk = agent.track;
    if (points_of_interest.tracks() == nullptr ||
        walk.lane >= points_of_interest.tracks()->lanes()) {
        return {};
    }
    const Lane& lane = points_of_interest.tracks()->lane(walk.lane);
    const double s = static_cast<double>(walk.s) +
                     (changes_lanes(agent) ? static_cast<double>(walk.changed) : 0.0);
    return {walk.lane, lane.on_lane(s), lane.length()};
}

}  // namespace zoned::ai
