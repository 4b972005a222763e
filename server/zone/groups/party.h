// Party: a group of players of a world, what rules ask of it, and what they are told.
#pragma once

#include "shared/core/ids.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace zoned::zone {

/// A party of the world, never reused.
using PartyId = StrongId<struct PartyTag>;

/// Beyond these an order is refused: players who ask on and on meet an end.
inline constexpr std::uint32_t kMostInvitationsFrom = 16;  ///< of a player, declined ones too
inline constexpr std::uint32_t kMostInvitationsTo = 16;    ///< of a player
inline constexpr std::size_t kMostPartyOrders = 1000;      ///< of a zone in a tick
inline constexpr std::size_t kMostPartyValues = 16;        ///< of a party
inline constexpr std::size_t kMostPartyKeyBytes = 64;
inline constexpr std::size_t kMostPartyValueBytes = 256;

struct PartySettings {
    std::uint32_t size = 5;      ///< members, at most
    std::uint32_t most = 10000;  ///< parties of the world
    /// An invitation is open so long. So long after it was declined, the same player asks in vain.
    Tick invitation_ticks = 1800;
    /// A member whose client left keeps its place so long; 0: not at all.
    Tick rejoin_ticks = 9000;
};

/// A player, by its avatar: where a client comes back with another, its account and name tell.
struct PartyPlayer {
    EntityId avatar;
    ClientId client;
    ZoneId zone;
    std::string account;  ///< empty: it cannot be known again
    std::string name;
};

struct PartyMember {
    PartyPlayer player;   ///< of one that is away, as it was
    Tick away_since = 0;  ///< 0: it is here

    [[nodiscard]] bool is_away() const { return away_since != 0; }
};

struct Party {
    PartyId id;
    std::vector<PartyMember> members;  ///< the leader, then the others as they came; never empty
    std::uint32_t invited = 0;         ///< open invitations
    /// Shared by its members, ascending by key.
    std::vector<std::pair<std::string, std::vector<std::uint8_t>>> values;

    [[nodiscard]] EntityId leader() const { return members.front().player.avatar; }
};

enum class PartyAct : std::uint8_t {
    kInvite,
    kAccept,
    kDecline,
    kLeave,
    kKick,
    kPromote,
    kDisband,
    kSetValue,
};

/// A wish of the rules of a zone. The world carries out the orders of a tick zone by zone.
struct PartyOrder {
    PartyAct act = PartyAct::kInvite;
    ZoneId zone;     ///< whose rules they are
    EntityId by;     ///< avatar of the player that acts
    EntityId other;  ///< avatar of the player that it acts on
    PartyId party;   ///< kAccept, kDecline, kSetValue
    std::string key;
    std::vector<std::uint8_t> value;
};

enum class PartyRefusal : std::uint8_t {
    kNone,
    kNoPlayer,    ///< an avatar is not that of a player who is here
    kOneself,     ///< nobody invites, kicks or promotes itself
    kInAParty,    ///< the player that would come in is in a party
    kNoParty,     ///< there is no such party, or the player is in none
    kNotLeader,   ///< that is the leader's to do
    kNotAMember,  ///< of the leader's party
    kAway,        ///< the member is not here to lead
    kFull,        ///< the party has parties.size members
    kNotInvited,  ///< or no longer
    kInvited,     ///< its answer is due
    kDeclined,    ///< lately
    kTooMany,     ///< parties, invitations or values
};

inline constexpr std::string_view kPartyRefusalNames[] = {"none",
                                                          "no_player",
                                                          "oneself",
                                                          "in_a_party",
                                                          "no_party",
                                                          "not_leader",
                                                          "not_a_member",
                                                          "away",
                                                          "full",
                                                          "not_invited",
                                                          "invited",
                                                          "declined",
                                                          "too_many"};

/// News of a player in a party, or of an order.
enum class PartyEvent : std::uint8_t {
    kRefused,   ///< an order of the player
    kInvited,   ///< by `other`
    kDeclined,  ///< the player did, or went into another party
    kExpired,   ///< the invitation of the player
    kJoined,    ///< the founder too
    kLeft,      ///< by itself, or because it was away too long or the party has ended
    kKicked,    ///< by `other`
    kAway,      ///< its client left, its place is kept
    kBack,
    kLeads,  ///< in place of `other`
    kEnded,  ///< the party; the player is the last one who left
};

inline constexpr std::string_view kPartyEventNames[] = {"refused",
                                                        "invited",
                                                        "declined",
                                                        "expired",
                                                        "joined",
                                                        "left",
                                                        "kicked",
                                                        "away",
                                                        "back",
                                                        "leads",
                                                        "ended"};

/// Told once: in the zone where the player is (kDeclined, kExpired: where the leader is). Of a
/// player that is away, in the zone of the leader; where that is away too, in the first zone.
struct PartyChange {
    PartyEvent event = PartyEvent::kRefused;
    PartyRefusal refusal = PartyRefusal::kNone;
    ZoneId zone;
    PartyId party;  ///< none: an order without one was refused
    EntityId player;
    EntityId other;
    ClientId client;   ///< of the player; none while it is away
    std::string name;  ///< of the player
};

/// The topic that the clients of a party's members are subscribed to.
inline std::string party_topic(PartyId party) {
    return "party/" + std::to_string(party.value);
}

}  // namespace zoned::zone
