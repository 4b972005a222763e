#include "server/ai/learning/guard.h"

#include "shared/math/heading.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace zoned::ai::learning {

namespace {

constexpr float kFullMove = 127.0F;

bool finite(const Vec2& v) {
    return std::isfinite(v.x()) && std::isfinite(v.y());
}

/// The yaw `wish`, or the nearest yaw that it may reach by turning from `yaw`.
std::uint16_t turned(std::uint16_t yaw, std::uint16_t wish, const Guard& guard, float dt) {
    constexpr float kUnits = 32768.0F / std::numbers::pi_v<float>;
    const float most = std::clamp(guard.max_turn_radps * dt * kUnits, 0.0F, 32767.0F);
    const auto limit = static_cast<int>(most);
    const int off = static_cast<std::int16_t>(wish - yaw);
    return static_cast<std::uint16_t>(yaw + std::clamp(off, -limit, limit));
}

/// Towards zero, so that the whole is never longer than `share`.
std::int8_t part(float share) {
    return static_cast<std::int8_t>(share * kFullMove);
}

/// The distance that it may still get away from here before it is on its way home.
float path_needed(float speed, const Guarded& body, const motion::CharacterLimits& limits) {
    return speed * body.horizon_s + speed * speed / limits.acceleration;
}

/// The share of full speed for going home: 0 unless the agent faces home.
float share_homewards(std::uint16_t yaw, const Guard& guard, const Guarded& body, float full) {
    const float distance = body.from_home.norm();
    const Vec2 heading = heading_of(yaw);
    const float inwards = -heading.dot(body.from_home) / distance;
    // A straight path of length w that begins at 60 degrees or less ends no farther out while w <=
    // distance.
    const bool homewards = inwards >= 0.5F && full * body.horizon_s <= distance;
    return homewards ? guard.max_speed : 0.0F;
}

}  // namespace

motion::InputCommand guarded(const Guard& guard,
                             const Wanted& wanted,
                             const Guarded& body,
                             const motion::CharacterLimits& limits) {
    motion::InputCommand command;
    command.yaw = body.yaw;
    float share = wanted.move.norm();
    if (!finite(wanted.move) || !finite(body.from_home) || !finite(body.velocity)) {
        return command;
    }
    const bool sprint = wanted.sprint && guard.may_sprint;
    const float top = limits.speed * (sprint ? limits.sprint_factor : 1.0F);
    share = std::min(share, guard.max_speed);
    Vec2 direction = wanted.move;
    const float distance = body.from_home.norm();
    bool home = false;
    if (guard.max_home_m > 0.0F) {
        const float speed = std::max(body.velocity.norm(), share * top);
        home =
            !(distance + path_needed(speed, body, limits) <= guard.max_home_m) && distance > 0.0F;
        direction = home ? Vec2(-body.from_home) : direction;
    }
    if (direction.squaredNorm() > 0.0F) {
        command.yaw = turned(body.yaw, yaw_of(direction), guard, body.dt);
    }
    if (home) {
        share = share_homewards(command.yaw, guard, body, guard.max_speed * limits.speed);
    }
    const Vec2 heading = heading_of(command.yaw);
    command.move_x = part(heading.x() * share);
    command.move_z = part(heading.y() * share);
    const bool moves = command.move_x != 0 || command.move_z != 0;
    command.buttons = sprint && moves && !home ? motion::kButtonSprint : 0;
    return command;
}

}  // namespace zoned::ai::learning
