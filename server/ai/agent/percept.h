// Percept: the result of one look around by an agent.
#pragma once

#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <limits>

namespace zoned::ai {

struct Percept {
    EntityId prey;              ///< the target: noticed, or remembered; or none
    float distance = 0.0F;      ///< to it, horizontally, m; infinity when there is none
    bool player_far = true;     ///< no player within far_m
    bool noticed = true;        ///< the target was noticed; false: it is remembered
    Vec3 place = Vec3::Zero();  ///< of the target, where it is or was noticed last
    float confidence = 0.0F;    ///< [0, 1]: 1 for a noticed target, 0 for none
    float allies = 0.0F;        ///< within perception
    float foes = 0.0F;          ///< targets that it could see or hear if nothing were in between
    EntityId ward;              ///< the entity that it looks after, or none

    /// The percept of an agent that notices no entity.
    static Percept none() {
        Percept percept;
        percept.distance = std::numeric_limits<float>::infinity();
        return percept;
    }
};

}  // namespace zoned::ai
