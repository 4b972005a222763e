#include "server/app/admin/spectator_details.h"

#include "server/ai/pathfinding/navmesh/navmesh_paths.h"
#include "server/ai/pathfinding/requests/grid_path_requests.h"
#include "server/ai/pathfinding/waypoints/waypoint_paths.h"
#include "server/app/admin/admin_figures.h"
#include "server/app/runtime/agent_report.h"
#include "shared/core/json.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

namespace zoned::app {

namespace {

using core::JsonWriter;

constexpr std::size_t kMostHeard = 2000;
constexpr std::size_t kMostErrorPairs = 1000;
constexpr std::size_t kMostLines = 20000;
constexpr float kGridStep_m = 1.0F;

struct Place {
    const zone::ZoneState& state;
    world::Row row;

    [[nodiscard]] Vec3d origin() const { return state.settings.region().origin(); }
};

void write_point(JsonWriter& json, const Vec3d& at) {
    json.begin_array();
    for (int axis = 0; axis < 3; ++axis) {
        json.value(1e-3 * std::round(1e3 * at[axis]));
    }
    json.end_array();
}

void write_state(JsonWriter& json, const config::Settings& settings, const Place& at) {
    const world::Entities& entities = at.state.entities;
    const world::EntityType& type = settings.types[entities.type[at.row]];
    json.field("id", entities.id[at.row].value)
        .field("type", type.name)
        .field("zone", settings.zones[at.state.settings.id.value - 1U].name)
        .field("tick", at.state.now)
        .field("client", entities.client[at.row].value)
        .field("at_rest", entities.has(at.row, world::kAtRest))
        .field("off_screen", entities.has(at.row, world::kDozing))
        .field("hidden", entities.has(at.row, world::kHidden))
        .field("grounded", entities.has(at.row, world::kGrounded))
        .field("mass_kg", static_cast<double>(type.mass))
        .field("speed_mps", static_cast<double>(entities.velocity[at.row].norm()));
    json.key("position");
    write_point(json, at.origin() + entities.position[at.row].cast<double>());
    json.key("velocity");
    write_point(json, entities.velocity[at.row].cast<double>());
    const std::uint8_t stance =
        std::min<std::uint8_t>(entities.stance[at.row], world::kStances - 1);
    json.field("stance", stance)
        .field("yaw_rad", static_cast<double>(entities.yaw[at.row]) * std::numbers::pi / 32768.0)
        .field("aura_m", static_cast<double>(type.aura_m[stance]))
        .field("nimbus_m", static_cast<double>(type.nimbus_m[stance]))
        .field("cone_m", static_cast<double>(type.nimbus_cone[stance].length_m))
        .field("cone_half_rad", static_cast<double>(type.nimbus_cone[stance].half_angle_rad));
    if (type.fields == nullptr) {
        return;
    }
    json.key("fields").begin_array();
    for (const wire::DeclaredField& field : type.fields->fields()) {
        if (field.name.starts_with(wire::kControlPointName)) {
            continue;  // the picture shows what these numbers tell
        }
        json.begin_object()
            .field("name", field.name)
            .field("value",
                   wire::text_of(field, wire::words_of(field, entities.field_values(at.row))))
            .end_object();
    }
    json.end_array();
}

void write_path(JsonWriter& json, const Place& at, const ai::Agent& agent) {
    const float height = at.state.entities.position[at.row].y();
    const auto point = [&](float x, float z) {
        write_point(json, at.origin() + Vec3(x, height, z).cast<double>());
    };
    json.key("path").begin_array();
    const ai::Slot slot = at.state.agents.slot_of(agent.entity);
    if (at.state.paths.has(slot, agent.entity)) {
        const auto answer = at.state.paths.answer(slot);
        if (!answer.waiting) {
            for (const ai::pathfinding::Spot& corner : answer.corners) {
                point(corner.x, corner.z);
            }
        }
    } else if (agent.timed && agent.segment.speed > 0.0F && agent.segment.length > 0.0F) {
        const Vec2 end = ai::end_of(agent.segment);
        point(end.x(), end.y());
    }
    json.end_array();
}

void write_agent(JsonWriter& json,
                 const config::Settings& settings,
                 zone::Zone& zone,
                 const Place& at) {
    const EntityId entity = at.state.entities.id[at.row];
    const ai::Agent* agent = at.state.agents.find(entity);
    if (agent == nullptr) {
        return;
    }
    const ai::AiSettings& agents = at.state.settings.ai;
    const ai::Brain& brain = agents.brains[agent->brain];
    json.key("agent").begin_object();
    json.field("text", agent_report(settings, zone, entity, at.state.now))
        .field("brain", brain.name)
        .field("suspended", agent->tier == ai::Tier::kSuspended)
        .field("perception_m", static_cast<double>(brain.perception_m))
        .field("around_m", static_cast<double>(brain.perception.around_m))
        .field("hearing_m", static_cast<double>(brain.perception.hearing_m))
        .field("half_angle_rad",
               brain.perception.given ? static_cast<double>(std::acos(std::clamp(
                                            brain.perception.cos_half_angle, -1.0F, 1.0F)))
                                      : std::numbers::pi)
        .field("prey", agent->prey.value)
        .field("noticed", agent->noticed);
    json.key("home");
    write_point(json, at.origin() + agent->home.cast<double>());
    json.key("target");
    write_point(json, at.origin() + agent->target.cast<double>());
    if (agent->prey) {
        json.key("known");
        write_point(json, at.origin() + agent->known.cast<double>());
    }
    write_path(json, at, *agent);
    json.end_object();
}

/// The entities that an avatar's client hears of, and how wrong it shows what moves.
void write_view(JsonWriter& json, const zone::ZoneState& state, ClientId client) {
    std::vector<replication::Replicator::AssumedState> shown;
    state.replicator.shown_to(client, state.now, shown);
    shown.resize(std::min(shown.size(), kMostHeard));
    const Vec3d origin = state.settings.region().origin();
    json.key("view").begin_array();
    for (const auto& seen : shown) {
        const world::Row row = state.entities.find(seen.entity);
        if (row == world::kNoRow) {
            continue;
        }
        json.begin_object().field("id", seen.entity.value).field("lod", seen.lod);
        if (!state.entities.has(row, world::kAtRest)) {
            const Vec3& truth = state.entities.position[row];
            json.field("error_m", static_cast<double>((seen.position - truth).norm()))
                .field("bound_m", static_cast<double>(seen.bound_m));
            json.key("shown");
            write_point(json, origin + seen.position.cast<double>());
            json.key("truth");
            write_point(json, origin + truth.cast<double>());
        }
        json.end_object();
    }
    json.end_array();
}

/// The bytes that clients of all zones were sent about an entity.
void write_spent(JsonWriter& json, const World& world, EntityId entity) {
    const replication::Replicator::NetworkUse all = network_use_of(world, entity);
    json.key("spent")
        .begin_object()
        .field("publications", all.publications)
        .field("records", all.records)
        .field("bytes", all.bytes)
        .end_object();
}

void write_recipients(JsonWriter& json, const World& world, EntityId entity) {
    json.key("heard_by").begin_array();
    for (const auto& zone : world.zones()) {
        for (const world::VisibleSet& set : std::as_const(*zone).state().visibility) {
            const auto it = std::lower_bound(
                set.visible.begin(), set.visible.end(), entity, [](const auto& v, EntityId id) {
                    return v.entity < id;
                });
            if (it != set.visible.end() && it->entity == entity) {
                json.begin_object()
                    .field("client", set.client.value)
                    .field("lod", it->lod)
                    .end_object();
            }
        }
    }
    json.end_array();
}

class LineBuffer {
  public:
    LineBuffer(const Vec3d& origin, const Vec2& middle, float reach_m)
        : origin_(origin),
          middle_(middle),
          reach_m_(reach_m) {}

    /// Zone-local, m; left out where it begins too far away.
    void add(const Vec3& a, const Vec3& b) {
        if (count_ < kMostLines && near(a)) {
            put(a);
            put(b);
            ++count_;
        }
    }

    [[nodiscard]] bool near(const Vec3& at) const {
        return (Vec2(at.x(), at.z()) - middle_).squaredNorm() <= reach_m_ * reach_m_;
    }

    [[nodiscard]] std::string take() { return std::move(bytes_); }

  private:
    void put(const Vec3& at) {
        for (int axis = 0; axis < 3; ++axis) {
            const auto value = static_cast<float>(origin_[axis] + static_cast<double>(at[axis]));
            bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value));
        }
    }

    Vec3d origin_;
    Vec2 middle_;
    float reach_m_;
    std::size_t count_ = 0;
    std::string bytes_;
};

void add_mesh(const ai::pathfinding::Navmesh& mesh, LineBuffer& out) {
    const auto corner = [&](const auto& polygon, int i) {
        return mesh.vertices()[polygon.corners[static_cast<std::size_t>(i % polygon.size)]];
    };
    for (const auto& polygon : mesh.polygons()) {
        for (int i = 0; i < polygon.size; ++i) {
            out.add(corner(polygon, i), corner(polygon, i + 1));
        }
    }
}

void add_grid(const ai::pathfinding::PathProvider& map,
              const Vec2& middle,
              float reach_m,
              LineBuffer& out) {
    const float arm = 0.3F * kGridStep_m;
    for (float x = middle.x() - reach_m; x <= middle.x() + reach_m; x += kGridStep_m) {
        for (float z = middle.y() - reach_m; z <= middle.y() + reach_m; z += kGridStep_m) {
            const ai::pathfinding::Spot spot{x, z};
            if (map.contains(spot) && !map.straight(spot, 0.0F, spot, 0.0F)) {
                out.add(Vec3(x - arm, 0.1F, z - arm), Vec3(x + arm, 0.1F, z + arm));
                out.add(Vec3(x - arm, 0.1F, z + arm), Vec3(x + arm, 0.1F, z - arm));
            }
        }
    }
}

/// The place that the path of an agent ends at; nothing where it has none.
std::optional<ai::pathfinding::Spot> goal_of(const zone::ZoneState& state, EntityId entity) {
    const ai::Slot slot = state.agents.slot_of(entity);
    if (!state.paths.has(slot, entity)) {
        return std::nullopt;
    }
    const auto answer = state.paths.answer(slot);
    if (answer.waiting || answer.corners.empty()) {
        return std::nullopt;
    }
    return answer.corners.back();
}

void add_flow(const ai::pathfinding::GroundGrid& grid,
              const std::function<ai::pathfinding::Hop(ai::pathfinding::Cell)>& flow,
              const Vec2& middle,
              float reach_m,
              LineBuffer& out) {
    using namespace ai::pathfinding;
    const Cell low = grid.cell({middle.x() - reach_m, middle.y() - reach_m});
    const Cell high = grid.cell({middle.x() + reach_m, middle.y() + reach_m});
    const float arm = 0.35F * grid.cell_m();
    for (std::uint16_t y = low.y; y <= high.y; ++y) {
        for (std::uint16_t x = low.x; x <= high.x; ++x) {
            const Hop hop = flow({x, y});
            if (hop >= kArrived) {
                continue;
            }
            const Spot at = grid.centre({x, y});
            const Vec2 step =
                arm *
                Vec2(static_cast<float>(kHopX[hop]), static_cast<float>(kHopY[hop])).normalized();
            out.add(Vec3(at.x - step.x(), 0.0F, at.z - step.y()),
                    Vec3(at.x + step.x(), 0.0F, at.z + step.y()));
        }
    }
}

}  // namespace

std::string flow_lines(const World& world, EntityId entity, float reach_m) {
    for (const auto& zone : world.zones()) {
        if (!zone->owns(entity)) {
            continue;
        }
        const zone::ZoneState& state = std::as_const(*zone).state();
        const auto goal = goal_of(state, entity);
        const Vec3& at = state.entities.position[state.entities.find(entity)];
        const Vec2 middle(at.x(), at.z());
        LineBuffer out(state.settings.region().origin(), middle, reach_m);
        for (std::size_t size = 0; goal && size < state.paths.sizes(); ++size) {
            const auto* map =
                dynamic_cast<const ai::pathfinding::GridPathRequests*>(&state.paths.map(size));
            const auto flow = map != nullptr && map->contains(*goal)
                                  ? map->flow_to(map->grid().cell(*goal))
                                  : nullptr;
            if (flow) {
                add_flow(map->grid(), flow, middle, reach_m, out);
                break;
            }
        }
        return out.take();
    }
    return {};
}

std::string details_json(const config::Settings& settings, const World& world, EntityId entity) {
    for (const auto& zone : world.zones()) {
        if (!zone->owns(entity)) {
            continue;
        }
        const zone::ZoneState& state = std::as_const(*zone).state();
        const Place at{state, state.entities.find(entity)};
        JsonWriter json;
        json.begin_object();
        write_state(json, settings, at);
        write_agent(json, settings, *zone, at);
        const ClientId client = state.entities.client[at.row];
        if (client) {
            write_view(json, state, client);
        }
        write_spent(json, world, entity);
        write_recipients(json, world, entity);
        json.end_object();
        return json.text();
    }
    return {};
}

std::string walkable_lines(const World& world, ZoneId zone, float x, float z, float reach_m) {
    if (zone.value == 0 || zone.value > world.zones().size()) {
        return {};
    }
    const zone::ZoneState& state = std::as_const(*world.zones()[zone.value - 1U]).state();
    const Vec3d origin = state.settings.region().origin();
    const Vec2 middle(static_cast<float>(static_cast<double>(x) - origin.x()),
                      static_cast<float>(static_cast<double>(z) - origin.z()));
    LineBuffer out(origin, middle, reach_m);
    for (std::size_t size = 0; size < state.paths.sizes(); ++size) {
        const ai::pathfinding::PathProvider& map = state.paths.map(size);
        if (const auto* mesh = dynamic_cast<const ai::pathfinding::NavmeshPaths*>(&map)) {
            add_mesh(mesh->mesh(), out);
        } else if (dynamic_cast<const ai::pathfinding::WaypointPaths*>(&map) == nullptr) {
            add_grid(map, middle, reach_m, out);
        }
    }
    return out.take();
}

ErrorShares sample_errors(const World& world) {
    std::vector<double> shares;
    std::vector<replication::Replicator::AssumedState> shown;
    for (const auto& zone : world.zones()) {
        const zone::ZoneState& state = std::as_const(*zone).state();
        const std::size_t sets = state.visibility.size();
        const std::size_t most = shares.size() + kMostErrorPairs / world.zones().size();
        for (std::size_t i = 0; i < sets && shares.size() < most; ++i) {
            const auto& set = state.visibility[(static_cast<std::size_t>(state.now) + i) % sets];
            state.replicator.shown_to(set.client, state.now, shown);
            for (const auto& seen : shown) {
                const world::Row row = state.entities.find(seen.entity);
                if (row == world::kNoRow || state.entities.has(row, world::kAtRest)) {
                    continue;
                }
                const float error = (seen.position - state.entities.position[row]).norm();
                shares.push_back(static_cast<double>(error / seen.bound_m));
            }
        }
    }
    std::sort(shares.begin(), shares.end());
    const auto at = [&](double share) {
        return shares.empty() ? 0.0
                              : shares[static_cast<std::size_t>(
                                    share * static_cast<double>(shares.size() - 1))];
    };
    return {shares.size(), at(0.5), at(0.99), at(1.0)};
}

}  // namespace zoned::app
