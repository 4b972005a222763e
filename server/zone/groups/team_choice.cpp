#include "server/zone/groups/team_choice.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace zoned::zone {

namespace {

class Search {
  public:
    Search(std::span<const std::uint32_t> sizes, const TeamShape& shape)
        : sizes_(sizes.first(std::min(sizes.size(), kTicketsSearched))),
          shape_(shape),
          players_(shape.teams, 0),
          teams_(sizes.size(), kNoTeam) {
        // Players of this ticket and all behind it.
        behind_.assign(sizes_.size() + 1, 0);
        for (std::size_t i = sizes_.size(); i-- > 0;) {
            behind_[i] = behind_[i + 1] + sizes_[i];
        }
    }

    bool run() { return !sizes_.empty() && place(0, true); }

    [[nodiscard]] const std::vector<std::uint16_t>& teams() const { return teams_; }

  private:
    [[nodiscard]] std::uint32_t missing() const {
        std::uint32_t sum = 0;
        for (const std::uint32_t players : players_) {
            sum += shape_.least - std::min(players, shape_.least);
        }
        return sum;
    }

    /// Ticket `i` and those behind it; `needed`: it must play.
    bool place(std::size_t i, bool needed) {
        if (++steps_ > kSearchSteps) {
            return false;
        }
        const std::uint32_t missing_now = missing();
        if (missing_now == 0 && i == sizes_.size()) {
            return true;
        }
        if (i == sizes_.size() || behind_[i] < missing_now) {
            return false;
        }
        return put_into_a_team(i) || (!needed && place(i + 1, false));
    }

    /// The emptiest first; teams with as many players are alike, so one of them is tried.
    bool put_into_a_team(std::size_t i) {
        std::vector<std::uint16_t> order(shape_.teams);
        std::iota(order.begin(), order.end(), std::uint16_t{0});
        std::ranges::sort(order, {}, [this](std::uint16_t t) { return std::pair(players_[t], t); });
        for (std::size_t k = 0; k < order.size(); ++k) {
            const std::uint16_t team = order[k];
            const bool alike = k > 0 && players_[order[k - 1]] == players_[team];
            if (alike || players_[team] + sizes_[i] > shape_.size) {
                continue;
            }
            players_[team] += sizes_[i];
            teams_[i] = team;
            if (place(i + 1, false)) {
                return true;
            }
            players_[team] -= sizes_[i];
            teams_[i] = kNoTeam;
        }
        return false;
    }

    std::span<const std::uint32_t> sizes_;
    TeamShape shape_;
    std::vector<std::uint32_t> players_;  // of each team
    std::vector<std::uint16_t> teams_;    // of each ticket
    std::vector<std::uint32_t> behind_;
    std::uint32_t steps_ = 0;
};

}  // namespace

std::optional<std::vector<std::uint16_t>> choose_teams(std::span<const std::uint32_t> sizes,
                                                       const TeamShape& shape) {
    Search search(sizes, shape);
    return search.run() ? std::optional(search.teams()) : std::nullopt;
}

}  // namespace zoned::zone
