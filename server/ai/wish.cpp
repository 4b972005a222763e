#include "server/ai/wish.h"

#include "server/ai/flock.h"
#include "server/ai/follow_track.h"
#include "server/ai/forage.h"
#include "server/ai/form_up.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::ai {

namespace {

constexpr float kReaimFreshCos = 0.99452F;  ///< cos 6 degrees
/// A standing returner sets out again only when pushed this far from home, m.
constexpr float kSetOutM = 2.0F;
/// Feet farther above or below each other stand on two floors, m.
constexpr float kOtherFloorM = 1.5F;

/// A ward that is slower than this stands, m/s.
constexpr float kStrollMps = 0.1F;
/// Who is within this many radii of a ward that stands is near enough.
constexpr float kNearShare = 1.5F;
/// Who follows stops within this share of the radius.
constexpr float kFollowStop = 0.7F;
/// Places that a herd goes along, at most.
constexpr std::size_t kMostStops = 32;
/// How far beside its path a herd turns back by half a right angle, as a share of its radius.
constexpr float kTrackShare = 0.5F;
/// What Mind::corner means to one who guards.
constexpr std::uint8_t kAtPost = 0;
constexpr std::uint8_t kEngaged = 1;

Vec2 flat(const Vec3& v) {
    return {v.x(), v.z()};
}

Vec2 corner_of(const Mind& mind, float radius, std::uint8_t corner) {
    const bool right = corner == 1 || corner == 2;
    const bool up = corner >= 2;
    return flat(mind.home) + Vec2(right ? radius : -radius, up ? radius : -radius);
}

std::uint8_t nearest_corner(const Mind& mind, float radius, const Vec2& here) {
    std::uint8_t best = 0;
    for (std::uint8_t corner = 1; corner < 4; ++corner) {
        if ((corner_of(mind, radius, corner) - here).squaredNorm() <
            (corner_of(mind, radius, best) - here).squaredNorm()) {
            best = corner;
        }
    }
    return best;
}

DesiredVelocity go_to(const Vec2& goal, const Vec2& here) {
    DesiredVelocity desired;
    desired.has_goal = true;
    desired.seeks = true;
    desired.goal = goal;
    desired.direction = goal - here;
    return desired;
}

DesiredVelocity wander_velocity(Mind& mind, const State& state, const Surroundings& around) {
    const Vec2 here = around.at;
    if (around.there || (flat(mind.target) - here).norm() < kArriveM) {
        pick_wander_target(mind, state.radius_m, around);
    }
    return go_to(flat(mind.target), here);
}

DesiredVelocity patrol_velocity(Mind& mind, const State& state, const Surroundings& around) {
    Vec2 goal = corner_of(mind, state.radius_m, mind.corner);
    if (around.there || (goal - around.at).norm() < kArriveM) {
        mind.corner = static_cast<std::uint8_t>((mind.corner + 1) & 3);
        restart_progress(mind, around.entities.position[around.self], around.now);
        goal = corner_of(mind, state.radius_m, mind.corner);
    }
    return go_to(goal, around.at);
}

/// Whether a goal that is near over the ground is on another floor, as far as maps tell floors.
bool on_other_floor(const Mind& mind,
                    const State& state,
                    const Vec2& goal,
                    const Surroundings& around) {
    const TypeIndex type = around.entities.type[around.self];
    if (around.paths == nullptr || !around.paths->plans_for(type)) {
        return false;
    }
    const float ground = around.paths->ground(type, {goal.x(), goal.y()});
    const float told = goal_floor(mind, state, around);
    const float floor = std::isnan(told) ? ground : told;
    const motion::CharacterLimits& body = around.types[type].character;
    const float feet = around.entities.position[around.self].y() - body.radius - body.half_segment;
    // Where the map tells no floors there is no other.
    return !std::isnan(ground) && std::abs(floor - feet) > kOtherFloorM;
}

/// To stand at: left only when pushed away from it.
DesiredVelocity go_and_stay(const Mind& mind,
                            const State& state,
                            const Vec2& goal,
                            const Surroundings& around) {
    const float over_ground = (goal - around.at).norm();
    const bool above = over_ground < kSetOutM && on_other_floor(mind, state, goal, around);
    const float distance = above ? kSetOutM : over_ground;
    DesiredVelocity desired;
    desired.far = around.there && !(distance < kArriveM);
    const bool stay = distance < (walks(mind) ? kArriveM : kSetOutM);
    return stay || desired.far ? desired : go_to(goal, around.at);
}

DesiredVelocity return_velocity(const Mind& mind, const State& state, const Surroundings& around) {
    return go_and_stay(mind, state, flat(mind.home), around);
}

DesiredVelocity place_velocity(const Mind& mind, const State& state, const Surroundings& around) {
    return go_and_stay(mind, state, around.places.spot(state.place, mind.entity), around);
}

/// Somebody as a mind takes them to be.
struct Other {
    Vec2 place = Vec2::Zero();
    Vec2 velocity = Vec2::Zero();
};

std::optional<Other> other_of(EntityId entity, const Surroundings& around) {
    const world::Row row = entity ? around.entities.find(entity) : world::kNoRow;
    if (row == world::kNoRow || around.entities.has(row, world::kHidden)) {
        return std::nullopt;
    }
    return Other{flat(around.entities.position[row]), flat(around.entities.velocity[row])};
}

/// Where it is, or was when it was noticed last.
std::optional<Other> target_of(const Mind& mind, const Surroundings& around) {
    if (mind.prey && !mind.noticed) {
        return Other{flat(mind.known), Vec2::Zero()};
    }
    return other_of(mind.prey, around);
}

/// Chase and flee: `sign` is +1 towards, -1 away.
DesiredVelocity prey_velocity(const Mind& mind,
                              const State& state,
                              const Surroundings& around,
                              float sign) {
    const std::optional<Other> target = target_of(mind, around);
    if (!target) {
        return {};
    }
    const Vec2 towards = target->place - around.at;
    const float distance = towards.norm();
    DesiredVelocity desired;
    if (sign > 0.0F && distance < (moving(mind) ? kChaseStopM : kChaseFollowM) &&
        !on_other_floor(mind, state, target->place, around)) {
        return desired;
    }
    desired.seeks = sign > 0.0F;
    desired.goal = target->place;
    // On the very spot of its prey any direction leads away.
    desired.direction = distance < 1e-4F ? Vec2(1.0F, 0.0F) : Vec2(sign * towards);
    return desired;
}

DesiredVelocity flock_velocity(Mind& mind,
                               const State& state,
                               float speed,
                               const Surroundings& around) {
    DesiredVelocity desired;
    desired.keep = !mind.fresh && moving(mind);
    if (desired.keep) {
        return desired;
    }
    const FlockQuery query{
        flock_pull(mind, state, speed, around.body(), around.places), around.self, around.drift};
    desired.direction = flock_heading(around.entities, around.grid, query);
    desired.fresh_cos = kReaimFlockCos;
    if (desired.direction.norm() < 1e-3F) {
        // Balanced: walk on, or set out anywhere.
        desired.keep = moving(mind);
        desired.direction = Vec2(mind.rng.range(-1.0F, 1.0F), 1.0F);
    }
    return desired;
}

/// Within `radius_m` of its ward, else of its target; it sets out when it is beyond, and stops well
/// within, so that who goes beside somebody does not stop and go with every step.
DesiredVelocity follow_velocity(const Mind& mind, const State& state, const Surroundings& around) {
    const std::optional<Other> whom =
        mind.ward ? other_of(mind.ward, around) : target_of(mind, around);
    if (!whom) {
        return {};
    }
    const float enough = moving(mind) ? kFollowStop * state.radius_m : state.radius_m;
    const bool near = (whom->place - around.at).norm() < enough &&
                      !on_other_floor(mind, state, whom->place, around);
    return near ? DesiredVelocity() : go_to(whom->place, around.at);
}

DesiredVelocity escort_velocity(const Mind& mind, const State& state, const Surroundings& around) {
    const std::optional<Other> ward = other_of(mind.ward, around);
    if (!ward) {
        return {};
    }
    const Vec2 here = around.at;
    const std::optional<Other> threat = target_of(mind, around);
    const Vec2 goal = escort_place(here,
                                   ward->place,
                                   ward->velocity,
                                   threat ? std::optional<Vec2>(threat->place) : std::nullopt,
                                   state.radius_m);
    return (goal - here).norm() < (moving(mind) ? 0.5F * kArriveM : kArriveM) ? DesiredVelocity()
                                                                              : go_to(goal, here);
}

DesiredVelocity guard_velocity(Mind& mind, const State& state, const Surroundings& around) {
    const std::optional<Other> target = target_of(mind, around);
    const float from_post = target ? (target->place - flat(mind.home)).norm() : 0.0F;
    const float reach = mind.corner == kEngaged ? state.leash_m : state.radius_m;
    mind.corner = target && from_post <= reach ? kEngaged : kAtPost;
    return mind.corner == kEngaged ? prey_velocity(mind, state, around, 1.0F)
                                   : return_velocity(mind, state, around);
}

}  // namespace

Vec2 escort_place(const Vec2& here,
                  const Vec2& ward,
                  const Vec2& ward_velocity,
                  const std::optional<Vec2>& threat,
                  float radius_m) {
    const Vec2 to_threat = threat ? Vec2(*threat - ward) : Vec2::Zero();
    const float distance = to_threat.norm();
    if (distance > 1e-3F) {
        return ward + to_threat * (std::min(radius_m, 0.5F * distance) / distance);
    }
    const Vec2 from_ward = here - ward;
    const float speed = ward_velocity.norm();
    if (speed > kStrollMps) {
        const Vec2 across(ward_velocity.y() / speed, -ward_velocity.x() / speed);
        return ward + across * (across.dot(from_ward) < 0.0F ? -radius_m : radius_m);
    }
    const float apart = from_ward.norm();
    const bool near = apart <= kNearShare * radius_m;
    return near || !(apart > 1e-3F) ? here : Vec2(ward + from_ward * (radius_m / apart));
}

DesiredVelocity::DesiredVelocity() : fresh_cos(kReaimFreshCos) {
}

FlockPull flock_pull(const Mind& mind,
                     const State& state,
                     float speed,
                     const Vec2& here,
                     const Places& places) {
    FlockPull pull;
    pull.home = flat(mind.home);
    pull.heading = aim_direction(mind);
    pull.radius_m = state.radius_m;
    pull.speed = speed;
    if (!state.along.empty()) {
        std::array<Vec2, kMostStops> stops;
        const std::size_t count = std::min(state.along.size(), kMostStops);
        for (std::size_t i = 0; i < count; ++i) {
            stops[i] = places.centre(state.along[i]);
        }
        pull.path = round_trip(std::span(stops.data(), count), here, kTrackShare * state.radius_m);
        pull.home = stops[0];
    }
    return pull;
}

bool walks(const Mind& mind) {
    return mind.timed ? mind.segment.speed > 0.0F : moving(mind);
}

bool moving(const Mind& mind) {
    return mind.aim.move_x != 0 || mind.aim.move_z != 0;
}

Vec2 aim_direction(const motion::InputCommand& aim) {
    const Vec2 move(aim.move_x, aim.move_z);
    return aim.move_x != 0 || aim.move_z != 0 ? Vec2(move / move.norm()) : Vec2(Vec2::Zero());
}

Vec2 aim_direction(const Mind& mind) {
    return aim_direction(mind.aim);
}

void restart_progress(Mind& mind, const Vec3& here, Tick now) {
    mind.anchor = here;
    mind.anchor_since = now;
}

/// A uniform point of the disc around home that is not where it stands already.
void pick_wander_target(Mind& mind, float radius, const Surroundings& around) {
    for (int attempt = 0; attempt < 8; ++attempt) {
        // Rejection from the square needs no trigonometry.
        Vec2 point = Vec2::Zero();
        do {
            point.x() = mind.rng.range(-1.0F, 1.0F);
            point.y() = mind.rng.range(-1.0F, 1.0F);
        } while (point.squaredNorm() > 1.0F);
        mind.target = mind.home + Vec3(point.x() * radius, 0.0F, point.y() * radius);
        if ((flat(mind.target) - around.at).norm() > 2.0F * kArriveM) {
            break;
        }
    }
    restart_progress(mind, around.entities.position[around.self], around.now);
}

void begin_deed(Mind& mind, const State& state, const Surroundings& around) {
    mind.detour_until = 0;
    restart_progress(mind, around.entities.position[around.self], around.now);
    if (state.action == ActionKind::kWander) {
        pick_wander_target(mind, state.radius_m, around);
    } else if (state.action == ActionKind::kGuard) {
        mind.corner = kAtPost;
    } else if (state.action == ActionKind::kForage) {
        mind.corner = kBegins;
        mind.target = Vec3(around.at.x(), 0.0F, around.at.y());
    } else if (state.action == ActionKind::kFollowTrack) {
        begin_spline(mind, state, around);
    } else if (state.action == ActionKind::kFormUp) {
        mind.corner = kNoRank;
        mind.steps = 0;
        mind.target = around.entities.position[around.self];
    } else if (state.action == ActionKind::kPatrol) {
        mind.corner = nearest_corner(mind, state.radius_m, around.at);
    }
}

DesiredVelocity desired_velocity(Mind& mind,
                                 const State& state,
                                 float speed,
                                 const Surroundings& around) {
    switch (state.action) {
        case ActionKind::kIdle:
            return {};
        case ActionKind::kWander:
            return wander_velocity(mind, state, around);
        case ActionKind::kPatrol:
            return patrol_velocity(mind, state, around);
        case ActionKind::kChase:
            return prey_velocity(mind, state, around, 1.0F);
        case ActionKind::kFlee:
            return prey_velocity(mind, state, around, -1.0F);
        case ActionKind::kFlock:
            return flock_velocity(mind, state, speed, around);
        case ActionKind::kReturn:
            return return_velocity(mind, state, around);
        case ActionKind::kGo:
            return place_velocity(mind, state, around);
        case ActionKind::kFollow:
            return follow_velocity(mind, state, around);
        case ActionKind::kEscort:
            return escort_velocity(mind, state, around);
        case ActionKind::kGuard:
            return guard_velocity(mind, state, around);
        case ActionKind::kForage:
            return go_to(flat(mind.target), around.at);
        case ActionKind::kFollowTrack:
            return track_velocity(mind, state, around);
        case ActionKind::kFormUp:
            // Who keeps its place is steered otherwise.
            return mind.ward ? go_to(flat(mind.target), around.body()) : DesiredVelocity();
    }
    ZONED_ASSERT(false, "an action is one of the enumeration");
    return {};
}

float goal_floor(const Mind& mind, const State& state, const Surroundings& around) {
    const auto below = [&](float middle, TypeIndex type) {
        const motion::CharacterLimits& body = around.types[type].character;
        return middle - body.radius - body.half_segment;
    };
    const TypeIndex own = around.entities.type[around.self];
    const auto of = [&](EntityId whom) {
        const world::Row row = whom ? around.entities.find(whom) : world::kNoRow;
        return row == world::kNoRow
                   ? below(mind.home.y(), own)
                   : below(around.entities.position[row].y(), around.entities.type[row]);
    };
    const auto of_prey = [&] {
        return mind.prey && !mind.noticed ? below(mind.known.y(), own) : of(mind.prey);
    };
    switch (state.action) {
        case ActionKind::kGo:
            return around.places.floor(state.place);
        case ActionKind::kChase:
        case ActionKind::kFlee:
            return of_prey();
        case ActionKind::kFollow:
        case ActionKind::kEscort:
            return mind.ward ? of(mind.ward) : of_prey();
        case ActionKind::kGuard:
            return mind.corner == kEngaged ? of_prey() : below(mind.home.y(), own);
        case ActionKind::kFormUp:
        case ActionKind::kFollowTrack:
        case ActionKind::kForage:
            return below(mind.target.y(), own);
        case ActionKind::kIdle:
        case ActionKind::kWander:
        case ActionKind::kPatrol:
        case ActionKind::kReturn:
        case ActionKind::kFlock:
            return below(mind.home.y(), own);
    }
    ZONED_ASSERT(false, "an action is one of the enumeration");
    return pathfinding::kOnGround;
}

void aim_along(Mind& mind, const State& state, const Vec2& direction) {
    aim_along(mind, Pace{state.speed_factor * mind.band, state.sprint}, direction);
}

void aim_along(Mind& mind, const Pace& pace, const Vec2& direction) {
    aim_along(mind.aim, pace, direction);
}

void move_along(motion::InputCommand& aim, const Pace& pace, const Vec2& direction) {
    const float scale = kFullMove * std::clamp(pace.factor, 0.0F, 1.0F);
    aim.move_x = static_cast<std::int8_t>(std::lround(direction.x() * scale));
    aim.move_z = static_cast<std::int8_t>(std::lround(direction.y() * scale));
    aim.buttons = pace.sprint ? motion::kButtonSprint : 0;
}

void face_along(motion::InputCommand& aim, const Vec2& direction) {
    // Turning +z about +y by an angle gives (sin, cos) in (x, z).
    const float turns =
        std::atan2(direction.x(), direction.y()) / (2.0F * std::numbers::pi_v<float>);
    aim.yaw = static_cast<std::uint16_t>(std::lround(turns * 65536.0F) & 0xFFFF);
}

void aim_along(motion::InputCommand& aim, const Pace& pace, const Vec2& direction) {
    move_along(aim, pace, direction);
    face_along(aim, direction);
}

float full_speed(const State& state, const Surroundings& around) {
    const motion::CharacterLimits& limits =
        around.types[around.entities.type[around.self]].character;
    return limits.speed * state.speed_factor * (state.sprint ? limits.sprint_factor : 1.0F);
}

}  // namespace zoned::ai
