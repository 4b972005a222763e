#include "server/config/expand/expand_server.h"

#include "server/config/text/config_numbers.h"
#include "proto/config/config.pb.h"

namespace zoned::config {

namespace {

ListenSettings expand_network(const proto::config::Network& from) {
    ListenSettings out;
    out.bind_address = from.bind_address();
    out.tcp_port = static_cast<std::uint16_t>(from.tcp_port());
    out.udp_port = static_cast<std::uint16_t>(from.udp_port());
    out.max_clients = from.max_clients();
    out.max_load = from.max_load();
    out.max_sessions_per_address = from.max_sessions_per_address();
    out.socket_buffer_bytes = from.socket_buffer_bytes();
    out.max_frame_bytes = from.max_frame_bytes();
    out.silence_timeout_s = from.silence_timeout_s();
    out.admin = from.admin();
    out.admin_address = from.admin_address();
    out.admin_port = static_cast<std::uint16_t>(from.admin_port());
    out.admin_certificate_file = from.admin_certificate_file();
    out.admin_key_file = from.admin_key_file();
    if (from.has_websocket_port()) {
        out.websocket_port = static_cast<std::uint16_t>(from.websocket_port());
    }
    out.websocket_address = from.websocket_address();
    out.websocket_origins.assign(from.websocket_origin().begin(), from.websocket_origin().end());
    out.advertise = {from.advertise().address(),
                     static_cast<std::uint16_t>(from.advertise().tcp_port()),
                     static_cast<std::uint16_t>(from.advertise().udp_port())};
    return out;
}

AgonesSettings expand_agones(const proto::config::Agones& from) {
    return {from.enabled(),
            from.health_every_s(),
            from.patience_s(),
            from.tcp_port_name(),
            from.udp_port_name()};
}

SessionSettings expand_session(const proto::config::Session& from,
                               const proto::config::Replication& replication) {
    SessionSettings out;
    out.grace_s = from.grace_s();
    out.login_timeout_s = from.login_timeout_s();
    out.tls_certificate_file = from.tls_certificate_file();
    out.tls_key_file = from.tls_key_file();
    out.state_folder = from.state_folder();
    out.dev_mode_loopback = from.dev_mode_loopback();
    if (from.dev_rights_size() > 0) {
        out.dev_rights = 0;
        for (const int right : from.dev_rights()) {
            *out.dev_rights |= static_cast<std::uint32_t>(right);
        }
    }
    out.ticket_public_key_files.assign(from.ticket_public_key_file().begin(),
                                       from.ticket_public_key_file().end());
    out.max_per_account = from.max_per_account();
    out.max_commands_per_s = from.max_commands_per_s();
    out.max_datagrams_per_s = from.max_datagrams_per_s();
    out.max_unacked_events = from.max_unacked_events();
    out.input_window_ticks = from.input_window_ticks();
    out.bandwidth = {replication.budget_bytes_per_s(),
                     replication.least_bytes_per_s(),
                     replication.congestion_control()};
    return out;
}

StoreSettings expand_store(const proto::config::Store& from, const std::string& state_folder) {
    return {static_cast<StoreKind>(from.kind()),
            from.has_file() ? from.file() : state_folder + "/store.db",
            static_cast<StoreDurability>(from.durability()),
            from.max_waiting_mb(),
            from.url()};
}

RecoverySettings expand_recovery(const proto::config::Recovery& from) {
    return {from.on(),
            from.snapshot_every_s(),
            static_cast<StoreDurability>(from.durability()),
            from.over_restarts()};
}

RunSettings expand_run(const proto::config::Run& from) {
    return {from.threads(),
            from.max_catch_up_ticks(),
            from.mailbox_capacity(),
            static_cast<LogLevel>(from.log_level()),
            static_cast<RulesException>(from.on_exception())};
}

LogSettings expand_log(const proto::config::Log& from, LogLevel level) {
    LogSettings out;
    out.json = from.format() == proto::config::LOG_JSON;
    out.levels.fill(level);
    for (const proto::config::LogAreaLevel& area : from.level()) {
        const std::size_t number = find_log_area(area.area());
        if (number < kLogAreas) {  // check_server reports the others
            out.levels[number] = static_cast<LogLevel>(area.level());
        }
    }
    out.lines_per_s = from.lines_per_s();
    return out;
}

/// Of a message with `probability` and `from_tick`.
template <class Fault>
zone::ShareFault share_of(const Fault& fault) {
    return {fault.probability(), static_cast<Tick>(fault.from_tick())};
}

zone::FaultSettings expand_faults(const proto::config::Testing& testing) {
    zone::FaultSettings out;
    if (testing.has_corrupt_field()) {
        out.corrupt_field = share_of(testing.corrupt_field());
    }
    if (testing.has_corrupt_position()) {
        out.corrupt = share_of(testing.corrupt_position());
        out.corrupt_offset_m = narrow(testing.corrupt_position().offset_m());
    }
    if (testing.has_hide_entity()) {
        out.hide = share_of(testing.hide_entity());
    }
    if (testing.has_leak_entity()) {
        out.leak = share_of(testing.leak_entity());
    }
    if (testing.has_leak_filtered()) {
        out.leak_filtered = share_of(testing.leak_filtered());
    }
    if (testing.has_drop_decision()) {
        out.drop_decision = share_of(testing.drop_decision());
    }
    out.silent_bound = testing.silent_bound();
    return out;
}

TestingSettings expand_testing(const proto::config::Testing& testing) {
    TestingSettings out;
    out.faults = expand_faults(testing);
    if (testing.has_stall_zone()) {
        const auto& stall = testing.stall_zone();
        out.stall = StallSettings{
            stall.zone(), static_cast<Tick>(stall.at_tick()), static_cast<Tick>(stall.ticks())};
    }
    if (testing.has_break_zone()) {
        const auto& broken = testing.break_zone();
        out.broken = BreakSettings{broken.zone(),
                                   static_cast<Tick>(broken.at_tick()),
                                   static_cast<zone::BreakKind>(broken.kind())};
    }
    if (testing.has_leak_topic()) {
        out.leak_topic = share_of(testing.leak_topic());
    }
    if (testing.has_drop_event()) {
        out.drop_event_probability = testing.drop_event().probability();
    }
    if (testing.has_double_event()) {
        out.double_event_probability = testing.double_event().probability();
    }
    if (testing.has_wrong_limit()) {
        const auto& wrong = testing.wrong_limit();
        out.wrong_limit = WrongLimitSettings{wrong.type(),
                                             narrow(wrong.max_acceleration_mps2()),
                                             narrow(wrong.max_velocity_jump_mps())};
    }
    out.wrong_clock = testing.wrong_clock();
    const auto& travel = testing.travel();
    out.travel = {static_cast<TravelStep>(travel.die_at()),
                  travel.die_after(),
                  travel.journal(),
                  travel.keep_avatar(),
                  travel.lose_records()};
    return out;
}

}  // namespace

ServerSettings expand_server(const proto::config::Config& config) {
    ServerSettings out;
    out.network = expand_network(config.network());
    out.session = expand_session(config.session(), config.replication());
    out.run = expand_run(config.run());
    out.log = expand_log(config.log(), out.run.log_level);
    out.agones = expand_agones(config.network().agones());
    out.compute = {config.compute().device(), config.compute().cache_folder()};
    for (const proto::config::Topic& topic : config.topic()) {
        out.topics.push_back({topic.name(), topic.history_events(), topic.history_bytes()});
    }
    out.recording_file = config.recording().file();
    out.ring_s = config.recording().ring_s();
    out.store = expand_store(config.store(), out.session.state_folder);
    out.recovery = expand_recovery(config.recovery());
    out.cluster = {config.cluster().name(),
                   config.cluster().realm(),
                   config.cluster().lease_s(),
                   config.cluster().replicas()};
    for (const proto::config::Arrival& arrival : config.arrival()) {
        out.arrivals.push_back({arrival.name(), {arrival.x_m(), arrival.y_m(), arrival.z_m()}});
    }
    for (const proto::config::Portal& portal : config.portal()) {
        out.portals.push_back({portal.name(),
                               {portal.min_x_m(), portal.min_y_m(), portal.min_z_m()},
                               {portal.max_x_m(), portal.max_y_m(), portal.max_z_m()},
                               portal.to_world(),
                               portal.arrival(),
                               portal.wait_s()});
    }
    out.testing = expand_testing(config.testing());
    out.started_max_clients = out.network.max_clients;
    return out;
}

}  // namespace zoned::config
