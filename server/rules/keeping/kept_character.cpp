#include "server/rules/keeping/kept_character.h"

#include "server/rules/agreement.h"
#include "server/rules/archive.h"
#include "server/rules/inventory.h"

#include <utility>

namespace zoned::rules {

namespace {

constexpr const char* kKey = "sandbox";
/// As many as fit into a handoff.
constexpr std::size_t kMostItems = ArchiveReader::kMaxItems;

mailbox::StoreKey key_of(const CharacterRecord& record) {
    return {mailbox::StoreScope::kCharacter, record.account, record.name, kKey};
}

void ask(RulesContext& context, EntityId avatar, CharacterRecord& record) {
    record.keeping =
        context.store_get(avatar, key_of(record)) != 0 ? Keeping::kAsked : Keeping::kUnread;
}

/// Number of the type by its name; none where the world has no such prop any more.
std::optional<TypeIndex> item_type(const RulesContext& context, const std::string& name) {
    for (std::size_t i = 0; i < context.types().size(); ++i) {
        const world::EntityType& type = context.types()[static_cast<TypeIndex>(i)];
        if (type.name == name && type.kind == world::EntityKind::kProp && type.assembly == 0) {
            return static_cast<TypeIndex>(i);
        }
    }
    return std::nullopt;
}

ItemFields read_fields(const sandbox::KeptItem& item) {
    ItemFields held;
    for (const sandbox::KeptField& field : item.fields()) {
        held.push_back({field.name(), field.value()});
    }
    return held;
}

void write_fields(const ItemFields& held, sandbox::KeptItem& item) {
    for (const ItemField& field : held) {
        sandbox::KeptField& to = *item.add_fields();
        to.set_name(field.name);
        to.set_value(field.value);
    }
}

/// An item is named by the id of the entity that it was. After a restart the old ids are those of
/// others: each item is an entity for a moment, and gets an id that nothing else has.
void restore_items(RulesContext& context,
                   world::Row avatar,
                   const sandbox::KeptCharacter& kept,
                   CharacterRecord& record) {
    const Vec3 at = context.entities().position[avatar];
    for (const sandbox::KeptItem& from : kept.items()) {
        const std::optional<TypeIndex> type = item_type(context, from.type());
        if (record.inventory.size() + record.strange_items.size() >= kMostItems) {
            return;
        }
        if (!type) {
            record.strange_items.push_back(
                {from.type(), static_cast<std::uint16_t>(from.appearance()), read_fields(from)});
            continue;
        }
        zone::SpawnDef def;
        def.type = *type;
        def.position = at;
        def.appearance = static_cast<std::uint16_t>(from.appearance());
        const EntityId id = context.spawn(def);
        context.despawn(id);
        record.inventory.push_back({id, *type, def.appearance, read_fields(from)});
    }
}

void restore(Game& game,
             RulesContext& context,
             EntityId avatar,
             CharacterRecord& record,
             const std::vector<std::uint8_t>& value) {
    sandbox::KeptCharacter kept;
    const world::Row row = owned_row(context, avatar);
    if (row == world::kNoRow ||
        !kept.ParseFromArray(value.data(), static_cast<int>(value.size()))) {
        ++game.stats.bad_states;
        record.keeping = Keeping::kUnread;
        return;
    }
    const bool changed = record.keep_due;
    record.keep_due = false;
    record.keeping = Keeping::kKept;
    record.deaths += kept.deaths();
    record.kills += kept.kills();
    record.trades += kept.trades();
    restore_items(context, row, kept, record);
    send_inventory(context, record);
    restored(game, context, avatar, record);
    if (changed) {
        keep(context, avatar, record);
    }
}

}  // namespace

void ask_for_kept(RulesContext& context, EntityId avatar, CharacterRecord& record) {
    if (!record.account.empty()) {
        ask(context, avatar, record);
    }
}

void keep(RulesContext& context, EntityId avatar, CharacterRecord& record) {
    if (record.account.empty()) {
        return;
    }
    if (record.keeping == Keeping::kAsked || record.keeping == Keeping::kUnread) {
        record.keep_due = true;
        if (record.keeping == Keeping::kUnread) {
            ask(context, avatar, record);
        }
        return;
    }
    sandbox::KeptCharacter kept;
    kept.set_deaths(record.deaths);
    kept.set_kills(record.kills);
    kept.set_trades(record.trades);
    for (const Item& item : record.inventory) {
        sandbox::KeptItem& to = *kept.add_items();
        to.set_type(context.types()[item.type].name);
        to.set_appearance(item.appearance);
        write_fields(item.held, to);
    }
    for (const StrangeItem& item : record.strange_items) {
        sandbox::KeptItem& to = *kept.add_items();
        to.set_type(item.type);
        to.set_appearance(item.appearance);
        write_fields(item.held, to);
    }
    zone::Bytes bytes(kept.ByteSizeLong());
    kept.SerializeToArray(bytes.data(), static_cast<int>(bytes.size()));
    const bool asked = context.store_put(avatar, key_of(record), std::move(bytes)) != 0;
    record.keeping = asked ? Keeping::kKept : Keeping::kRefused;
}

bool is_kept(const CharacterRecord& record) {
    return record.keeping == Keeping::kKept;
}

void on_kept(Game& game, RulesContext& context, const mailbox::StoreAnswer& answer) {
    const auto it = game.characters.find(answer.target);
    if (it == game.characters.end() || key_of(it->second) != answer.key) {
        ++game.stats.missed_messages;  // it left meanwhile
        return;
    }
    CharacterRecord& record = it->second;
    if (answer.act == mailbox::StoreAct::kPut) {
        if (answer.status == mailbox::StoreStatus::kRefused) {
            record.keeping = Keeping::kRefused;
        }
        return;
    }
    if (record.keeping != Keeping::kAsked) {
        return;
    }
    switch (answer.status) {
        case mailbox::StoreStatus::kDone:
            restore(game, context, answer.target, record, answer.value);
            break;
        case mailbox::StoreStatus::kAbsent:
            record.keeping = Keeping::kKept;
            if (std::exchange(record.keep_due, false)) {
                keep(context, answer.target, record);
            }
            break;
        case mailbox::StoreStatus::kRefused:
            record.keeping = Keeping::kUnread;
            break;
    }
}

}  // namespace zoned::rules
