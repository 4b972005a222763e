#include "server/rules/combat.h"

#include "server/rules/agreement.h"
#include "server/rules/machines/ragdolls.h"
#include "server/rules/peer_messages.h"

#include <algorithm>
#include <cmath>

namespace zoned::rules {

namespace {

constexpr Tick kBiteEvery = 8;  ///< avatars take turns: each is looked at every so many ticks

void fall(Game& game, RulesContext& context, EntityId entity, EntityId by) {
    CharacterRecord& record = game.characters.at(entity);
    record.killer = by;
    if (!record.client) {
        die(game, context, entity, record);
        return;
    }
    sandbox::Kill kill;
    kill.set_killer(by.value);
    kill.set_killed(entity.value);
    ++record.deaths;  // decided; all later messages include it
    record.kill_event = context.send(record.client, event(sandbox::EVENT_KILL, kill, true));
    record.life = Life::kDying;
    record.life_until = context.now() + ticks(context, game.settings.confirm_s);
    update_pending(game, entity);
}

bool is_npc(const RulesContext& context, world::Row row) {
    const world::Entities& e = context.entities();
    return !e.client[row] && context.types()[e.type[row]].brain != 0;
}

/// Reports a fight between a player and an NPC, which difficulty may follow. A killer that is gone
/// meanwhile reports nothing.
void send_outcome(RulesContext& context, EntityId killed, EntityId killer) {
    const world::Entities& e = context.entities();
    const world::Row loser = e.find(killed);
    const world::Row winner = killer ? e.find(killer) : world::kNoRow;
    if (loser == world::kNoRow || winner == world::kNoRow) {
        return;
    }
    if (e.client[winner] && is_npc(context, loser)) {
        context.note_outcome(true);
    } else if (e.client[loser] && is_npc(context, winner)) {
        context.note_outcome(false);
    }
}

void respawn(Game& game, RulesContext& context, EntityId entity, CharacterRecord& record) {
    context.show(entity, to_local(context, record.spawn), Vec3::Zero());
    record.health = static_cast<std::uint32_t>(game.settings.health);
    record.life = Life::kBack;
    record.life_until = context.now() + 1;
    record.killer = EntityId();
    ++game.stats.respawns;
}

}  // namespace

void die(Game& game, RulesContext& context, EntityId entity, CharacterRecord& record) {
    sandbox::Kill kill;
    kill.set_killer(record.killer.value);
    kill.set_killed(entity.value);
    // Announced before it is hidden: afterwards nobody hears of it any more.
    context.announce(entity, event(sandbox::EVENT_KILL, kill));
    send_outcome(context, entity, record.killer);
    fall_as_ragdoll(game, context, entity);
    context.hide(entity);
    record.life = Life::kDead;
    record.kill_event = EventId();
    record.life_until = context.now() + ticks(context, game.settings.respawn_s);
    ++game.stats.kills;
    update_pending(game, entity);
    const auto killer = game.characters.find(record.killer);
    if (killer != game.characters.end() && killer->second.client && killer->first != entity) {
        ++killer->second.kills;
        killer->second.killer_event =
            context.send(killer->second.client, event(sandbox::EVENT_KILL, kill, true));
        decided(game, context, killer->first, killer->second);
    }
    decided(game, context, entity, record);
}

void hurt(Game& game, RulesContext& context, EntityId target, EntityId by, std::uint32_t amount) {
    const world::Row row = context.entities().find(target);
    if (row == world::kNoRow) {
        return;
    }
    if (context.entities().has(row, world::kGhost)) {
        context.message(target, encode(Hurt{by, amount}));
        return;
    }
    take_damage(game, context, row, by, amount);
}

void take_damage(Game& game,
                 RulesContext& context,
                 world::Row row,
                 EntityId by,
                 std::uint32_t amount) {
    const EntityId entity = context.entities().id[row];
    CharacterRecord& record = record_of(game, context, row);
    if (record.life != Life::kAlive || context.entities().has(row, world::kHidden)) {
        return;
    }
    const std::uint32_t taken = std::min(amount, record.health);
    record.health -= taken;
    ++game.stats.hits;
    sandbox::Hit hit;
    hit.set_shooter(by.value);
    hit.set_target(entity.value);
    hit.set_damage(taken);
    hit.set_health_left(record.health);
    context.announce(entity, event(sandbox::EVENT_HIT, hit));
    if (record.health == 0) {
        fall(game, context, entity, by);
    }
}

void knock(RulesContext& context, EntityId target, const Vec3& change) {
    const world::Row row = context.entities().find(target);
    if (row == world::kNoRow) {
        return;
    }
    if (context.entities().has(row, world::kGhost)) {
        context.message(target, encode(Knock{change}));
    } else {
        context.add_velocity(target, change);
    }
}

void impact(Game& game, RulesContext& context, const zone::EntityContact& contact) {
    if (contact.approach_speed <= game.settings.impact_mps) {
        return;
    }
    // Both zones see the contact at a border: the owner of its first entity throws the debris.
    if (owned_row(context, contact.a ? contact.a : contact.b) != world::kNoRow) {
        // Off the static world, not into it.
        throw_debris(
            game, context, contact.point, contact.b ? contact.normal : Vec3(-contact.normal));
    }
    // Only the zone that owns the prop knows that it was thrown: so exactly one zone acts, though
    // both may see the contact.
    auto prop = game.props.find(contact.a);
    const bool prop_is_a = prop != game.props.end() && static_cast<bool>(prop->second.thrown_by);
    if (!prop_is_a) {
        prop = game.props.find(contact.b);
    }
    if (prop == game.props.end() || !prop->second.thrown_by) {
        return;
    }
    const EntityId victim = prop_is_a ? contact.b : contact.a;
    const EntityId by = prop->second.thrown_by;
    const world::Row row = victim ? context.entities().find(victim) : world::kNoRow;
    if (row == world::kNoRow || victim == by || !is_character(context, row)) {
        return;
    }
    const float mass = context.types()[context.entities().type[row]].mass;
    const float speed = std::min(contact.impulse / mass, game.settings.impact_knock_mps);
    const float wanted = contact.impulse * game.settings.impact_damage_per_ns;
    const auto damage =
        static_cast<std::uint32_t>(std::lround(std::clamp(wanted, 0.0F, game.settings.health)));
    const EntityId thing = prop->first;
    game.props.erase(prop);  // hits once
    update_pending(game, thing);
    knock(context, victim, contact.normal * (prop_is_a ? speed : -speed));
    if (damage > 0) {
        hurt(game, context, victim, by, damage);
    }
}

void confirm_kill(Game& game, RulesContext& context, ClientId client, EventId event) {
    const auto avatar = game.avatars.find(client);
    if (avatar != game.avatars.end()) {
        CharacterRecord& record = game.characters.at(avatar->second);
        if (record.life == Life::kDying && record.kill_event == event) {
            ++game.stats.confirmed;
            die(game, context, avatar->second, record);
            return;
        }
        // The other decisions stand already: it is only noted that the client knows.
        for (EventId* waits : {&record.trade_event, &record.killer_event}) {
            if (event && *waits == event) {
                *waits = EventId();
                ++game.stats.confirmed;
                return;
            }
        }
    }
    ++game.stats.stray_confirms;
}

void run_life(Game& game, RulesContext& context, EntityId entity, CharacterRecord& record) {
    if (record.life == Life::kAlive || context.now() < record.life_until) {
        return;
    }
    switch (record.life) {
        case Life::kAlive:
            break;
        case Life::kDying:
            ++game.stats.kills_unconfirmed;
            die(game, context, entity, record);
            break;
        case Life::kDead:
            respawn(game, context, entity, record);
            break;
        case Life::kBack: {
            sandbox::Respawn message;
            message.set_entity(entity.value);
            context.announce(entity, event(sandbox::EVENT_RESPAWN, message));
            record.life = Life::kAlive;
            update_pending(game, entity);
            break;
        }
    }
}

void bite(Game& game, RulesContext& context) {
    if (game.settings.bite_type.empty() || game.settings.bite_damage <= 0.0F) {
        return;
    }
    const TypeIndex type = context.type_named(game.settings.bite_type);
    const world::Entities& entities = context.entities();
    std::vector<EntityId> around;
    for (const auto& [client, avatar] : game.avatars) {
        CharacterRecord& record = game.characters.at(avatar);
        const bool turn = (context.now() + static_cast<Tick>(avatar.value)) % kBiteEvery == 0;
        const world::Row row = turn ? owned_row(context, avatar) : world::kNoRow;
        if (row == world::kNoRow || record.life != Life::kAlive ||
            context.now() < record.next_bite) {
            continue;
        }
        around.clear();
        context.near(entities.position[row], game.settings.bite_range_m, around);
        for (const EntityId other : around) {
            const world::Row biter = entities.find(other);
            if (biter != world::kNoRow && entities.type[biter] == type && other != avatar &&
                entities.stance[biter] == static_cast<std::uint8_t>(world::Stance::kRunning)) {
                record.next_bite = context.now() + ticks(context, game.settings.bite_cooldown_s);
                take_damage(game,
                            context,
                            row,
                            other,
                            static_cast<std::uint32_t>(game.settings.bite_damage));
                break;
            }
        }
    }
}

}  // namespace zoned::rules
