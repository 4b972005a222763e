#include "server/ai/ways.h"

#include "server/ai/navigation/line_of_sight.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace zoned::ai {

namespace {

/// Whether characters of both bodies walk on the same ground.
bool same_ground(const motion::CharacterLimits& a, const motion::CharacterLimits& b) {
    return a.radius == b.radius && a.half_segment == b.half_segment &&
           a.max_slope_cos == b.max_slope_cos && a.step_up == b.step_up &&
           a.step_down == b.step_down;
}

float apart(navigation::Spot a, navigation::Spot b) {
    return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.z - b.z) * (a.z - b.z));
}

/// The first tick after `now` at which a door turns.
Tick next_turn(std::span<const motion::Timetable> doors, Tick now) {
    Tick next = motion::Timetable::kNever;
    for (const motion::Timetable& door : doors) {
        next = std::min(next, door.next_change(now));
    }
    return next;
}

}  // namespace

Ways::Ways(const WaysSettings& settings,
           const motion::StaticGeometry& statics,
           const navigation::GroundRect& area,
           const world::TypeTable& types,
           Tick now)
    : size_of_type_(types.size(), kNoSize) {
    if (settings.cell_m == 0.0F) {
        return;
    }
    std::vector<motion::CharacterLimits> bodies;
    for (std::size_t t = 0; t < types.size(); ++t) {
        if (types[t].mind == 0 || types[t].kind != world::EntityKind::kCharacter) {
            continue;
        }
        const motion::CharacterLimits& body = types[t].character;
        auto same = std::find_if(bodies.begin(), bodies.end(), [&](const auto& other) {
            return same_ground(body, other);
        });
        if (same == bodies.end()) {
            same = bodies.insert(bodies.end(), body);
        }
        size_of_type_[t] = static_cast<std::uint8_t>(same - bodies.begin());
    }
    ZONED_ASSERT(bodies.size() < kNoSize, "sizes of characters with minds are few");
    for (const motion::Door& door : statics.doors()) {
        timetables_.push_back(door.times);
    }
    next_turn_ = next_turn(timetables_, now);
    WaysSettings share = settings;
    share.work_per_tick = std::max<std::uint64_t>(
        1, settings.work_per_tick / std::max<std::size_t>(1, bodies.size()));
    for (const motion::CharacterLimits& body : bodies) {
        add_size(share, statics, area, body, now);
    }
}

void Ways::add_size(const WaysSettings& settings,
                    const motion::StaticGeometry& statics,
                    const navigation::GroundRect& area,
                    const motion::CharacterLimits& limits,
                    Tick now) {
    Size& size = sizes_.emplace_back();
    size.limits = limits;
    navigation::GroundMap ground = navigation::bake_ground(statics, limits, area, settings.cell_m);
    size.ground = std::make_unique<navigation::GroundMap>(ground);
    if (!timetables_.empty()) {
        size.doors = navigation::DoorMap(
            navigation::bake_doors(statics, limits, area, settings.cell_m, ground), ground.cells);
        changes_.clear();
        for (std::uint32_t d = 0; d < timetables_.size(); ++d) {
            size.doors.turn(d, !timetables_[d].open_at(now), changes_);
        }
        for (const navigation::CellChange& c : changes_) {
            ground.cells.set_passable(c.cell, c.passable);
        }
        changes_.clear();
    }
    navigation::WaySettings service;
    service.work_per_tick = settings.work_per_tick;
    size.service = std::make_unique<navigation::WayService>(std::move(ground), service);
}

void Ways::note(std::span<const std::uint32_t> requests,
                std::size_t number,
                std::vector<Slot>& out) const {
    const Size& size = sizes_[number];
    for (const std::uint32_t request : requests) {
        // The request may have been released since, and be another's by now.
        const Slot mind = size.mind_of_request[request];
        if (asked_[mind].size == number && asked_[mind].ticket.slot == request) {
            out.push_back(mind);
        }
    }
}

void Ways::put_in_order(std::vector<Slot>& minds) {
    std::sort(minds.begin(), minds.end());
    minds.erase(std::unique(minds.begin(), minds.end()), minds.end());
}

void Ways::follow_doors(Tick now) {
    requeued_.clear();
    if (now < next_turn_ || sizes_.empty()) {
        return;
    }
    for (std::size_t s = 0; s < sizes_.size(); ++s) {
        Size& size = sizes_[s];
        changes_.clear();
        for (std::uint32_t d = 0; d < timetables_.size(); ++d) {
            size.doors.turn(d, !timetables_[d].open_at(now), changes_);
        }
        if (!changes_.empty()) {
            size.service->change(changes_);
            note(size.service->requeued(), s, requeued_);
        }
    }
    put_in_order(requeued_);
    next_turn_ = next_turn(timetables_, now);
}

void Ways::ask(Slot mind,
               EntityId entity,
               TypeIndex type,
               navigation::Spot from,
               navigation::Spot to) {
    ZONED_ASSERT(plans_for(type), "characters with minds ask for ways where ways are planned");
    release(mind);
    if (mind >= asked_.size()) {
        asked_.resize(mind + std::size_t{1});
    }
    Size& size = sizes_[size_of_type_[type]];
    const navigation::GroundGrid& grid = size.service->grid();
    const bool place = std::isfinite(to.x) && std::isfinite(to.z);
    const std::optional<navigation::Spot> out = place ? portal_out(size, from, to) : std::nullopt;
    const bool beyond = out || (place && !grid.contains(to));
    navigation::Spot end = to;
    if (beyond) {
        end = out ? *out : way_out(*size.service, from, to);
    }
    const navigation::WayTicket ticket = size.service->ask({navigation::WayAsk::kAlone, from, end});
    asked_[mind] = {entity, ticket, size_of_type_[type], beyond};
    if (ticket.slot >= size.mind_of_request.size()) {
        size.mind_of_request.resize(ticket.slot + std::size_t{1});
    }
    size.mind_of_request[ticket.slot] = mind;
}

void Ways::know_zones(std::size_t size,
                      std::shared_ptr<const navigation::ZonePortals> portals,
                      std::uint32_t zone) {
    sizes_[size].portals = std::move(portals);
    sizes_[size].ground.reset();
    zone_ = zone;
}

void Ways::forget_ground() {
    for (Size& size : sizes_) {
        size.ground.reset();
    }
}

std::optional<navigation::Spot> Ways::portal_out(Size& size,
                                                 navigation::Spot from,
                                                 navigation::Spot to) {
    if (size.portals == nullptr) {
        return std::nullopt;
    }
    navigation::WayService& service = *size.service;
    const navigation::GroundGrid& grid = service.grid();
    const navigation::GridMap& map = service.planner().map();
    if (grid.contains(to)) {
        // A goal in an obstacle stands for what is nearest, and is looked for within the zone.
        const navigation::Cell goal = grid.cell(to);
        if (!map.passable(goal) || service.reaches(from, goal)) {
            return std::nullopt;
        }
    }
    const std::optional<std::uint32_t> other = size.portals->zone_of(zone_, to);
    if (!other) {
        return std::nullopt;
    }
    return size.portals->way_out(
        zone_,
        from,
        *other,
        size.portals->local(zone_, to, *other),
        [&](navigation::Cell c) { return service.length(from, c); },
        portal_scratch_);
}

navigation::Spot Ways::way_out(navigation::WayService& service,
                               navigation::Spot from,
                               navigation::Spot to) {
    const navigation::GroundGrid& grid = service.grid();
    const navigation::GridMap& map = service.planner().map();
    const int right = grid.width() - 1;
    const int bottom = grid.height() - 1;
    const navigation::Spot first = grid.centre({0, 0});
    const navigation::Spot last =
        grid.centre({static_cast<std::uint16_t>(right), static_cast<std::uint16_t>(bottom)});
    navigation::Spot best{std::clamp(to.x, first.x, last.x), std::clamp(to.z, first.z, last.z)};
    float least = std::numeric_limits<float>::infinity();
    const auto consider = [&](int x, int y) {
        const navigation::Cell c{static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)};
        const navigation::Spot at = grid.centre(c);
        const float sum = apart(from, at) + apart(at, to);
        if (sum < least && map.passable(c) && service.reaches(from, c)) {
            least = sum;
            best = at;
        }
    };
    for (int y = 0; y <= bottom && (to.x < first.x || to.x > last.x); ++y) {
        consider(to.x < first.x ? 0 : right, y);
    }
    for (int x = 0; x <= right && (to.z < first.z || to.z > last.z); ++x) {
        consider(x, to.z < first.z ? 0 : bottom);
    }
    return best;
}

void Ways::release(Slot mind) {
    if (mind < asked_.size() && asked_[mind].size != kNoSize) {
        sizes_[asked_[mind].size].service->release(asked_[mind].ticket);
        asked_[mind] = Asked();
    }
}

void Ways::serve() {
    answered_.clear();
    for (std::size_t s = 0; s < sizes_.size(); ++s) {
        sizes_[s].service->serve();
        note(sizes_[s].service->answered(), s, answered_);
    }
    std::erase_if(answered_, [this](Slot mind) { return answer(mind).waiting; });
    put_in_order(answered_);
}

navigation::WayAnswer Ways::answer(Slot mind) const {
    const Asked& asked = asked_[mind];
    navigation::WayAnswer answer = sizes_[asked.size].service->answer(asked.ticket);
    if (asked.beyond && answer.outcome == navigation::Outcome::kFound) {
        answer.outcome = navigation::Outcome::kPartial;
    }
    return answer;
}

void Ways::see(Slot mind, navigation::Spot at) {
    const Asked& asked = asked_[mind];
    sizes_[asked.size].service->see(asked.ticket, at);
}

navigation::Spot Ways::heading(Slot mind, navigation::Spot at, float near_m) {
    const Asked& asked = asked_[mind];
    return sizes_[asked.size].service->heading(asked.ticket, at, near_m);
}

bool Ways::straight(TypeIndex type, navigation::Spot from, navigation::Spot to) const {
    ZONED_ASSERT(plans_for(type), "characters with minds ask for ways where ways are planned");
    const navigation::WayService& service = *sizes_[size_of_type_[type]].service;
    const navigation::GroundGrid& grid = service.grid();
    const navigation::GridMap& map = service.planner().map();
    if (!grid.contains(from) || !grid.contains(to) || !map.passable(grid.cell(from)) ||
        !map.passable(grid.cell(to))) {
        return false;
    }
    std::uint32_t looked = 0;
    return navigation::sees(map, grid.cell(from), grid.cell(to), looked);
}

navigation::WayCounts Ways::counts() const {
    navigation::WayCounts sum;
    for (const Size& size : sizes_) {
        const navigation::WayCounts& c = size.service->counts();
        sum.asked += c.asked;
        sum.served += c.served;
        sum.straight += c.straight;
        sum.by_field += c.by_field;
        sum.by_areas += c.by_areas;
        sum.fields += c.fields;
        sum.broken += c.broken;
        sum.reviewed += c.reviewed;
        sum.waiting += c.waiting;
        sum.longest_wait_ticks = std::max(sum.longest_wait_ticks, c.longest_wait_ticks);
        sum.work += c.work;
    }
    return sum;
}

std::size_t Ways::bytes() const {
    std::size_t bytes = asked_.capacity() * sizeof(Asked) +
                        (answered_.capacity() + requeued_.capacity()) * sizeof(Slot) +
                        changes_.capacity() * sizeof(navigation::CellChange);
    for (const Size& size : sizes_) {
        bytes += size.ground != nullptr ? size.ground->floor_m.capacity() * sizeof(float) : 0;
        bytes += size.service->bytes() + size.doors.bytes() +
                 size.mind_of_request.capacity() * sizeof(Slot);
    }
    return bytes;
}

}  // namespace zoned::ai
