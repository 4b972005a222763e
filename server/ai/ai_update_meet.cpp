#include "server/ai/ai_update.h"
#include "server/ai/ai_update_lookup.h"

#include <algorithm>

namespace zoned::ai {

namespace {

/// Who is faster than it goes on its own account by more than this share was pushed.
constexpr float kPushed = 1.01F;

bool is_met(const world::Entities& entities, world::Row row) {
    return !entities.has(row, world::kDozing) && !entities.has(row, world::kHidden);
}

/// Of one who is where its row says.
ProximitySchedule::Body body_of(const AiContext& world,
                                const PerceptionRanges& reaches,
                                PerceptionRanges::PerceiverKind kind,
                                world::Row row) {
    const Vec3& at = world.entities.position[row];
    const Vec3& velocity = world.entities.velocity[row];
    const float speed = Vec2(velocity.x(), velocity.z()).norm();
    return {kind,
            world.entities.id[row],
            {at.x(), at.z()},
            std::max(speed, reaches.top_speed(kind.type))};
}

}  // namespace

ProximitySchedule::Scene AiUpdate::scene(const AgentStore& agents, const AiContext& world) const {
    return {agents, perception_ranges_, world.half_size, world.shared_m, world.now, world.dt};
}

/// Of an active one that meets others; null: it has no agent here.
const Agent* AiUpdate::agent_at(const AgentStore& agents,
                                const world::Entities& entities,
                                world::Row row) const {
    if (row >= slot_hints_.size() || slot_hints_[row] >= agents.slots()) {
        return nullptr;
    }
    const Agent& agent = agents.at(slot_hints_[row]);
    return agent.entity == entities.id[row] ? &agent : nullptr;
}

/// Who looks for whom; where that is new, who sleeps and meets others is found anew.
void AiUpdate::index_suspended(AgentStore& agents,
                               const AiContext& world,
                               const AiSettings& settings) {
    const bool changed =
        perception_ranges_.set(settings.compiled, settings.brain_of_type, world.types);
    if (!perception_ranges_.any()) {
        return;
    }
    slot_hints_.resize(std::max<std::size_t>(slot_hints_.size(), world.entities.size()));
    proximity_schedule_.grow(agents.slots());
    if (!changed) {
        return;
    }
    proximity_schedule_.clear();
    const ProximitySchedule::Scene scene = this->scene(agents, world);
    for (std::size_t n = 0; n < agents.size(); ++n) {
        const Slot slot = agents.nth(n);
        Agent& agent = agents.at(slot);
        const world::Row row = agent.tier == Tier::kSuspended
                                   ? row_of(world.entities, agent.entity, row_hints_[slot])
                                   : world::kNoRow;
        if (row == world::kNoRow ||
            perception_ranges_.farthest({world.entities.type[row], agent.brain}) < 0.0F) {
            continue;
        }
        agent.next_proximity_check =
            agent.next_proximity_check == kNever ? world.now : agent.next_proximity_check;
        proximity_schedule_.put(
            slot, world.entities.type[row], scene, agent.next_event < world.now);
    }
}

/// Wakes those who may come to perceive somebody, or be perceived. All that is simulated looks for
/// them in turn, what was put somewhere or pushed at once; those who sleep among themselves when it
/// is time.
void AiUpdate::meet(AgentStore& agents, const AiContext& world) {
    if (!perception_ranges_.any()) {
        return;
    }
    const world::Entities& e = world.entities;
    for (const Slot slot : agents.active()) {
        const Agent& agent = agents.at(slot);
        const world::Row row = row_of(e, agent.entity, row_hints_[slot]);
        row_hints_[slot] = row;
        if (row != world::kNoRow) {
            slot_hints_[row] = slot;
            look_around(agents, world, {e.type[row], agent.brain}, row);
        }
    }
    if (perception_ranges_.has_strangers(e.counts())) {
        for (world::Row row = 0; row < e.size(); ++row) {
            const PerceptionRanges::PerceiverKind kind = perception_ranges_.kind_of(e.type[row]);
            if (perception_ranges_.farthest(kind) >= 0.0F && is_met(e, row) &&
                agent_at(agents, e, row) == nullptr) {
                look_around(agents, world, kind, row);
            }
        }
    }
    proximity_schedule_.take_due(scene(agents, world),
                                 [&](Slot slot) { check_suspended(agents, world, slot); });
}

/// Of one who is simulated.
void AiUpdate::look_around(const AgentStore& agents,
                           const AiContext& world,
                           PerceptionRanges::PerceiverKind kind,
                           world::Row row) {
    const world::Entities& e = world.entities;
    if (perception_ranges_.farthest(kind) < 0.0F) {
        return;
    }
    const ProximitySchedule::Body body = body_of(world, perception_ranges_, kind, row);
    const bool turn =
        (world.now + static_cast<Tick>(body.entity.value)) % ProximitySchedule::kTurn == 0;
    const bool jumped = e.discontinuity_tick[row] >= world.now - 1;
    if (turn || jumped || body.speed > kPushed * perception_ranges_.top_speed(kind.type)) {
        proximity_schedule_.look_around(body, scene(agents, world), waking_);
    }
}

void AiUpdate::check_suspended(AgentStore& agents, const AiContext& world, Slot slot) {
    const ProximitySchedule::Scene scene = this->scene(agents, world);
    const ProximitySchedule::Body body = proximity_schedule_.suspended_body(slot, scene);
    Agent& agent = agents.at(slot);
    if (agent.next_proximity_check <= world.now) {
        const Tick apart = proximity_schedule_.apart(body, scene, waking_);
        if (apart < ProximitySchedule::kSoon) {
            waking_.push_back(slot);
            return;
        }
        agent.next_proximity_check = world.now + apart - ProximitySchedule::kSoon / 2;
    }
    proximity_schedule_.put(slot, body.kind.type, scene, agent.next_event < world.now);
}

/// AgentStore::settle(), for proximity_schedule as well. Who is new here, from another zone, is
/// checked soon.
void AiUpdate::settle(AgentStore& agents, Slot slot, Tick left, const AiContext& world, bool late) {
    agents.settle(slot, left, world.dt, late);
    if (!perception_ranges_.any()) {
        return;
    }
    Agent& agent = agents.at(slot);
    const world::Row row = row_of(world.entities, agent.entity, row_hints_[slot]);
    if (row == world::kNoRow ||
        perception_ranges_.farthest({world.entities.type[row], agent.brain}) < 0.0F) {
        return;
    }
    if (!proximity_schedule_.knows(slot, agent.entity)) {
        agent.next_proximity_check = world.now;
    }
    proximity_schedule_.put(slot, world.entities.type[row], scene(agents, world), late);
}

/// Whether an active agent can fall asleep, though it meets others: for so long nobody comes. Says
/// when it is to be checked then.
bool AiUpdate::meets_nobody(AgentStore& agents,
                            const DueAgent& due,
                            const AiContext& world,
                            Tick calm) {
    Agent& agent = agents.at(due.slot);
    const world::Entities& e = world.entities;
    const PerceptionRanges::PerceiverKind kind{e.type[due.row], agent.brain};
    if (!perception_ranges_.any() || perception_ranges_.farthest(kind) < 0.0F) {
        return true;
    }
    const ProximitySchedule::Scene scene = this->scene(agents, world);
    const ProximitySchedule::Body body = body_of(world, perception_ranges_, kind, due.row);
    const Tick enough = std::max(calm, 2 * ProximitySchedule::kTurn);
    met_.clear();
    const Tick apart = proximity_schedule_.apart(body, scene, met_);
    bool alone = apart >= enough;
    // Who is faster than anybody goes by itself is on the watch all the time.
    const float radius = ProximitySchedule::within(perception_ranges_.farthest(kind),
                                                   body.speed + perception_ranges_.fastest(),
                                                   enough,
                                                   world.dt);
    if (alone) {
        others_->for_each_within(body.at.x(), body.at.y(), radius, [&](world::Row row, float) {
            if (!alone || row == due.row || !is_met(e, row)) {
                return;
            }
            const Agent* const its = agent_at(agents, e, row);
            const PerceptionRanges::PerceiverKind other =
                its != nullptr ? PerceptionRanges::PerceiverKind{e.type[row], its->brain}
                               : perception_ranges_.kind_of(e.type[row]);
            const float reach = perception_ranges_.between(kind, other);
            alone = reach < 0.0F ||
                    ProximitySchedule::apart(
                        body, body_of(world, perception_ranges_, other, row), reach, world.dt) >=
                        enough;
        });
    }
    if (alone) {
        agent.next_proximity_check = world.now + apart - ProximitySchedule::kSoon / 2;
    }
    return alone;
}

}  // namespace zoned::ai
