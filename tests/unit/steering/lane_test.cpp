#include "server/ai/splines/lane.h"

#include "server/ai/splines/spline_network.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace zoned::ai::splines {

namespace {

using testing::HasSubstr;

SplineDef lane_ring(float radius, float width, std::uint32_t lanes) {
    SplineDef def;
    def.closed = true;
    def.width_m = width;
    def.lanes = lanes;
    for (int i = 0; i < 48; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / 48;
        def.points.push_back({radius * static_cast<float>(std::cos(angle)),
                              radius * static_cast<float>(std::sin(angle))});
    }
    return def;
}

SplineDef bends(Curve curve, bool closed) {
    SplineDef def;
    def.curve = curve;
    def.closed = closed;
    def.points = {{0, 0}, {40, 8}, {56, 36}, {32, 60}, {36, 100}, {-12, 112}, {-32, 64}, {-36, 20}};
    def.width_m = 6.0F;
    def.lanes = 3;
    return def;
}

/// Where its points are h apart, the ring of 48 points is within 0.024 h^4 / r^3 of a circle. The
/// same holds for a lane of it; its length differs by 2 pi as much.
TEST(Lane, OfARingIsACircleOfItsOwnLength) {
    const Spline ring = Spline::make(lane_ring(30.0F, 8.0F, 4)).value();
    for (std::uint32_t k = 0; k < 4; ++k) {
        const double offset = ring.offset_of(k);
        const Lane lane = Lane::make(ring, offset, 0.25).value();
        // The ring turns to the right: points on the right are inside.
        const double radius = 30.0 - offset;
        EXPECT_NEAR(lane.length(), 2.0 * std::numbers::pi * radius, 0.02) << k;
        for (double s = 0.0; s < lane.length(); s += 0.37) {
            EXPECT_NEAR(lane.at(s).at.norm(), radius, 0.003);
        }
    }
}

/// By brute force: no place of the lane is farther from a segment than was allowed. Segments are at
/// least half as long as a circle of that curvature would allow.
TEST(Lane, LegsLeadNoFartherFromItThanAllowed) {
    for (const Curve curve : {Curve::kCatmullRom, Curve::kBSpline}) {
        for (const bool closed : {false, true}) {
            const Spline track = Spline::make(bends(curve, closed)).value();
            const Lane lane = Lane::make(track, track.offset_of(0), 0.25).value();
            double longest = 0.0;
            for (const double off : {0.02, 0.1, 0.5}) {
                const SegmentLimits limits{off, 0.8, 256.0};
                for (double s = 0.0; s < lane.length() - 1.0; s += 0.9) {
                    const double segment = lane.segment_m(s, limits);
                    longest = std::max(longest, segment);
                    const Vec2d a = lane.at(s).at;
                    const Vec2d along = (lane.at(s + segment).at - a).normalized();
                    double worst = 0.0;
                    for (int k = 1; k < 64; ++k) {
                        const Vec2d p = lane.at(s + segment * k / 64.0).at - a;
                        worst = std::max(worst, std::abs(along.x() * p.y() - along.y() * p.x()));
                    }
                    // 0.5 m are always allowed, and the curvature between two samples may be a
                    // little more than at these.
                    EXPECT_LE(worst, std::max(1.02 * off, 0.125 * lane.most_curved() * 0.25))
                        << s << " + " << segment;
                    const double least = std::min({0.5 * std::sqrt(8.0 * off / lane.most_curved()),
                                                   0.5 * 0.8 / lane.most_curved(),
                                                   lane.closed() ? 1e9 : lane.length() - s});
                    EXPECT_GE(segment, std::min(least, lane.length() / 2.0) - 1e-6);
                }
            }
            EXPECT_GT(longest, 6.0);
        }
    }
}

TEST(Lane, FindsTheNearestOfItsPlaces) {
    const Spline track = Spline::make(bends(Curve::kCatmullRom, true)).value();
    const Lane lane = Lane::make(track, 1.0, 0.25).value();
    for (double s = 0.0; s < lane.length(); s += 3.3) {
        const SplinePoint p = lane.at(s);
        const Vec2d beside = p.at + 1.5 * Vec2d(-p.ahead.y(), p.ahead.x());
        const Lane::NearestOnLane all = lane.nearest(beside);
        const Lane::NearestOnLane about = lane.nearest(beside, s - 9.0, 20.0);
        // Nothing is nearer than the point straight across; others may be as near.
        EXPECT_LE(all.distance_m, 1.5 + 2e-3);
        EXPECT_LE(about.distance_m, 1.5 + 2e-3);
        EXPECT_NEAR((lane.at(all.s).at - beside).norm(), all.distance_m, 1e-9);
    }
}

/// A chord turns by an eighth at most to either side of its middle, and lies within 0.4 of the
/// error of its arc. Along the chord, places are linear to h^3 / 24 r^2.
TEST(Lane, FindsTheNearestPlaceByItsChords) {
    for (const bool closed : {true, false}) {
        SplineDef def = lane_ring(30.0F, 8.0F, 1);
        def.closed = closed;
        const Lane lane = Lane::make(Spline::make(def).value(), 0.0, 0.25).value();
        for (double s = closed ? 0.0 : 12.0; s < lane.length() - (closed ? 0.0 : 12.0); s += 0.37) {
            const SplinePoint p = lane.at(s);
            for (const double beside : {-3.0, 0.0, 3.0}) {
                const Lane::NearestOnLane near =
                    lane.nearest_by_chords(p.at + beside * Vec2d(-p.ahead.y(), p.ahead.x()));
                const double apart =
                    closed ? std::remainder(near.s - s, lane.length()) : near.s - s;
                EXPECT_NEAR(apart, 0.0, std::abs(beside) / 8.0 + 0.02)
                    << s << " beside by " << beside;
                EXPECT_NEAR(near.distance_m, std::abs(beside), 0.4 * 0.25) << s;
            }
        }
    }
}

TEST(SplineNetwork, HasLanesBothWaysWhereEveryoneKeepsToTheSameSide) {
    NamedSpline road{"road", bends(Curve::kCatmullRom, false), 0.25F, std::nullopt};
    NamedSpline ring{"ring", lane_ring(30.0F, 8.0F, 2), 0.25F, 0.5F};
    const std::vector<NamedSpline> tracks{road, ring};
    const SplineNetwork net = SplineNetwork::make(tracks).value();
    EXPECT_EQ(net.lanes(), 2U * 3U + 2U * 3U);
    const LaneId right = net.id_of({0, 2, false, false});
    const LaneId right_back = net.id_of({0, 2, false, true});
    const Lane& there = net.lane(right);
    const Lane& back = net.lane(right_back);
    // The right one of three, in each direction: on opposite sides of the middle, two lanes apart.
    const Vec2d a = there.at(there.length() / 2.0).at;
    EXPECT_NEAR(back.nearest(a).distance_m, 4.0, 0.1);
    EXPECT_EQ(net.name(right_back), "road, lane 2 of 3, backwards");
    const Lane& racing = net.lane(net.id_of({1, 0, true, false}));
    EXPECT_EQ(net.name(net.id_of({1, 0, true, false})), "ring, racing line");
    // The shortest and least curved line in a ring is some circle within it.
    EXPECT_LT(racing.length(), 2.0 * std::numbers::pi * 34.0);
    EXPECT_GT(racing.length(), 2.0 * std::numbers::pi * 26.0);
}

TEST(SplineNetwork, SaysWhichTrackIsWrong) {
    std::vector<NamedSpline> tracks{{"bad", SplineDef{}, 0.25F, std::nullopt}};
    const auto net = SplineNetwork::make(tracks);
    ASSERT_FALSE(net);
    EXPECT_THAT(net.error(), HasSubstr("track 'bad': a track has from 2"));
}

}  // namespace

}  // namespace zoned::ai::splines
