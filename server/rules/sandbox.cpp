#include "server/rules/sandbox.h"

#include "server/rules/agents/gate_guard.h"
#include "server/rules/agreement.h"
#include "server/rules/archive.h"
#include "server/rules/chat.h"
#include "server/rules/combat.h"
#include "server/rules/inventory.h"
#include "server/rules/keeping/kept_character.h"
#include "server/rules/machines/ragdolls.h"
#include "server/rules/machines/vehicles.h"
#include "server/rules/peer_messages.h"
#include "server/rules/push.h"
#include "server/rules/shooting.h"
#include "server/rules/weather.h"
#include "shared/core/archive/field_archive.h"

namespace zoned::rules {

namespace {

constexpr std::size_t kMaxPayload = 512;
constexpr float kIdleAfterS = 1.0F;
/// Of an input's scale of 127: what asks for more than half of the walking speed does not sneak.
constexpr int kSneakPace = 64;
/// First byte of a saved record; a change of the fields changes it.
constexpr std::uint8_t kCharacterFormat = 0x13;
constexpr std::uint8_t kPropFormat = 0x21;
constexpr std::uint8_t kRagdollFormat = 0x31;

zone::RulesEvent name_event(sandbox::EventKind kind, const CharacterRecord& who, EntityId avatar) {
    sandbox::PlayerName name;
    name.set_client(who.client.value);
    name.set_avatar(avatar.value);
    name.set_name(who.name);
    return event(kind, name);
}

/// The stance that an input calls for by itself; none: it depends on what came before.
std::optional<world::Stance> stance_of(const RulesContext& context,
                                       const motion::InputCommand& command) {
    const int pace2 = command.move_x * command.move_x + command.move_z * command.move_z;
    if (pace2 != 0 && (command.buttons & motion::kButtonSprint) != 0) {
        return world::Stance::kRunning;
    }
    std::optional<world::Stance> stance;
    if ((command.buttons & sandbox::BUTTON_SPYGLASS) != 0) {
        stance = context.stance_named("spyglass");
    }
    if (!stance && (command.buttons & sandbox::BUTTON_SNEAK) != 0 &&
        pace2 <= kSneakPace * kSneakPace) {
        stance = context.stance_named("sneaking");
    }
    return stance;
}

template <class Archive>
void serialize_game(Archive& archive, Game& game) {
    archive(game.characters, game.props, game.ragdolls, game.avatars, game.pending);
    archive(game.surveyed, game.stats);
}

}  // namespace

Sandbox::Sandbox(const zone::RulesSettings& settings, const world::TypeTable& types) {
    game_.settings = parse_settings(settings, types);
}

EntityId Sandbox::on_join(RulesContext& context, const zone::JoinRequest& request) {
    zone::SpawnDef def;
    def.type = context.type_named(game_.settings.player_type);
    def.position = request.spawn_position;
    def.client = request.client;
    const EntityId avatar = context.spawn(def);
    CharacterRecord& record = game_.characters[avatar];
    record = CharacterRecord{};
    record.client = request.client;
    record.name = request.name;
    record.team = request.team;
    record.spawn = to_world(context, request.spawn_position);
    record.health = static_cast<std::uint32_t>(game_.settings.health);
    record.moved_at = context.now();
    game_.avatars[request.client] = avatar;
    // Subscribed first, so that a client hears of its own arrival and knows by which name.
    context.subscribe(request.client, kWorldTopic);
    if (!request.team.empty()) {
        context.subscribe(request.client, team_topic(request.team));
    }
    context.publish(kWorldTopic, name_event(sandbox::EVENT_JOIN, record, avatar));
    record.account = request.account;
    ask_for_kept(context, avatar, record);
    return avatar;
}

void Sandbox::on_leave(RulesContext& context, ClientId client, EntityId avatar) {
    const auto it = game_.characters.find(avatar);
    const world::Row row = owned_row(context, avatar);
    if (it != game_.characters.end() && it->second.client == client) {
        context.publish(kWorldTopic, name_event(sandbox::EVENT_LEAVE, it->second, avatar));
        if (row != world::kNoRow) {
            if (it->second.life == Life::kDying) {
                die(game_, context, avatar, it->second);  // leaving does not undo a kill
            }
            if (!is_kept(it->second)) {
                drop_inventory(context, row, it->second);
            }
        }
    }
    forget(game_, avatar);
    if (row != world::kNoRow) {
        context.despawn(avatar);
    }
}

void Sandbox::on_command(RulesContext& context,
                         ClientId client,
                         EntityId avatar,
                         std::uint16_t kind,
                         std::span<const std::uint8_t> payload) {
    ++game_.stats.commands;
    const auto it = game_.characters.find(avatar);
    Actor actor{client, avatar, owned_row(context, avatar), nullptr, kind};
    if (it == game_.characters.end() || it->second.client != client || actor.row == world::kNoRow) {
        deny(game_, context, actor, "no avatar");
        return;
    }
    actor.record = &it->second;
    if (payload.size() > kMaxPayload) {
        deny_malformed(game_, context, actor);
        return;
    }
    switch (kind) {
        case sandbox::COMMAND_CHAT:
            chat(game_, context, actor, payload);
            return;
        case sandbox::COMMAND_SUBSCRIBE:
            subscribe(game_, context, actor, payload);
            return;
        case sandbox::COMMAND_AGREE:
            agree(game_, context, actor, payload);
            return;
        default:
            break;
    }
    if (!actor.record->can_act()) {
        deny(game_, context, actor, "dead");
        return;
    }
    switch (kind) {
        case sandbox::COMMAND_SHOOT:
            shoot(game_, context, actor, payload);
            return;
        case sandbox::COMMAND_PICK_UP:
            pick_up(game_, context, actor, payload);
            return;
        case sandbox::COMMAND_THROW:
            throw_item(game_, context, actor, payload);
            return;
        case sandbox::COMMAND_OFFER:
            offer(game_, context, actor, payload);
            return;
        case sandbox::COMMAND_ACCEPT:
            accept(game_, context, actor, payload);
            return;
        case sandbox::COMMAND_PUSH:
            push(game_, context, actor, payload);
            return;
        case sandbox::COMMAND_RIDE:
            ride(game_, context, actor, payload);
            return;
        default:
            ++game_.stats.malformed;
            deny(game_, context, actor, "unknown command");
            return;
    }
}

void Sandbox::on_input(RulesContext& context,
                       EntityId avatar,
                       const motion::InputCommand& command,
                       std::uint16_t /*pressed*/) {
    const auto it = game_.characters.find(avatar);
    const world::Row row = owned_row(context, avatar);
    if (it == game_.characters.end() || row == world::kNoRow ||
        context.entities().has(row, world::kHidden)) {
        return;
    }
    const bool moving = command.move_x != 0 || command.move_z != 0;
    if (moving) {
        it->second.moved_at = context.now();
    }
    // A running character is heard farther, a sneaking one less far, and one that has stood for a
    // while as well. A spyglass shows what is far off.
    world::Stance stance = world::Stance::kNormal;
    if (context.entities().has(row, world::kCarried)) {
        stance = world::Stance::kRiding;
    } else if (const auto asked = stance_of(context, command)) {
        stance = *asked;
    } else if (context.now() - it->second.moved_at >= ticks(context, kIdleAfterS)) {
        stance = world::Stance::kIdle;
    }
    if (context.entities().stance[row] != static_cast<std::uint8_t>(stance)) {
        context.set_stance(avatar, stance);
    }
}

void Sandbox::on_contact(RulesContext& context, const zone::EntityContact& contact) {
    impact(game_, context, contact);
}

void Sandbox::survey(const RulesContext& context) {
    // Characters of the world's beginning are not spawned by these rules: their first place is
    // where they come back to.
    for (world::Row row = 0; row < context.entities().size(); ++row) {
        if (!context.entities().has(row, world::kGhost) && !context.entities().client[row] &&
            is_character(context, row)) {
            record_of(game_, context, row);
        }
    }
    game_.surveyed = true;
}

void Sandbox::run_timers(RulesContext& context) {
    due_.assign(game_.pending.begin(), game_.pending.end());
    for (const EntityId entity : due_) {
        const auto character = game_.characters.find(entity);
        if (character != game_.characters.end()) {
            run_shots(game_, context, entity, character->second);
            run_agreement(game_, context, character->second);
            run_life(game_, context, entity, character->second);
        }
        const auto prop = game_.props.find(entity);
        if (prop != game_.props.end() && !run_prop(game_, context, entity, prop->second)) {
            game_.props.erase(prop);
        }
        const auto ragdoll = game_.ragdolls.find(entity);
        if (ragdoll != game_.ragdolls.end() && !run_ragdoll(context, entity, ragdoll->second)) {
            game_.ragdolls.erase(ragdoll);
        }
        update_pending(game_, entity);
    }
}

void Sandbox::on_tick(RulesContext& context) {
    if (!game_.surveyed) {
        survey(context);
    }
    run_timers(context);
    bite(game_, context);
    hail(game_, context);
}

void Sandbox::on_confirm(RulesContext& context, ClientId client, EventId event) {
    confirm_kill(game_, context, client, event);
}

void Sandbox::on_message(RulesContext& context,
                         EntityId target,
                         std::span<const std::uint8_t> payload) {
    const std::optional<PeerMessage> message = decode(payload);
    if (!message) {
        ++game_.stats.bad_messages;
        return;
    }
    const world::Row row = owned_row(context, target);
    if (const auto* hurt = std::get_if<Hurt>(&*message)) {
        if (row == world::kNoRow || !is_character(context, row)) {
            ++game_.stats.missed_messages;
            return;
        }
        take_damage(game_, context, row, hurt->by, hurt->amount);
    } else if (const auto* knock = std::get_if<Knock>(&*message)) {
        if (row == world::kNoRow || context.entities().has(row, world::kHidden)) {
            ++game_.stats.missed_messages;
            return;
        }
        context.add_velocity(target, knock->change);
    } else if (const auto* request = std::get_if<PickRequest>(&*message)) {
        on_pick_request(game_, context, target, *request);
    } else if (const auto* grant = std::get_if<PickGrant>(&*message)) {
        on_pick_grant(game_, context, target, *grant);
    } else if (std::holds_alternative<PickRefusal>(*message)) {
        on_pick_refusal(game_, context, target);
    } else if (const auto* done = std::get_if<PickDone>(&*message)) {
        on_pick_done(game_, context, target, *done);
    }
}

void Sandbox::on_store(RulesContext& context, const mailbox::StoreAnswer& answer) {
    on_kept(game_, context, answer);
}

zone::Bytes Sandbox::take_entity(EntityId entity) {
    zone::Bytes bytes;
    Writer writer(bytes);
    const auto character = game_.characters.find(entity);
    const auto prop = game_.props.find(entity);
    const auto ragdoll = game_.ragdolls.find(entity);
    if (character != game_.characters.end()) {
        bytes.push_back(kCharacterFormat);
        CharacterRecord::fields(writer, character->second);
    } else if (prop != game_.props.end()) {
        bytes.push_back(kPropFormat);
        PropRecord::fields(writer, prop->second);
    } else if (ragdoll != game_.ragdolls.end()) {
        bytes.push_back(kRagdollFormat);
        RagdollRecord::fields(writer, ragdoll->second);
    }
    forget(game_, entity);
    return bytes;
}

void Sandbox::load_entity(EntityId entity, std::span<const std::uint8_t> state) {
    if (state.empty()) {
        return;  // there was nothing to remember
    }
    ArchiveReader reader(state.subspan(1));
    if (state.front() == kCharacterFormat) {
        CharacterRecord record;
        CharacterRecord::fields(reader, record);
        if (reader.done()) {
            if (record.client) {
                game_.avatars[record.client] = entity;
            }
            game_.characters[entity] = std::move(record);
            update_pending(game_, entity);
            return;
        }
    } else if (state.front() == kPropFormat) {
        PropRecord record;
        PropRecord::fields(reader, record);
        if (reader.done()) {
            game_.props[entity] = record;
            update_pending(game_, entity);
            return;
        }
    } else if (state.front() == kRagdollFormat) {
        RagdollRecord record;
        RagdollRecord::fields(reader, record);
        if (reader.done()) {
            game_.ragdolls[entity] = record;
            update_pending(game_, entity);
            return;
        }
    }
    ++game_.stats.bad_states;
}

bool Sandbox::save(zone::Bytes& out) const {
    core::FieldWriter archive(out);
    serialize_game(archive, const_cast<Game&>(game_));  // writing leaves it as it is
    return archive.good();
}

std::string Sandbox::load(std::span<const std::uint8_t> bytes) {
    core::FieldReader archive(bytes);
    serialize_game(archive, game_);
    if (archive.good() && archive.left() > 0) {
        archive.fail(std::to_string(archive.left()) + " bytes are left over");
    }
    return archive.wrong();
}

bool Sandbox::busy() const {
    return !game_.pending.empty();
}

ai::state_machine::CodedMachines Sandbox::coded_machines() const {
    return gate_guards();
}

void Sandbox::hash(core::StateHash& hash) const {
    Hasher hasher(hash);
    hash.add(game_.surveyed);
    hash.add(static_cast<std::uint64_t>(game_.characters.size()));
    game_.characters.take_touched([&](EntityId entity, const CharacterRecord* record) {
        hash.add(entity.value);
        hash.add(record != nullptr);
        if (record != nullptr) {
            CharacterRecord::fields(hasher, *record);
        }
    });
    hash.add(static_cast<std::uint64_t>(game_.props.size()));
    for (const auto& [entity, record] : game_.props) {
        hash.add(entity.value);
        PropRecord::fields(hasher, record);
    }
    for (const auto& [entity, record] : game_.ragdolls) {
        hash.add(entity.value);
        RagdollRecord::fields(hasher, record);
    }
}

const CharacterRecord* Sandbox::find(EntityId character) const {
    const auto it = game_.characters.find(character);
    return it == game_.characters.end() ? nullptr : &it->second;
}

}  // namespace zoned::rules

std::unique_ptr<zoned::zone::Rules> zoned::zone::make_rules(const RulesSettings& settings,
                                                            const world::TypeTable& types) {
    return std::make_unique<rules::Sandbox>(settings, types);
}
