#include "server/rules/agreement.h"

#include "server/rules/inventory.h"
#include "server/rules/keeping/kept_character.h"
#include "shared/core/state_hash.h"

#include <algorithm>
#include <utility>

namespace zoned::rules {

namespace {

constexpr std::uint32_t kMostRepeats = 20;
constexpr float kRepeatS = 0.5F;
constexpr float kOfferS = 20.0F;
constexpr float kTradeReachM = 4.0F;

void send_ledger(RulesContext& context, CharacterRecord& record, bool reset) {
    sandbox::Ledger ledger;
    ledger.set_serial(++record.ledger_serial);
    ledger.set_deaths(record.deaths);
    ledger.set_kills(record.kills);
    ledger.set_trades(record.trades);
    core::StateHash digest;
    digest.add(record.deaths);
    digest.add(record.kills);
    digest.add(record.trades);
    for (const Item& item : record.inventory) {
        ledger.add_items(item.id.value);
        digest.add(item.id.value);
    }
    ledger.set_reset(reset);
    record.ledger_digest = digest.value();
    record.ledger_due = context.now() + ticks(context, kRepeatS);
    context.send(record.client, event(sandbox::EVENT_LEDGER, ledger));
}

/// Index of the item in an inventory; its size when it is not there.
std::size_t slot_of(const CharacterRecord& record, std::uint32_t item) {
    std::size_t slot = 0;
    while (slot < record.inventory.size() && record.inventory[slot].id.value != item) {
        ++slot;
    }
    return slot;
}

/// The other side of a trade: a player of this zone within reach, alive.
CharacterRecord* partner(Game& game,
                         const RulesContext& context,
                         const Actor& actor,
                         EntityId avatar) {
    const auto it = game.characters.find(avatar);
    const world::Row row = owned_row(context, avatar);
    if (avatar == actor.avatar || it == game.characters.end() || !it->second.client ||
        row == world::kNoRow || !it->second.can_act()) {
        return nullptr;
    }
    const float distance =
        (context.entities().position[row] - context.entities().position[actor.row]).norm();
    return distance <= kTradeReachM ? &it->second : nullptr;
}

}  // namespace

void decided(Game& game, RulesContext& context, EntityId avatar, CharacterRecord& record) {
    if (!record.client) {
        return;
    }
    keep(context, avatar, record);
    record.ledger_repeats = 1;
    send_ledger(context, record, false);
    update_pending(game, avatar);
}

void restored(Game& game, RulesContext& context, EntityId avatar, CharacterRecord& record) {
    record.ledger_repeats = 1;
    send_ledger(context, record, true);
    update_pending(game, avatar);
}

void run_agreement(Game& game, RulesContext& context, CharacterRecord& record) {
    if (record.ledger_repeats == 0 || context.now() < record.ledger_due) {
        return;
    }
    if (record.ledger_repeats++ >= kMostRepeats) {
        record.ledger_repeats = 0;
        ++game.stats.ledgers_given_up;
        return;
    }
    ++game.stats.ledgers_repeated;
    send_ledger(context, record, false);
}

void agree(Game& game, RulesContext& context, const Actor& actor, Payload payload) {
    sandbox::Agree word;
    if (!word.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
        deny_malformed(game, context, actor);
        return;
    }
    CharacterRecord& record = *actor.record;
    if (record.ledger_repeats == 0 || word.serial() != record.ledger_serial) {
        ++game.stats.stray_confirms;  // of one that was sent again since
        return;
    }
    if (word.digest() == record.ledger_digest) {
        ++game.stats.ledgers_agreed;
        record.ledger_repeats = 0;
        update_pending(game, actor.avatar);
        return;
    }
    ++game.stats.ledgers_diverged;
    context.reset_view(actor.client);
    send_ledger(context, record, true);
}

void offer(Game& game, RulesContext& context, const Actor& actor, Payload payload) {
    sandbox::Offer wish;
    if (!wish.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
        deny_malformed(game, context, actor);
        return;
    }
    CharacterRecord* other = partner(game, context, actor, EntityId(wish.with()));
    if (other == nullptr) {
        deny(game, context, actor, "nobody to trade with");
        return;
    }
    if (slot_of(*actor.record, wish.give()) == actor.record->inventory.size()) {
        deny(game, context, actor, "not in your inventory");
        return;
    }
    actor.record->offer_to = EntityId(wish.with());
    actor.record->offer_give = EntityId(wish.give());
    actor.record->offer_want = EntityId(wish.want());
    actor.record->offer_until = context.now() + ticks(context, kOfferS);
    wish.set_with(actor.avatar.value);
    context.send(other->client, event(sandbox::EVENT_OFFER, wish));
}

void accept(Game& game, RulesContext& context, const Actor& actor, Payload payload) {
    sandbox::Offer wish;
    if (!wish.ParseFromArray(payload.data(), static_cast<int>(payload.size()))) {
        deny_malformed(game, context, actor);
        return;
    }
    const EntityId from(wish.with());
    CharacterRecord* other = partner(game, context, actor, from);
    const bool stands = other != nullptr && other->offer_to == actor.avatar &&
                        other->offer_give.value == wish.give() &&
                        other->offer_want.value == wish.want() &&
                        context.now() <= other->offer_until;
    if (!stands) {
        deny(game, context, actor, "no such offer");
        return;
    }
    const std::size_t given = slot_of(*other, wish.give());
    const std::size_t taken = slot_of(*actor.record, wish.want());
    if (given == other->inventory.size() || taken == actor.record->inventory.size()) {
        deny(game, context, actor, "not in the inventory");
        return;
    }
    std::swap(other->inventory[given], actor.record->inventory[taken]);
    other->offer_to = EntityId();
    ++other->trades;
    ++actor.record->trades;
    ++game.stats.trades;
    sandbox::Trade trade;
    trade.set_a(from.value);
    trade.set_b(actor.avatar.value);
    trade.set_from_a(wish.give());
    trade.set_from_b(wish.want());
    const zone::RulesEvent notice = event(sandbox::EVENT_TRADE, trade, true);
    other->trade_event = context.send(other->client, notice);
    actor.record->trade_event = context.send(actor.client, notice);
    decided(game, context, from, *other);
    decided(game, context, actor.avatar, *actor.record);
}

}  // namespace zoned::rules
