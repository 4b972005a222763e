// Walk: what a mind does on its own account as legs, one after the other, by a timetable. It is the
// same whether the mind's entity is simulated and keeps to it, or is put where it has come to.
#pragma once

#include "server/ai/wish.h"

namespace zoned::ai {

/// Whose body is farther than this from where its leg says was pushed or held up, m: the leg is
/// made anew from where it is.
inline constexpr float kAstrayM = 1.0F;

/// Where a mind takes itself to be, x, z at the end of the last tick: where its leg says, unless
/// its body, which is at `body`, has gone astray. What it senses of itself follows from this alone,
/// so that it decides alike whether its body is simulated or not.
Vec2 whereabouts(const Mind& mind, const Vec2& body, Tick now, float dt);

/// Whether the walk hangs on nobody else, so that it goes by legs: those of herds, of who follows
/// somebody, runs or runs after somebody do not.
bool goes_by_legs(const Mind& mind, const State& state);

/// The mind's leg begins at its body, with the velocity of that; plan_leg() has to say where it
/// leads.
void start_leg(Mind& mind, const Surroundings& around);

/// Sets the leg to what the mind wants now, from its leg as it is. Moves on targets that are
/// reached. The same goal again: it just walks on.
void plan_leg(Mind& mind, const State& state, bool entered, const Surroundings& around);

}  // namespace zoned::ai
