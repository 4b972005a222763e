// Store messages: the requests of a zone to the durable store, and its answers.
#pragma once

#include "shared/core/ids.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace zoned::mailbox {

inline constexpr std::size_t kMaxStoreNameBytes = 64;  ///< account, character and key, each
inline constexpr std::size_t kMaxStoreValueBytes = 65536;
/// Of one zone and tick; more are refused at once.
inline constexpr std::size_t kMaxStoreRequests = 256;

/// Whose record it is.
enum class StoreScope : std::uint8_t {
    kWorld,
    kAccount,
    kCharacter,  ///< of one name of an account
};

/// The name of a record. Clean UTF-8, 1 to kMaxStoreNameBytes bytes where the scope asks for a
/// part, else empty.
struct StoreKey {
    StoreScope scope = StoreScope::kWorld;
    std::string account;
    std::string character;
    std::string key;

    bool operator==(const StoreKey&) const = default;
};

/// Whether the parts are there that the scope asks for, and none is too long. Their encoding is
/// another matter.
[[nodiscard]] inline bool has_good_lengths(const StoreKey& key) {
    const auto fits = [](const std::string& part, bool wanted) {
        return wanted ? !part.empty() && part.size() <= kMaxStoreNameBytes : part.empty();
    };
    return fits(key.account, key.scope != StoreScope::kWorld) &&
           fits(key.character, key.scope == StoreScope::kCharacter) && fits(key.key, true);
}

enum class StoreAct : std::uint8_t {
    kGet,
    kPut,
    kRemove,
    kStand,  ///< where a character stands; of the server, rules hear nothing of it
    kEvent,  ///< a durable event
};
inline constexpr StoreAct kLastStoreAct = StoreAct::kEvent;

/// A tick's requests become one transaction, its writes before its reads.
struct StoreRequest {
    StoreAct act = StoreAct::kGet;
    std::uint64_t number = 0;  ///< of the answer; 0: none is wanted
    ZoneId zone;
    EntityId target;  ///< the answer goes to the zone that owns it then; none: to `zone`
    StoreKey key;     ///< kStand: account and character; kEvent: account, and the topic as key
    std::vector<std::uint8_t> value;  ///< kPut, kEvent
    double position[3] = {0, 0, 0};   ///< kStand, world coordinates, m
    std::uint16_t kind = 0;           ///< kEvent
};

enum class StoreStatus : std::uint8_t {
    kDone,     ///< durable, or read
    kAbsent,   ///< kGet: there is no such record
    kRefused,  ///< not stored and not read: the store takes no more
};

struct StoreAnswer {
    std::uint64_t number = 0;  ///< of the request
    StoreAct act = StoreAct::kGet;
    StoreStatus status = StoreStatus::kDone;
    ZoneId zone;
    EntityId target;
    StoreKey key;
    std::vector<std::uint8_t> value;  ///< kGet
};

}  // namespace zoned::mailbox
