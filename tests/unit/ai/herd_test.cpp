// build: computes
// Off-screen herds: they roam as herds in view do.
#include "tests/unit/ai/field.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace zoned::ai {
namespace {

using namespace test;

constexpr std::uint32_t kHerd = 24;
constexpr float kRadius = 12.0F;

/// Properties of a herd, in one number each.
enum Figure : std::size_t {
    kProgress,  ///< of its centre along the round trip, m
    kBeside,    ///< mean distance of the centre from the round trip (along one), or from home, m
    kSpread,    ///< root mean square of the distances to the centre, m
    kBreath,    ///< standard deviation of that over time, m
    kStride,    ///< mean distance that the centre moves in a second, m
    kMemory,    ///< correlation of the centre's movements in two seconds that are 4 s apart
    kFigures
};

using Figures = std::array<double, kFigures>;

const std::array<Vec2, 4> kStops{Vec2(0.0F, 0.0F),
                                 Vec2(80.0F, 10.0F),
                                 Vec2(70.0F, 70.0F),
                                 Vec2(-10.0F, 50.0F)};

struct OnTour {
    float along = 0.0F;   ///< of the nearest point, m from the first stop
    float beside = 0.0F;  ///< distance, m
};

float tour_length() {
    float length = 0.0F;
    for (std::size_t k = 0; k < kStops.size(); ++k) {
        length += (kStops[(k + 1) % kStops.size()] - kStops[k]).norm();
    }
    return length;
}

OnTour on_tour(const Vec2& at) {
    OnTour best{0.0F, std::numeric_limits<float>::infinity()};
    float before = 0.0F;
    for (std::size_t k = 0; k < kStops.size(); ++k) {
        const Vec2 piece = kStops[(k + 1) % kStops.size()] - kStops[k];
        const float share = std::clamp(piece.dot(at - kStops[k]) / piece.squaredNorm(), 0.0F, 1.0F);
        const float beside = (kStops[k] + share * piece - at).norm();
        if (beside < best.beside) {
            best = {before + share * piece.norm(), beside};
        }
        before += piece.norm();
    }
    return best;
}

/// A herd of sheep on a plain.
class Herd {
  public:
    Herd(float viewer_range_m,
         bool along,
         std::uint64_t seed,
         bool reversed = false,
         std::uint32_t size = kHerd)
        : along_(along),
          size_(size) {
        field.settings.brains = {single(ActionKind::kFlock, kRadius)};
        field.settings.brains[0].states[0].speed_factor = 0.7F;
        PoiSettings points_of_interest;
        for (std::size_t k = 0; k < kStops.size(); ++k) {
            PointOfInterestDef place;
            place.name = std::to_string(k);
            place.at = kStops[k].cast<double>();
            points_of_interest.points_of_interest.push_back(place);
            if (along) {
                field.settings.brains[0].states[0].along.push_back(static_cast<std::uint16_t>(k));
            }
        }
        field.points_of_interest = PointsOfInterest(points_of_interest, Vec2d::Zero(), kDt);
        field.settings.viewer_range_m = viewer_range_m;
        field.solid = true;
        field.types[kSheep].character.acceleration = 20.0F;
        compile(field.settings, kDt);
        core::Rng rng(seed, 3);
        std::vector<Vec3> places_at(size);
        for (Vec3& at : places_at) {
            const float z = rng.range(-20.0F, 20.0F);
            const float x = rng.range(-20.0F, 20.0F);
            at = Vec3(x, 0.9F, z);
        }
        for (std::uint32_t k = 1; k <= size; ++k) {
            add(reversed ? size + 1 - k : k, places_at[(reversed ? size + 1 - k : k) - 1]);
        }
    }

    void add(std::uint32_t id, const Vec3& at) {
        field.add_npc(id, kSheep, 0, at);
        field.entities.set(field.entities.find(EntityId(id)), world::kGrounded, true);
        field.agents.find(EntityId(id))->home = Vec3(0.0F, at.y(), 0.0F);
    }

    /// Where an animal is, on-screen or off-screen.
    [[nodiscard]] Vec2 at(std::uint32_t id) {
        const Agent& agent = *field.agents.find(EntityId(id));
        const Vec3& body = field.position(id);
        return agent.tier == Tier::kSuspended ? position_at(agent.segment, field.now - 1, kDt)
                                              : Vec2(body.x(), body.z());
    }

    [[nodiscard]] Vec2 centre() {
        Vec2 sum = Vec2::Zero();
        for (std::uint32_t id = 1; id <= size_; ++id) {
            sum += at(id);
        }
        return sum / static_cast<float>(size_);
    }

    /// Root mean square of the distances to it, m.
    [[nodiscard]] double spread() {
        const Vec2 middle = centre();
        double square = 0.0;
        for (std::uint32_t id = 1; id <= size_; ++id) {
            square += static_cast<double>((at(id) - middle).squaredNorm()) / size_;
        }
        return std::sqrt(square);
    }

    /// Means over `seconds`, after ten seconds in which it comes together.
    Figures live(int seconds) {
        field.run(10.0F);
        Figures figures{};
        Vec2 before = centre();
        const double share = 1.0 / seconds;
        double squares = 0.0;
        std::vector<Vec2> paths;
        for (int s = 0; s < seconds; ++s) {
            field.run(1.0F);
            const Vec2 now = centre();
            float turn = on_tour(now).along - on_tour(before).along;
            turn -= tour_length() * std::round(turn / tour_length());
            figures[kProgress] += static_cast<double>(turn);
            figures[kBeside] +=
                share * static_cast<double>(along_ ? on_tour(now).beside : now.norm());
            figures[kSpread] += share * spread();
            squares += share * spread() * spread();
            paths.emplace_back(now - before);
            figures[kStride] += share * static_cast<double>(paths.back().norm());
            before = now;
        }
        figures[kBreath] = std::sqrt(std::max(0.0, squares - figures[kSpread] * figures[kSpread]));
        figures[kMemory] = memory(paths);
        return figures;
    }

    Field field;

  private:
    static double memory(const std::vector<Vec2>& paths) {
        constexpr std::size_t kLag = 4;
        double together = 0.0;
        double squares = 1e-12;
        for (std::size_t s = kLag; s < paths.size(); ++s) {
            together += static_cast<double>(paths[s].dot(paths[s - kLag]));
            squares += static_cast<double>(paths[s].squaredNorm());
        }
        return together / squares;
    }

    bool along_;
    std::uint32_t size_;
};

constexpr float kAll = std::numeric_limits<float>::infinity();
constexpr float kNobody = 50.0F;
constexpr int kHerdSeeds = 12;

struct Sample {
    double sum = 0.0;
    double squares = 0.0;

    void add(double value) {
        sum += value / kHerdSeeds;
        squares += value * value / kHerdSeeds;
    }

    [[nodiscard]] double mean() const { return sum; }

    /// Variance of the mean.
    [[nodiscard]] double variance() const {
        return std::max(0.0, squares - sum * sum) / (kHerdSeeds - 1);
    }
};

using Samples = std::array<Sample, kFigures>;

/// The obstacles where a herd of this size lives.
struct Pasture {
    std::uint32_t herd = kHerd;
    std::vector<motion::StaticBox> boxes{};
    float speed_factor = 0.7F;
};

/// A player may stand at (`watcher_m`, 0).
Samples samples_of(int seconds,
                   float viewer_range_m,
                   bool along,
                   float watcher_m = 0.0F,
                   const Pasture& pasture = {}) {
    Samples samples;
    for (int seed = 1; seed <= kHerdSeeds; ++seed) {
        Herd herd(viewer_range_m, along, static_cast<std::uint64_t>(seed), false, pasture.herd);
        herd.field.statics = {pasture.boxes, 0.0F};
        herd.field.settings.brains[0].states[0].speed_factor = pasture.speed_factor;
        compile(herd.field.settings, kDt);
        if (watcher_m > 0.0F) {
            herd.field.add_player(900, Vec3(watcher_m, 0.9F, 0.0F));
            // How often an animal steers would depend on how near the watcher is.
            herd.field.settings.far_m = 0.0F;
        }
        const Figures figures = herd.live(seconds);
        for (std::size_t f = 0; f < kFigures; ++f) {
            samples[f].add(figures[f]);
        }
    }
    return samples;
}

/// Welch's test of two means: of 22 degrees of freedom or fewer, |t| exceeds 2.82 or more in one of
/// a hundred cases in which nothing differs; of 11, the fewest here, 3.11.
double apart(const Samples& a, const Samples& b, Figure f) {
    return std::abs(a[f].mean() - b[f].mean()) /
           std::sqrt(std::max(1e-12, a[f].variance() + b[f].variance()));
}

/// A step takes a second, and between its ends an animal is on the chord of its arc. On a circle of
/// radius r the chord lies inside by (v s)^2 / 12 r on average. So the paths of a second are
/// shorter by (v s / r)^2 / 12. At 1.4 m/s about 3 m, the sharpest turn of a herd here, that is 1.8
/// %.
constexpr double kChordShare = 0.018;

/// Whether means agree to within the bound of Welch's test, or as well as they can.
bool alike(const Samples& seen, const Samples& unseen, Figure f, double bound) {
    const double off = std::abs(seen[f].mean() - unseen[f].mean());
    return apart(seen, unseen, f) < bound ||
           (f == kStride && off < kChordShare * seen[kStride].mean());
}

class HerdOffscreen : public testing::TestWithParam<bool> {};

TEST_P(HerdOffscreen, RoamsAsOneThatIsSeen) {
    const Samples seen = samples_of(300, kAll, GetParam());
    const Samples unseen = samples_of(300, kNobody, GetParam());
    for (const Figure f : {kProgress, kBeside, kSpread, kBreath, kStride, kMemory}) {
        EXPECT_TRUE(alike(seen, unseen, f, 2.82))
            << "figure " << f << ": " << seen[f].mean() << " seen, " << unseen[f].mean();
        RecordProperty("seen_" + std::to_string(f), std::to_string(seen[f].mean()));
        RecordProperty("unseen_" + std::to_string(f), std::to_string(unseen[f].mean()));
    }
    // It does something: 200 s of the 300 along the path, or about its home.
    EXPECT_GT(unseen[kSpread].mean(), 1.0);
    EXPECT_TRUE(!GetParam() || unseen[kProgress].mean() > 200.0 * 1.4);
}

/// A few, many, and as many as before with one house on their path and another beside their home.
TEST_P(HerdOffscreen, RoamsAsOneThatIsSeenWhateverItsSizeAndWhatIsInTheWay) {
    // 36 comparisons: one in 3,600 cases each, so that one in a hundred fails by chance.
    constexpr double kOfMany = 4.4;
    motion::StaticBox house;
    house.centre = Vec3(40.0F, 2.0F, 5.0F);
    house.half_extents = Vec3(3.0F, 2.0F, 3.0F);
    motion::StaticBox shed;
    shed.centre = Vec3(0.0F, 2.0F, 8.0F);
    shed.half_extents = Vec3(2.0F, 2.0F, 2.0F);
    for (const Pasture& pasture : {Pasture{6}, Pasture{60}, Pasture{kHerd, {house, shed}}}) {
        const Samples seen = samples_of(150, kAll, GetParam(), 0.0F, pasture);
        const Samples unseen = samples_of(150, kNobody, GetParam(), 0.0F, pasture);
        for (const Figure f : {kProgress, kBeside, kSpread, kBreath, kStride, kMemory}) {
            EXPECT_TRUE(alike(seen, unseen, f, kOfMany))
                << pasture.herd << ", " << pasture.boxes.size() << " houses, figure " << f << ": "
                << seen[f].mean() << " seen, " << unseen[f].mean();
        }
    }
}

/// A player stands where the herd passes, so that part of it is seen.
TEST_P(HerdOffscreen, RoamsAsOneThatIsSeenWhereSomeAre) {
    const float watcher_m = GetParam() ? 30.0F : 29.0F;
    const Samples seen = samples_of(150, kAll, GetParam(), watcher_m);
    const Samples some = samples_of(150, 1.0F, GetParam(), watcher_m);
    for (const Figure f : {kProgress, kBeside, kSpread}) {
        EXPECT_LT(apart(seen, some, f), 2.82)
            << "figure " << f << ": " << seen[f].mean() << " seen, " << some[f].mean();
    }
    Herd one(1.0F, GetParam(), 1);
    one.field.add_player(900, Vec3(watcher_m, 0.9F, 0.0F));
    int mixed = 0;
    for (int s = 0; s < 150; ++s) {
        one.field.run(1.0F);
        const std::size_t active = one.field.agents.active().size();
        mixed += active > 0 && active < kHerd ? 1 : 0;
    }
    EXPECT_GT(mixed, 10) << "some of it was seen";
}

/// The comparison finds the difference to a herd that walks 3 % more slowly.
TEST_P(HerdOffscreen, IsToldFromASlowerOne) {
    const Samples seen = samples_of(150, kAll, GetParam());
    const Samples slower =
        samples_of(150, kNobody, GetParam(), 0.0F, Pasture{kHerd, {}, 0.7F * 0.97F});
    EXPECT_FALSE(alike(seen, slower, kStride, 4.4));
}

INSTANTIATE_TEST_SUITE_P(AlongAWayAndAtHome, HerdOffscreen, testing::Bool());

TEST(FlockSums, AreTheSameEightAtATime) {
    constexpr std::size_t kAnimals = 403;
    constexpr float kTime_s = 0.4F;
    core::Rng rng(3, 1);
    std::array<std::vector<float>, 4> columns;
    std::vector<EntityId> entity;
    for (std::size_t n = 0; n < kAnimals; ++n) {
        for (std::size_t c = 0; c < columns.size(); ++c) {
            const float size = c < 2 ? 20.0F : 3.0F;
            // Some stand on the same spot.
            columns[c].push_back(n % 50 == 1 ? columns[c].back() : rng.range(-size, size));
        }
        entity.emplace_back(static_cast<std::uint32_t>(1 + (n * 7) % kAnimals));
    }
    for (std::vector<float>& column : columns) {
        column.resize(kAnimals + 8, 1e9F);
    }
    const FlockSum::Columns animals{
        columns[0].data(), columns[1].data(), columns[2].data(), columns[3].data(), entity.data()};
    for (const auto& [begin, end] :
         {std::pair<std::size_t, std::size_t>{0, kAnimals}, {5, 6}, {17, 190}, {60, 60}, {9, 25}}) {
        for (std::size_t self = 0; self < kAnimals; self += 3) {
            const auto place = [&](std::size_t n) {
                return Vec2(columns[0][n] + columns[2][n] * kTime_s,
                            columns[1][n] + columns[3][n] * kTime_s);
            };
            const Vec2 here = place(self);
            FlockSum one_by_one(12.0F);
            for (std::size_t n = begin; n < end; ++n) {
                if (n != self) {
                    one_by_one.add(place(n) - here,
                                   Vec2(columns[2][n], columns[3][n]),
                                   entity[self] < entity[n]);
                }
            }
            FlockSum together(12.0F);
            together.add_run(animals, begin, end, self, here, kTime_s);
            const FlockPull pull;
            ASSERT_EQ(one_by_one.heading(here, pull), together.heading(here, pull))
                << begin << " to " << end << ", " << self;
        }
    }
}

TEST(HerdOffscreenOnes, DependNotOnRows) {
    Herd one(kNobody, true, 1);
    Herd other(kNobody, true, 1, true);
    one.field.run(60.0F);
    other.field.run(60.0F);
    for (std::uint32_t id = 1; id <= kHerd; ++id) {
        EXPECT_EQ(one.at(id), other.at(id)) << id;
    }
}

/// A pen of 16 m by 16 m, which has less room than the herd wants.
TEST(HerdOffscreenOnes, StayBehindTheirWalls) {
    for (const bool along : {true, false}) {
        Herd herd(kNobody, along, 1);
        std::vector<motion::StaticBox> walls;
        for (const float side : {-8.0F, 8.0F}) {
            motion::StaticBox wall;
            wall.centre = Vec3(side, 1.0F, 0.0F);
            wall.half_extents = Vec3(0.2F, 1.0F, 8.2F);
            walls.push_back(wall);
            wall.centre = Vec3(0.0F, 1.0F, side);
            wall.half_extents = Vec3(8.2F, 1.0F, 0.2F);
            walls.push_back(wall);
        }
        herd.field.statics = {walls, 0.0F};
        for (std::uint32_t id = 1; id <= kHerd; ++id) {
            herd.field.position(id) *= 0.3F;
            herd.field.position(id).y() = 0.9F;
        }
        float farthest = 0.0F;
        for (int second = 0; second < 300; ++second) {
            herd.field.run(1.0F);
            for (std::uint32_t id = 1; id <= kHerd; ++id) {
                farthest = std::max(farthest, herd.at(id).cwiseAbs().maxCoeff());
            }
        }
        EXPECT_TRUE(herd.field.agents.active().empty());
        // An animal that touches the wall has its middle a radius away from it.
        EXPECT_LT(farthest, 7.8F - herd.field.types[kSheep].character.radius + 0.01F);
        EXPECT_GT(farthest, 7.0F) << "they go where they can";
    }
}

/// A herd that leaves a platform of 3 m goes down with its feet first.
TEST(HerdOffscreenOnes, FallAsTheyWouldHaveFallen) {
    Herd herd(kNobody, true, 1);
    motion::StaticBox platform;
    platform.centre = Vec3(0.0F, 1.5F, 0.0F);
    platform.half_extents = Vec3(30.0F, 1.5F, 22.0F);
    herd.field.statics = {{platform}, 0.0F};
    for (std::uint32_t id = 1; id <= kHerd; ++id) {
        herd.field.position(id).y() = 3.9F;
    }
    bool woke = false;
    int below = 0;
    for (int second = 0; second < 90; ++second) {
        herd.field.run(1.0F);
        woke = woke || (second > 5 && !herd.field.agents.active().empty());
        below = 0;
        for (std::uint32_t id = 1; id <= kHerd; ++id) {
            const Vec2 at = herd.at(id);
            const bool over = std::abs(at.x()) < 29.0F && std::abs(at.y()) < 21.0F;
            const bool beyond = std::abs(at.x()) > 31.5F || std::abs(at.y()) > 23.5F;
            const bool dozes = herd.field.agents.find(EntityId(id))->tier == Tier::kSuspended;
            const float height = herd.field.position(id).y();
            below += beyond ? 1 : 0;
            if (dozes && (over || beyond)) {
                ASSERT_NEAR(height, beyond ? 0.9F : 3.9F, 0.05F) << id << " after " << second;
            }
        }
    }
    EXPECT_TRUE(woke);
    EXPECT_GT(below, 12) << "they went on";
}

}  // namespace
}  // namespace zoned::ai
