// Walk: what a mind does on its own account as legs, one after the other, by a timetable. It is the
// same whether the mind's entity is simulated and keeps to it, or is put where it has come to.
#pragma once

#include "server/ai/wish.h"

namespace zoned::ai {

/// Whose body is farther than this from where its leg says was pushed or held up, m: the leg is
/// made anew from where it is.
inline constexpr float kAstrayM = 1.0F;

/// Whether the mind goes by its leg, and its body, which is at `body` (x, z, m), has not gone
/// astray.
bool keeps_to_leg(const Mind& mind, const Vec2& body, Tick now, float dt);

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

/// Whether the leg is at its end, or it is time to look again for a path that was not there.
inline bool leg_is_over(const Mind& mind, Tick now, float dt) {
    return now >= (mind.leg.length > 0.0F ? arrival_of(mind.leg, dt) : mind.again_at);
}

/// Sets the leg to what the mind wants now, from its leg as it is: to the next corner of its path,
/// or to another goal. Moves on targets that are reached. True: it needs a path to mind.leg.goal
/// first (whoever asks for it sets mind.on_path), and follow_path() in the same tick; nothing has
/// changed so far. Different minds may plan at the same time.
bool plan_leg(Mind& mind, const State& state, bool entered, const Surroundings& around);

/// For walks that go by no legs: turns `wish` to the next corner of a path to its goal where the
/// body can't go straight there. True: it needs a path, asked for anew at each decision, since
/// goals move.
bool turn_to_path(Mind& mind, const State& state, Wish& wish, const Surroundings& around);

/// Once the mind's path was asked for and served: sets out to its next corner, or ahead of it as
/// long as it waits; stands where there is none.
void follow_path(Mind& mind, const State& state, const Surroundings& around);

}  // namespace zoned::ai
