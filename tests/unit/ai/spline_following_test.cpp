// Agents that follow splines: on-screen or off-screen, they are where their timetables say.
#include "server/ai/steering/spline_following.h"

#include "server/ai/explain.h"
#include "server/ai/serialization/serialize_agents.h"
#include "tests/unit/ai/field.h"
#include "tests/unit/allocation_count.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace zoned::ai {
namespace {

using namespace test;
using splines::NamedSpline;
using splines::SplineNetwork;
using testing::HasSubstr;

constexpr float kBody = 0.9F;
/// As steering.cpp: a body farther than this from its segment is corrected.
constexpr double kOffSegment = 0.2;

NamedSpline course(splines::Curve curve, bool closed) {
    NamedSpline track;
    track.name = "course";
    track.def.curve = curve;
    track.def.closed = closed;
    track.def.points = {
        {0, 0}, {40, 8}, {56, 36}, {32, 60}, {36, 100}, {-12, 112}, {-32, 64}, {-36, 20}};
    track.def.width_m = 6.0F;
    track.def.lanes = 3;
    return track;
}

NamedSpline straight_road(const char* name, Vec2 from, Vec2 to) {
    NamedSpline track;
    track.name = name;
    track.def.points = {from, Vec2(0.5F * (from + to)), to};
    return track;
}

class Followers {
  public:
    Followers(std::vector<NamedSpline> tracks, const FollowDef& follow, bool simulated = true) {
        field.settings.points_of_interest.tracks =
            std::make_shared<const SplineNetwork>(SplineNetwork::make(tracks).value());
        field.points_of_interest =
            PointsOfInterest(field.settings.points_of_interest, Vec2d(100.0, -50.0), kDt);
        Brain brain = single(ActionKind::kFollowTrack);
        brain.states[0].follow = follow;
        brain.states[0].speed_factor = 0.8F;
        field.settings.brains = {brain};
        field.settings.viewer_range_m = simulated ? std::numeric_limits<float>::infinity() : 50.0F;
        field.types[kGuard].character.acceleration = 20.0F;
        field.types[kGuard].character.gravity = 0.0F;
        compile(field.settings, kDt);
    }

    [[nodiscard]] const SplineNetwork& net() const {
        return *field.settings.points_of_interest.tracks;
    }

    [[nodiscard]] const splines::Lane& lane(splines::LaneId id) const { return net().lane(id); }

    /// On a lane, in world coordinates of the splines.
    void add(std::uint32_t id, const Vec2d& at) {
        const Vec2 here = (at - field.points_of_interest.origin()).cast<float>();
        field.add_npc(id, kGuard, 0, Vec3(here.x(), kBody, here.y()));
        field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
        begin(*field.agents.find(EntityId(id)), field.settings.compiled[0], field.now);
    }

    [[nodiscard]] const Agent& agent(std::uint32_t id) { return *field.agents.find(EntityId(id)); }

    /// The place of its body at the end of the last tick, in the splines' coordinates.
    [[nodiscard]] Vec2d body(std::uint32_t id) {
        const Vec3& at = field.position(id);
        return Vec2(at.x(), at.z()).cast<double>() + field.points_of_interest.origin();
    }

    /// By its segment.
    [[nodiscard]] Vec2d timed(std::uint32_t id) {
        return position_at(agent(id).segment, field.now - 1, kDt).cast<double>() +
               field.points_of_interest.origin();
    }

    /// Where the timetable has it at the end of the last tick, on a lane that it does not change.
    [[nodiscard]] Vec2d due(std::uint32_t id) {
        const SplineWalk& walk = agent(id).track;
        const double left = static_cast<double>(walk.due - (field.now - 1)) * double{kDt} +
                            static_cast<double>(walk.due_s);
        return lane(walk.lane).at(static_cast<double>(walk.s) - 3.2 * left).at;
    }

    Field field;
};

FollowDef follow_lane(splines::LaneId first, std::uint16_t count = 1) {
    FollowDef follow;
    follow.draws = {{first, count, 1.0F}};
    return follow;
}

class CurveOf : public testing::TestWithParam<std::tuple<splines::Curve, bool>> {};

/// At 0.8 of 4 m/s. The timetable is that of even speed along the lane from beginning to end, and
/// is compared with one computed here. The segment is within error_m of it. The body is within 0.2
/// m of the segment, plus its walk until it is corrected.
TEST_P(CurveOf, FollowersAreWhereEvenSpeedAlongTheLaneLeads) {
    const auto [curve, closed] = GetParam();
    const double error = 0.25;
    Followers one({course(curve, closed)}, follow_lane(2));
    one.field.solid = true;
    const splines::Lane& lane = one.lane(2);
    one.add(1, lane.at(5.0).at);
    one.field.run(2.0F);
    ASSERT_EQ(one.agent(1).corner, kOnTrack);
    // By now it has come up to speed.
    const double from = lane.nearest(one.due(1)).s;
    const Tick begun = one.field.now;
    const double lap_s = (lane.length() - 12.0) / 3.2;
    double worst_segment = 0.0;
    double worst_body = 0.0;
    double drift = 0.0;
    while (static_cast<double>(one.field.now - begun) * double{kDt} <
           (closed ? 4.0 : 1.0) * lap_s) {
        one.field.step();
        const double walked = 3.2 * static_cast<double>(one.field.now - begun) * double{kDt};
        const Vec2d ideal = lane.at(from + walked).at;
        worst_segment = std::max(worst_segment, (one.timed(1) - ideal).norm());
        worst_body = std::max(worst_body, (one.body(1) - ideal).norm());
        drift = std::max(drift, (one.due(1) - ideal).norm());
    }
    EXPECT_LT(drift, 0.01) << "time and path are summed to the last bit but some";
    EXPECT_LT(worst_segment, error);
    EXPECT_LT(worst_body, error + kOffSegment + 3.2 / 30.0);
    EXPECT_GT(worst_segment, 0.02) << "segments are straight";
}

INSTANTIATE_TEST_SUITE_P(Tracks,
                         CurveOf,
                         testing::Combine(testing::Values(splines::Curve::kCatmullRom,
                                                          splines::Curve::kBSpline),
                                          testing::Bool()));

TEST(FollowTrack, WhoNobodySeesIsWhereItWouldHaveWalked) {
    Followers all({course(splines::Curve::kCatmullRom, true)}, follow_lane(0, 3), true);
    Followers some({course(splines::Curve::kCatmullRom, true)}, follow_lane(0, 3), false);
    std::uint64_t events = 0;
    for (Followers* side : {&all, &some}) {
        side->field.solid = true;
        for (std::uint32_t id = 1; id <= 20; ++id) {
            side->add(id, side->lane(1).at(12.0 * id).at);
        }
    }
    for (int minute = 0; minute < 5; ++minute) {
        for (int k = 0; k < 60 * 30; ++k) {
            all.field.step();
            events += some.field.step().events;
        }
        for (std::uint32_t id = 1; id <= 20; ++id) {
            ASSERT_EQ(some.agent(id).tier, Tier::kSuspended);
            EXPECT_EQ(some.agent(id).track.lane, all.agent(id).track.lane);
            EXPECT_LT((some.timed(id) - all.body(id)).norm(), kOffSegment + 3.2 / 30.0) << id;
        }
    }
    // A segment of this course is 4 m long or more: 1.25 s.
    EXPECT_LT(events, 20U * 300U);
}

TEST(FollowTrack, ResumesWhereItIsDueWithoutAJump) {
    Followers some({course(splines::Curve::kCatmullRom, true)}, follow_lane(0), false);
    some.field.solid = true;
    some.add(1, some.lane(0).at(3.0).at);
    some.field.run(31.0F);
    ASSERT_EQ(some.agent(1).tier, Tier::kSuspended);
    const Vec2 near = (some.due(1) - some.field.points_of_interest.origin()).cast<float>();
    some.field.add_player(900, Vec3(near.x() + 20.0F, kBody, near.y()));
    for (int k = 0; k < 20; ++k) {
        some.field.step();
    }
    ASSERT_EQ(some.agent(1).tier, Tier::kActive);
    for (int k = 0; k < 300; ++k) {
        const Vec2d before = some.body(1);
        some.field.step();
        EXPECT_LT((some.body(1) - before).norm(), 4.0 / 30.0 + 1e-3);
        EXPECT_LT((some.body(1) - some.due(1)).norm(), 0.25 + kOffSegment + 3.2 / 30.0);
    }
}

/// Three lanes of 2 m, drawn anew each 20 m. Over 8 m it changes lanes, and in a tick it never
/// moves farther than it walks.
TEST(FollowTrack, ChangesLanesSmoothly) {
    FollowDef follow = follow_lane(0, 3);
    follow.blend_m = 8.0F;
    follow.change_every_m = 20.0F;
    Followers one({course(splines::Curve::kBSpline, true)}, follow);
    one.field.solid = true;
    one.add(1, one.lane(1).at(3.0).at);
    one.field.run(2.0F);
    int changes = 0;
    bool changing = false;
    Vec2d heading = Vec2d::Zero();
    double sharpest = 1.0;
    for (int k = 0; k < 300 * 30; ++k) {
        const Vec2d before = one.timed(1);
        one.field.step();
        const Vec2d step = one.timed(1) - before;
        EXPECT_LT(step.norm(), 4.0 / 30.0 + 0.01);
        EXPECT_GT(step.norm(), 0.6 * 3.2 / 30.0);
        if (heading.norm() > 0.0) {
            sharpest = std::min(sharpest, heading.dot(step.normalized()));
        }
        heading = step.normalized();
        const bool now = one.agent(1).track.from != splines::kNoLane;
        changes += now && !changing ? 1 : 0;
        changing = now;
        double nearest = 1e9;
        for (splines::LaneId id = 0; id < 3; ++id) {
            nearest = std::min(nearest, one.lane(id).nearest(one.timed(1)).distance_m);
        }
        // Between two lanes it is a metre from both at the most.
        EXPECT_LT(nearest, now ? 1.0 + 0.25 : 0.25);
    }
    // 960 m, a draw each 20 m and 8 m for each of the two thirds that change: 38 draws, 25 changes,
    // their deviation 3.
    EXPECT_NEAR(changes, 25, 12);
    // 20 m/s2 turn 3.2 m/s by 0.21 rad in a tick.
    EXPECT_GT(sharpest, std::cos(0.22));
}

/// A crossroads: an agent that comes in leaves by one of the other two roads, as their weights say.
/// Where a road ends it stands.
TEST(FollowTrack, GoesOnWhereTheNextTrackBegins) {
    FollowDef follow = follow_lane(0);
    const std::vector<NamedSpline> roads{straight_road("in", {0, 0}, {30, 0}),
                                         straight_road("left", {30, 0}, {50, -30}),
                                         straight_road("right", {30, 0}, {50, 30})};
    // Each has one lane there and one back.
    follow.draws = {{0, 1, 1.0F}, {2, 1, 3.0F}, {4, 1, 1.0F}};
    Followers many(roads, follow);
    many.field.solid = true;
    int left = 0;
    int right = 0;
    for (std::uint32_t id = 1; id <= 200; ++id) {
        many.add(id, Vec2d(2.0, 0.0));
    }
    many.field.run(60.0F);
    for (std::uint32_t id = 1; id <= 200; ++id) {
        const Vec2d at = many.body(id);
        const bool is_left = (at - Vec2d(50, -30)).norm() < 1.2;
        const bool is_right = (at - Vec2d(50, 30)).norm() < 1.2;
        EXPECT_TRUE(is_left || is_right) << id << ": " << at.transpose();
        left += is_left ? 1 : 0;
        right += is_right ? 1 : 0;
        EXPECT_EQ(many.field.entities.velocity[many.field.entities.find(EntityId(id))].norm(), 0);
    }
    // 3 to 1 of 200: 150 of a deviation of 6.
    EXPECT_NEAR(left, 150, 25);
    EXPECT_EQ(left + right, 200);
}

TEST(FollowTrack, GoesToAndFroWhereItMayTurnBack) {
    FollowDef follow;
    follow.draws = {{0, 1, 1.0F}, {1, 1, 1.0F}};
    follow.blend_m = 2.0F;
    Followers one({straight_road("road", {0, 0}, {30, 0})}, follow);
    one.field.solid = true;
    one.add(1, Vec2d(15.0, 0.0));
    int turns = 0;
    splines::LaneId before = 7;
    double low = 15.0;
    double high = 15.0;
    for (int k = 0; k < 100 * 30; ++k) {
        one.field.step();
        turns += one.agent(1).track.lane != before ? 1 : 0;
        before = one.agent(1).track.lane;
        low = std::min(low, one.body(1).x());
        high = std::max(high, one.body(1).x());
    }
    // 320 m; it takes 2 v / a = 0.32 s to turn about, in which it goes on for 0.26 m.
    EXPECT_NEAR(turns, 11, 2);
    EXPECT_NEAR(low, 0.0, 0.6);
    EXPECT_NEAR(high, 30.0, 0.6);
}

TEST(FollowTrack, WhoIsPushedOffComesBackAndGoesOn) {
    for (const double push : {3.0, 20.0}) {
        Followers one({course(splines::Curve::kCatmullRom, true)}, follow_lane(1));
        one.field.solid = true;
        one.add(1, one.lane(1).at(10.0).at);
        one.field.run(5.0F);
        one.field.position(1).x() += static_cast<float>(push);
        one.field.run(20.0F);
        EXPECT_LT((one.body(1) - one.due(1)).norm(), 0.25 + kOffSegment + 3.2 / 30.0);
        EXPECT_EQ(one.agent(1).corner, kOnTrack);
    }
}

TEST(FollowTrack, IsTakenAlongToAnotherZoneToTheCentimetre) {
    Followers one({course(splines::Curve::kCatmullRom, true)}, follow_lane(1));
    Followers other({course(splines::Curve::kCatmullRom, true)}, follow_lane(1));
    one.field.solid = other.field.solid = true;
    one.add(1, one.lane(1).at(10.0).at);
    one.field.run(5.0F);
    // A zone whose origin lies 64 m farther on.
    other.field.points_of_interest =
        PointsOfInterest(other.field.settings.points_of_interest, Vec2d(164.0, -50.0), kDt);
    other.field.now = one.field.now;
    Agent agent = one.field.agents.take(EntityId(1));
    shift(agent, Vec3(-64.0F, 0.0F, 0.0F));
    const Vec3 at = one.field.position(1) - Vec3(64.0F, 0.0F, 0.0F);
    const Vec3 velocity = one.field.entities.velocity[0];
    const world::Row row = other.field.entities.add(EntityId(1), kGuard);
    other.field.entities.position[row] = at;
    other.field.entities.velocity[row] = velocity;
    other.field.entities.set(row, world::kGrounded, true);
    other.field.agents.add(agent);
    const SplineWalk before = agent.track;
    other.field.run(0.1F);
    EXPECT_EQ(other.agent(1).track.lane, before.lane);
    for (int k = 0; k < 300; ++k) {
        other.field.step();
        EXPECT_LT((other.body(1) - other.due(1)).norm(), 0.25 + kOffSegment + 3.2 / 30.0);
    }
}

TEST(FollowTrack, IsWrittenDownAndReadAgainAndRefusedWhereThereIsNoSuchTrack) {
    Followers one({course(splines::Curve::kCatmullRom, true)}, follow_lane(0, 3));
    one.add(1, one.lane(1).at(10.0).at);
    one.field.run(5.0F);
    std::vector<std::uint8_t> bytes;
    save_agents(one.field.agents, one.field.steps, one.field.points_of_interest, bytes);
    Followers same({course(splines::Curve::kCatmullRom, true)}, follow_lane(0, 3));
    EXPECT_EQ(load_agents(bytes,
                          same.field.settings,
                          same.field.agents,
                          same.field.steps,
                          same.field.points_of_interest),
              "");
    core::StateHash a;
    core::StateHash b;
    hash(a, one.agent(1));
    hash(b, same.agent(1));
    EXPECT_EQ(a.value(), b.value());
    Followers none({straight_road("road", {0, 0}, {3, 0})}, follow_lane(0));
    EXPECT_THAT(load_agents(bytes,
                            none.field.settings,
                            none.field.agents,
                            none.field.steps,
                            none.field.points_of_interest),
                HasSubstr("track that there is not"));
}

TEST(FollowTrack, IsExplained) {
    Followers one({course(splines::Curve::kCatmullRom, true)}, follow_lane(1));
    one.add(1, one.lane(1).at(10.0).at);
    one.field.run(5.0F);
    const std::string text = explain(one.agent(1),
                                     one.field.settings.brains[0],
                                     one.field.settings.compiled[0],
                                     Percept::none(),
                                     Vec2::Zero(),
                                     one.field.points_of_interest,
                                     one.field.now,
                                     kDt);
    EXPECT_THAT(text, HasSubstr("on track course, lane 1 of 3: at "));
}

/// A follower on a round course costs as many events as a patrol round a square whose sides are as
/// long as its segments. The step allocates nothing for it (allocation_test counts).
TEST(FollowTrack, LegsAreAsLongAsTheErrorAllows) {
    std::array<std::uint64_t, 2> events{};
    for (const int k : {0, 1}) {
        NamedSpline track = course(splines::Curve::kBSpline, true);
        track.error_m = k == 0 ? 0.25F : 1.0F;
        Followers some({track}, follow_lane(1), false);
        some.field.types[kGuard].character.acceleration = 0.0F;
        some.add(1, some.lane(1).at(3.0).at);
        for (int tick = 0; tick < 300 * 30; ++tick) {
            events[static_cast<std::size_t>(k)] += some.field.step().events;
        }
    }
    // Lengths go by the square root of the error where bends are longer than segments.
    EXPECT_NEAR(static_cast<double>(events[0]) / static_cast<double>(events[1]), 2.0, 0.5);
}

/// A guard at 0.8 of 4 m/s that follows the first lane, with a band between 2.56 and 3.84 m/s.
Brain banded_follower(const learning::RubberBand& band) {
    Brain brain = single(ActionKind::kFollowTrack);
    brain.perception_m = 5000.0F;
    brain.states[0].follow = follow_lane(0);
    brain.states[0].speed_factor = 0.8F;
    brain.states[0].rubber_band = band;
    return brain;
}

/// The lead of a player at `speed` over a follower on a straight road after two minutes, m. It
/// starts `lead` m ahead and walks `beside` m beside the road.
double lead_after(const learning::RubberBand& band, float lead, float speed, float beside = 0.0F) {
    Followers one({straight_road("road", {0, 0}, {2000, 0})}, follow_lane(0));
    one.field.solid = true;
    one.field.settings.brains = {banded_follower(band)};
    compile(one.field.settings, kDt);
    one.add(1, Vec2d(200.0, 0.0));
    const Vec2d origin = one.field.points_of_interest.origin();
    const Vec2 start = (Vec2d(200.0, beside) - origin).cast<float>();
    one.field.add_player(2, Vec3(start.x() + lead, kBody, start.y()));
    for (int tick = 0; tick < 120 * 30; ++tick) {
        one.field.position(2).x() += speed * kDt;
        one.field.step();
    }
    return static_cast<double>(one.field.position(2).x() - one.field.position(1).x());
}

/// The gap is measured along the track and the speed is that of a timetable, so the balance is
/// known: factor 1 + 0.5 (gap - 10) / 10 beyond 10 m. The body is within 0.2 m of its segment, and
/// a segment lasts a second, in which what is left of the approach (2 minutes at a time constant of
/// 10 m / (0.5 * 3.2 m/s)) is nothing.
TEST(RubberBandOnATrack, HoldsAFollowerAtTheDistanceThatFollowsFromItsGain) {
    const learning::RubberBand band{10.0F, 0.5F, 0.8F, 1.2F, 0.2F};
    constexpr double kOff = kOffSegment + 3.84 / 30.0;
    // Behind a player at 3.6 m/s, which is 1.125 of 3.2: 10 (1 + 0.125 / 0.5) m.
    EXPECT_NEAR(lead_after(band, 30.0F, 3.6F), 12.5, kOff);
    // Before a player at 2.8 m/s as far.
    EXPECT_NEAR(lead_after(band, -30.0F, 2.8F), -12.5, kOff);
    // Beyond the caps, 3.84 and 2.56 m/s, it falls back or leaves the player behind.
    EXPECT_GT(lead_after(band, 20.0F, 4.2F), 20.0 + 120.0 * 0.3);
    EXPECT_LT(lead_after(band, -20.0F, 2.2F), -20.0 - 120.0 * 0.3);
}

TEST(RubberBandOnATrack, IsSlackNearThePlayerAndWherePlayersDoNotDrive) {
    const learning::RubberBand band{10.0F, 0.5F, 0.8F, 1.2F, 0.2F};
    constexpr double kOff = kOffSegment + 3.2 / 30.0;
    EXPECT_NEAR(lead_after(band, 9.0F, 3.2F), 9.0, kOff);
    EXPECT_NEAR(lead_after(band, -9.0F, 3.2F), -9.0, kOff);
    // 7.9 m beside the lane the player counts, 8.1 m do not: the follower keeps to 3.2 m/s.
    EXPECT_NEAR(lead_after(band, 30.0F, 3.6F, 7.9F), 12.5, kOff + 0.2);
    EXPECT_NEAR(lead_after(band, 30.0F, 3.6F, 8.1F), 30.0 + 120.0 * 0.4, kOff);
}

/// Eight rivals within 90 m of the beginning of a course, on both sides, and a player who drives
/// round it from there.
class RacingField : public Followers {
  public:
    explicit RacingField(const learning::RubberBand& band, bool simulated = true)
        : Followers({course(splines::Curve::kBSpline, true)}, follow_lane(0), simulated) {
        field.solid = true;
        field.settings.brains = {banded_follower(band)};
        compile(field.settings, kDt);
        for (std::uint32_t k = 0; k < 8; ++k) {
            add(1 + k, lane(0).at(lane(0).on_lane(25.0 * k - 87.5)).at);
        }
    }

    void add_driver() { field.add_player(20, driver()); }

    /// The player drives at `speed` m/s for a tick.
    void drive(double speed) {
        driven_ += speed * double{kDt};
        field.position(20) = driver();
        field.step();
    }

    /// The rivals within so far of the player along the lane, m.
    [[nodiscard]] int within(double metres) {
        int near = 0;
        for (std::uint32_t id = 1; id <= 8; ++id) {
            const double s = lane(0).nearest(body(id)).s;
            const double apart = std::remainder(s - driven_, lane(0).length());
            near += std::abs(apart) < metres ? 1 : 0;
        }
        return near;
    }

  private:
    [[nodiscard]] Vec3 driver() const {
        const Vec2d at =
            lane(0).at(lane(0).on_lane(driven_)).at - field.points_of_interest.origin();
        return {static_cast<float>(at.x()), kBody, static_cast<float>(at.y())};
    }

    double driven_ = 0.0;
};

/// The player takes 0.94 or 1.06 of a rival's own speed, so in balance rivals that are held are
/// within 10 (1 + 0.0625 / 0.5) m, and the others are 10 (2 - 0.0625 / 0.5) m away or farther. The
/// farthest has 76 m to come at 0.44 m/s or more.
TEST(RubberBandOnATrack, KeepsThatManyRivalsNearThePlayerAndTheOthersAway) {
    for (const double speed : {3.0, 3.4}) {
        for (const std::uint32_t rivals : {0U, 3U}) {
            RacingField race({10.0F, 0.5F, 0.8F, 1.2F, 0.2F, rivals});
            race.add_driver();
            const int expected = rivals == 0 ? 8 : static_cast<int>(rivals);
            for (int tick = 0; tick < 280 * 30; ++tick) {
                race.drive(speed);
                if (tick > 260 * 30) {
                    ASSERT_EQ(race.within(12.0), expected) << rivals << " at " << speed;
                    ASSERT_EQ(race.within(18.0), expected) << rivals << " at " << speed;
                }
            }
        }
    }
}

TEST(RubberBandOnATrack, AllocatesNothingWhileItCountsRivals) {
    RacingField race({10.0F, 0.5F, 0.8F, 1.2F, 0.2F, 3});
    race.add_driver();
    // A whole round, so that the index has had its greatest extent.
    for (int tick = 0; tick < 180 * 30; ++tick) {
        race.drive(3.0);
    }
    const std::uint64_t allocated = allocation_count();
    for (int tick = 0; tick < 300; ++tick) {
        race.drive(3.0);
    }
    EXPECT_EQ(allocation_count(), allocated);
}

/// No index of entities is asked for, bands are exactly 1, and where suspension is on all rivals go
/// from event to event.
TEST(RubberBandOnATrack, CostsNothingWhereNoPlayerDrives) {
    for (const bool simulated : {true, false}) {
        RacingField race({10.0F, 0.5F, 0.8F, 1.2F, 0.2F, 3}, simulated);
        race.field.run(1.0F);
        race.add_driver();
        for (int tick = 0; tick < 300; ++tick) {
            race.drive(3.0);
        }
        EXPECT_GT(race.agent(3).band, 1.0F);  // 34 m behind at first, and the third nearest
        race.field.entities.set(race.field.entities.find(EntityId(20)), world::kHidden, true);
        race.field.run(20.0F);
        int asked = 0;
        for (int tick = 0; tick < 30; ++tick) {
            AiContext ai = race.field.context();
            ai.make_grid = [&]() -> const spatial::PointGrid& {
                ++asked;
                return race.field.grid;
            };
            const AiReport report = race.field.steps.run(ai);
            EXPECT_EQ(report.active, simulated ? 8U : 0U);
            ++race.field.now;
        }
        EXPECT_EQ(asked, 0);
        for (std::uint32_t id = 1; id <= 8; ++id) {
            EXPECT_EQ(race.agent(id).band, 1.0F);
        }
    }
}

}  // namespace
}  // namespace zoned::ai
