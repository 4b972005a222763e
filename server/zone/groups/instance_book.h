// InstanceBook: which instances of a world are open, and who is in them.
#pragma once

#include "server/zone/groups/instance.h"
#include "server/zone/groups/party_book.h"
#include "shared/core/state_hash.h"

#include <bit>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace zoned::zone {

/// A zone as the world knows it.
struct ZoneUse {
    bool runs = true;  ///< false: it has stopped after a fault
    std::size_t clients = 0;
};

using ZoneLookup = std::function<ZoneUse(ZoneId zone)>;

/// One book for all zones, as the parties' is (party_book.h).
class InstanceBook {
  public:
    explicit InstanceBook(InstanceSettings settings) : settings_(std::move(settings)) {}

    // ---- for rules ----

    /// Null: it is not open.
    [[nodiscard]] const Instance* find(InstanceId instance) const;
    /// The instance that is open in a zone; null: none.
    [[nodiscard]] const Instance* in(ZoneId zone) const;
    [[nodiscard]] const InstanceKind& kind_of(const Instance& instance) const;
    [[nodiscard]] bool has_kind(std::string_view name) const;
    /// The place to which a player of a copy's zone goes back.
    [[nodiscard]] Vec3d return_of(ClientId client) const;

    /// Whether a zone is a copy, open or not.
    [[nodiscard]] bool is_copy(ZoneId zone) const;

    // ---- for the world ----

    void begin(Tick now, const ZoneLookup& zone_of);
    void apply(const InstanceOrder& order,
               const ZoneLookup& zone_of,
               const PlayerLookup& player_of);
    /// A free copy, which is told in its zone alone; null: there is none.
    const Instance* try_open(std::string_view kind, const ZoneLookup& zone_of);
    /// Nothing where it is not open any more.
    void close(InstanceId instance);
    /// The avatar of a client is in another zone.
    void move(ClientId client, ZoneId zone);
    void leave(ClientId client);

    [[nodiscard]] std::span<const InstanceChange> changes() const { return changes_; }

    [[nodiscard]] bool tells(ZoneId zone) const;

    [[nodiscard]] std::span<const Instance> open() const { return open_; }

    [[nodiscard]] std::uint64_t refused() const { return refused_; }

    [[nodiscard]] Tick changed() const { return changed_; }

    [[nodiscard]] std::uint64_t digest() const { return digest_.value(); }

    [[nodiscard]] std::string unsound() const;

    template <class Archive>
    void serialize(Archive& archive) {
        std::uint64_t digest = digest_.value();
        archive(open_, visits_, changes_, next_instance_, refused_, changed_, digest, now_);
        if constexpr (Archive::kReads) {
            digest_ = std::bit_cast<core::StateHash>(digest);
            std::string wrong = unsound();
            if (!wrong.empty()) {
                archive.fail(std::move(wrong));
            }
        }
    }

  private:
    struct Visit {
        InstanceId instance;
        EntityId avatar;
        Vec3d from = Vec3d::Zero();
        bool arrived = false;
    };

    const Instance* open_one(std::string_view kind, EntityId asker, const ZoneLookup& zone_of);
    void enter(const InstanceOrder& order, const PlayerLookup& player_of);
    void end(Instance& instance);
    void arrive(Visit& visit, const Instance& instance);
    void refuse(const InstanceOrder& order);
    void note(InstanceEvent event, ZoneId zone, const Instance& instance, EntityId player);
    void note(InstanceChange change);

    InstanceSettings settings_;
    std::vector<Instance> open_;  // ascending by id
    std::map<ClientId, Visit> visits_;
    std::vector<InstanceChange> changes_;
    std::uint32_t next_instance_ = 0;
    std::uint64_t refused_ = 0;
    Tick changed_ = 0;
    core::StateHash digest_;
    Tick now_ = 0;
};

}  // namespace zoned::zone
