#include "server/ai/flock.h"

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

/// A sum of vectors that is the same in every order of its terms.
struct ExactSum {
    std::int64_t x = 0;
    std::int64_t z = 0;

    void add(const Vec2& v) {
        x += std::llround(v.x() * kFixedPoint);
        z += std::llround(v.y() * kFixedPoint);
    }

    [[nodiscard]] Vec2 value() const {
        return {static_cast<float>(x) / kFixedPoint, static_cast<float>(z) / kFixedPoint};
    }
};

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

Vec2 flock_heading(const world::Entities& entities,
                   const spatial::PointGrid& grid,
                   const FlockQuery& query) {
    const Vec3& here = entities.position[query.self];
    const TypeIndex type = entities.type[query.self];
    const float separation = kSeparationShare * query.radius_m;
    ExactSum apart;
    ExactSum along;
    ExactSum together;
    int neighbours = 0;
    grid.for_each_within(here.x(), here.z(), query.radius_m, [&](world::Row row, float d2) {
        if (row == query.self || entities.type[row] != type || entities.has(row, world::kHidden)) {
            return;
        }
        ++neighbours;
        const Vec2 offset(entities.position[row].x() - here.x(),
                          entities.position[row].z() - here.z());
        const float distance = std::sqrt(d2);
        if (distance < separation) {
            apart.add(
                away(offset, distance, separation, entities.id[query.self] < entities.id[row]));
        }
        along.add(Vec2(entities.velocity[row].x(), entities.velocity[row].z()));
        together.add(offset);
    });
    Vec2 heading = kInertiaWeight * query.heading;
    if (neighbours > 0) {
        const float share = 1.0F / static_cast<float>(neighbours);
        heading += kSeparationWeight * apart.value();
        heading += kAlignmentWeight * share / query.speed * along.value();
        heading += kCohesionWeight * share / query.radius_m * together.value();
    }
    if (query.way != Vec2::Zero()) {
        return heading + kWayWeight * query.way;
    }
    const Vec2 to_home = query.home - Vec2(here.x(), here.z());
    const float distance = to_home.norm();
    if (distance > 0.0F) {
        const float pull = std::min(kHomePullLimit, distance / (2.0F * query.radius_m));
        heading += kHomeWeight * pull / distance * to_home;
    }
    return heading;
}

}  // namespace zoned::ai
