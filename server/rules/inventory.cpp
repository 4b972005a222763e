#include "server/rules/inventory.h"

#include "server/rules/keeping/item_fields.h"
#include "server/rules/keeping/kept_character.h"

#include <array>
#include <cmath>

namespace zoned::rules {

namespace {

constexpr float kReservationS = 1.0F;
constexpr float kThrownS = 5.0F;
constexpr float kClearanceM = 0.1F;

bool portable(const Game& game, const RulesContext& context, world::Row row) {
    const world::EntityType& type = context.types()[context.entities().type[row]];
    return type.kind == world::EntityKind::kProp && type.mass < game.settings.pickup_kg &&
           type.assembly == 0 && !context.has_joints(context.entities().id[row]);
}

bool has_room(const Game& game, const CharacterRecord& record) {
    return record.inventory.size() < static_cast<std::size_t>(game.settings.inventory);
}

Item item_of(const RulesContext& context, world::Row row) {
    return {context.entities().id[row],
            context.entities().type[row],
            context.entities().appearance[row],
            item_fields(context, context.entities().id[row])};
}

void store(Game& game,
           RulesContext& context,
           EntityId picker,
           CharacterRecord& record,
           const Item& item) {
    record.inventory.push_back(item);
    sandbox::PickedUp picked;
    picked.set_picker(picker.value);
    picked.set_item(item.id.value);
    context.announce(picker, event(sandbox::EVENT_PICK_UP, picked));
    keep(context, picker, record);
    send_inventory(context, record);
    ++game.stats.pick_ups;
}

Actor actor_of(CharacterRecord& record, EntityId avatar, sandbox::CommandKind kind) {
    return {record.client, avatar, world::kNoRow, &record, static_cast<std::uint16_t>(kind)};
}

CharacterRecord* player_record(Game& game, EntityId avatar) {
    const auto it = game.characters.find(avatar);
    return it == game.characters.end() || !it->second.client ? nullptr : &it->second;
}

}  // namespace

void send_inventory(RulesContext& context, const CharacterRecord& record) {
    sandbox::Inventory inventory;
    for (const Item& item : record.inventory) {
        inventory.add_items(item.id.value);
    }
    zone::RulesEvent notice = event(sandbox::EVENT_INVENTORY, inventory);
    notice.durable = is_kept(record);
    context.send(record.client, notice);
}

void pick_up(Game& game, RulesContext& context, const Actor& actor, Payload payload) {
    sandbox::PickUp pick;
    if (!pick.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
        deny_malformed(game, context, actor);
        return;
    }
    const EntityId item(pick.entity());
    const world::Entities& entities = context.entities();
    const world::Row row = item ? entities.find(item) : world::kNoRow;
    // One answer for a missing and a hidden prop: a client learns nothing of either.
    if (row == world::kNoRow || entities.has(row, world::kHidden)) {
        deny(game, context, actor, "no such thing");
        return;
    }
    if (!portable(game, context, row)) {
        deny(game, context, actor, "cannot be carried");
        return;
    }
    const float distance = (entities.position[row] - entities.position[actor.row]).norm();
    if (!(distance <= game.settings.pickup_range_m)) {
        deny(game, context, actor, "out of reach");
        return;
    }
    if (!has_room(game, *actor.record)) {
        deny(game, context, actor, "inventory full");
        return;
    }
    if (entities.has(row, world::kGhost)) {
        context.message(item, encode(PickRequest{actor.avatar}));
        return;
    }
    const Item taken = item_of(context, row);
    forget(game, item);
    context.despawn(item);
    store(game, context, actor.avatar, *actor.record, taken);
}

void throw_item(Game& game, RulesContext& context, const Actor& actor, Payload payload) {
    sandbox::Throw command;
    if (!command.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
        deny_malformed(game, context, actor);
        return;
    }
    const std::optional<Vec3> along = direction(command.dx(), command.dy(), command.dz());
    if (!along) {
        deny_malformed(game, context, actor);
        return;
    }
    std::vector<Item>& inventory = actor.record->inventory;
    std::size_t slot = 0;
    while (slot < inventory.size() && inventory[slot].id.value != command.item()) {
        ++slot;
    }
    if (slot == inventory.size()) {
        deny(game, context, actor, "not in your inventory");
        return;
    }
    if (context.now() < actor.record->next_throw) {
        deny(game, context, actor, "too fast");
        return;
    }
    const Item item = inventory[slot];
    const Vec3 from = eye(context, actor.row);
    const motion::CharacterLimits& body =
        context.types()[context.entities().type[actor.row]].character;
    const float size = context.types()[item.type].extent();
    // Far enough to be clear of the thrower's own capsule, also when thrown downwards past it.
    const float ahead =
        body.radius + size + kClearanceM +
        std::max(0.0F, -along->y()) * (2.0F * body.half_segment + 0.5F * body.radius);
    if (context.ray_cast(from, *along, ahead + size, actor.avatar).hit) {
        deny(game, context, actor, "no room to throw");
        return;
    }
    actor.record->next_throw = context.now() + ticks(context, game.settings.throw_cooldown_s);
    inventory.erase(inventory.begin() + static_cast<std::ptrdiff_t>(slot));
    zone::SpawnDef def;
    def.type = item.type;
    def.position = from + *along * ahead;
    def.velocity = *along * game.settings.throw_mps;
    def.appearance = item.appearance;
    const EntityId thrown = context.spawn(def);
    give_fields(context, thrown, item.held);
    game.props[thrown] =
        PropRecord{actor.avatar, context.now() + ticks(context, kThrownS), EntityId(), 0};
    update_pending(game, thrown);
    keep(context, actor.avatar, *actor.record);
    send_inventory(context, *actor.record);
    ++game.stats.throws;
}

void drop_inventory(RulesContext& context, world::Row avatar, CharacterRecord& record) {
    // Eight places on a ring, by exact fractions so that no trigonometry enters.
    constexpr float kDiagonal = 0.70710678F;
    constexpr std::array<std::array<float, 2>, 8> kRing = {{{1.0F, 0.0F},
                                                            {-1.0F, 0.0F},
                                                            {0.0F, 1.0F},
                                                            {0.0F, -1.0F},
                                                            {kDiagonal, kDiagonal},
                                                            {-kDiagonal, -kDiagonal},
                                                            {-kDiagonal, kDiagonal},
                                                            {kDiagonal, -kDiagonal}}};
    const EntityId owner = context.entities().id[avatar];
    const Vec3 centre = context.entities().position[avatar];  // spawning moves the columns
    for (std::size_t i = 0; i < record.inventory.size(); ++i) {
        const Item& item = record.inventory[i];
        const float size = context.types()[item.type].extent();
        const float ring = 1.0F + static_cast<float>(i / kRing.size());
        const Vec3 outwards(kRing[i % kRing.size()][0], 0.0F, kRing[i % kRing.size()][1]);
        const float distance = ring * (kClearanceM + 2.0F * size);
        // Never through a wall: a prop without room there falls where its carrier stood.
        const bool blocked = context.ray_cast(centre, outwards, distance + size, owner).hit;
        zone::SpawnDef def;
        def.type = item.type;
        def.position = blocked ? centre : Vec3(centre + outwards * distance);
        def.appearance = item.appearance;
        give_fields(context, context.spawn(def), item.held);
    }
    record.inventory.clear();
}

void on_pick_request(Game& game, RulesContext& context, EntityId item, const PickRequest& request) {
    const world::Row row = owned_row(context, item);
    if (row == world::kNoRow || context.entities().has(row, world::kHidden) ||
        !portable(game, context, row)) {
        context.message(request.picker, encode(PickRefusal{item}));
        return;
    }
    PropRecord& record = game.props[item];
    record = PropRecord{};
    record.reserved_for = request.picker;
    record.reserved_until = context.now() + ticks(context, kReservationS);
    update_pending(game, item);
    context.message(request.picker, encode(PickGrant{item_of(context, row)}));
    context.hide(item);
}

void on_pick_grant(Game& game, RulesContext& context, EntityId picker, const PickGrant& grant) {
    CharacterRecord* record = player_record(game, picker);
    const bool known = grant.item.type < context.types().size();
    const bool takes = record != nullptr && known && has_room(game, *record);
    context.message(grant.item.id, encode(PickDone{static_cast<std::uint8_t>(takes ? 1 : 0)}));
    if (takes) {
        store(game, context, picker, *record, grant.item);
    } else if (record != nullptr) {
        deny(game, context, actor_of(*record, picker, sandbox::COMMAND_PICK_UP), "inventory full");
    }
}

void on_pick_refusal(Game& game, RulesContext& context, EntityId picker) {
    CharacterRecord* record = player_record(game, picker);
    if (record != nullptr) {
        deny(game, context, actor_of(*record, picker, sandbox::COMMAND_PICK_UP), "no such thing");
    }
}

void on_pick_done(Game& game, RulesContext& context, EntityId item, const PickDone& done) {
    const auto prop = game.props.find(item);
    const world::Row row = owned_row(context, item);
    if (prop == game.props.end() || !prop->second.reserved_for || row == world::kNoRow) {
        ++game.stats.missed_messages;
        return;
    }
    forget(game, item);
    if (done.taken != 0) {
        context.despawn(item);
    } else {
        context.show(item, Vec3(context.entities().position[row]), Vec3::Zero());
        ++game.stats.pick_ups_returned;
    }
}

bool run_prop(Game& game, RulesContext& context, EntityId entity, PropRecord& record) {
    if (record.reserved_for) {
        if (context.now() < record.reserved_until) {
            return true;
        }
        const world::Row row = owned_row(context, entity);
        if (row != world::kNoRow) {
            context.show(entity, Vec3(context.entities().position[row]), Vec3::Zero());
        }
        ++game.stats.pick_ups_returned;
        return false;
    }
    return context.now() < record.thrown_until;
}

}  // namespace zoned::rules
