// RulesMatches: the matches of the world as rules see them, and what rules ask of them.
#pragma once

#include "server/zone/groups/match.h"

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace zoned::zone {

class MatchBook;

/// Orders take effect behind this tick; Rules::on_match tells what has become of them. False:
/// refused at once.
class RulesMatches {
  public:
    RulesMatches(ZoneId zone, std::vector<MatchOrder>& orders) : zone_(zone), orders_(&orders) {}

    /// From now on rules see this book, which must outlive them.
    void use(const MatchBook& book) { book_ = &book; }

    [[nodiscard]] const MatchBook* book() const { return book_; }

    /// Null: there is no such match, or it has ended. Good during the call.
    [[nodiscard]] const Match* find(MatchId match) const;
    /// None: the player is in no match.
    [[nodiscard]] MatchId of(EntityId player) const;
    [[nodiscard]] bool waits(EntityId player) const;

    /// A player waits for a match of that kind; the leader of a party with all members that are
    /// here.
    bool queue(std::string_view kind, EntityId player);
    /// With all that wait with the player.
    bool unqueue(EntityId player);
    /// The match is over. With `event` (>= kFirstRulesEvent) its players get the result as a
    /// durable event of that kind, on the topic match_topic(); 0: there is none.
    bool end(MatchId match, std::uint16_t event, std::span<const std::uint8_t> result);

  private:
    MatchOrder* give(MatchAct act, EntityId player);

    ZoneId zone_;
    std::vector<MatchOrder>* orders_;
    const MatchBook* book_ = nullptr;
};

}  // namespace zoned::zone
