// Team choice: which of those who wait play with each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace zoned::zone {

struct TeamShape {
    std::uint32_t teams = 2;
    std::uint32_t size = 5;   ///< of a team, at most
    std::uint32_t least = 5;  ///< of each team
};

/// Team of a ticket that does not play.
inline constexpr std::uint16_t kNoTeam = 0xFFFF;

/// Searches this deep, and no farther: a counted bound, the same on every machine.
inline constexpr std::size_t kTicketsSearched = 100;
inline constexpr std::uint32_t kSearchSteps = 20'000;

/// The team of each ticket, or none where no match comes about. `sizes`: players of each ticket,
/// the longest waiting first; a ticket is never parted. The first ticket plays. Among all choices
/// the one is taken that holds the earliest tickets, compared one after the other, as full as
/// `shape` allows: a depth-first search that takes a ticket before it passes it.
std::optional<std::vector<std::uint16_t>> choose_teams(std::span<const std::uint32_t> sizes,
                                                       const TeamShape& shape);

}  // namespace zoned::zone
