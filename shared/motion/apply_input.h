// apply_input: one tick of character movement, the same function on the server and in the client's
// prediction.
#pragma once

#include "shared/math/types.h"
#include "shared/motion/input_command.h"
#include "shared/motion/static_geometry.h"

namespace zoned::motion {

/// Body and abilities of a character type.
struct CharacterLimits {
    float radius = 0.4F;            ///< capsule radius, m
    float half_segment = 0.5F;      ///< half length of the capsule's segment along y, m
    float speed = 5.0F;             ///< full walking speed, m/s
    float sprint_factor = 1.6F;     ///< speed with kButtonSprint / speed
    float acceleration = 20.0F;     ///< on the ground, m/s2
    float air_acceleration = 4.0F;  ///< in the air, m/s2
    float jump_speed = 5.0F;        ///< m/s
    float max_slope_cos = 0.64F;    ///< steeper ground (normal.y below this) does not carry
    float step_down = 0.35F;        ///< largest drop that a walking character follows down, m
    float gravity = kGravity;       ///< m/s2
    float step_up = 0.3F;  ///< highest ledge that a walking character climbs, m; works up to
                           ///< 0.9 radius, higher ledges are walls
};

/// The full movement state of a character; `position` is the capsule's centre.
struct CharacterState {
    Vec3 position = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    std::uint16_t yaw = 0;
    bool grounded = false;
    /// Moves straight on, whatever its command: it rides on something, or is hidden and stands.
    bool carried = false;
};

/// Moves an upright capsule for `dt` seconds (dt > 0).
/// - On the ground the horizontal velocity goes towards the wanted one at `acceleration`; the
///   vertical one follows the ground. Walls are slid along, ground that falls away is followed down
///   by `step_down`, ledges are climbed up to `step_up`. A vertical velocity given from outside to
///   a grounded character has no effect: clear `grounded` to throw it.
/// - In the air the vertical motion is the exact parabola; steep slopes are slid down.
/// - A grounded character without input and velocity keeps its state bit for bit, only the yaw
///   follows the command: there is no creep on a slope that carries.
/// - Carried, it keeps its velocity and turns; who carries it says otherwise.
/// - Nothing tunnels at any speed: moves are swept, and keep about a millimetre of air to boxes. A
///   capsule that begins inside a box is moved out by the shortest way.
/// - Doors are as at `tick`, which is the one whose state is returned. A door that shuts on a
///   character pushes it out by the shortest way, at its walking speed; a character that
///   stands still is moved as well. kAllDoorsOpen: no door and no platform is there.
/// - `dt` is one tick where a platform is near. A character that stands on a platform is carried
///   along (PlatformCarry) and walks relative to it; its velocity is that of the world. Jumping or
///   walking off, it keeps the platform's velocity. In the air over a platform, up to the height of
///   a jump, it steers relative to it, so that a jump straight up comes down where it began.
/// Deterministic: same arguments, same bits. No allocation.
CharacterState apply_input(const CharacterState& from,
                           const InputCommand& command,
                           const CharacterLimits& limits,
                           const StaticGeometry& world,
                           float dt,
                           Tick tick = kAllDoorsOpen);

/// Whether a door may move a character that stands still there. A door that touches it has just
/// shut or opened, or a shut door overlaps it.
bool moved_by_door(const Vec3& position,
                   const CharacterLimits& limits,
                   const StaticGeometry& world,
                   Tick tick);

/// Orientation of a character that faces `yaw` (65536 = one turn about +y).
Quat orientation_from_yaw(std::uint16_t yaw);

}  // namespace zoned::motion
