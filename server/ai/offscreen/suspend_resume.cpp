#include "server/ai/offscreen/suspend_resume.h"

#include "server/ai/agent/decision.h"
#include "server/ai/offscreen/herd.h"
#include "server/ai/offscreen/next_change_forecast.h"
#include "server/ai/steering/path_following.h"
#include "server/ai/steering/steering.h"
#include "shared/motion/apply_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace zoned::ai {

namespace {

const motion::CharacterLimits& limits_of(const AiContext& ai, world::Row row) {
    return ai.types[ai.entities.type[row]].character;
}

/// Less than this off the line is rounding, m.
constexpr float kOnLine_m = 0.005F;

/// The place at (x, z) of a character that walked there from `from`: on the floor that its map
/// knows, or, where it knows none, by the same walk.
Vec3 walked_to(const Vec2& at,
               const Vec3& from,
               const motion::CharacterLimits& limits,
               const AiContext& ai,
               world::Row row) {
    const bool has_map = ai.paths != nullptr && ai.paths->plans_for(ai.entities.type[row]);
    const float feet_m = limits.radius + limits.half_segment;
    const float floor =
        has_map
            ? ai.paths->floor_along(
                  ai.entities.type[row], {from.x(), from.z()}, from.y() - feet_m, {at.x(), at.y()})
            : pathfinding::kOnGround;
    const Vec2 way = at - over_ground(from);
    const float length = way.norm();
    if (std::isnan(floor) && length > 0.0F) {
        const Vec2 direction = way / length;
        const LookAhead walk = look_ahead(from, direction, length, limits, ai.statics, ai.now);
        if (walk.length >= length && walk.aside < kOnLine_m) {
            return {at.x(), walk.end.y(), at.y()};
        }
        // A timetable leads along a wall within it, and ends in the tick in which its walker would
        // meet one.
        const LookAhead slid =
            look_ahead(from, direction, length, limits, ai.statics, ai.now, kDriftM);
        if ((over_ground(slid.end) - at).norm() < kDriftM) {
            return slid.end;
        }
    }
    return standing_at(ai.statics, limits, from, at, floor, ai.now);
}

/// The walk of the entity until its next event.
struct Course {
    float speed = 0.0F;                    ///< its top speed, m/s
    const PathSegment* segment = nullptr;  ///< the segment that it keeps to; null: it goes with a
                                           ///< herd, which sets out anew before the forecast ends
};

Course course_of(const Agent& agent, const CompiledBrain& brain, const AiContext& ai) {
    const float speed =
        std::max(agent.segment.speed, velocity_at(agent.segment, ai.now - 1, ai.dt).norm());
    if (!roams(agent, brain)) {
        return {speed, &agent.segment};
    }
    const world::Row row = ai.entities.find(agent.entity);
    return {
        row == world::kNoRow
            ? speed
            : std::max(speed, roam_speed(brain.states[agent.current_action], limits_of(ai, row))),
        nullptr};
}

/// The input of a blend for an agent that perceives no entity; NaN where that may change.
float input_alone(SenseIndex sense, const Agent& agent, const CompiledBrain& brain) {
    switch (sense) {
        case kSensePlayerDistance:
            return Percept::none().distance;
        case kSenseConfidence:
        case kSenseAllies:
        case kSenseFoes:
            return 0.0F;
        case kSenseLeads:
            return leads(brain, EntityId()) ? 1.0F : 0.0F;
        default:
            break;
    }
    const std::size_t v = sense - std::size_t{kOwnSenses};
    const std::size_t count = brain.variables.size();
    const bool constant =
        sense >= kOwnSenses && v < count && brain.rates[agent.current_action * count + v] == 0.0F;
    return constant ? agent.variables[v] : std::numeric_limits<float>::quiet_NaN();
}

/// A simulated agent with a blend follows no segments.
bool blends(const Agent& agent, const CompiledBrain& brain) {
    return brain.choices[agent.state_machine.leaf].blend >= 0;
}

/// Whether a blend does one action to the full, and stays so: no later decision changes its degrees
/// by a bit. With constant inputs degrees get there within response_s (fuzzy::FuzzyStateMachine
/// moves them by a bounded step).
bool is_settled(const Agent& agent,
                const CompiledBrain& brain,
                const CompiledBrain::LeafChoice& choice) {
    if (agent.current_action < choice.first) {
        return false;
    }
    const CompiledBrain::Blend& blend = brain.blends[static_cast<std::size_t>(choice.blend)];
    std::array<float, fuzzy::kMaxInputs> in{};
    for (std::size_t k = 0; k < blend.inputs.size(); ++k) {
        in[k] = input_alone(blend.inputs[k], agent, brain);
        if (std::isnan(in[k])) {
            return false;
        }
    }
    std::array<float, kMaxBlended> only{};
    only[agent.current_action - choice.first] = 1.0F;
    std::array<float, kMaxBlended> next = agent.degrees;
    blend.brain.step(std::span<const float>(in.data(), blend.inputs.size()),
                     std::span(next.data(), blend.brain.states()));
    return agent.degrees == only && next == only;
}

/// A tick before which a trade at the agent's place cannot be done, as long as `wait` lasts. Adds
/// its stock to `wait`.
Tick trade_from(const Agent& agent,
                const CompiledBrain& brain,
                std::size_t t,
                const AiContext& ai,
                StockWait& wait) {
    const Trade& trade = brain.states[agent.current_action].trades[t];
    const bool in_stock = ai.points_of_interest.can(trade, ai.now);
    if (!able(agent, brain, trade, ai.now)) {
        const Tick from = able_from(agent, brain, trade, ai.now);
        if (in_stock || from > ai.now + decision_period(brain, ai.dt)) {
            return from;
        }
    }
    if (in_stock) {
        return ai.now + 1;
    }
    wait.trades = static_cast<std::uint8_t>(wait.trades | 1U << t);
    return kNever;
}

/// A tick before which the agent cannot be at a place where it is not now.
Tick at_place_from(const Agent& agent,
                   std::size_t place,
                   const Course& course,
                   const AiContext& ai) {
    const Vec2 here = position_at(agent.segment, ai.now - 1, ai.dt);
    const float way = ai.points_of_interest.outside(place, here) - kAtPointM;
    const Tick by_speed = ai.now + static_cast<Tick>(std::min(way / (course.speed * ai.dt), 1e9F));
    return course.segment == nullptr
               ? by_speed
               : std::max(by_speed,
                          stays_until(*course.segment,
                                      ai.points_of_interest.centre(place),
                                      ai.points_of_interest.radius_m(place) + kAtPointM,
                                      ai.now,
                                      ai.dt));
}

/// A tick before which the agent can do no trade that it still wants, as long as `wait` lasts. Adds
/// stock to `wait`. A trade at another point of interest has to wait until the agent can have
/// walked there.
Tick trades_from(const Agent& agent,
                 const CompiledBrain& brain,
                 const Course& course,
                 const AiContext& ai,
                 StockWait& wait) {
    const std::vector<Trade>& trades = brain.states[agent.current_action].trades;
    if (agent.wants == 0 || trades.empty()) {
        return kNever;
    }
    const Vec2 here = position_at(agent.segment, ai.now - 1, ai.dt);
    Tick from = kNever;
    for (std::size_t t = 0; t < trades.size(); ++t) {
        const bool away = ai.points_of_interest.outside(trades[t].place, here) > kAtPointM;
        if ((agent.wants & 1U << t) == 0 || (away && !(course.speed * ai.dt > 0.0F))) {
            continue;
        }
        from = std::min(from,
                        away ? at_place_from(agent, trades[t].place, course, ai)
                             : trade_from(agent, brain, t, ai, wait));
    }
    return std::max(from, ai.now + 1);
}

Tick segment_or_decision(const Agent& agent, const AiContext& ai) {
    const Tick arrives =
        agent.segment.length > 0.0F ? arrival_of(agent.segment, ai.dt) : agent.again_at;
    return std::min(agent.next_decision, std::max(arrives, ai.now + 1));
}

}  // namespace

bool can_suspend(const Agent& agent, const CompiledBrain& brain) {
    const BrainState& state = brain.states[agent.current_action];
    const CompiledBrain::LeafChoice& choice = brain.choices[agent.state_machine.leaf];
    // A policy acts a little differently at each tick.
    const bool even = (choice.blend < 0 || is_settled(agent, brain, choice)) &&
                      !std::holds_alternative<PolicyChoice>(state.choice);
    // A rubber band that goes back to 1 changes the speed at each tick.
    return even && !agent.prey && !agent.ward && agent.band == 1.0F;
}

void suspend(Agent& agent, const CompiledBrain& brain, const AiContext& ai, world::Row row) {
    world::Entities& e = ai.entities;
    if (!agent.timed) {
        Surroundings around = surroundings_of(ai, agent, row);
        around.all_out = blends(agent, brain);
        start_segment(agent, around);
        plan_segment(agent, brain.states[agent.current_action], true, around);
    }
    agent.placed = surroundings_of(ai, agent, row).body();
    e.command[row] = motion::InputCommand{};
    e.command[row].yaw = e.yaw[row];
    e.velocity[row].setZero();
    e.acceleration[row].setZero();
    e.set(row, world::kAtRest, true);
    e.set(row, world::kDozing, true);
    e.discontinuity_tick[row] = ai.now;
}

void catch_up(Agent& agent, const AiContext& ai, world::Row row) {
    world::Entities& e = ai.entities;
    const Vec2 at = position_at(agent.segment, ai.now - 1, ai.dt);
    if (at != surroundings_of(ai, agent, row).body()) {
        const motion::CharacterLimits& limits = limits_of(ai, row);
        const Vec3& body = e.position[row];
        // The end of its step is nearer to its position than where its entity was placed.
        const Vec3 from = on_step(agent) ? agent.target : body;
        const bool there = on_step(agent) && at_step_end(agent, at);
        e.position[row] = there ? from : walked_to(at, from, limits, ai, row);
        e.discontinuity_tick[row] = ai.now;
    }
    agent.placed = at;
}

bool walk_on(Agent& agent,
             const CompiledBrain& brain,
             const AiContext& ai,
             world::Row row,
             Slot slot) {
    const BrainState& state = brain.states[agent.current_action];
    const bool entered = std::exchange(agent.entered, false);
    agent.fresh = false;
    Surroundings around = surroundings_of(ai, agent, row, slot);
    around.all_out = blends(agent, brain);
    if (entered) {
        begin_action(agent, state, around);
    }
    return (entered || segment_is_over(agent, ai.now, ai.dt)) &&
           plan_segment(agent, state, entered, around);
}

Tick next_event(Agent& agent, const CompiledBrain& brain, const AiContext& ai) {
    const Tick period = decision_period(brain, ai.dt);
    Senses senses;
    const Vec2 here = position_at(agent.segment, ai.now - 1, ai.dt);
    const std::uint64_t wanted = brain.senses_of_leaf[agent.state_machine.leaf];
    sense(agent, brain, Percept::none(), here, ai.points_of_interest, ai.now, senses, wanted);
    const Course course = course_of(agent, brain, ai);
    const ForecastInputs inputs{
        course.speed, ai.points_of_interest.day_s(), ai.dt, ai.points_of_interest, course.segment};
    NextChange next_change = forecast_next_change(agent, brain, senses, inputs, ai.now);
    next_change.until =
        std::min(next_change.until, trades_from(agent, brain, course, ai, next_change.wait));
    agent.next_decision = next_change.until == kNever
                              ? kNever
                              : next_decision(agent.entity, period, next_change.until - 1);
    // An agent that decides at its very next decision anyway need not wait for stock as well.
    const bool at_once = agent.next_decision == next_decision(agent.entity, period, ai.now);
    agent.wait = at_once ? StockWait{} : next_change.wait;
    return segment_or_decision(agent, ai);
}

Tick next_event_undecided(Agent& agent, const CompiledBrain& brain, const AiContext& ai) {
    const std::uint64_t reads = brain.senses_of_leaf[agent.state_machine.leaf];
    const bool trades = agent.wants != 0 && !brain.states[agent.current_action].trades.empty();
    return trades || (reads & brain.senses_of_poi) != 0 ? next_event(agent, brain, ai)
                                                        : segment_or_decision(agent, ai);
}

void resume(Agent& agent, const CompiledBrain& brain, const AiContext& ai, world::Row row) {
    world::Entities& e = ai.entities;
    catch_up(agent, ai, row);
    const Vec2 velocity = velocity_at(agent.segment, ai.now - 1, ai.dt);
    e.velocity[row] = Vec3(velocity.x(), 0.0F, velocity.y());
    e.yaw[row] = agent.aim.yaw;
    e.orientation[row] = motion::orientation_from_yaw(agent.aim.yaw);
    e.set(row, world::kAtRest, velocity == Vec2::Zero());
    e.set(row, world::kDozing, false);
    e.set(row, world::kGrounded, true);
    e.discontinuity_tick[row] = ai.now;
    agent.offscreen_since = kNever;
    agent.next_proximity_check = kNever;
    // An agent far from players steers again at its turn, as it would have done.
    const Tick over =
        agent.segment.length > 0.0F ? arrival_of(agent.segment, ai.dt) : agent.again_at;
    agent.next_steering = std::clamp(over, ai.now, next_turn(agent, ai.now - 1));
    agent.detour_until = 0;
    agent.next_decision = next_decision(agent.entity, decision_period(brain, ai.dt), ai.now - 1);
    restart_progress(agent, e.position[row], ai.now);
}

}  // namespace zoned::ai
