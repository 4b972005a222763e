#include "server/ai/steering/flocking.h"

#include "server/ai/steering/herd_drift.h"
#include "server/spatial/box_lanes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace zoned::ai {

namespace {

constexpr float kHomeWeight = 0.6F;
constexpr float kInertiaWeight = 0.6F;
constexpr float kPathWeight = 1.2F;
constexpr float kHomePullLimit = 2.5F;  ///< far from home nothing else may win
constexpr float kFixedPoint = 4096.0F;
/// By more than this share no square of a length is off.
constexpr float kFlockRounding = 1e-6F;
/// All whole numbers up to this are floats.
constexpr float kExact = 16'777'216.0F;
/// Two that are nearer than this stand on the same spot, m.
constexpr float kSameSpot = 1e-4F;

/// To the nearest integer; inlined, as std::llround() is not.
std::int64_t fixed(float value) {
    const float scaled = value * kFixedPoint;
    return static_cast<std::int64_t>(scaled + (scaled < 0.0F ? -0.5F : 0.5F));
}

/// The data that an animal has about another one.
struct Neighbour {
    Vec2 offset;    ///< to where it is, x, z, m
    Vec2 velocity;  ///< m/s
};

Neighbour neighbour_at(const world::Entities& entities,
                       const Vec3& here,
                       world::Row row,
                       const HerdDrift* drift) {
    const Vec2 body(entities.position[row].x(), entities.position[row].z());
    const Vec2 velocity(entities.velocity[row].x(), entities.velocity[row].z());
    const PathSegment* const segment = drift != nullptr && entities.has(row, world::kDozing)
                                           ? drift->segment_of(entities, row)
                                           : nullptr;
    const Vec2 at = segment != nullptr ? position_at(*segment, drift->now - 1, drift->dt) : body;
    return {at - Vec2(here.x(), here.z()),
            segment != nullptr ? velocity_at(*segment, drift->now - 1, drift->dt) : velocity};
}

/// Away from a neighbour, 1 when it touches, 0 at the separation distance. Two on the same spot
/// part along x, the older one to the left.
Vec2 away(const Vec2& to_neighbour, float distance, float separation, bool older) {
    if (distance < kSameSpot) {
        return {older ? -1.0F : 1.0F, 0.0F};
    }
    return to_neighbour * (-(separation - distance) / (separation * distance));
}

/// As fixed(), eight at a time, but still floats: whole numbers, exact up to kExact.
Array8 fixed_lanes(const Array8& values) {
    const Array8 scaled = values * kFixedPoint;
    return Array8::from((scaled.max(0.0F) + 0.5F).truncated()) -
           Array8::from(((-scaled).max(0.0F) + 0.5F).truncated());
}

/// One in the lanes whose bits are set, else zero, for each set of bits.
const std::array<Array8, 256>& lanes_of_bits() {
    static const std::array<Array8, 256> lanes = [] {
        std::array<Array8, 256> all;
        for (std::size_t bits = 0; bits < all.size(); ++bits) {
            for (std::size_t lane = 0; lane < spatial::kLanes; ++lane) {
                all[bits][static_cast<Eigen::Index>(lane)] = static_cast<float>(bits >> lane & 1U);
            }
        }
        return all;
    }();
    return lanes;
}

/// A sum of vectors, lane by lane, as long as it is exact.
struct SumOfLanes {
    Array8 x = 0.0F;
    Array8 z = 0.0F;

    void add(const Array8& add_x, const Array8& add_z) {
        x += fixed_lanes(add_x);
        z += fixed_lanes(add_z);
    }
};

}  // namespace

Vec2 round_trip(std::span<const Vec2> stops, const Vec2& here, float width_m) {
    if (stops.size() == 1) {
        const Vec2 path = stops[0] - here;
        const float distance = path.norm();
        return distance > width_m ? Vec2(path / distance) : Vec2(Vec2::Zero());
    }
    float least = std::numeric_limits<float>::infinity();
    Vec2 wanted = Vec2::Zero();
    for (std::size_t i = 0; i < stops.size(); ++i) {
        const Vec2 piece = stops[(i + 1) % stops.size()] - stops[i];
        const float length2 = piece.squaredNorm();
        const float along = piece.dot(here - stops[i]);
        // Beyond its end the next piece, which begins there, leads on.
        if (!(along < length2)) {
            continue;
        }
        const Vec2 to = stops[i] + std::max(0.0F, along / length2) * piece - here;
        if (to.squaredNorm() < least) {
            least = to.squaredNorm();
            wanted = piece / std::sqrt(length2) + to / width_m;
        }
    }
    const float norm = wanted.norm();
    return norm > 0.0F ? Vec2(wanted / norm) : Vec2(Vec2::Zero());
}

void FlockSum::ExactSum::add(const Vec2& v) {
    add(fixed(v.x()), fixed(v.y()));
}

Vec2 FlockSum::ExactSum::value() const {
    return {static_cast<float>(x) / kFixedPoint, static_cast<float>(z) / kFixedPoint};
}

void FlockSum::add(const Vec2& offset, const Vec2& velocity, bool older) {
    const float distance = offset.norm();
    if (distance > radius_m_) {
        return;
    }
    ++neighbours_;
    part(offset, older);
    along_.add(velocity);
    together_.add(offset);
}

void FlockSum::part(const Vec2& offset, bool older) {
    const float distance = offset.norm();
    const float separation = kSeparationShare * radius_m_;
    if (distance < separation) {
        apart_.add(away(offset, distance, separation, older));
    }
}

void FlockSum::add_run(const Columns& animals,
                       std::size_t begin,
                       std::size_t end,
                       std::size_t self,
                       const Vec2& here,
                       float time_s) {
    const std::array<Array8, 256>& lanes = lanes_of_bits();
    // This many sums of eight terms are exact; of larger terms none.
    const float largest = kFixedPoint * std::max(radius_m_, kFastestOfLanes) + 1.0F;
    const auto batches = static_cast<std::size_t>(kExact / (8.0F * largest));
    const float separation = kSeparationShare * radius_m_;
    const auto square = [](float length, float widen) {
        return Array8(length * length * widen);
    };
    // Squares and roots are rounded. An animal at the edge is checked by its exact distance, as
    // add() does. Roots of eight at a time would be approximate.
    const Array8 within = square(radius_m_, 1.0F - kFlockRounding);
    const Array8 perhaps_within = square(radius_m_, 1.0F + kFlockRounding);
    const Array8 perhaps_apart = square(separation, 1.0F + kFlockRounding);
    while (begin < end) {
        SumOfLanes along;
        SumOfLanes together;
        for (std::size_t k = 0; k < std::max<std::size_t>(batches, 1) && begin < end;
             ++k, begin += spatial::kLanes) {
            const Array8 vx = Array8::load(animals.velocity_x + begin);
            const Array8 vz = Array8::load(animals.velocity_z + begin);
            const Array8 dx = Array8::load(animals.x + begin) + vx * time_s - here.x();
            const Array8 dz = Array8::load(animals.z + begin) + vz * time_s - here.y();
            const Array8 d2 = dx * dx + dz * dz;
            const std::uint32_t there =
                (0xFFU >> (spatial::kLanes - std::min(end - begin, spatial::kLanes))) &
                ~static_cast<std::uint32_t>(std::uint64_t{1}
                                            << std::min<std::size_t>(self - begin, 32));
            const std::uint32_t sure =
                batches > 0 ? spatial::lanes_at_most(d2, within) & there : 0U;
            along.add(vx * lanes[sure], vz * lanes[sure]);
            together.add(dx * lanes[sure], dz * lanes[sure]);
            neighbours_ += std::popcount(sure);
            const auto one_by_one = [&](std::uint32_t bits, auto&& visit) {
                for (; bits != 0; bits &= bits - 1) {
                    const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
                    const auto i = static_cast<Eigen::Index>(lane);
                    visit(Vec2(dx[i], dz[i]),
                          Vec2(vx[i], vz[i]),
                          animals.entity[self] < animals.entity[begin + lane]);
                }
            };
            one_by_one(sure & spatial::lanes_at_most(d2, perhaps_apart),
                       [&](const Vec2& offset, const Vec2& /*velocity*/, bool older) {
                           part(offset, older);
                       });
            one_by_one(spatial::lanes_at_most(d2, perhaps_within) & there & ~sure,
                       [&](const Vec2& offset, const Vec2& velocity, bool older) {
                           add(offset, velocity, older);
                       });
        }
        along_.add(static_cast<std::int64_t>(along.x.sum()),
                   static_cast<std::int64_t>(along.z.sum()));
        together_.add(static_cast<std::int64_t>(together.x.sum()),
                      static_cast<std::int64_t>(together.z.sum()));
    }
}

Vec2 FlockSum::heading(const Vec2& here, const FlockPull& pull) const {
    Vec2 heading = kInertiaWeight * pull.heading;
    if (neighbours_ > 0) {
        const float share = 1.0F / static_cast<float>(neighbours_);
        heading += pull.weights.separation * apart_.value();
        heading += pull.weights.alignment * share / pull.speed * along_.value();
        heading += pull.weights.cohesion * share / pull.radius_m * together_.value();
    }
    if (pull.path != Vec2::Zero()) {
        return heading + kPathWeight * pull.path;
    }
    const Vec2 to_home = pull.home - here;
    const float distance = to_home.norm();
    if (distance > 0.0F) {
        const float strength = std::min(kHomePullLimit, distance / (2.0F * pull.radius_m));
        heading += kHomeWeight * strength / distance * to_home;
    }
    return heading;
}

Vec2 flock_heading(const world::Entities& entities,
                   const spatial::PointGrid& grid,
                   const FlockQuery& query) {
    const Vec3& here = entities.position[query.self];
    const TypeIndex type = entities.type[query.self];
    const float reach = query.drift != nullptr ? query.drift->reach_m : 0.0F;
    FlockSum sum(query.radius_m);
    grid.for_each_within(here.x(), here.z(), query.radius_m + reach, [&](world::Row row, float) {
        if (row != query.self && entities.type[row] == type && !entities.has(row, world::kHidden)) {
            const Neighbour other = neighbour_at(entities, here, row, query.drift);
            sum.add(other.offset, other.velocity, entities.id[query.self] < entities.id[row]);
        }
    });
    return sum.heading(Vec2(here.x(), here.z()), query);
}

}  // namespace zoned::ai
