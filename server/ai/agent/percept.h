// Percept: what an agent noticed at one look around.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <limits>

namespace zoned::ai {

struct Percept {
    EntityId prey;              ///< the target: noticed, or remembered; or none
    float distance = 0.0F;      ///< to it, horizontally, m; infinity when there is none
    bool player_far = true;     ///< no player within far_m
    bool noticed = true;        ///< the target was, else it is remembered
    Vec3 place = Vec3::Zero();  ///< of the target, where it is or was noticed last
    float confidence = 0.0F;    ///< [0, 1]: 1 of one that is noticed, 0 of none
    float allies = 0.0F;        ///< within perception
    float foes = 0.0F;          ///< whom it looks for and could see or hear, were nothing between
    EntityId ward;              ///< the one that it looks after, or none

    /// Nobody is there.
    static Percept none() {
        Percept percept;
        percept.distance = std::numeric_limits<float>::infinity();
        return percept;
    }
};

}  // namespace zoned::ai
