#include "server/ai/flock.h"

#include "server/ai/herd.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace zoned::ai {

namespace {

constexpr float kSeparationWeight = 2.0F;
constexpr float kAlignmentWeight = 1.0F;
constexpr float kCohesionWeight = 0.8F;
constexpr float kHomeWeight = 0.6F;
constexpr float kInertiaWeight = 0.6F;
constexpr float kWayWeight = 1.2F;
constexpr float kHomePullLimit = 2.5F;  ///< far from home nothing else may win
constexpr float kFixedPoint = 4096.0F;

/// To the nearest integer; inlined, as std::llround() is not.
std::int64_t fixed(float value) {
    const float scaled = value * kFixedPoint;
    return static_cast<std::int64_t>(scaled + (scaled < 0.0F ? -0.5F : 0.5F));
}

/// What an animal knows of another one.
struct Neighbour {
    Vec2 offset;    ///< to where it is, x, z, m
    Vec2 velocity;  ///< m/s
};

Neighbour neighbour_at(const world::Entities& entities,
                       const Vec3& here,
                       world::Row row,
                       const Drift* drift) {
    const Vec2 body(entities.position[row].x(), entities.position[row].z());
    const Vec2 velocity(entities.velocity[row].x(), entities.velocity[row].z());
    const Leg* const leg = drift != nullptr && entities.has(row, world::kDozing)
                               ? drift->leg_of(entities, row)
                               : nullptr;
    const Vec2 at = leg != nullptr ? position_at(*leg, drift->now - 1, drift->dt) : body;
    return {at - Vec2(here.x(), here.z()),
            leg != nullptr ? velocity_at(*leg, drift->now - 1, drift->dt) : velocity};
}

/// Away from a neighbour, 1 when it touches, 0 at the separation distance. Two on the same spot
/// part along x, the older one to the left.
Vec2 away(const Vec2& to_neighbour, float distance, float separation, bool older) {
    if (distance < 1e-4F) {
        return {older ? -1.0F : 1.0F, 0.0F};
    }
    return to_neighbour * (-(separation - distance) / (separation * distance));
}

}  // namespace

Vec2 round_trip(std::span<const Vec2> stops, const Vec2& here, float width_m) {
    if (stops.size() == 1) {
        const Vec2 way = stops[0] - here;
        const float distance = way.norm();
        return distance > width_m ? Vec2(way / distance) : Vec2(Vec2::Zero());
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
    x += fixed(v.x());
    z += fixed(v.y());
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
    const float separation = kSeparationShare * radius_m_;
    if (distance < separation) {
        apart_.add(away(offset, distance, separation, older));
    }
    along_.add(velocity);
    together_.add(offset);
}

Vec2 FlockSum::heading(const Vec2& here, const FlockPull& pull) const {
    Vec2 heading = kInertiaWeight * pull.heading;
    if (neighbours_ > 0) {
        const float share = 1.0F / static_cast<float>(neighbours_);
        heading += kSeparationWeight * apart_.value();
        heading += kAlignmentWeight * share / pull.speed * along_.value();
        heading += kCohesionWeight * share / pull.radius_m * together_.value();
    }
    if (pull.way != Vec2::Zero()) {
        return heading + kWayWeight * pull.way;
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
