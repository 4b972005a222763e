#include "server/ai/steering/local_avoidance.h"

#include "server/ai/steering/desired_velocity.h"
#include "shared/motion/apply_input.h"
#include "shared/motion/capsule_sweep.h"
#include "shared/motion/static_geometry.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace zoned::ai {

namespace {

constexpr std::uint8_t kCrowded = 1;  ///< on a collision course: has to avoid it
constexpr std::uint8_t kNear = 2;     ///< counts as an obstacle for a crowded walker
constexpr std::uint8_t kGaveWay = 1;
constexpr std::uint8_t kHeld = 2;

/// Margin between two that yield, as a share of the smaller radius: it covers rounding.
constexpr float kMarginShare = 0.01F;
/// A walker that would come nearer than this to another avoids it, m.
constexpr float kBerth = 0.05F;
/// Places may lie beyond their side by this much, m: rounding far from the zone's centre.
constexpr float kRounding = 1e-4F;
/// Walls do not turn a walker aside if it stops within this distance, m.
constexpr float kShortStop = 0.1F;
/// The most by which ground may lie lower after a path of 1 m downhill: a little more than on the
/// steepest ground that carries.
constexpr float kSteepestFall = 1.2F;
/// Shares of the best velocity that are tried, one after the other; the last is to brake.
constexpr std::array kTries = {1.0F, 0.75F, 0.5F, 0.25F, 0.0F};
/// A batch of eight at a time.
constexpr std::size_t kBatches = 8;

Vec2 on_ground(const Vec3& v) {
    return {v.x(), v.z()};
}

float gait(const motion::CharacterLimits& limits, const motion::InputCommand& command) {
    const bool sprints = (command.buttons & motion::kButtonSprint) != 0;
    return limits.speed * (sprints ? limits.sprint_factor : 1.0F);
}

/// The velocity that apply_input reads from the command, m/s.
Vec2 wanted(const motion::CharacterLimits& limits, const motion::InputCommand& command) {
    const Vec2 move(static_cast<float>(command.move_x) / kFullMove,
                    static_cast<float>(command.move_z) / kFullMove);
    const float length = move.norm();
    return move * (gait(limits, command) / (length > 1.0F ? length : 1.0F));
}

/// The place at which a walker with `velocity` stops when it brakes.
Vec2 braking_end(const Vec2& at, const Vec2& velocity, const motion::CharacterLimits& limits) {
    return at + velocity * (velocity.norm() / (2.0F * std::max(limits.acceleration, 1e-3F)));
}

/// The horizontal reach of an entity's body, m.
float width_of(const world::EntityType& type) {
    if (type.kind == world::EntityKind::kCharacter) {
        return type.character.radius;
    }
    return type.shape == world::TypeShape::kBox
               ? Vec2(type.half_extents.x(), type.half_extents.z()).norm()
               : type.extent();
}

float height_of(const world::EntityType& type) {
    return type.kind == world::EntityKind::kCharacter
               ? type.character.radius + type.character.half_segment
               : type.extent();
}

/// The point of the segment from a to b that is nearest to p.
Vec2 nearest_on(const Vec2& a, const Vec2& b, const Vec2& p) {
    const Vec2 path = b - a;
    const float length2 = path.squaredNorm();
    const float t = length2 > 0.0F ? std::clamp(path.dot(p - a) / length2, 0.0F, 1.0F) : 0.0F;
    return a + t * path;
}

/// The nearest points of two segments that do not cross: one of them is an end.
struct Nearest {
    Vec2 a = Vec2::Zero();
    Vec2 b = Vec2::Zero();
    float d2 = std::numeric_limits<float>::infinity();

    void take(const Vec2& one, const Vec2& other) {
        const float distance2 = (one - other).squaredNorm();
        if (distance2 < d2) {
            a = one;
            b = other;
            d2 = distance2;
        }
    }
};

Nearest nearest(const Vec2& a0, const Vec2& a1, const Vec2& b0, const Vec2& b1) {
    Nearest found;
    found.take(a0, nearest_on(b0, b1, a0));
    found.take(a1, nearest_on(b0, b1, a1));
    found.take(nearest_on(a0, a1, b0), b0);
    found.take(nearest_on(a0, a1, b1), b1);
    return found;
}

/// Towards zero: never faster than was found.
std::int8_t slower(float share) {
    return static_cast<std::int8_t>(
        std::clamp(std::trunc(share * kFullMove), -kFullMove, kFullMove));
}

/// True: no wall turns the character aside while it brakes towards `end`. A character that is
/// turned aside would stop elsewhere. Short paths are not checked.
bool brakes_freely(const Vec3& from,
                   const Vec2& end,
                   const motion::CharacterLimits& limits,
                   const motion::StaticGeometry& statics,
                   Tick now) {
    const Vec3 path(end.x() - from.x(), 0.0F, end.y() - from.z());
    if (path.squaredNorm() <= kShortStop * kShortStop) {
        return true;
    }
    const motion::CapsuleSweep sweep(statics,
                                     {limits.radius, limits.half_segment},
                                     Aabb{from, from}.grown(path.norm() + 0.1F),
                                     now);
    const motion::SweepHit hit = sweep.sweep(from, path);
    return !hit.hit || hit.ground_plane || hit.normal.y() >= limits.max_slope_cos;
}

}  // namespace

float path_left(const Agent& agent,
                const BrainState& state,
                const PointsOfInterest& points_of_interest,
                const Vec2& here) {
    switch (state.action) {
        case ActionKind::kWander:
            return (on_ground(agent.target) - here).norm();
        case ActionKind::kReturn:
        case ActionKind::kGuard:
            return (on_ground(agent.home) - here).norm();
        case ActionKind::kGo:
            return (points_of_interest.spot(state.place, agent.entity) - here).norm();
        default:
            return 0.0F;
    }
}

// ---------------------------------------------------------------- gathering neighbours

void LocalAvoidance::add_walker(const AvoidingAgent& walker, const AiContext& ai) {
    const world::Entities& e = ai.entities;
    const world::Row row = walker.row;
    const motion::CharacterLimits& limits = ai.types[e.type[row]].character;
    const Vec2 at = on_ground(e.position[row]);
    const Vec2 velocity = on_ground(e.velocity[row]);
    const Vec2 want = wanted(limits, e.command[row]);
    seen_.add(e.id[row].value, at.x(), at.y(), limits.radius, gait(limits, e.command[row]));
    seen_.vx.back() = velocity.x();
    seen_.vz.back() = velocity.y();
    seen_.want_x.back() = want.x();
    seen_.want_z.back() = want.y();
    seen_.path_left.back() = walker.path_left_m;
    // A body in the air cannot brake.
    const bool walks = e.has(row, world::kGrounded);
    seen_.yield.back() = walks ? 1.0F : 0.0F;
    rows_.push_back(row);
    courses_.push_back({at,
                        walks ? braking_end(at, velocity, limits) : Vec2(at + velocity * ai.dt),
                        e.position[row].y(),
                        height_of(ai.types[e.type[row]])});
}

void LocalAvoidance::add_other(world::Row row, const AiContext& ai) {
    const world::Entities& e = ai.entities;
    const world::EntityType& type = ai.types[e.type[row]];
    const Vec2 at = on_ground(e.position[row]);
    const Vec2 velocity = on_ground(e.velocity[row]);
    const float speed = velocity.norm();
    seen_.add(e.id[row].value, at.x(), at.y(), width_of(type), speed);
    seen_.vx.back() = velocity.x();
    seen_.vz.back() = velocity.y();
    seen_.want_x.back() = velocity.x();
    seen_.want_z.back() = velocity.y();
    // Its own zone makes it yield likewise, by the same places and velocities.
    const bool yields = e.has(row, world::kGhost) && e.has(row, world::kGrounded) &&
                        type.kind == world::EntityKind::kCharacter && type.brain != 0 &&
                        !e.client[row];
    seen_.yield.back() = yields ? 1.0F : 0.0F;
    rows_.push_back(row);
    courses_.push_back(
        {at,
         yields ? braking_end(at, velocity, type.character) : Vec2(at + velocity * ai.dt),
         e.position[row].y(),
         height_of(type)});
}

/// Obstacles are characters of players or with a body (one that is not simulated has none), and
/// bodies that move.
void LocalAvoidance::gather(std::span<const AvoidingAgent> walkers, const AiContext& ai) {
    const world::Entities& e = ai.entities;
    seen_.clear();
    rows_.clear();
    courses_.clear();
    taken_.resize(std::max(taken_.size(), e.size()), 0);
    for (const AvoidingAgent& walker : walkers) {
        add_walker(walker, ai);
        taken_[walker.row] = 1;
    }
    walkers_ = seen_.size();
    others_.clear();
    world::for_each_row(e.stirring(), [&](world::Row row) {
        if (taken_[row] != 0 || e.has(row, world::kHidden)) {
            return;
        }
        const bool character = ai.types[e.type[row]].kind == world::EntityKind::kCharacter;
        if (character ? (e.body[row] || e.client[row])
                      : (e.body[row] && !e.has(row, world::kAtRest))) {
            others_.push_back(row);
        }
    });
    for (const AvoidingAgent& walker : walkers) {
        taken_[walker.row] = 0;
    }
    std::sort(others_.begin(), others_.end(), [&e](world::Row a, world::Row b) {
        return e.id[a] < e.id[b];
    });
    for (const world::Row row : others_) {
        add_other(row, ai);
    }
}

/// The distance beyond which others do not matter. It is the range of the search, and at least so
/// far that two cannot touch within a tick and braking after it.
float LocalAvoidance::reach(const AiContext& ai,
                            const steering::AvoidanceSettings& settings) const {
    float radius = 0.0F;
    float course = 0.0F;
    for (std::size_t i = 0; i < seen_.size(); ++i) {
        const float step = (i < walkers_ ? seen_.most_speed[i] : 0.0F) * ai.dt;
        radius = std::max(radius, seen_.radius[i]);
        course = std::max(course, (courses_[i].end - courses_[i].at).norm() + 2.0F * step);
    }
    return std::max(settings.neighbour_m, 2.0F * (radius + course));
}

template <class Visit>
void LocalAvoidance::for_each_near(const steering::CrowdBatch& batch, Visit&& visit) const {
    for (int row = batch.row - 1; row <= batch.row + 1; ++row) {
        const auto [begin, end] = order_.stretch(row, batch.first_cell - 1, batch.last_cell + 1);
        for (std::uint32_t i = begin; i < end; ++i) {
            visit(order_.rows()[i]);
        }
    }
}

bool LocalAvoidance::apart_in_height(std::uint32_t one, std::uint32_t other) const {
    return std::abs(courses_[one].y - courses_[other].y) >=
           courses_[one].half_height + courses_[other].half_height;
}

// ---------------------------------------------------------------- finding collision courses

/// True if the two, at their wanted velocities, come nearer to each other than allowed within the
/// horizon.
bool LocalAvoidance::would_meet(std::uint32_t one,
                                std::uint32_t other,
                                const steering::AvoidanceSettings& settings) const {
    const Vec2 p(seen_.x[other] - seen_.x[one], seen_.z[other] - seen_.z[one]);
    const Vec2 v(seen_.want_x[one] - seen_.want_x[other], seen_.want_z[one] - seen_.want_z[other]);
    const float both = seen_.radius[one] + seen_.radius[other];
    const float d2 = p.squaredNorm();
    if (d2 < both * both) {
        return true;
    }
    const float coming = p.dot(v);
    const float speed2 = v.squaredNorm();
    if (coming <= 0.0F || speed2 <= 0.0F) {
        return false;
    }
    const float when = std::min(coming / speed2, settings.horizon_s);
    const float near = both + kBerth;
    return (p - when * v).squaredNorm() < near * near;
}

/// The line between two characters, seen from one of them.
LocalAvoidance::DividingLine LocalAvoidance::side_of(std::uint32_t one, std::uint32_t other) const {
    const BrakingCourse& a = courses_[one];
    const BrakingCourse& b = courses_[other];
    Nearest points = nearest(a.at, a.end, b.at, b.end);
    float distance = std::sqrt(points.d2);
    Vec2 n = points.a - points.b;
    if (distance < 1e-5F) {
        // Where the courses meet, it points away from the other; on the same spot one goes left,
        // one right.
        n = a.at - b.at;
        const float apart = n.norm();
        n = apart > 1e-5F ? Vec2(n / apart)
                          : Vec2(seen_.id[one] < seen_.id[other] ? -1.0F : 1.0F, 0.0F);
        distance = 0.0F;
    } else {
        n /= distance;
    }
    const float margin = kMarginShare * std::min(seen_.radius[one], seen_.radius[other]);
    const float gap = distance - seen_.radius[one] - seen_.radius[other] - margin;
    const float share = seen_.yield[other] > 0.0F ? 0.5F : 1.0F;
    return {n, n.dot(points.a) - share * std::max(gap, 0.0F) - kRounding};
}

bool LocalAvoidance::is_crowded(std::uint32_t one,
                                const steering::CrowdBatch& batch,
                                const AiContext& ai,
                                const steering::AvoidanceSettings& settings) const {
    const world::Row row = rows_[one];
    bool crowded = false;
    bool looked = false;
    BrakingStop stop;
    for_each_near(batch, [&](std::uint32_t other) {
        if (crowded || other == one) {
            return;
        }
        const float d2 =
            Vec2(seen_.x[other] - seen_.x[one], seen_.z[other] - seen_.z[one]).squaredNorm();
        if (d2 > reach_ * reach_ || apart_in_height(one, other)) {
            return;
        }
        if (would_meet(one, other, settings)) {
            crowded = true;
            return;
        }
        // A character beyond the ends of both courses plus one tick's path cannot collide.
        const float most = seen_.radius[one] + seen_.radius[other] +
                           (courses_[one].end - courses_[one].at).norm() +
                           (courses_[other].end - courses_[other].at).norm() +
                           2.0F * (seen_.most_speed[one] + seen_.most_speed[other]) * ai.dt;
        if (d2 > most * most) {
            return;
        }
        if (!looked) {
            stop = stop_of(row, ai.entities.command[row], ai);
            looked = true;
            crowded = !stop.free;
        }
        const DividingLine side = side_of(one, other);
        crowded = crowded || side.n.dot(stop.at) < side.c || side.n.dot(stop.end) < side.c;
    });
    return crowded;
}

void LocalAvoidance::find_crowded(const AiContext& ai,
                                  const steering::AvoidanceSettings& settings) {
    const std::vector<steering::CrowdBatch>& batches = order_.batches();
    ai.team.run(batches.size(), kBatches, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            for (std::uint32_t i = batches[b].begin; i < batches[b].end; ++i) {
                const std::uint32_t one = order_.rows()[i];
                if (one < walkers_ && seen_.yield[one] > 0.0F &&
                    is_crowded(one, batches[b], ai, settings)) {
                    crowded_[one] = kCrowded;
                }
            }
        }
    });
}

/// Adds the neighbours of crowded walkers, so that these walkers see them.
void LocalAvoidance::take_in_neighbours(const steering::AvoidanceSettings& settings) {
    for (const steering::CrowdBatch& batch : order_.batches()) {
        for (std::uint32_t i = batch.begin; i < batch.end; ++i) {
            const std::uint32_t one = order_.rows()[i];
            if ((crowded_[one] & kCrowded) == 0) {
                continue;
            }
            for_each_near(batch, [&](std::uint32_t other) {
                const float d2 = Vec2(seen_.x[other] - seen_.x[one], seen_.z[other] - seen_.z[one])
                                     .squaredNorm();
                if (d2 < settings.neighbour_m * settings.neighbour_m &&
                    !apart_in_height(one, other)) {
                    crowded_[other] |= kNear;
                }
            });
        }
    }
    close_.clear();
    close_of_.assign(seen_.size(), 0);
    for (std::uint32_t i = 0; i < seen_.size(); ++i) {
        if (crowded_[i] == 0) {
            continue;
        }
        close_of_[i] = static_cast<std::uint32_t>(close_.size());
        close_.add(seen_.id[i], seen_.x[i], seen_.z[i], seen_.radius[i], seen_.most_speed[i]);
        close_.vx.back() = seen_.vx[i];
        close_.vz.back() = seen_.vz[i];
        close_.want_x.back() = seen_.want_x[i];
        close_.want_z.back() = seen_.want_z[i];
        close_.path_left.back() = seen_.path_left[i];
        close_.yield.back() = seen_.yield[i];
    }
}

// ---------------------------------------------------------------- choosing other commands

/// Computed as the movement pass will do in this tick.
LocalAvoidance::BrakingStop LocalAvoidance::stop_of(world::Row row,
                                                    const motion::InputCommand& command,
                                                    const AiContext& ai) const {
    const world::Entities& e = ai.entities;
    const motion::CharacterLimits& limits = ai.types[e.type[row]].character;
    const motion::CharacterState after = motion::apply_input(
        {e.position[row], e.velocity[row], e.yaw[row], e.has(row, world::kGrounded)},
        command,
        limits,
        ai.statics,
        ai.dt,
        ai.now);
    const Vec2 at = on_ground(after.position);
    const Vec2 end = braking_end(at, on_ground(after.velocity), limits);
    const bool free = brakes_freely(after.position, end, limits, ai.statics, ai.now);
    return {at, end, after.position.y(), free};
}

/// True if there is ground at the stopping place, as near below as movement keeps to it.
bool LocalAvoidance::is_carried(world::Row row, const BrakingStop& stop, const AiContext& ai) {
    const motion::CharacterLimits& limits = ai.types[ai.entities.type[row]].character;
    const float feet = stop.y - limits.radius - limits.half_segment;
    const float steep = (stop.end - stop.at).norm() * kSteepestFall;
    const float drop = limits.step_down + steep;
    if (feet - ai.statics.ground_height() <= drop) {
        return true;
    }
    const Vec3 above(stop.end.x(), stop.y + limits.step_up, stop.end.y());
    const float fall = limits.step_up + drop;
    const motion::CapsuleSweep sweep(
        ai.statics,
        {limits.radius, limits.half_segment},
        Aabb{above - Vec3(0.0F, fall, 0.0F), above}.grown(limits.radius + 0.1F),
        ai.now);
    const motion::SweepHit hit = sweep.sweep_down(above, fall, [&](const motion::SweepHit& h) {
        return h.normal.y() >= limits.max_slope_cos;
    });
    return hit.hit;
}

void LocalAvoidance::give_command(std::uint32_t one,
                                  const steering::CrowdBatch& batch,
                                  const AiContext& ai) {
    const world::Row row = rows_[one];
    const std::uint32_t near = close_of_[one];
    motion::InputCommand command = ai.entities.command[row];
    const motion::InputCommand want = command;
    const float full = std::max(1e-3F, gait(ai.types[ai.entities.type[row]].character, want));
    const Vec2 best = Vec2(close_.vx[near], close_.vz[near]) / full;
    // No walker is made to step off an edge, but one that wants to may.
    const bool leaps = !is_carried(row, stop_of(row, want, ai), ai);
    for (const float share : kTries) {
        command.move_x = slower(share * best.x());
        command.move_z = slower(share * best.y());
        const bool brakes = command.move_x == 0 && command.move_z == 0;
        outcome_[one] = brakes ? kHeld : 0;
        if (brakes) {
            break;
        }
        const BrakingStop stop = stop_of(row, command, ai);
        bool keeps = stop.free && (leaps || is_carried(row, stop, ai));
        for_each_near(batch, [&](std::uint32_t other) {
            if (!keeps || other == one || apart_in_height(one, other)) {
                return;
            }
            const float d2 =
                Vec2(seen_.x[other] - seen_.x[one], seen_.z[other] - seen_.z[one]).squaredNorm();
            if (d2 > reach_ * reach_) {
                return;
            }
            const DividingLine side = side_of(one, other);
            keeps = side.n.dot(stop.at) >= side.c && side.n.dot(stop.end) >= side.c;
        });
        if (keeps) {
            break;
        }
    }
    outcome_[one] |= command == want ? 0 : kGaveWay;
    ai.entities.command[row] = command;
}

void LocalAvoidance::give_commands(const AiContext& ai) {
    const std::vector<steering::CrowdBatch>& batches = order_.batches();
    ai.team.run(batches.size(), kBatches, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            for (std::uint32_t i = batches[b].begin; i < batches[b].end; ++i) {
                const std::uint32_t one = order_.rows()[i];
                if ((crowded_[one] & kCrowded) != 0) {
                    give_command(one, batches[b], ai);
                }
            }
        }
    });
}

LocalAvoidanceReport LocalAvoidance::step(std::span<const AvoidingAgent> walkers,
                                          const AiContext& ai,
                                          steering::KnownWalls& walls,
                                          const steering::AvoidanceSettings& settings) {
    LocalAvoidanceReport report;
    if (walkers.empty()) {
        return report;
    }
    gather(walkers, ai);
    reach_ = reach(ai, settings);
    order_.sort(seen_, reach_, ai.team);
    crowded_.assign(seen_.size(), 0);
    outcome_.assign(seen_.size(), 0);
    find_crowded(ai, settings);
    for (std::size_t i = 0; i < walkers_; ++i) {
        report.crowded += crowded_[i];
    }
    if (report.crowded == 0) {
        return report;
    }
    take_in_neighbours(settings);
    avoidance_.set(settings);
    avoidance_.step(close_, walls.of(ai.statics), static_cast<std::uint64_t>(ai.now), ai.team);
    give_commands(ai);
    for (std::size_t i = 0; i < walkers_; ++i) {
        report.gave_way += (outcome_[i] & kGaveWay) != 0 ? 1U : 0U;
        report.held += (outcome_[i] & kHeld) != 0 ? 1U : 0U;
    }
    return report;
}

}  // namespace zoned::ai
