#include "server/app/admin/admin_figures.h"

#include "server/app/log/log.h"
#include "server/app/runtime/agent_report.h"
#include "server/net/socket_address.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace zoned::app {

namespace {

void fill(const core::Histogram& from, proto::admin::Quantiles& out) {
    out.set_p50(from.percentile(0.5));
    out.set_p99(from.percentile(0.99));
    out.set_max(from.max());
}

void fill_passes(const LoopStats& loop, proto::admin::Status& out) {
    double all_ns = 0.0;
    for (const PassTotals& pass : loop.passes) {
        all_ns += static_cast<double>(pass.ns);
    }
    for (std::size_t p = 0; p < zone::kPasses; ++p) {
        const PassTotals& from = loop.passes[p];
        proto::admin::PassTime& to = *out.add_passes();
        const auto ns = static_cast<double>(from.ns);
        to.set_name(std::string(zone::pass_name(static_cast<zone::Pass>(p))));
        to.set_mean_us(1e-3 * ns / std::max(1.0, static_cast<double>(loop.ticks)));
        to.set_share(all_ns > 0.0 ? ns / all_ns : 0.0);
        to.set_ticks_run(static_cast<double>(from.ran));
        to.set_ticks_skipped(static_cast<double>(from.skipped));
        to.set_skip_reason(from.skip_reason);
    }
}

std::string stance_name(const config::Settings& settings, std::uint8_t stance) {
    static constexpr std::array<const char*, world::kFirstNamedStance> kNames{
        "normal", "idle", "running", "riding"};
    const std::size_t own = stance - kNames.size();
    return stance < kNames.size()          ? kNames[stance]
           : own < settings.stances.size() ? settings.stances[own]
                                           : std::to_string(stance);
}

}  // namespace

std::string hex_of(std::uint64_t number) {
    std::array<char, 20> text{};
    std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(number));
    return text.data();
}

void fill_status(const AdminFigures& f, proto::admin::Status& out) {
    out.set_world(f.settings.world_name);
    out.set_version(ZONED_VERSION);
    out.set_target(ZONED_TARGET_NAME);
    out.set_config_digest(f.settings.digest);
    out.set_uptime_s(f.uptime_s);
    out.set_tick_rate_hz(f.settings.tick_rate_hz);
    out.set_tick(static_cast<double>(f.loop.ticks));
    out.set_tick_age_s(std::max(0.0, f.now_s - f.loop.published_s));
    fill(f.loop.wall_ms, *out.mutable_tick_ms());
    fill(f.loop.late_ms, *out.mutable_tick_late_ms());
    fill(f.loop.turn_ms, *out.mutable_turn_ms());
    fill(f.loop.turn_cpu_ms, *out.mutable_turn_cpu_ms());
    out.set_overruns(static_cast<double>(f.loop.overruns));
    out.set_dropped_ticks(static_cast<double>(f.loop.dropped_ticks));
    out.set_entities(f.loop.entities);
    out.set_awake_bodies(f.loop.awake_bodies);
    out.set_zones(static_cast<std::uint32_t>(f.loop.zones.size()));
    out.set_state_hash(hex_of(f.loop.state_hash));
    out.set_sessions(f.network.host.sessions);
    out.set_sessions_max(f.network.host.sessions_max);
    out.set_connections(static_cast<std::uint32_t>(f.network.connections));
    out.set_rtt_ms_p50(f.network.rtt.p50_ms);
    out.set_rtt_ms_p99(f.network.rtt.p99_ms);
    out.set_bytes_in(static_cast<double>(f.network.host.bytes_in));
    out.set_bytes_out(static_cast<double>(f.network.host.bytes_out));
    out.set_draining(f.draining);
    out.set_log_level(log_level());
    for (std::size_t a = 0; a < config::kLogAreas; ++a) {
        (*out.mutable_log_levels())[std::string(config::kLogAreaNames[a])] =
            log_level_of(static_cast<LogArea>(a));
    }
    const LogCounts lines = Log::counts();
    out.set_log_lines_lost(static_cast<double>(lines.left_out + lines.dropped));
    for (const StoppedZone& zone : f.loop.stopped) {
        proto::admin::StoppedZone& stopped = *out.add_stopped_zones();
        stopped.set_zone(zone.zone.value);
        stopped.set_tick(static_cast<double>(zone.tick));
        stopped.set_place(zone.place);
        stopped.set_text(zone.text);
    }
    for (const config::SettingChange& change : f.waiting) {
        fill_change(change, *out.add_waiting_changes());
    }
    for (const auto& [reason, count] : f.network.host.rejected) {
        (*out.mutable_rejected())[reason] = static_cast<double>(count);
    }
    for (const auto& [reason, count] : f.router.refused()) {
        (*out.mutable_admin_refused())[reason] = static_cast<double>(count);
    }
    fill_passes(f.loop, out);
}

void fill_change(const config::SettingChange& from, proto::admin::SettingChange& out) {
    out.set_path(from.path);
    out.set_before(from.before);
    out.set_after(from.after);
    out.set_live(from.live);
    out.set_note(from.note);
}

void fill_zones(const config::Settings& settings,
                const LoopStats& loop,
                proto::admin::ZoneList& out) {
    for (std::size_t i = 0; i < loop.zones.size(); ++i) {
        const ZoneSample& from = loop.zones[i];
        proto::admin::ZoneFigures& to = *out.add_zones();
        to.set_id(settings.zones[i].id.value);
        to.set_name(settings.zones[i].name);
        to.set_entities(from.entities);
        to.set_ghosts(from.ghosts);
        to.set_awake_bodies(from.awake_bodies);
        to.set_viewers(from.viewers);
        to.set_step_ms(1e-6 * static_cast<double>(from.step_ns));
        to.set_state_hash(hex_of(from.state_hash));
    }
}

void fill_session(const session::SessionFigures& from, proto::admin::SessionFigures& out) {
    out.set_client(from.client.value);
    out.set_account(from.account);
    out.set_name(from.name);
    out.set_team(from.team);
    out.set_address(net::text_of(from.address));
    out.set_zone(from.zone.value);
    out.set_avatar(from.avatar.value);
    out.set_connected(from.connected);
    out.set_udp(from.udp);
    out.set_rtt_ms(from.rtt_ms);
    out.set_bytes_in(static_cast<double>(from.bytes_in));
    out.set_bytes_out(static_cast<double>(from.bytes_out));
    out.set_silent_s(from.silent_s);
    out.set_waiting_events(static_cast<std::uint32_t>(from.waiting_events));
}

replication::Replicator::NetworkUse network_use_of(const World& world, EntityId entity) {
    replication::Replicator::NetworkUse all;
    for (const auto& zone : world.zones()) {
        const auto use = std::as_const(*zone).state().replicator.spent_on(entity);
        all.publications += use.publications;
        all.records += use.records;
        all.bytes += use.bytes;
    }
    return all;
}

bool fill_entity(const config::Settings& settings,
                 const World& world,
                 EntityId entity,
                 proto::admin::EntityFigures& out) {
    for (const auto& zone : world.zones()) {
        if (!zone->owns(entity)) {
            continue;
        }
        const zone::ZoneState& state = std::as_const(*zone).state();
        const world::Entities& entities = state.entities;
        const world::Row row = entities.find(entity);
        const Vec3d at = state.settings.region().origin() + entities.position[row].cast<double>();
        const Quat& q = entities.orientation[row];
        out.set_id(entity.value);
        out.set_type(settings.types[entities.type[row]].name);
        out.set_zone(state.settings.id.value);
        out.set_tick(static_cast<double>(world.now()));
        for (int axis = 0; axis < 3; ++axis) {
            out.add_position_m(at[axis]);
            out.add_velocity_mps(static_cast<double>(entities.velocity[row][axis]));
        }
        for (const float part : {q.w(), q.x(), q.y(), q.z()}) {
            out.add_orientation(static_cast<double>(part));
        }
        out.set_at_rest(entities.has(row, world::kAtRest));
        out.set_hidden(entities.has(row, world::kHidden));
        out.set_client(entities.client[row].value);
        out.set_appearance(entities.appearance[row]);
        out.set_stance(stance_name(settings, entities.stance[row]));
        if (const auto& schema = settings.types[entities.type[row]].fields) {
            for (const wire::DeclaredField& field : schema->fields()) {
                proto::admin::FieldFigures& figures = *out.add_fields();
                figures.set_name(field.name);
                figures.set_value(
                    wire::text_of(field, wire::words_of(field, entities.field_values(row))));
            }
        }
        out.set_agent(agent_report(settings, *zone, entity, world.now()));
        const replication::Replicator::NetworkUse use = network_use_of(world, entity);
        out.set_sent_bytes(static_cast<double>(use.bytes));
        out.set_sent_records(static_cast<double>(use.records));
        out.set_publications(static_cast<double>(use.publications));
        return true;
    }
    return false;
}

}  // namespace zoned::app
