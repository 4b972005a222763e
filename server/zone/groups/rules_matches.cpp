#include "server/zone/groups/rules_matches.h"

#include "server/zone/context/rules_records.h"
#include "server/zone/groups/match_book.h"

namespace zoned::zone {

const Match* RulesMatches::find(MatchId match) const {
    return book_->find(match);
}

MatchId RulesMatches::of(EntityId player) const {
    return book_->match_of(player);
}

bool RulesMatches::waits(EntityId player) const {
    return book_->waits(player);
}

MatchOrder* RulesMatches::give(MatchAct act, EntityId player) {
    if (orders_->size() >= kMostMatchOrders) {
        return nullptr;
    }
    MatchOrder& order = orders_->emplace_back();
    order.act = act;
    order.zone = zone_;
    order.player = player;
    return &order;
}

bool RulesMatches::queue(std::string_view kind, EntityId player) {
    MatchOrder* const order = book_->has_kind(kind) ? give(MatchAct::kQueue, player) : nullptr;
    if (order != nullptr) {
        order->kind = kind;
    }
    return order != nullptr;
}

bool RulesMatches::unqueue(EntityId player) {
    return give(MatchAct::kUnqueue, player) != nullptr;
}

bool RulesMatches::end(MatchId match, std::uint16_t event, std::span<const std::uint8_t> result) {
    if ((event != 0 && event < kFirstRulesEvent) || result.size() > kMostResultBytes) {
        return false;
    }
    MatchOrder* const order = give(MatchAct::kEnd, EntityId());
    if (order != nullptr) {
        order->match = match;
        order->event = event;
        order->result.assign(result.begin(), result.end());
    }
    return order != nullptr;
}

}  // namespace zoned::zone
