#include "server/ai/pathfinding/path_service.h"

#include "server/ai/pathfinding/navmesh/navmesh_paths.h"
#include "server/ai/pathfinding/requests/grid_paths.h"
#include "server/ai/pathfinding/waypoints/waypoint_lattice.h"
#include "server/ai/pathfinding/waypoints/waypoint_paths.h"
#include "shared/core/assert.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace zoned::ai {

namespace {

/// True if characters of both bodies walk on the same ground.
bool same_ground(const motion::CharacterLimits& a, const motion::CharacterLimits& b) {
    return a.radius == b.radius && a.half_segment == b.half_segment &&
           a.max_slope_cos == b.max_slope_cos && a.step_up == b.step_up &&
           a.step_down == b.step_down;
}

/// Bodies that walk on different ground, and which of them each type has.
struct BodySizes {
    std::vector<motion::CharacterLimits> bodies;
    std::vector<std::uint8_t> of_type;  ///< SavedPathService::kNoSize: the type plans no paths
};

BodySizes sizes_of(const PathfindingSettings& settings, const world::TypeTable& types) {
    BodySizes sizes{{}, std::vector<std::uint8_t>(types.size(), SavedPathService::kNoSize)};
    for (std::size_t t = 0; settings.cell_m != 0.0F && t < types.size(); ++t) {
        const bool travels = settings.travels.empty() || settings.travels[t] != 0;
        if (types[t].brain == 0 || types[t].kind != world::EntityKind::kCharacter || !travels) {
            continue;
        }
        const motion::CharacterLimits& body = types[t].character;
        auto same = std::find_if(sizes.bodies.begin(), sizes.bodies.end(), [&](const auto& other) {
            return same_ground(body, other);
        });
        if (same == sizes.bodies.end()) {
            same = sizes.bodies.insert(sizes.bodies.end(), body);
        }
        sizes.of_type[t] = static_cast<std::uint8_t>(same - sizes.bodies.begin());
    }
    ZONED_ASSERT(sizes.bodies.size() < SavedPathService::kNoSize,
                 "sizes of characters with agents are few");
    return sizes;
}

/// The area to bake for a mesh of `area`: a mesh ends before the sides of the baked area. The gap
/// is the body's width, rounded up, a cell that Recast takes for a ledge, and the error of
/// contours.
pathfinding::GroundRect mesh_area(const pathfinding::GroundRect& area,
                                  const motion::CharacterLimits& limits,
                                  float cell_m) {
    const float more = limits.radius + 4.0F * cell_m;
    return {area.min_x - more, area.min_z - more, area.max_x + more, area.max_z + more};
}

}  // namespace

std::string PathService::defect_of(const PathfindingSettings& settings,
                                   const motion::StaticGeometry& statics,
                                   const pathfinding::GroundRect& area,
                                   const world::TypeTable& types) {
    if (settings.map != PathMapKind::kNavmesh) {
        return {};
    }
    for (const motion::CharacterLimits& body : sizes_of(settings, types).bodies) {
        const pathfinding::GroundRect wide = mesh_area(area, body, settings.cell_m);
        std::string defect = pathfinding::Navmesh::defect_of(
            statics, body, wide, {settings.cell_m, settings.cell_height_m});
        if (!defect.empty()) {
            return defect;
        }
    }
    return {};
}

PathService::PathService(const PathfindingSettings& settings,
                         const motion::StaticGeometry& statics,
                         const pathfinding::GroundRect& area,
                         const world::TypeTable& types,
                         Tick now,
                         const Vec3d& origin) {
    BodySizes sizes = sizes_of(settings, types);
    size_of_type_ = std::move(sizes.of_type);
    if (settings.cell_m == 0.0F) {
        return;
    }
    const std::vector<motion::CharacterLimits>& bodies = sizes.bodies;
    statics_ = statics;
    see_doors(now);
    PathfindingSettings share = settings;
    share.work_per_tick = std::max<std::uint64_t>(
        1, settings.work_per_tick / std::max<std::size_t>(1, bodies.size()));
    for (const motion::CharacterLimits& body : bodies) {
        sizes_.push_back({make_map(share, statics, area, body, shut_, origin), {}, false});
    }
}

std::unique_ptr<pathfinding::PathProvider> PathService::make_map(
    const PathfindingSettings& settings,
    const motion::StaticGeometry& statics,
    const pathfinding::GroundRect& area,
    const motion::CharacterLimits& limits,
    std::span<const std::uint8_t> shut,
    const Vec3d& origin) {
    switch (settings.map) {
        case PathMapKind::kGrid: {
            pathfinding::GridPathSettings service;
            service.work_per_tick = settings.work_per_tick;
            service.crowding = settings.crowding;
            service.search = settings.search;
            return std::make_unique<pathfinding::GridPaths>(
                statics, limits, area, settings.cell_m, shut, service);
        }
        case PathMapKind::kNavmesh: {
            const pathfinding::GroundRect wide = mesh_area(area, limits, settings.cell_m);
            auto mesh = pathfinding::Navmesh::bake(
                statics, limits, wide, {settings.cell_m, settings.cell_height_m});
            if (!mesh) {
                throw std::runtime_error("ai.pathfinding: no mesh of a zone: " + mesh.error());
            }
            pathfinding::NavmeshPathsSettings paths;
            paths.queue.work_per_tick = settings.work_per_tick;
            return std::make_unique<pathfinding::NavmeshPaths>(
                std::move(mesh).value(), wide, shut, paths);
        }
        case PathMapKind::kWaypointGraph: {
            auto graph = settings.waypoints
                             ? core::Result<pathfinding::WaypointGraph>(
                                   settings.waypoints->seen_from(origin))
                             : pathfinding::waypoint_lattice(pathfinding::bake_ground(
                                   statics, limits, area, settings.cell_m));
            if (!graph) {
                throw std::runtime_error("ai.pathfinding: no waypoints of a zone: " +
                                         graph.error());
            }
            std::vector<pathfinding::WaypointDoor> doors =
                pathfinding::waypoint_doors(*graph, statics, limits);
            pathfinding::WaypointPathsSettings paths;
            paths.queue.work_per_tick = settings.work_per_tick;
            return std::make_unique<pathfinding::WaypointPaths>(
                std::move(graph).value(), std::move(doors), shut, paths);
        }
    }
    ZONED_ASSERT(false, "a map is one of the enumeration");
    return nullptr;
}

bool PathService::see_doors(Tick now) {
    bool turned = false;
    shut_.resize(statics_.doors().size());
    for (std::uint32_t door = 0; door < shut_.size(); ++door) {
        const std::uint8_t shut = statics_.shut_at(door, now) ? 1 : 0;
        turned = std::exchange(shut_[door], shut) != shut || turned;
    }
    next_turn_ = statics_.next_turn(now);
    return turned;
}

void PathService::note(std::span<const std::uint32_t> requests,
                       std::size_t number,
                       std::vector<Slot>& out) const {
    const Size& size = sizes_[number];
    for (const std::uint32_t request : requests) {
        // The request may have been released since, and be another's by now.
        const Slot agent = size.agent_of_request[request];
        if (asked_[agent].size == number && asked_[agent].ticket.slot == request) {
            out.push_back(agent);
        }
    }
}

void PathService::put_in_order(std::vector<Slot>& agents) {
    std::sort(agents.begin(), agents.end());
    agents.erase(std::unique(agents.begin(), agents.end()), agents.end());
}

void PathService::follow_doors(Tick now) {
    requeued_.clear();
    for (std::size_t s = 0; s < sizes_.size(); ++s) {
        note(sizes_[s].map->review_crowds(), s, requeued_);
        sizes_[s].learned = sizes_[s].map->learn_exits();
        std::copy_if(rough_.begin(), rough_.end(), std::back_inserter(requeued_), [&](Slot agent) {
            return sizes_[s].learned && asked_[agent].size == s;
        });
    }
    if (now >= next_turn_ && !sizes_.empty() && see_doors(now)) {
        for (std::size_t s = 0; s < sizes_.size(); ++s) {
            sizes_[s].map->turn_doors(shut_);
            note(sizes_[s].map->requeued(), s, requeued_);
        }
    }
    put_in_order(requeued_);
}

void PathService::ask(Slot agent,
                      EntityId entity,
                      TypeIndex type,
                      pathfinding::Spot from,
                      pathfinding::Spot to,
                      PathHeights heights) {
    ZONED_ASSERT(plans_for(type), "characters with agents ask for paths where paths are planned");
    release(agent);
    if (agent >= asked_.size()) {
        asked_.resize(agent + std::size_t{1});
    }
    const pathfinding::Spot goal = to;
    Asked asked{entity, {}, size_of_type_[type], false, false, {}};
    if (const auto out = sizes_[asked.size].map->exit_towards(from, heights.from, to)) {
        to = out->at;
        heights.to = out->y;
        asked.beyond = true;
        asked.rough = out->rough;
        asked.goal = goal;
    }
    ask_of(agent, asked, {pathfinding::PathRequest::kAlone, from, to, heights.from, heights.to});
}

void PathService::ask_of(Slot agent, const Asked& asked, const pathfinding::PathRequest& request) {
    Size& size = sizes_[asked.size];
    asked_[agent] = asked;
    asked_[agent].ticket = size.map->ask(request);
    const std::uint32_t number = asked_[agent].ticket.slot;
    if (number >= size.agent_of_request.size()) {
        size.agent_of_request.resize(number + std::size_t{1});
    }
    size.agent_of_request[number] = agent;
    if (asked.rough) {
        note_rough(agent);
    }
}

void PathService::note_rough(Slot agent) {
    const auto after =
        std::lower_bound(rough_.begin(), rough_.end(), agent, [this](Slot a, Slot b) {
            return asked_[a].entity < asked_[b].entity;
        });
    rough_.insert(after, agent);
}

void PathService::refine_exits(std::size_t number) {
    pathfinding::PathProvider& map = *sizes_[number].map;
    const std::vector<Slot> rough = rough_;
    for (const Slot agent : rough) {
        Asked asked = asked_[agent];
        if (asked.size != number) {
            continue;
        }
        const pathfinding::PathProvider::RequestEnds ends = map.ends(asked.ticket);
        const auto out = map.exit_towards(ends.from, pathfinding::kOnGround, asked.goal);
        asked.rough = out && out->rough;
        if (out && (out->at.x != ends.to.x || out->at.z != ends.to.z)) {
            release(agent);
            ask_of(agent, asked, {pathfinding::PathRequest::kAlone, ends.from, out->at});
        } else if (!asked.rough) {
            asked_[agent].rough = false;
            std::erase(rough_, agent);
        }
    }
}

void PathService::know_zones(std::size_t size,
                             std::shared_ptr<const pathfinding::ZonePortals> portals,
                             std::uint32_t zone) {
    sizes_[size].map->know_zones(std::move(portals), zone);
}

void PathService::forget_ground() {
    for (Size& size : sizes_) {
        size.map->forget_ground();
    }
}

void PathService::release(Slot agent) {
    if (agent < asked_.size() && asked_[agent].size != kNoSize) {
        sizes_[asked_[agent].size].map->release(asked_[agent].ticket);
        if (asked_[agent].rough) {
            std::erase(rough_, agent);
        }
        asked_[agent] = Asked();
    }
}

void PathService::serve() {
    answered_.clear();
    for (std::size_t s = 0; s < sizes_.size(); ++s) {
        if (std::exchange(sizes_[s].learned, false)) {
            refine_exits(s);
        }
        sizes_[s].map->serve();
        note(sizes_[s].map->answered(), s, answered_);
    }
    std::erase_if(answered_, [this](Slot agent) { return answer(agent).waiting; });
    put_in_order(answered_);
}

pathfinding::PathResult PathService::answer(Slot agent) const {
    const Asked& asked = asked_[agent];
    pathfinding::PathResult answer = sizes_[asked.size].map->answer(asked.ticket);
    if (asked.beyond && answer.outcome == pathfinding::PathOutcome::kFound) {
        answer.outcome = pathfinding::PathOutcome::kPartial;
    }
    return answer;
}

bool PathService::settled() const {
    return std::all_of(
        sizes_.begin(), sizes_.end(), [](const Size& size) { return size.map->settled(); });
}

bool PathService::counts_bodies() const {
    return std::any_of(
        sizes_.begin(), sizes_.end(), [](const Size& size) { return size.map->counts_bodies(); });
}

void PathService::count_bodies(std::span<const float> x, std::span<const float> z) {
    for (Size& size : sizes_) {
        if (size.map->counts_bodies()) {
            size.map->count_bodies(x, z);
        }
    }
}

void PathService::see(Slot agent, pathfinding::Spot at, float at_y) {
    const Asked& asked = asked_[agent];
    sizes_[asked.size].map->see(asked.ticket, at, at_y);
}

pathfinding::Spot PathService::heading(Slot agent, pathfinding::Spot at, float near_m) {
    const Asked& asked = asked_[agent];
    return sizes_[asked.size].map->heading(asked.ticket, at, near_m);
}

bool PathService::straight(TypeIndex type,
                           pathfinding::Spot from,
                           pathfinding::Spot to,
                           PathHeights heights) const {
    ZONED_ASSERT(plans_for(type), "characters with agents ask for paths where paths are planned");
    return sizes_[size_of_type_[type]].map->straight(from, heights.from, to, heights.to);
}

pathfinding::PathCounts PathService::counts() const {
    pathfinding::PathCounts sum;
    for (const Size& size : sizes_) {
        const pathfinding::PathCounts& c = size.map->counts();
        sum.asked += c.asked;
        sum.served += c.served;
        sum.straight += c.straight;
        sum.by_field += c.by_field;
        sum.around_crowds += c.around_crowds;
        sum.by_regions += c.by_regions;
        sum.fields += c.fields;
        sum.broken += c.broken;
        sum.reviewed += c.reviewed;
        sum.waiting += c.waiting;
        sum.longest_wait_ticks = std::max(sum.longest_wait_ticks, c.longest_wait_ticks);
        sum.work += c.work;
    }
    return sum;
}

std::size_t PathService::bytes() const {
    std::size_t bytes =
        asked_.capacity() * sizeof(Asked) +
        (answered_.capacity() + requeued_.capacity() + rough_.capacity()) * sizeof(Slot) +
        shut_.capacity();
    for (const Size& size : sizes_) {
        bytes += size.map->bytes() + size.agent_of_request.capacity() * sizeof(Slot);
    }
    return bytes;
}

}  // namespace zoned::ai
