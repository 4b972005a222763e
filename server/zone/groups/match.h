// Match: players in teams who play for a result, and the queue in which they wait for it.
#pragma once

#include "server/zone/groups/instance.h"
#include "shared/core/ids.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace zoned::zone {

/// A match of the world, never reused.
using MatchId = StrongId<struct MatchTag>;

inline constexpr std::size_t kMostMatchOrders = 1000;  ///< of a zone in a tick
inline constexpr std::size_t kMostTickets = 10'000;    ///< of the world
inline constexpr std::size_t kMostResultBytes = 4096;

struct MatchKind {
    std::string name;
    std::uint32_t teams = 2;
    std::uint32_t size = 5;   ///< players of a team
    std::uint32_t least = 5;  ///< of a team, once the first has waited for wait_ticks
    std::string instance;     ///< kind of the instance that it is played in; empty: in none
    Tick wait_ticks = 900;
    Tick limit_ticks = 0;   ///< 0: none
    bool backfill = false;  ///< places of those who are lost are given to others
};

struct MatchSettings {
    std::vector<MatchKind> kinds;
    Tick call_ticks = 300;  ///< a player that has not come by then is lost
    Tick grace_ticks = 30;  ///< from the end of the time to the end of the match
};

struct MatchPlayer {
    EntityId avatar;
    ClientId client;
    ZoneId zone;
    std::uint16_t team = 0;
    bool here = false;  ///< has come to the match
    bool lost = false;
};

struct Match {
    MatchId id;
    std::uint16_t kind = 0;
    InstanceId instance;  ///< none: it is played where its players are
    ZoneId zone;          ///< whose rules run it
    std::vector<MatchPlayer> players;
    Tick called = 0;    ///< when its newest players were
    Tick began = 0;     ///< 0: not yet
    bool over = false;  ///< its time is: rules may still give a result
    Tick ended = 0;     ///< 0: not yet
};

enum class MatchAct : std::uint8_t {
    kQueue,
    kUnqueue,
    kEnd,
};

struct MatchOrder {
    MatchAct act = MatchAct::kQueue;
    ZoneId zone;  ///< whose rules they are
    EntityId player;
    MatchId match;
    std::string kind;
    std::uint16_t event = 0;  ///< kind of the event that carries the result; 0: there is none
    std::vector<std::uint8_t> result;
};

enum class MatchRefusal : std::uint8_t {
    kNone,
    kNoPlayer,  ///< it is not the avatar of a player who is here
    kNoKind,
    kNotLeader,  ///< a party waits as a whole, and its leader asks
    kTooLarge,   ///< the party is larger than a team
    kWaiting,    ///< one of them waits already
    kPlaying,    ///< one of them is in a match
    kNotWaiting,
    kNoMatch,  ///< or it has ended
    kTooMany,  ///< tickets of the world
};

inline constexpr std::string_view kMatchRefusalNames[] = {"none",
                                                          "no_player",
                                                          "no_kind",
                                                          "not_leader",
                                                          "too_large",
                                                          "waiting",
                                                          "playing",
                                                          "not_waiting",
                                                          "no_match",
                                                          "too_many"};

/// A player's own are told in its zone, the others in the zone of the match.
enum class MatchEvent : std::uint8_t {
    kRefused,   ///< an order of the player
    kQueued,    ///< the player waits
    kUnqueued,  ///< and does not any more
    kCalled,    ///< the player; it is sent to the instance behind this call
    kCame,      ///< the player, told in the zone of the match
    kBegan,
    kLost,    ///< the player, told in the zone of the match
    kTimeUp,  ///< the match ends soon; rules may give a result
    kEnded,   ///< its result is sent, and its instance ends
};

inline constexpr std::string_view kMatchEventNames[] =
    {"refused", "queued", "unqueued", "called", "came", "began", "lost", "time_up", "ended"};

struct MatchChange {
    MatchEvent event = MatchEvent::kRefused;
    MatchRefusal refusal = MatchRefusal::kNone;
    ZoneId zone;  ///< where it is told
    MatchId match;
    std::string kind;
    EntityId player;
    std::uint16_t team = 0;
    std::uint16_t result_event = 0;  ///< 0: there is no result
    std::vector<std::uint8_t> result;
};

/// The topic that the clients of a match's players are subscribed to.
inline std::string match_topic(MatchId match) {
    return "match/" + std::to_string(match.value);
}

}  // namespace zoned::zone
