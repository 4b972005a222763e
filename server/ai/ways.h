// Ways: the ways of all minds of a zone, on maps of where characters of each size can walk.
#pragma once

#include "server/ai/minds.h"
#include "server/ai/navigation/door_cells.h"
#include "server/ai/navigation/way_service.h"
#include "server/ai/navigation/zone_portals.h"
#include "server/world/entity_type.h"
#include "shared/motion/static_geometry.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace zoned::ai {

struct WaysSettings {
    float cell_m = 0.0F;  ///< of the maps; 0: no ways are planned
    /// Of a tick and zone, in units of about 2 ns; shared evenly among the sizes of characters.
    std::uint64_t work_per_tick = 1'000'000;
};

/// A zone has one; it is empty, and costs nothing, where no ways are planned. A tick goes:
/// follow_doors(), then any ask() and release(), then serve(); answers hold until the next
/// follow_doors(), ask() or release() of the same mind, or serve().
///
/// A mind has one way at most. What is answered, and when, hangs on the calls and their order
/// alone: ask in an order that is always the same (ascending by entity). Nothing is allocated once
/// as many have asked as ever will.
class Ways {
  public:
    Ways() = default;

    /// Bakes a map of `area` (zone-local, m; navigation::GroundGrid::defect_of() is empty) and an
    /// index for each size of character that has a mind: types whose capsules and abilities to
    /// climb are alike share one. Doors are as at `now`.
    Ways(const WaysSettings& settings,
         const motion::StaticGeometry& statics,
         const navigation::GroundRect& area,
         const world::TypeTable& types,
         Tick now);

    /// Whether a character of that type can ask.
    [[nodiscard]] bool plans_for(TypeIndex type) const {
        return type < size_of_type_.size() && size_of_type_[type] != kNoSize;
    }

    [[nodiscard]] bool empty() const { return sizes_.empty(); }

    /// Doors are as at `now` from here on. Ways that a door cuts, as far as their minds still have
    /// to go, and those that an opened one may shorten, are looked for anew. Costs nothing in a
    /// tick in which no door turns.
    void follow_doors(Tick now);

    /// What portals of one size are made of: the map as baked, with all doors open. It is kept from
    /// the start until know_zones() or forget_ground().
    [[nodiscard]] const navigation::GroundMap& ground(std::size_t size) const {
        return *sizes_[size].ground;
    }

    /// From now on ways to places that cannot be reached within the zone lead through the portals
    /// of the world; this zone is `zone` there.
    void know_zones(std::size_t size,
                    std::shared_ptr<const navigation::ZonePortals> portals,
                    std::uint32_t zone);

    /// Where no other zone will be known.
    void forget_ground();

    /// A way from a place to another, both zone-local; in place of the one that the mind has.
    /// plans_for(type). To a place beyond the zone, or in it but out of reach within it, the way
    /// leads to the portal by which the zone is best left (kPartial; doors of other zones count as
    /// open). Where portals are not known or none leads there, to a place beyond: of the cells that
    /// can be reached along the sides of the map that the place lies beyond, to the one by which
    /// two straight lines lead there soonest.
    void ask(Slot mind,
             EntityId entity,
             TypeIndex type,
             navigation::Spot from,
             navigation::Spot to);

    /// The mind wants no way any more, or is gone. Nothing where it has none.
    void release(Slot mind);

    /// Once per tick, after all have asked. Who asked in this tick is answered in it, unless its
    /// work is used up: then in its turn, after WaySettings::longest_wait_ticks at most.
    void serve();

    /// Whether the mind of that entity has asked. The slot may have been another's.
    [[nodiscard]] bool has(Slot mind, EntityId entity) const {
        return mind < asked_.size() && asked_[mind].size != kNoSize &&
               asked_[mind].entity == entity;
    }

    /// Of a mind that has asked. Corners are those where the way turns, in any direction, the last
    /// is its end; without the start. kFound: to the place itself. kPartial: to the nearest place
    /// from which one comes no nearer; best = false: a way that is near the best.
    [[nodiscard]] navigation::WayAnswer answer(Slot mind) const;

    /// Where to walk from `at`, see WayService::heading: somewhere sensible before the way is there
    /// too. Different minds may ask at the same time.
    navigation::Spot heading(Slot mind, navigation::Spot at, float near_m);

    /// Minds whose answers the last serve() has made, ascending; those whose way a door has cut or
    /// shortened are among them again once they have another.
    [[nodiscard]] std::span<const Slot> answered() const { return answered_; }

    /// Minds whose ways the last follow_doors() has cut, or may have made longer than need be,
    /// ascending: they wait again.
    [[nodiscard]] std::span<const Slot> requeued() const { return requeued_; }

    /// A mind that has asked is here now: who waits is told a way from where it was seen last.
    void see(Slot mind, navigation::Spot at);

    /// Whether a character of that type can walk straight from one place to another, as far as the
    /// map tells: then it needs no way. Different threads may ask at the same time, while nobody
    /// changes anything.
    [[nodiscard]] bool straight(TypeIndex type, navigation::Spot from, navigation::Spot to) const;

    [[nodiscard]] std::size_t sizes() const { return sizes_.size(); }

    [[nodiscard]] const navigation::WayService& service(std::size_t size) const {
        return *sizes_[size].service;
    }

    /// Counts of all sizes together.
    [[nodiscard]] navigation::WayCounts counts() const;

    [[nodiscard]] std::size_t bytes() const;

  private:
    static constexpr std::uint8_t kNoSize = 255;

    struct Size {
        motion::CharacterLimits limits;
        std::unique_ptr<navigation::WayService> service;
        navigation::DoorMap doors;
        std::unique_ptr<navigation::GroundMap> ground;           // until portals are made of it
        std::shared_ptr<const navigation::ZonePortals> portals;  // of the world; may be null
        std::vector<Slot> mind_of_request;  // by the service's number of the request
    };

    /// By slot of the mind.
    struct Asked {
        EntityId entity;
        navigation::WayTicket ticket;
        std::uint8_t size = kNoSize;
        bool beyond = false;  ///< the goal lies beyond the zone
    };

    void add_size(const WaysSettings& settings,
                  const motion::StaticGeometry& statics,
                  const navigation::GroundRect& area,
                  const motion::CharacterLimits& limits,
                  Tick now);
    /// Where to leave the zone for a place that cannot be reached within it, through other zones;
    /// nothing where it can be, or nothing is known of them.
    std::optional<navigation::Spot> portal_out(Size& size,
                                               navigation::Spot from,
                                               navigation::Spot to);
    /// Where to leave the map for a place beyond it, as straight lines lead.
    static navigation::Spot way_out(navigation::WayService& service,
                                    navigation::Spot from,
                                    navigation::Spot to);
    /// Appends whose requests of a size these are.
    void note(std::span<const std::uint32_t> requests,
              std::size_t number,
              std::vector<Slot>& out) const;
    static void put_in_order(std::vector<Slot>& minds);

    std::uint32_t zone_ = 0;  // in the portals
    navigation::ZonePortals::Scratch portal_scratch_;
    std::vector<std::uint8_t> size_of_type_;
    std::vector<Size> sizes_;
    std::vector<motion::Timetable> timetables_;   // of the doors
    Tick next_turn_ = motion::Timetable::kNever;  // of any door
    std::vector<Asked> asked_;
    std::vector<Slot> answered_;
    std::vector<Slot> requeued_;
    std::vector<navigation::CellChange> changes_;
};

}  // namespace zoned::ai
