#include "server/ai/update/meeting_update.h"

#include <algorithm>

namespace zoned::ai {

namespace {

/// An entity whose speed is above its own top speed by more than this share was pushed.
constexpr float kPushed = 1.01F;

bool is_met(const world::Entities& entities, world::Row row) {
    return !entities.has(row, world::kDozing) && !entities.has(row, world::kHidden);
}

/// The body of an entity that is at the position in its row.
ProximitySchedule::Body body_of(const AiContext& ai,
                                const PerceptionRanges& reaches,
                                PerceptionRanges::PerceiverKind kind,
                                world::Row row) {
    const Vec3& at = ai.entities.position[row];
    const Vec3& velocity = ai.entities.velocity[row];
    const float speed = Vec2(velocity.x(), velocity.z()).norm();
    return {
        kind, ai.entities.id[row], {at.x(), at.z()}, std::max(speed, reaches.top_speed(kind.type))};
}

/// The active agent of a row that meets others; null: the row has no agent in this zone.
const Agent* agent_at(const AiContext& ai, const AiTurn& turn, world::Row row) {
    if (row >= turn.slot_hints.size() || turn.slot_hints[row] >= ai.agents.slots()) {
        return nullptr;
    }
    const Agent& agent = ai.agents.at(turn.slot_hints[row]);
    return agent.entity == ai.entities.id[row] ? &agent : nullptr;
}

}  // namespace

void MeetingUpdate::index_suspended(const AiContext& ai, AiTurn& turn) {
    const bool changed =
        schedule_.ranges().set(ai.settings.compiled, ai.settings.brain_of_type, ai.types);
    if (!schedule_.ranges().any()) {
        return;
    }
    turn.slot_hints.resize(std::max<std::size_t>(turn.slot_hints.size(), ai.entities.size()));
    schedule_.grow(ai.agents.slots());
    if (!changed) {
        return;
    }
    schedule_.clear();
    for (std::size_t n = 0; n < ai.agents.size(); ++n) {
        const Slot slot = ai.agents.nth(n);
        Agent& agent = ai.agents.at(slot);
        const world::Row row = agent.tier == Tier::kSuspended
                                   ? row_of(ai.entities, agent.entity, turn.row_hints[slot])
                                   : world::kNoRow;
        if (row == world::kNoRow ||
            schedule_.ranges().farthest({ai.entities.type[row], agent.brain}) < 0.0F) {
            continue;
        }
        // One that was read again may be due in this tick, or have been put off to it by the last.
        const bool is_new = agent.next_proximity_check == kNever;
        agent.next_proximity_check = is_new ? ai.now : agent.next_proximity_check;
        schedule_.put(slot, ai.entities.type[row], ai, agent.next_event < ai.now, is_new ? 1 : 0);
    }
}

/// Simulated bodies look for suspended agents in turn. A body that was teleported or pushed looks
/// at once. Suspended agents check for each other at their scheduled ticks.
void MeetingUpdate::meet(const AiContext& ai, AiTurn& turn) {
    if (!schedule_.ranges().any()) {
        return;
    }
    const world::Entities& e = ai.entities;
    for (const Slot slot : ai.agents.active()) {
        const Agent& agent = ai.agents.at(slot);
        const world::Row row = row_of(e, agent.entity, turn.row_hints[slot]);
        turn.row_hints[slot] = row;
        if (row != world::kNoRow) {
            turn.slot_hints[row] = slot;
            look_around(ai, turn, {e.type[row], agent.brain}, row);
        }
    }
    if (schedule_.ranges().has_strangers(e.counts())) {
        for (world::Row row = 0; row < e.size(); ++row) {
            const PerceptionRanges::PerceiverKind kind = schedule_.ranges().kind_of(e.type[row]);
            if (schedule_.ranges().farthest(kind) >= 0.0F && is_met(e, row) &&
                agent_at(ai, turn, row) == nullptr) {
                look_around(ai, turn, kind, row);
            }
        }
    }
    schedule_.take_due(ai, [&](Slot slot) { check_suspended(ai, turn, slot); });
}

/// Looks around for one simulated body.
void MeetingUpdate::look_around(const AiContext& ai,
                                AiTurn& turn,
                                PerceptionRanges::PerceiverKind kind,
                                world::Row row) {
    const world::Entities& e = ai.entities;
    if (schedule_.ranges().farthest(kind) < 0.0F) {
        return;
    }
    const ProximitySchedule::Body body = body_of(ai, schedule_.ranges(), kind, row);
    const bool its_turn =
        (ai.now + static_cast<Tick>(body.entity.value)) % ProximitySchedule::kTurn == 0;
    const bool jumped = e.discontinuity_tick[row] >= ai.now - 1;
    if (its_turn || jumped || body.speed > kPushed * schedule_.ranges().top_speed(kind.type)) {
        schedule_.look_around(body, ai, turn.waking);
    }
}

void MeetingUpdate::check_suspended(const AiContext& ai, AiTurn& turn, Slot slot) {
    const ProximitySchedule::Body body = schedule_.suspended_body(slot, ai);
    Agent& agent = ai.agents.at(slot);
    if (agent.next_proximity_check <= ai.now) {
        const Tick apart = schedule_.apart(body, ai, turn.waking);
        if (apart < ProximitySchedule::kSoon) {
            turn.waking.push_back(slot);
            return;
        }
        agent.next_proximity_check = ai.now + apart - ProximitySchedule::kSoon / 2;
    }
    schedule_.put(slot, body.kind.type, ai, agent.next_event < ai.now);
}

/// An agent that has just come from another zone is checked soon.
void MeetingUpdate::settle(const AiContext& ai, AiTurn& turn, Slot slot, Tick left, bool late) {
    ai.agents.settle(slot, left, ai.dt, late);
    if (!schedule_.ranges().any()) {
        return;
    }
    Agent& agent = ai.agents.at(slot);
    const world::Row row = row_of(ai.entities, agent.entity, turn.row_hints[slot]);
    if (row == world::kNoRow ||
        schedule_.ranges().farthest({ai.entities.type[row], agent.brain}) < 0.0F) {
        return;
    }
    if (!schedule_.knows(slot, agent.entity)) {
        agent.next_proximity_check = ai.now;
    }
    schedule_.put(slot, ai.entities.type[row], ai, late);
}

bool MeetingUpdate::meets_nobody(const AiContext& ai,
                                 const AiTurn& turn,
                                 const DueAgent& due,
                                 Tick calm) {
    Agent& agent = ai.agents.at(due.slot);
    const world::Entities& e = ai.entities;
    const PerceptionRanges::PerceiverKind kind{e.type[due.row], agent.brain};
    if (!schedule_.ranges().any() || schedule_.ranges().farthest(kind) < 0.0F) {
        return true;
    }
    const ProximitySchedule::Body body = body_of(ai, schedule_.ranges(), kind, due.row);
    const Tick enough = std::max(calm, 2 * ProximitySchedule::kTurn);
    met_.clear();
    const Tick apart = schedule_.apart(body, ai, met_);
    bool alone = apart >= enough;
    // An entity that moves faster than any moves by itself looks around in every tick.
    const float radius = ProximitySchedule::within(schedule_.ranges().farthest(kind),
                                                   body.speed + schedule_.ranges().fastest(),
                                                   enough,
                                                   ai.dt);
    if (alone) {
        ai.near->for_each_within(body.at.x(), body.at.y(), radius, [&](world::Row row, float) {
            if (!alone || row == due.row || !is_met(e, row)) {
                return;
            }
            const Agent* const its = agent_at(ai, turn, row);
            const PerceptionRanges::PerceiverKind other =
                its != nullptr ? PerceptionRanges::PerceiverKind{e.type[row], its->brain}
                               : schedule_.ranges().kind_of(e.type[row]);
            const float reach = schedule_.ranges().between(kind, other);
            alone = reach < 0.0F ||
                    ProximitySchedule::apart(
                        body, body_of(ai, schedule_.ranges(), other, row), reach, ai.dt) >= enough;
        });
    }
    if (alone) {
        agent.next_proximity_check = ai.now + apart - ProximitySchedule::kSoon / 2;
    }
    return alone;
}

}  // namespace zoned::ai
