// InputCommand: the intent of a player (or an agent) for its character during one tick.
#pragma once

#include "shared/core/ids.h"

#include <cstdint>

namespace zoned::motion {

/// Buttons that apply_input itself understands; the others belong to the rules of the game.
enum InputButton : std::uint16_t {
    kButtonJump = 1u << 0,
    kButtonSprint = 1u << 1,
    // Bits 4..15 are free for a studio's rules.
};

/// One tick of intent, small and quantised so that server and client compute with the same numbers.
struct InputCommand {
    Tick tick = 0;  ///< the server tick that shall consume it
    std::int8_t move_x =
        0;  ///< world x part of the wanted direction, -127..127 = -1..1 of full speed
    std::int8_t move_z = 0;     ///< world z part, same scale
    std::uint16_t yaw = 0;      ///< facing, 65536 = one turn about +y, 0 looks along +z
    std::int16_t pitch = 0;     ///< -16384..16384 = -90..90 degrees, up is positive
    std::uint16_t buttons = 0;  ///< InputButton bits

    friend bool operator==(const InputCommand&, const InputCommand&) = default;
};

}  // namespace zoned::motion
