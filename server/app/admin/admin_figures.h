// Admin figures: fills the answers of the admin interface from the figures of the process.
#pragma once

#include "server/app/admin/admin_api.h"
#include "server/app/world/world.h"
#include "proto/admin.pb.h"

#include <cstdint>
#include <optional>
#include <string>

namespace zoned::app {

/// Everything that an answer may draw on.
struct AdminFigures {
    const config::Settings& settings;
    const LoopStats& loop;
    const NetworkSample& network;
    const admin::AdminStats& stats;
    const admin::AdminRouter& router;
    double uptime_s = 0.0;
    double now_s = 0.0;  ///< steady clock
    bool draining = false;
    std::optional<store::StoreFigures> store;  ///< none: nothing is kept
    /// Changes of the newest reload that wait for a restart.
    const std::vector<config::SettingChange>& waiting;
};

void fill_change(const config::SettingChange& from, proto::admin::SettingChange& out);

void fill_status(const AdminFigures& figures, proto::admin::Status& out);
void fill_zones(const config::Settings& settings,
                const LoopStats& loop,
                proto::admin::ZoneList& out);
void fill_session(const session::SessionFigures& from, proto::admin::SessionFigures& out);
/// Bytes and records about an entity that the clients of all zones were sent.
[[nodiscard]] replication::Replicator::NetworkUse network_use_of(const World& world,
                                                                 EntityId entity);
/// False when no zone owns the entity.
bool fill_entity(const config::Settings& settings,
                 const World& world,
                 EntityId entity,
                 proto::admin::EntityFigures& out);
/// In the text format of Prometheus.
[[nodiscard]] std::string metrics_of(const AdminFigures& figures);

[[nodiscard]] std::string hex_of(std::uint64_t number);

}  // namespace zoned::app
