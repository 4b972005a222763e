#include "client-sim/view/aim.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

namespace zoned::view {

namespace {

/// Entry of a ray into a ball about `centre`; below 0: none.
double ray_ball(const Vec3d& eye, const Vec3d& direction, const Vec3d& centre, double radius) {
    const Vec3d to = eye - centre;
    const double b = to.dot(direction);
    const double c = to.squaredNorm() - radius * radius;
    if (c <= 0.0) {
        return 0.0;
    }
    const double root = b * b - c;
    return b < 0.0 && root >= 0.0 ? -b - std::sqrt(root) : -1.0;
}

/// How far the ray passes an upright segment's surroundings, m: from the point of the ray that is
/// nearest to the centre. Exact enough to choose the near ones.
double gap(const Vec3d& eye,
           const Vec3d& direction,
           const Vec3d& centre,
           double radius,
           double half_segment) {
    const double along = std::max(0.0, (centre - eye).dot(direction));
    Vec3d off = eye + direction * along - centre;
    off.y() -= std::clamp(off.y(), -half_segment, half_segment);
    return off.norm() - radius;
}

/// Where the ray goes into the flat ground; a body may be displayed partly below it.
double to_the_ground(const View& view, const Vec3d& eye, const Vec3d& direction) {
    const ZoneInfo* zone = view.world().zone(view.zone());
    if (zone == nullptr || direction.y() >= 0.0) {
        return std::numeric_limits<double>::infinity();
    }
    const double ground = zone->origin.y() + static_cast<double>(zone->geometry.ground_height());
    return std::max(0.0, (ground - eye.y()) / direction.y());
}

}  // namespace

double ray_capsule(const Vec3d& eye,
                   const Vec3d& direction,
                   const Vec3d& centre,
                   double radius,
                   double half_segment) {
    const Vec3d up(0.0, half_segment, 0.0);
    double best = -1.0;
    const auto take = [&](double t) {
        if (t >= 0.0 && (best < 0.0 || t < best)) {
            best = t;
        }
    };
    take(ray_ball(eye, direction, centre + up, radius));
    take(ray_ball(eye, direction, centre - up, radius));
    // The side: a circle in the plane, between the two ends.
    const double a = direction.x() * direction.x() + direction.z() * direction.z();
    const double x = eye.x() - centre.x();
    const double z = eye.z() - centre.z();
    const double c = x * x + z * z - radius * radius;
    if (c <= 0.0 && std::abs(eye.y() - centre.y()) <= half_segment) {
        return 0.0;
    }
    const double b = x * direction.x() + z * direction.z();
    const double root = b * b - a * c;
    if (a > 0.0 && c > 0.0 && b < 0.0 && root >= 0.0) {
        const double t = (-b - std::sqrt(root)) / a;
        if (std::abs(eye.y() + t * direction.y() - centre.y()) <= half_segment) {
            take(t);
        }
    }
    return best;
}

double eye_height(const motion::CharacterLimits& body) {
    return static_cast<double>(body.half_segment + 0.5F * body.radius);
}

Vec3d own_eye(const View& view) {
    return view.own().position() + Vec3d(0.0, eye_height(view.own().limits()), 0.0);
}

Aim aim(const View& view, const Vec3d& eye, const Vec3d& direction, double range_m) {
    Aim result;
    result.past = view.kind() == ViewKind::kInterpolate;
    result.tick = view.displayed_tick();
    result.fraction = view.displayed_fraction();
    const double reach = std::min(range_m, to_the_ground(view, eye, direction));
    std::multimap<double, AimSight> near;  // by distance from the ray, those alike by id
    for (const auto& [id, entity] : view.store().entities()) {
        if (!entity.typed || !entity.present() || id == view.own().id() ||
            !view.world().types[entity.type].character) {
            continue;
        }
        const auto shown = view.on_screen(entity);
        if (!shown) {
            continue;
        }
        const Version* version = EntityStore::version_at(entity, view.tick());
        const Tick publication = version != nullptr ? version->publication_tick
                                                    : entity.versions.back().publication_tick;
        const motion::CharacterLimits& body = view.world().types[entity.type].limits;
        const auto radius = static_cast<double>(body.radius);
        const auto half = static_cast<double>(body.half_segment);
        const double off = gap(eye, direction, shown->position, radius, half);
        if (off < kNearRayM) {
            near.emplace(off, AimSight{id, shown->position, publication});
            if (near.size() > kMostSights) {
                near.erase(std::prev(near.end()));
            }
        }
        const double t = ray_capsule(eye, direction, shown->position, radius, half);
        if (t >= 0.0 && t <= reach && (!result.hit || t < result.distance)) {
            result.hit = id;
            result.distance = t;
        }
    }
    for (const auto& [off, sight] : near) {
        result.near.push_back(sight);
    }
    return result;
}

}  // namespace zoned::view
