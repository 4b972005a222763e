// Motors: leads the motors of joints to their targets, which follow time, rules or a driver.
#pragma once

#include "server/zone/zone_state.h"

namespace zoned::zone {

/// Gives a joint that was just made the motor of its plan.
void begin_motor(ZoneState& state, EntityJoint& joint);

/// Motors whose target goes on changing by itself.
std::uint32_t moving_motors(const ZoneState& state);

/// Lets drivers move the controls of what they ride, and tells the scene the speed of each motor
/// for the coming step. A motor that holds a position goes there as fast as it may, and slower from
/// where four ticks at that speed would overshoot. Returns how many motors there are.
std::uint32_t follow_motors(ZoneState& state);

/// Rules or a driver set the target from now on: rad/s or rad, m/s or m. False where the joint has
/// no motor, or the number is not finite or too large.
bool set_motor_target(ZoneState& state, EntityJoint& joint, float target);

/// Sets all controls of an assembly to what a stick that nobody touches gives.
void release_controls(ZoneState& state, EntityId root);

}  // namespace zoned::zone
