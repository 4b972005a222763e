// Records: the state of characters and props in the sandbox game; one list of fields drives saving,
// loading and hashing.
#pragma once

#include "server/rules/keeping/item_fields.h"
#include "shared/core/ids.h"
#include "shared/math/types.h"

#include <cstdint>
#include <string>
#include <vector>

namespace zoned::rules {

/// A prop in somebody's inventory. The entity itself is gone; its id is the handle by which the
/// owner names the item.
struct Item {
    EntityId id;
    TypeIndex type = 0;
    std::uint16_t appearance = 0;
    ItemFields held;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.id);
        archive(self.type);
        archive(self.appearance);
        archive(self.held);
    }
};

/// An item of a type that this world has not: it stays with its owner, for a world that has it.
struct StrangeItem {
    std::string type;
    std::uint16_t appearance = 0;
    ItemFields held;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.type);
        archive(self.appearance);
        archive(self.held);
    }
};

/// The displayed state of an entity in a view, as its client says.
struct SeenRecord {
    EntityId entity;
    Vec3d position = Vec3d::Zero();  ///< world coordinates, m
    Tick publication = 0;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.entity);
        archive(self.position);
        archive(self.publication);
    }
};

/// A shot that waits for its tick, with its client's view.
struct FiredShot {
    Tick tick = 0;  ///< fired from where the avatar is after it
    Vec3 along = Vec3::UnitZ();
    Tick seen_tick = 0;
    std::uint32_t fraction = 0;  ///< of the tick after it, in 1/65536
    std::uint8_t past = 0;       ///< 1: an interpolating view
    EntityId aimed;
    std::vector<SeenRecord> sightings;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.tick);
        archive(self.along);
        archive(self.seen_tick);
        archive(self.fraction);
        archive(self.past);
        archive(self.aimed);
        archive(self.sightings);
    }
};

enum class Life : std::uint8_t {
    kAlive,
    kDying,  ///< killed, waits until `life_until` for its client to confirm
    kDead,   ///< hidden until `life_until`
    kBack,   ///< respawned; to be announced when those around hear of it, one tick later
};
inline constexpr Life kLastLife = Life::kBack;

/// The store's knowledge of a character.
enum class Keeping : std::uint8_t {
    kNothing,  ///< its client has no account
    kAsked,    ///< its kept record is on its way
    kUnread,   ///< the store could not say what it kept before
    kKept,     ///< all that the character owns, or it is on its way there
    kRefused,  ///< it took the last change not
};
inline constexpr Keeping kLastKeeping = Keeping::kRefused;

struct CharacterRecord {
    ClientId client;  ///< none for characters that nobody plays
    std::string name;
    std::string team;
    Vec3d spawn = Vec3d::Zero();  ///< world coordinates, m
    std::uint32_t health = 0;
    Life life = Life::kAlive;
    EntityId killer;
    EventId kill_event;  ///< that the killed client has to confirm
    Tick life_until = 0;
    Tick next_shot = 0;
    Tick next_throw = 0;
    Tick next_push = 0;
    Tick next_bite = 0;
    Tick chat_due = 0;    ///< theoretical arrival time of the rate limit
    Tick denial_due = 0;  ///< the same for denials
    Tick moved_at = 0;    ///< last tick with a movement command
    std::vector<Item> inventory;
    std::vector<FiredShot> shots;  ///< whose tick has not come yet
    std::uint32_t deaths = 0;
    std::uint32_t kills = 0;
    std::uint32_t trades = 0;
    std::uint64_t ledger_serial = 0;
    std::uint64_t ledger_digest = 0;   ///< of the last ledger sent
    std::uint32_t ledger_repeats = 0;  ///< how often it was sent; 0: the client agrees
    Tick ledger_due = 0;               ///< when it is sent again
    EntityId offer_to;
    EntityId offer_give;
    EntityId offer_want;
    Tick offer_until = 0;
    EventId trade_event;   ///< that the client has to confirm
    EventId killer_event;  ///< likewise, of a kill of its own
    std::string account;   ///< empty: it cannot be known again
    Keeping keeping = Keeping::kNothing;
    bool keep_due = false;                   ///< changed while its past was on its way
    std::vector<StrangeItem> strange_items;  ///< kept ones of types that this world has not

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.client);
        archive(self.name);
        archive(self.team);
        archive(self.spawn);
        archive(self.health);
        archive(self.life);
        archive(self.killer);
        archive(self.kill_event);
        archive(self.life_until);
        archive(self.next_shot);
        archive(self.next_throw);
        archive(self.next_push);
        archive(self.next_bite);
        archive(self.chat_due);
        archive(self.denial_due);
        archive(self.moved_at);
        archive(self.inventory);
        archive(self.shots);
        archive(self.deaths);
        archive(self.kills);
        archive(self.trades);
        archive(self.ledger_serial);
        archive(self.ledger_digest);
        archive(self.ledger_repeats);
        archive(self.ledger_due);
        archive(self.offer_to);
        archive(self.offer_give);
        archive(self.offer_want);
        archive(self.offer_until);
        archive(self.trade_event);
        archive(self.killer_event);
        archive(self.account);
        archive(self.keeping);
        archive(self.keep_due);
        archive(self.strange_items);
    }

    [[nodiscard]] bool can_act() const { return life == Life::kAlive || life == Life::kBack; }

    [[nodiscard]] bool pending() const {
        return life != Life::kAlive || !shots.empty() || ledger_repeats != 0;
    }
};

struct PropRecord {
    EntityId thrown_by;  ///< flies since a throw and has hit nobody yet
    Tick thrown_until = 0;
    EntityId reserved_for;  ///< hidden, in transfer to the inventory of somebody in another zone
    Tick reserved_until = 0;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.thrown_by);
        archive(self.thrown_until);
        archive(self.reserved_for);
        archive(self.reserved_until);
    }
};

/// The remains of a killed character.
struct RagdollRecord {
    Tick gone_at = 0;

    template <class Archive, class Self>
    static void fields(Archive& archive, Self& self) {
        archive(self.gone_at);
    }
};

}  // namespace zoned::rules
