#include "server/ai/ai_step.h"
#include "server/ai/step_lookup.h"

#include <algorithm>

namespace zoned::ai {

namespace {

/// Who is faster than it goes on its own account by more than this share was pushed.
constexpr float kPushed = 1.01F;

bool is_met(const world::Entities& entities, world::Row row) {
    return !entities.has(row, world::kDozing) && !entities.has(row, world::kHidden);
}

/// Of one who is where its row says.
Encounters::Body body_of(const AiContext& world,
                         const Reaches& reaches,
                         Reaches::Kind kind,
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

Encounters::Scene AiUpdate::scene(const AgentStore& agents, const AiContext& world) const {
    return {agents, reaches_, world.half_size, world.shared_m, world.now, world.dt};
}

/// Of an awake one that meets others; null: it has no agent here.
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
void AiUpdate::know_sleepers(AgentStore& agents,
                             const AiContext& world,
                             const AiSettings& settings) {
    const bool changed = reaches_.set(settings.compiled, settings.brain_of_type, world.types);
    if (!reaches_.any()) {
        return;
    }
    slot_hints_.resize(std::max<std::size_t>(slot_hints_.size(), world.entities.size()));
    encounters_.grow(agents.slots());
    if (!changed) {
        return;
    }
    encounters_.clear();
    const Encounters::Scene scene = this->scene(agents, world);
    for (std::size_t n = 0; n < agents.size(); ++n) {
        const Slot slot = agents.nth(n);
        Agent& agent = agents.at(slot);
        const world::Row row = agent.tier == Tier::kCoarse
                                   ? row_of(world.entities, agent.entity, row_hints_[slot])
                                   : world::kNoRow;
        if (row == world::kNoRow ||
            reaches_.farthest({world.entities.type[row], agent.brain}) < 0.0F) {
            continue;
        }
        agent.look_at = agent.look_at == kNever ? world.now : agent.look_at;
        encounters_.put(slot, world.entities.type[row], scene, agent.next_event < world.now);
    }
}

/// Wakes those who may come to perceive somebody, or be perceived. All that is simulated looks for
/// them in turn, what was put somewhere or pushed at once; those who sleep among themselves when it
/// is time.
void AiUpdate::meet(AgentStore& agents, const AiContext& world) {
    if (!reaches_.any()) {
        return;
    }
    const world::Entities& e = world.entities;
    for (const Slot slot : agents.awake()) {
        const Agent& agent = agents.at(slot);
        const world::Row row = row_of(e, agent.entity, row_hints_[slot]);
        row_hints_[slot] = row;
        if (row != world::kNoRow) {
            slot_hints_[row] = slot;
            look_around(agents, world, {e.type[row], agent.brain}, row);
        }
    }
    if (reaches_.has_strangers(e.counts())) {
        for (world::Row row = 0; row < e.size(); ++row) {
            const Reaches::Kind kind = reaches_.kind_of(e.type[row]);
            if (reaches_.farthest(kind) >= 0.0F && is_met(e, row) &&
                agent_at(agents, e, row) == nullptr) {
                look_around(agents, world, kind, row);
            }
        }
    }
    encounters_.take_due(scene(agents, world),
                         [&](Slot slot) { check_sleeper(agents, world, slot); });
}

/// Of one who is simulated.
void AiUpdate::look_around(const AgentStore& agents,
                           const AiContext& world,
                           Reaches::Kind kind,
                           world::Row row) {
    const world::Entities& e = world.entities;
    if (reaches_.farthest(kind) < 0.0F) {
        return;
    }
    const Encounters::Body body = body_of(world, reaches_, kind, row);
    const bool turn = (world.now + static_cast<Tick>(body.entity.value)) % Encounters::kTurn == 0;
    const bool jumped = e.discontinuity_tick[row] >= world.now - 1;
    if (turn || jumped || body.speed > kPushed * reaches_.top_speed(kind.type)) {
        encounters_.look_around(body, scene(agents, world), waking_);
    }
}

void AiUpdate::check_sleeper(AgentStore& agents, const AiContext& world, Slot slot) {
    const Encounters::Scene scene = this->scene(agents, world);
    const Encounters::Body body = encounters_.sleeper(slot, scene);
    Agent& agent = agents.at(slot);
    if (agent.look_at <= world.now) {
        const Tick apart = encounters_.apart(body, scene, waking_);
        if (apart < Encounters::kSoon) {
            waking_.push_back(slot);
            return;
        }
        agent.look_at = world.now + apart - Encounters::kSoon / 2;
    }
    encounters_.put(slot, body.kind.type, scene, agent.next_event < world.now);
}

/// AgentStore::settle(), for encounters as well. Who is new here, from another zone, is checked
/// soon.
void AiUpdate::settle(AgentStore& agents, Slot slot, Tick left, const AiContext& world, bool late) {
    agents.settle(slot, left, world.dt, late);
    if (!reaches_.any()) {
        return;
    }
    Agent& agent = agents.at(slot);
    const world::Row row = row_of(world.entities, agent.entity, row_hints_[slot]);
    if (row == world::kNoRow || reaches_.farthest({world.entities.type[row], agent.brain}) < 0.0F) {
        return;
    }
    if (!encounters_.knows(slot, agent.entity)) {
        agent.look_at = world.now;
    }
    encounters_.put(slot, world.entities.type[row], scene(agents, world), late);
}

/// Whether an awake agent can fall asleep, though it meets others: for so long nobody comes. Says
/// when it is to be checked then.
bool AiUpdate::meets_nobody(AgentStore& agents, const Due& due, const AiContext& world, Tick calm) {
    Agent& agent = agents.at(due.slot);
    const world::Entities& e = world.entities;
    const Reaches::Kind kind{e.type[due.row], agent.brain};
    if (!reaches_.any() || reaches_.farthest(kind) < 0.0F) {
        return true;
    }
    const Encounters::Scene scene = this->scene(agents, world);
    const Encounters::Body body = body_of(world, reaches_, kind, due.row);
    const Tick enough = std::max(calm, 2 * Encounters::kTurn);
    met_.clear();
    const Tick apart = encounters_.apart(body, scene, met_);
    bool alone = apart >= enough;
    // Who is faster than anybody goes by itself is on the watch all the time.
    const float radius = Encounters::within(
        reaches_.farthest(kind), body.speed + reaches_.fastest(), enough, world.dt);
    if (alone) {
        others_->for_each_within(body.at.x(), body.at.y(), radius, [&](world::Row row, float) {
            if (!alone || row == due.row || !is_met(e, row)) {
                return;
            }
            const Agent* const its = agent_at(agents, e, row);
            const Reaches::Kind other = its != nullptr ? Reaches::Kind{e.type[row], its->brain}
                                                       : reaches_.kind_of(e.type[row]);
            const float reach = reaches_.between(kind, other);
            alone = reach < 0.0F ||
                    Encounters::apart(
                        body, body_of(world, reaches_, other, row), reach, world.dt) >= enough;
        });
    }
    if (alone) {
        agent.look_at = world.now + apart - Encounters::kSoon / 2;
    }
    return alone;
}

}  // namespace zoned::ai
