#include "client-sim/bot/ledger.h"

#include "proto/sandbox.pb.h"
#include "shared/core/state_hash.h"

#include <algorithm>

namespace zoned::bot {

std::uint64_t Ledger::digest() const {
    core::StateHash hash;
    hash.add(deaths_);
    hash.add(kills_);
    hash.add(trades_);
    for (const std::uint32_t item : items_) {
        hash.add(item);
    }
    return hash.value();
}

bool Ledger::apply(const wire::EventMessage& event, EntityId avatar, std::string& answer) {
    switch (event.kind) {
        case sandbox::EVENT_KILL: {
            // Only the killer and the killed confirm it; other clients receive it as information.
            sandbox::Kill kill;
            if (event.confirm && kill.ParseFromString(event.payload)) {
                deaths_ += kill.killed() == avatar.value ? 1U : 0U;
                kills_ += kill.killer() == avatar.value ? 1U : 0U;
            }
            return false;
        }
        case sandbox::EVENT_TRADE: {
            sandbox::Trade trade;
            if (trade.ParseFromString(event.payload)) {
                ++trades_;
                const bool first = trade.a() == avatar.value;
                std::replace(items_.begin(),
                             items_.end(),
                             first ? trade.from_a() : trade.from_b(),
                             first ? trade.from_b() : trade.from_a());
            }
            return false;
        }
        case sandbox::EVENT_INVENTORY: {
            sandbox::Inventory inventory;
            if (inventory.ParseFromString(event.payload)) {
                items_.assign(inventory.items().begin(), inventory.items().end());
            }
            return false;
        }
        case sandbox::EVENT_LEDGER:
            return compare(event, answer);
        default:
            return false;
    }
}

bool Ledger::compare(const wire::EventMessage& event, std::string& answer) {
    sandbox::Ledger word;
    if (!word.ParseFromString(event.payload)) {
        return false;
    }
    const bool same =
        deaths_ == word.deaths() && kills_ == word.kills() && trades_ == word.trades() &&
        std::equal(items_.begin(), items_.end(), word.items().begin(), word.items().end());
    diverged_ += same || word.reset() ? 0 : 1;
    if (word.reset()) {
        deaths_ = word.deaths();
        kills_ = word.kills();
        trades_ = word.trades();
        items_.assign(word.items().begin(), word.items().end());
    }
    sandbox::Agree agree;
    agree.set_serial(word.serial());
    agree.set_digest(digest());
    answer = agree.SerializeAsString();
    return true;
}

}  // namespace zoned::bot
