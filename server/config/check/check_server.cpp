#include "server/config/check/config_checks.h"
#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "server/config/text/store_url.h"
#include "server/config/types/stances.h"
#include "proto/config/config.pb.h"

#include <arpa/inet.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>
#include <tuple>
#include <utility>

namespace zoned::config {

namespace {

/// An entity received across a border must be a ghost there. A viewer may stand
/// handoff_hysteresis_m behind the border, and keeps entities up to (1 + hysteresis) x the radius.
void check_margin(const proto::config::Config& config, Diagnostics& diagnostics) {
    // A nanometre of tolerance: 1.1 x 50 m is a little more than 55 m in binary.
    const double margin = config.zones().ghost_margin_m() + 1e-9;
    const double grow = 1.0 + config.interest().hysteresis();
    const double behind = config.zones().handoff_hysteresis_m();
    double nimbus = 0.0;
    for (int t = 0; t < config.type_size(); ++t) {
        nimbus = std::max(nimbus, largest_radius(config.type(t).nimbus_m()));
    }
    const auto report = [&](const std::string& path, const char* what, double radius) {
        char text[300];
        std::snprintf(text,
                      sizeof(text),
                      "%s of %g m, with hysteresis %g and handoff_hysteresis_m %g, reaches %g m "
                      "and is larger than zones.ghost_margin_m, %g",
                      what,
                      radius,
                      config.interest().hysteresis(),
                      behind,
                      radius * grow + behind,
                      margin);
        diagnostics.add(path, text);
    };
    const bool nimbus_reaches = nimbus * grow + behind > margin;
    for (int t = 0; t < config.type_size(); ++t) {
        const auto& type = config.type(t);
        const std::string path = join_path("", "type", t);
        if (largest_radius(type.nimbus_m()) > 0.0 &&
            largest_radius(type.nimbus_m()) * grow + behind > margin) {
            report(path + ".nimbus_m", "nimbus", largest_radius(type.nimbus_m()));
        }
        // An aura matters only where some nimbus reaches beyond the margin as well.
        if (nimbus_reaches && largest_radius(type.aura_m()) * grow + behind > margin) {
            report(path + ".aura_m", "aura", largest_radius(type.aura_m()));
        }
    }
}

/// A client goes on showing for a while, farther away, by the bound that it was promised nearby.
void check_bounds_widen(const proto::config::Config& config, int l, Diagnostics& diagnostics) {
    if (l == 0) {
        return;
    }
    const auto& nearer = config.lod(l - 1);
    const auto& farther = config.lod(l);
    const auto check = [&](const char* field, double here, double before) {
        if (here < before) {
            diagnostics.add(join_path("", "lod", l) + "." + field,
                            text_of("%g is less than the bound nearer by, %g: a bound may only "
                                    "widen with the distance",
                                    here,
                                    before));
        }
    };
    check("position_bound_m", farther.position_bound_m(), nearer.position_bound_m());
    check("orientation_bound_rad", farther.orientation_bound_rad(), nearer.orientation_bound_rad());
}

void check_lods(const proto::config::Config& config, Diagnostics& diagnostics) {
    const double quantum =
        0.5 * std::sqrt(3.0) * config.replication().quantization().position_step_m();
    double before = 0.0;
    for (int l = 0; l < config.lod_size(); ++l) {
        const auto& lod = config.lod(l);
        const std::string path = join_path("", "lod", l);
        const bool last = l + 1 == config.lod_size();
        if (last && lod.has_radius_m()) {
            diagnostics.add(path + ".radius_m",
                            "the last level of detail holds beyond all radii: leave it out");
        } else if (!last && !lod.has_radius_m()) {
            diagnostics.add(path, "radius_m is missing: only the last level of detail has none");
        } else if (!last && lod.radius_m() <= before) {
            diagnostics.add(
                path + ".radius_m",
                text_of("radii must ascend: %g is not more than %g", lod.radius_m(), before));
        }
        before = std::max(before, lod.radius_m());
        check_bounds_widen(config, l, diagnostics);
        if (quantum > lod.position_bound_m()) {
            diagnostics.add(path + ".position_bound_m",
                            text_of("%g m is finer than the quantisation itself, %.4g m; make "
                                    "quantization.position_step_m smaller",
                                    lod.position_bound_m(),
                                    quantum));
        }
    }
}

void check_extent(const proto::config::Config& config,
                  const std::vector<ZoneRegion>& zones,
                  Diagnostics& diagnostics) {
    const auto& q = config.replication().quantization();
    const std::string path = "replication.quantization";
    double half = 0.0;
    for (const ZoneRegion& zone : zones) {
        half = std::max({half, 0.5 * (zone.max_x - zone.min_x), 0.5 * (zone.max_z - zone.min_z)});
    }
    const double margin = config.zones().ghost_margin_m();
    if (half + margin > q.horizontal_extent_m()) {
        diagnostics.add(path + ".horizontal_extent_m",
                        text_of("%g is less than half of the largest zone, %g, and the ghost "
                                "margin, %g, together",
                                q.horizontal_extent_m(),
                                half,
                                margin));
    }
    if (std::abs(config.world().ground_height_m()) + 100.0 > q.vertical_extent_m()) {
        diagnostics.add(path + ".vertical_extent_m",
                        text_of("%g leaves less than 100 m around the ground at %g",
                                q.vertical_extent_m(),
                                config.world().ground_height_m()));
    }
}

void check_file(const std::string& file,
                const std::string& path,
                const std::string& advice,
                Diagnostics& diagnostics) {
    const std::ifstream in(file);
    if (!in.good()) {
        diagnostics.add(path, "cannot read '" + file + "'; " + advice);
    }
}

bool is_address(const std::string& address) {
    unsigned char bytes[sizeof(in6_addr)];
    return inet_pton(AF_INET, address.c_str(), bytes) == 1 ||
           inet_pton(AF_INET6, address.c_str(), bytes) == 1;
}

void check_address(const std::string& address, const std::string& path, Diagnostics& diagnostics) {
    if (!is_address(address)) {
        diagnostics.add(path, "'" + address + "' is no IPv4 or IPv6 address");
    }
}

/// True for the addresses that clients on this computer reach as loopback: loopback itself and all.
bool serves_loopback(const std::string& address) {
    in6_addr six{};
    if (inet_pton(AF_INET6, address.c_str(), &six) == 1) {
        return IN6_IS_ADDR_UNSPECIFIED(&six) || IN6_IS_ADDR_LOOPBACK(&six);
    }
    in_addr four{};
    return inet_pton(AF_INET, address.c_str(), &four) == 1 &&
           (four.s_addr == htonl(INADDR_ANY) || ntohl(four.s_addr) >> 24U == 127U);
}

/// At least one kind of client must be able to log in: by a ticket, or in development mode by
/// loopback with the right to play.
void check_entrance(const proto::config::Config& config, Diagnostics& diagnostics) {
    const auto& session = config.session();
    if (session.ticket_public_key_file_size() > 0) {
        return;
    }
    if (!session.dev_mode_loopback()) {
        diagnostics.add("session",
                        "nobody can log in: name a ticket_public_key_file (`zoned keygen` makes a "
                        "pair of keys), or set dev_mode_loopback for development");
        return;
    }
    const bool plays =
        session.dev_rights_size() == 0 ||
        std::find(session.dev_rights().begin(), session.dev_rights().end(), proto::config::PLAY) !=
            session.dev_rights().end();
    if (!plays) {
        diagnostics.add("session.dev_rights[0]",
                        "nobody can log in: without PLAY the development mode lets nobody play, "
                        "and there is no ticket_public_key_file");
    }
    const std::string& address = config.network().bind_address();
    if (is_address(address) && !serves_loopback(address)) {
        diagnostics.add("network.bind_address",
                        "nobody can log in: the development mode lets in loopback addresses only, "
                        "which do not reach " +
                            address + ", and there is no ticket_public_key_file");
    }
}

/// Certificate and key go together, and can be read.
void check_pair(bool has_certificate,
                const std::string& certificate,
                const std::string& certificate_path,
                bool has_key,
                const std::string& key,
                const std::string& key_path,
                const std::string& advice,
                Diagnostics& diagnostics) {
    if (has_certificate != has_key) {
        diagnostics.add(has_key ? key_path : certificate_path,
                        "needs " + (has_key ? certificate_path : key_path) + " as well");
    }
    if (has_certificate) {
        check_file(certificate, certificate_path, advice, diagnostics);
    }
    if (has_key) {
        check_file(key, key_path, advice, diagnostics);
    }
}

void check_log(const proto::config::Log& log, Diagnostics& diagnostics) {
    std::set<std::string> named;
    for (int a = 0; a < log.level_size(); ++a) {
        const std::string& area = log.level(a).area();
        const std::string path = join_path("log", "level", a) + ".area";
        if (find_log_area(area) == kLogAreas) {
            diagnostics.add(path,
                            "'" + area + "' is no area of the log; there are " + log_area_list());
        } else if (!named.insert(area).second) {
            diagnostics.add(path, "'" + area + "' is given twice");
        }
    }
}

void check_session(const proto::config::Session& session, Diagnostics& diagnostics) {
    check_pair(session.has_tls_certificate_file(),
               session.tls_certificate_file(),
               "session.tls_certificate_file",
               session.has_tls_key_file(),
               session.tls_key_file(),
               "session.tls_key_file",
               "leave both files out to have a certificate made for development",
               diagnostics);
    for (int k = 0; k < session.ticket_public_key_file_size(); ++k) {
        check_file(session.ticket_public_key_file(k),
                   join_path("session", "ticket_public_key_file", k),
                   "`zoned keygen` makes a pair of keys",
                   diagnostics);
    }
}

void check_store(const proto::config::Store& store, Diagnostics& diagnostics) {
    const auto refuse = [&](bool given, const char* path, const std::string& kind) {
        if (given) {
            diagnostics.add(path, "has no meaning while store.kind is " + kind);
        }
    };
    const std::string kind = proto::config::StoreKind_Name(store.kind());
    if (store.kind() != proto::config::STORE_SQLITE) {
        refuse(store.has_file(), "store.file", kind);
        refuse(store.has_durability(), "store.durability", kind);
    }
    if (store.kind() == proto::config::STORE_NONE) {
        refuse(store.has_max_waiting_mb(), "store.max_waiting_mb", kind);
    }
    if (store.kind() != proto::config::STORE_POSTGRESQL) {
        refuse(store.has_url(), "store.url", kind);
        return;
    }
    if (!store.has_url()) {
        diagnostics.add("store.url", "is missing: it names the database; " + store_url_advice());
    } else if (const std::string why = wrong_with_store_url(store.url()); !why.empty()) {
        diagnostics.add("store.url", why);
    }
}

void check_recovery(const proto::config::Recovery& recovery, Diagnostics& diagnostics) {
    if (recovery.on()) {
        return;
    }
    for (const auto& [given, path] :
         {std::pair(recovery.has_snapshot_every_s(), "recovery.snapshot_every_s"),
          std::pair(recovery.has_durability(), "recovery.durability"),
          std::pair(recovery.has_over_restarts(), "recovery.over_restarts")}) {
        if (given) {
            diagnostics.add(path, "has no meaning while recovery.on is false");
        }
    }
}

/// Names of a cluster are parts of NATS subjects and keys.
void check_cluster_name(const std::string& name, const std::string& path, Diagnostics& out) {
    const bool good = std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '-' || c == '_';
    });
    if (!good) {
        out.add(path, "'" + name + "' must consist of letters, digits, - and _");
    }
}

void check_portal(const proto::config::Portal& portal,
                  const std::string& name,
                  const std::string& path,
                  Diagnostics& out) {
    for (const auto& [given, field] : {std::pair(portal.has_min_x_m(), "min_x_m"),
                                       std::pair(portal.has_min_z_m(), "min_z_m"),
                                       std::pair(portal.has_max_x_m(), "max_x_m"),
                                       std::pair(portal.has_max_z_m(), "max_z_m")}) {
        if (!given) {
            out.add(path, std::string(field) + " is missing");
        }
    }
    for (const auto& [lower, upper, axis] : {std::tuple(portal.min_x_m(), portal.max_x_m(), "x"),
                                             std::tuple(portal.min_y_m(), portal.max_y_m(), "y"),
                                             std::tuple(portal.min_z_m(), portal.max_z_m(), "z")}) {
        if (lower >= upper) {
            out.add(path, std::string("min_") + axis + "_m must be less than max_" + axis + "_m");
        }
    }
    if (portal.to_world().empty()) {
        out.add(path, "to_world is missing: the cluster.name of the world that it leads to");
    } else if (portal.to_world() == name) {
        out.add(path + ".to_world", "is this world itself");
    } else {
        check_cluster_name(portal.to_world(), path + ".to_world", out);
    }
}

void check_cluster(const proto::config::Config& config,
                   const std::vector<ZoneRegion>& zones,
                   Diagnostics& out) {
    const auto& cluster = config.cluster();
    if (cluster.name().empty()) {
        if (config.has_cluster()) {
            out.add("cluster", "name is missing: it names this world in its realm");
        }
        if (config.portal_size() > 0) {
            out.add("portal[0]", "has no meaning without cluster.name");
        }
        return;
    }
    check_cluster_name(cluster.name(), "cluster.name", out);
    check_cluster_name(cluster.realm(), "cluster.realm", out);
    if (config.portal_size() > 0 && config.session().ticket_public_key_file_size() == 0) {
        out.add("portal[0]",
                "leads nowhere: only clients with a ticket can travel, and "
                "session.ticket_public_key_file is not set");
    }
    std::set<std::string> names;
    for (int k = 0; k < config.arrival_size(); ++k) {
        const std::string path = join_path("", "arrival", k);
        const auto& arrival = config.arrival(k);
        if (check_name(arrival.name(), "arrival", path, out) &&
            !names.insert(arrival.name()).second) {
            out.add(path + ".name", "'" + arrival.name() + "' is given twice");
        }
        const bool inside = std::any_of(zones.begin(), zones.end(), [&](const ZoneRegion& zone) {
            return arrival.x_m() >= zone.min_x && arrival.x_m() < zone.max_x &&
                   arrival.z_m() >= zone.min_z && arrival.z_m() < zone.max_z;
        });
        if (!inside) {
            out.add(path, "lies in no zone");
        }
    }
    names.clear();
    for (int k = 0; k < config.portal_size(); ++k) {
        const std::string path = join_path("", "portal", k);
        const auto& portal = config.portal(k);
        if (check_name(portal.name(), "portal", path, out) && !names.insert(portal.name()).second) {
            out.add(path + ".name", "'" + portal.name() + "' is given twice");
        }
        check_portal(portal, cluster.name(), path, out);
        for (const proto::config::Arrival& arrival : config.arrival()) {
            const bool inside =
                arrival.x_m() >= portal.min_x_m() && arrival.x_m() <= portal.max_x_m() &&
                arrival.z_m() >= portal.min_z_m() && arrival.z_m() <= portal.max_z_m();
            if (inside && portal.wait_s() <= 0.0) {
                out.add(path,
                        "who comes to the arrival '" + arrival.name() +
                            "' would leave at once: move either, or set wait_s");
            }
        }
    }
}

void check_testing(const proto::config::Config& config,
                   const std::vector<ZoneRegion>& zones,
                   Diagnostics& diagnostics) {
    const auto& testing = config.testing();
    const auto check_zone = [&](const std::string& path, const std::string& name) {
        const bool known = std::any_of(
            zones.begin(), zones.end(), [&](const ZoneRegion& zone) { return zone.name == name; });
        if (!known) {
            diagnostics.add(path, "there is no zone named '" + name + "'");
        }
    };
    if (testing.stall_zone().has_zone()) {
        check_zone("testing.stall_zone.zone", testing.stall_zone().zone());
    }
    if (testing.break_zone().has_zone()) {
        check_zone("testing.break_zone.zone", testing.break_zone().zone());
    }
    if (testing.wrong_limit().has_type()) {
        const bool known = std::any_of(
            config.type().begin(), config.type().end(), [&](const proto::config::Type& type) {
                return type.name() == testing.wrong_limit().type();
            });
        if (!known) {
            diagnostics.add("testing.wrong_limit.type",
                            "there is no type named '" + testing.wrong_limit().type() + "'");
        }
    }
}

/// An origin is what a browser's Origin header says: a scheme, a host and perhaps a port, no path.
bool is_origin(const std::string& text) {
    const std::size_t scheme = text.starts_with("https://")  ? 8
                               : text.starts_with("http://") ? 7
                                                             : 0;
    return scheme > 0 && text.size() > scheme &&
           std::all_of(text.begin() + static_cast<std::ptrdiff_t>(scheme), text.end(), [](char c) {
               return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '.' || c == '-' ||
                      c == ':' || c == '[' || c == ']';
           });
}

void check_websocket(const proto::config::Network& network, Diagnostics& diagnostics) {
    check_address(network.websocket_address(), "network.websocket_address", diagnostics);
    if (!network.has_websocket_port() &&
        (network.has_websocket_address() || network.websocket_origin_size() > 0)) {
        diagnostics.add(network.has_websocket_address() ? "network.websocket_address"
                                                        : "network.websocket_origin[0]",
                        "needs network.websocket_port: without it there are no WebSockets");
    }
    if (network.websocket_port() != 0 && (network.websocket_port() == network.tcp_port() ||
                                          network.websocket_port() == network.admin_port())) {
        diagnostics.add("network.websocket_port", "is the same as tcp_port or admin_port");
    }
    for (int i = 0; i < network.websocket_origin_size(); ++i) {
        if (!is_origin(network.websocket_origin(i))) {
            diagnostics.add(join_path("network", "websocket_origin", i),
                            "'" + network.websocket_origin(i) +
                                "' is no origin: it wants http:// or https:// and a host in small "
                                "letters, perhaps a port, and no path (https://play.example)");
        }
    }
}

}  // namespace

void check_replication(const proto::config::Config& config,
                       const std::vector<ZoneRegion>& zones,
                       Diagnostics& diagnostics) {
    if (zones.size() > 1) {
        check_margin(config, diagnostics);
    }
    check_lods(config, diagnostics);
    check_extent(config, zones, diagnostics);
    if (!config.replication().has_silence_ticks()) {
        return;
    }
    const double silence = config.replication().silence_ticks() / config.world().tick_rate_hz();
    if (silence > 0.5) {
        diagnostics.add(
            "replication.silence_ticks",
            text_of(
                "%g ticks are %.3g s at world.tick_rate_hz %g; clients need a sign of life every "
                "0.5 s",
                config.replication().silence_ticks(),
                silence,
                config.world().tick_rate_hz()));
    }
}

void check_server(const proto::config::Config& config,
                  const std::vector<ZoneRegion>& zones,
                  Diagnostics& diagnostics) {
    const auto& network = config.network();
    check_address(network.bind_address(), "network.bind_address", diagnostics);
    check_address(network.admin_address(), "network.admin_address", diagnostics);
    check_pair(network.has_admin_certificate_file(),
               network.admin_certificate_file(),
               "network.admin_certificate_file",
               network.has_admin_key_file(),
               network.admin_key_file(),
               "network.admin_key_file",
               "leave both files out to use the certificate of the sessions",
               diagnostics);
    if (network.tcp_port() != 0 && network.tcp_port() == network.admin_port()) {
        diagnostics.add("network.admin_port", "is the same as tcp_port");
    }
    check_websocket(network, diagnostics);
    check_session(config.session(), diagnostics);
    check_log(config.log(), diagnostics);
    check_store(config.store(), diagnostics);
    check_recovery(config.recovery(), diagnostics);
    check_cluster(config, zones, diagnostics);
    check_entrance(config, diagnostics);
    check_testing(config, zones, diagnostics);
    std::set<std::string> names;
    for (int r = 0; r < config.rules_size(); ++r) {
        const std::string path = join_path("", "rules", r);
        if (check_name(config.rules(r).name(), "rules setting", path, diagnostics) &&
            !names.insert(config.rules(r).name()).second) {
            diagnostics.add(path + ".name", "'" + config.rules(r).name() + "' is given twice");
        }
    }
}

}  // namespace zoned::config
