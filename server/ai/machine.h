// Machine: a finite state machine as flat tables, compiled from the config at load.
#pragma once

#include "server/ai/senses.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::ai {

/// What a state makes its entity do.
enum class ActionKind : std::uint8_t {
    kIdle,    ///< stand still
    kWander,  ///< walk to random points within `radius_m` of home
    kPatrol,  ///< walk the square of `radius_m` around home, corner by corner
    kChase,   ///< run at the nearest player
    kFlee,    ///< run from the nearest player
    kFlock,  ///< separation, alignment, cohesion with its own type (Reynolds 1987), drifting around
             ///< home
    kReturn,  ///< walk home
};

/// What a transition's condition reads.
enum class Sensor : std::uint8_t {
    kPlayerDistance,  ///< to the nearest player, m; infinity when none is within `perception_m`
    kHomeDistance,    ///< m
    kTimeInState,     ///< s
    kRandom,          ///< uniform [0, 1) drawn once per decision
};

/// True for `hold_s` seconds on end before the transition fires: together with two thresholds this
/// is the hysteresis.
struct Transition {
    std::uint16_t to = 0;
    Sensor sensor = Sensor::kTimeInState;
    Compare compare = Compare::kAbove;
    float threshold = 0.0F;
    float hold_s = 0.0F;
};

struct State {
    std::string name;
    ActionKind action = ActionKind::kIdle;
    float speed_factor = 1.0F;  ///< of the character's speed, [0, 1]
    bool sprint = false;
    float radius_m = 20.0F;
    std::uint8_t behaviour = 0;           ///< index of the behavioural radii while in this state
    std::vector<Transition> transitions;  ///< tried in order, the first that holds is taken
};

struct Machine {
    std::string name;
    std::vector<State> states;    ///< the first is where an entity starts
    float perception_m = 40.0F;   ///< how far players are noticed
    float decide_every_s = 0.2F;  ///< period of decisions; steering runs every tick
};

}  // namespace zoned::ai
