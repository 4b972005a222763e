#include "server/zone/viewers/lag_compensation.h"

#include "server/physics/query/shape_ray.h"
#include "server/zone/simulation/type_body.h"

#include <algorithm>
#include <cmath>

namespace zoned::zone {

namespace {

/// The target's client is notified of a miss that came this near.
constexpr float kNearMissM = 2.0F;

/// The displayed moment, within the bound.
struct Moment {
    Tick tick = 0;
    float fraction = 0.0F;
    Tick oldest = 0;
    bool cut = false;
};

Moment moment_of(const ZoneState& state, const Seen& seen) {
    // Within a step the world is as the tick before left it.
    const Tick present = state.now - 1;
    Moment m;
    m.oldest = std::max<Tick>(0, present - state.settings.rewind.most_ticks);
    m.tick = std::clamp(seen.tick, m.oldest, present);
    m.cut = m.tick != seen.tick;
    const bool inside = !m.cut && m.tick < present;
    m.fraction =
        inside && std::isfinite(seen.fraction) ? std::clamp(seen.fraction, 0.0F, 1.0F) : 0.0F;
    return m;
}

const SeenEntity* claim_of(const Seen& seen, EntityId entity) {
    const auto it = std::find_if(seen.entities.begin(),
                                 seen.entities.end(),
                                 [&](const SeenEntity& s) { return s.entity == entity; });
    return it == seen.entities.end() ? nullptr : &*it;
}

/// Where an entity stands as seen; none: it cannot have been seen.
std::optional<Pose> pose_as_seen(const ZoneState& state,
                                 ClientId client,
                                 const Seen& seen,
                                 const Moment& moment,
                                 world::Row row,
                                 bool& doubted) {
    const world::Entities& e = state.entities;
    if (e.has(row, world::kHidden) || e.discontinuity_tick[row] > moment.tick) {
        return std::nullopt;
    }
    const EntityId entity = e.id[row];
    Pose pose = state.history.at(entity, moment.tick, moment.fraction)
                    .value_or(Pose{e.position[row], e.orientation[row]});
    const SeenEntity* claim = claim_of(seen, entity);
    const bool present = seen.view == Seen::DisplayedTime::kPresent;
    if (claim == nullptr) {
        // A view of the present shows nothing of a new entity before its first update comes.
        const Tick update_ticks = present ? state.replicator.one_way_ticks(client) : 0;
        return e.discontinuity_tick[row] + update_ticks > moment.tick ? std::nullopt
                                                                      : std::optional<Pose>(pose);
    }
    if (present && claim->publication < e.discontinuity_tick[row]) {
        return std::nullopt;  // displayed where it was before it jumped
    }
    float allowed = state.settings.rewind.slack_m;
    if (present) {
        const auto sent = state.replicator.sent_state(
            client, entity, claim->publication, moment.tick, moment.oldest);
        if (sent) {
            pose.position = sent->position;
            allowed += sent->blend_m;
        }
    } else {
        allowed += state.replicator.bound_m(client, entity);
    }
    const Vec3 off = claim->position - pose.position;
    const float distance = off.norm();
    if (!std::isfinite(distance)) {
        doubted = true;
        return pose;
    }
    doubted = doubted || distance > allowed;
    pose.position += distance > allowed ? Vec3(off * (allowed / distance)) : off;
    return pose;
}

bool reaches(const Vec3& centre, float radius, const Vec3& origin, const Vec3& direction) {
    const Vec3 to = centre - origin;
    const float along = std::max(0.0F, to.dot(direction));
    return (to - direction * along).squaredNorm() <= radius * radius;
}

/// The nearest thing that is not rewound.
RayResult cast_at_rest(const ZoneState& state,
                       const Vec3& origin,
                       const Vec3& direction,
                       float max_distance,
                       EntityId ignore) {
    physics::QueryFilter filter;
    filter.ignore_user = ignore.value;
    filter.categories = ~(kRewindableCategory | kRewindablePartCategory | kMovingCategory);
    physics::QueryHit hit;
    RayResult result;
    result.hit = state.scene.query().ray({origin, direction, max_distance}, filter, hit);
    result.entity = EntityId(result.hit ? hit.user : 0U);
    result.distance = result.hit ? hit.distance : max_distance;
    result.point = hit.point;
    result.normal = hit.normal;
    return result;
}

/// Takes a static box for the hit if it is nearer. `direction` has unit length.
void ray_to_box(const motion::StaticBox& box,
                const Vec3& origin,
                const Vec3& direction,
                RayResult& hit) {
    float distance = 0.0F;
    Vec3 normal;
    if (physics::cast_ray(
            {physics::Shape::box(box.half_extents), box.centre, box.orientation.toRotationMatrix()},
            origin,
            direction,
            hit.distance,
            distance,
            normal) &&
        (distance < hit.distance || !hit.hit)) {
        hit.hit = true;
        hit.entity = EntityId();
        hit.distance = distance;
        hit.point = origin + direction * distance;
        hit.normal = normal;
    }
}

/// The nearest of the doors that were shut at a tick and of the platforms where they were then,
/// within `hit.distance`.
void ray_to_moving_parts(const ZoneState& state,
                         Tick tick,
                         const Vec3& origin,
                         const Vec3& direction,
                         RayResult& hit) {
    const motion::StaticGeometry& statics = *state.settings.statics;
    const Vec3 end = origin + direction * hit.distance;
    const Aabb along{origin.cwiseMin(end), origin.cwiseMax(end)};
    statics.for_each_door_near(along, [&](std::uint32_t door) {
        if (statics.shut_at(door, tick)) {
            ray_to_box(statics.doors()[door].box, origin, direction, hit);
        }
    });
    statics.for_each_platform_near(along, [&](std::uint32_t platform) {
        ray_to_box(statics.platform_box(platform, tick), origin, direction, hit);
    });
}

}  // namespace

std::uint32_t record_history(ZoneState& state) {
    const world::Entities& e = state.entities;
    std::vector<std::pair<EntityId, world::Row>>& rows = state.history_rows;
    rows.clear();
    const auto add = [&](world::Row row) {
        if (!e.has(row, world::kHidden)) {
            rows.emplace_back(e.id[row], row);
        }
    };
    // Of all that is rewindable and all that is heard, the fewer are looked through.
    if (e.rewindable().count() <= state.replicator.heard_count()) {
        world::for_each_row(e.rewindable(), [&](world::Row row) {
            if (e.client[row] || state.replicator.heard(e.id[row])) {
                add(row);
            }
        });
        std::sort(rows.begin(), rows.end());
    } else {
        const auto add_rewindable = [&](world::Row row) {
            if (row != world::kNoRow && e.rewindable().has(row)) {
                add(row);
            }
        };
        world::for_each_row(e.avatars(), add_rewindable);
        state.replicator.for_each_heard([&](EntityId id) { add_rewindable(e.find(id)); });
        std::sort(rows.begin(), rows.end());
        rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    }
    state.history.begin(state.now);
    for (const auto& [entity, row] : rows) {
        state.history.add(entity, {e.position[row], e.orientation[row]});
    }
    return static_cast<std::uint32_t>(rows.size());
}

SeenHit ray_cast_as_seen(const ZoneState& state,
                         ClientId client,
                         const Seen& seen,
                         const Vec3& origin,
                         const Vec3& direction,
                         float max_distance,
                         EntityId ignore) {
    const Moment moment = moment_of(state, seen);
    SeenHit best;
    static_cast<RayResult&>(best) = cast_at_rest(state, origin, direction, max_distance, ignore);
    ray_to_moving_parts(state, moment.tick, origin, direction, best);
    best.cut = moment.cut;
    best.rewound_s =
        (static_cast<float>(state.now - 1 - moment.tick) - moment.fraction) * state.settings.dt;
    const world::Entities& e = state.entities;
    const world::RowSet& rows = e.rewindable();
    for (world::Row row = rows.next(0); row != world::kNoRow; row = rows.next(row + 1)) {
        const world::EntityType& type = (*state.settings.types)[e.type[row]];
        if (e.id[row] == ignore) {
            continue;
        }
        bool doubted = false;
        const auto pose = pose_as_seen(state, client, seen, moment, row, doubted);
        const bool aimed = e.id[row] == seen.aimed;
        if (!pose ||
            !reaches(
                pose->position, type.extent() + (aimed ? kNearMissM : 0.0F), origin, direction)) {
            continue;
        }
        best.aimed_near = best.aimed_near || aimed;
        best.doubted = best.doubted || doubted;
        const physics::BodyDef body = body_of(type, state.settings.solids);
        const Mat3 rotation = pose->orientation.toRotationMatrix();
        float distance = 0.0F;
        Vec3 normal;
        if (!physics::cast_ray({body.shape, pose->position, rotation},
                               origin,
                               direction,
                               best.distance,
                               distance,
                               normal)) {
            continue;
        }
        const bool tied = best.hit && best.entity && distance == best.distance;
        if (!tied || e.id[row] < best.entity) {
            best.hit = true;
            best.entity = e.id[row];
            best.distance = distance;
            best.point = origin + direction * distance;
            best.normal = normal;
        }
    }
    return best;
}

}  // namespace zoned::zone
