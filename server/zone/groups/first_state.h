// FirstState: the entities of an instance as its config places them, made when it opens and
// removed when it ends.
#pragma once

#include "server/zone/context/rules_records.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::zone {

struct ZoneState;

/// Shared by all copies: positions are zone-local.
struct FirstState {
    struct FirstEntity {
        SpawnDef def;
        std::string name;  ///< may be empty
    };

    struct FirstJointEnd {
        int entity = -1;  ///< -1: the world
        std::uint16_t part = 0;
    };

    struct FirstJoint {
        FirstJointEnd a;
        FirstJointEnd b;
        std::uint16_t number = 0;  ///< of ZoneSettings::placed_joints
    };

    std::vector<FirstEntity> entities;
    std::vector<FirstJoint> joints;
};

/// Makes the maps of paths that a copy has while it is open.
void load_maps(ZoneState& state);

/// In a zone without entities but avatars. Its names are those of its own entities.
void place_first_state(ZoneState& state);

/// Removes all entities but avatars, with what the rules remember of them, all timers, and the maps
/// of paths.
void clear_zone(ZoneState& state);

}  // namespace zoned::zone
