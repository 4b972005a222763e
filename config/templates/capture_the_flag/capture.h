// Places, buttons, commands and events of @GAME@, for its rules and its bots.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace capture {

inline constexpr std::size_t kTeams = 2;
inline constexpr std::array<const char*, kTeams> kTeamNames = {"red", "blue"};
/// Where the flag of a team stands, on the axis x, m.
inline constexpr std::array<float, kTeams> kHomeX = {-25.0F, 25.0F};

inline constexpr float kReachM = 1.5F;  // of a flag
inline constexpr float kShoveM = 2.5F;
inline constexpr float kShoveMps = 7.0F;
inline constexpr float kDashMps = 6.0F;
inline constexpr float kShoveCooldownS = 8.0F;
inline constexpr float kDashCooldownS = 3.0F;
inline constexpr float kDazedS = 2.0F;
inline constexpr float kReturnS = 1.0F;  // unseen, on its way home
inline constexpr float kLiesS = 10.0F;   // then a dropped flag goes home by itself

inline constexpr std::uint16_t kDash = 1U << 4U;  ///< button: a leap forward
inline constexpr std::uint16_t kShove = 1;        ///< command, no payload: the nearest opponent

/// Events. Kinds below 16 are the server's.
enum Event : std::uint16_t {
    kTaken = 100,  ///< a flag was taken from its home or the ground; payload: its team
    kDropped,      ///< its carrier was shoved, or left; payload: its team
    kReturned,     ///< it stands at home again; payload: its team
    kScored,       ///< payload: the team that scored
    kLeaderboard,  ///< payload: lines "captures name", the best first
};

}  // namespace capture
