#include "server/zone/zone_state.h"

#include <algorithm>
#include <utility>

namespace zoned::zone {

namespace {

constexpr float kGridCell = 32.0F;

void list_rows(const world::RowSet& a, const world::RowSet& b, std::vector<world::Row>& out) {
    out.clear();
    world::for_each_row(a, b, [&](world::Row row) { out.push_back(row); });
}

void build_grid(ZoneState& state) {
    // So many that doze may have been touched before they are kept anew.
    constexpr std::size_t kTouchedShare = 16;
    world::Entities& e = state.entities;
    const std::size_t stirring = e.stirring().count();
    if (stirring == e.size()) {
        state.grid.build(e.position, kGridCell);
        return;
    }
    list_rows(e.stirring(), e.touched(world::Reader::kGrid), state.grid_rows);
    if (state.grid_rows.size() - stirring > e.size() / kTouchedShare) {
        state.grid_rows.clear();
        for (world::Row row = 0; row < e.size(); ++row) {
            if (!e.stirring().has(row)) {
                state.grid_rows.push_back(row);
            }
        }
        state.grid.keep(e.position, state.grid_rows, kGridCell);
        e.forget_touched(world::Reader::kGrid);
        list_rows(e.stirring(), e.stirring(), state.grid_rows);
    }
    state.grid.follow(e.position, state.grid_rows, kGridCell);
}

/// Predictions of falling entities end where characters stand as well.
replication::ReplicationSettings with_ground(const ZoneSettings& settings) {
    replication::ReplicationSettings out = settings.replication;
    out.ground = settings.statics;
    out.fields = world::field_schemas(*settings.types);
    return out;
}

}  // namespace

void StepOutput::clear() {
    packets.clear();
    messages.clear();
    events.clear();
    bursts.clear();
    clocks.clear();
    doors.clear();
    platforms.clear();
    topics.clear();
    rules_messages.clear();
    handoffs.clear();
    departed.clear();
    store.clear();
    travels.clear();
    lines.clear();
    figures.clear();
    party_orders.clear();
    instance_orders.clear();
    match_orders.clear();
}

ZoneState::ZoneState(ZoneSettings zone_settings, std::unique_ptr<Rules> game_rules)
    : settings(std::move(zone_settings)),
      scene(settings.physics),
      rules(std::move(game_rules)),
      parties(settings.id, out.party_orders),
      instances(settings.id, out.instance_orders),
      matches(settings.id, out.match_orders),
      rng(settings.seed, settings.id.value),
      replicator(with_ground(settings)) {
    entities.declare_fields(world::field_schemas(*settings.types));
    entities.declare_types(*settings.types);
    const Vec3d origin = settings.region().origin();
    points_of_interest = ai::PointsOfInterest(
        settings.ai.points_of_interest, Vec2d(origin.x(), origin.z()), settings.dt);
    ai_update.difficulty() = ai::first_of(settings.ai.difficulty);
    filters_visibility = std::any_of(
        settings.types->begin(), settings.types->end(), [](const world::EntityType& type) {
            return type.visibility_filter != world::VisibilityFilter::kNothing;
        });
    const bool rewinds = std::any_of(settings.types->begin(),
                                     settings.types->end(),
                                     [](const world::EntityType& type) { return type.rewindable; });
    if (rewinds) {
        // The present is one of them, and the tick that is being made replaces one.
        history.resize(settings.rewind.most_ticks + 2);
    }
}

world::Visibility& matched_sets(ZoneState& state) {
    return state.filters_visibility ? state.filtered.heard : state.visibility;
}

const world::Visibility& matched_sets(const ZoneState& state) {
    return state.filters_visibility ? state.filtered.heard : state.visibility;
}

int find_client(const ZoneState& state, ClientId client) {
    const auto it = std::lower_bound(
        state.clients.begin(), state.clients.end(), client, [](const ZoneClient& c, ClientId id) {
            return c.client < id;
        });
    return it != state.clients.end() && it->client == client
               ? static_cast<int>(it - state.clients.begin())
               : -1;
}

const spatial::PointGrid& current_grid(ZoneState& state) {
    if (!state.grid_valid) {
        build_grid(state);
        state.grid_valid = true;
    }
    return state.grid;
}

}  // namespace zoned::zone
