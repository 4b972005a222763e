// Terrain walk: where a character comes that walks over the static world, found without a body.
#pragma once

#include "shared/motion/apply_input.h"
#include "shared/motion/static_geometry.h"

namespace zoned::ai {

/// x and z.
inline Vec2 over_ground(const Vec3& v) {
    return {v.x(), v.z()};
}

/// The velocity that a command asks for, as in motion::apply_input(); x, z, m/s.
Vec2 wanted_by(const motion::InputCommand& command, const motion::CharacterLimits& limits);

/// A character after a walk along walls, over ledges, up and down the ground (motion::apply_input).
/// `free`: nothing was in its path.
struct Walked {
    motion::CharacterState state;
    bool free = true;
};

/// Walks for `time_s` (longer than a tick) by one held command. Even and free ground takes one
/// piece, other ground as many pieces as follow it. Each piece climbs ledges once, and once follows
/// ground that falls away.
Walked walked(const motion::CharacterState& from,
              const motion::InputCommand& command,
              const motion::CharacterLimits& limits,
              const motion::StaticGeometry& statics,
              float time_s,
              Tick now);

/// A straight walk may lead as deep into a wall along which its walker slides, m. The walker itself
/// stands beside the wall, however thin it is: it is placed by such a walk.
inline constexpr float kLedAside_m = 0.1F;

/// A straight walk that was tried ahead of time.
struct LookAhead {
    float length = 0.0F;      ///< m, of it before something solid holds the character up
    float aside = 0.0F;       ///< m, by which that has led it off its line
    Vec3 end = Vec3::Zero();  ///< where it is then, m
};

/// How far a character at `from` gets that wants to walk `length` m along `direction` (x, z, unit).
/// Ledges, slopes and drops that it can take do not hold it up. Nor does what it slides along, as
/// long as that leads it aside by `aside_m` at most. The world is as at `now`.
LookAhead look_ahead(const Vec3& from,
                     const Vec2& direction,
                     float length,
                     const motion::CharacterLimits& limits,
                     const motion::StaticGeometry& statics,
                     Tick now,
                     float aside_m = kLedAside_m);

/// The place at (x, z) where a character that came from `before` stands at `tick`. `floor`: height
/// of its feet on a map of several layers; NaN where there is none.
Vec3 standing_at(const motion::StaticGeometry& statics,
                 const motion::CharacterLimits& limits,
                 const Vec3& before,
                 const Vec2& at,
                 float floor,
                 Tick tick);

}  // namespace zoned::ai
