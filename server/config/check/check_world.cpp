#include "server/config/check/config_checks.h"
#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <map>

namespace zoned::config {

namespace {

constexpr int kMaxPairsNamed = 20;

bool overlap(const ZoneRegion& a, const ZoneRegion& b) {
    return a.min_x < b.max_x && b.min_x < a.max_x && a.min_z < b.max_z && b.min_z < a.max_z;
}

std::vector<double> sorted_edges(double low, double high, std::vector<double> edges) {
    edges.push_back(low);
    edges.push_back(high);
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    return edges;
}

std::size_t edge_number(const std::vector<double>& edges, double value) {
    return static_cast<std::size_t>(std::lower_bound(edges.begin(), edges.end(), value) -
                                    edges.begin());
}

/// Cuts the world along all zone edges and names the first piece that belongs to no zone. The zones
/// must not overlap and lie inside the world.
void check_gaps(const proto::config::World& world,
                const std::vector<ZoneRegion>& zones,
                Diagnostics& diagnostics) {
    std::vector<double> xs;
    std::vector<double> zs;
    for (const ZoneRegion& zone : zones) {
        xs.insert(xs.end(), {zone.min_x, zone.max_x});
        zs.insert(zs.end(), {zone.min_z, zone.max_z});
    }
    xs = sorted_edges(world.min_x_m(), world.max_x_m(), std::move(xs));
    zs = sorted_edges(world.min_z_m(), world.max_z_m(), std::move(zs));
    const std::size_t columns = xs.size() - 1;
    std::vector<bool> owned(columns * (zs.size() - 1), false);
    for (const ZoneRegion& zone : zones) {
        for (std::size_t z = edge_number(zs, zone.min_z); z < edge_number(zs, zone.max_z); ++z) {
            for (std::size_t x = edge_number(xs, zone.min_x); x < edge_number(xs, zone.max_x);
                 ++x) {
                owned[z * columns + x] = true;
            }
        }
    }
    const auto gap = std::find(owned.begin(), owned.end(), false);
    if (gap == owned.end()) {
        return;
    }
    const auto cell = static_cast<std::size_t>(gap - owned.begin());
    char text[200];
    std::snprintf(text,
                  sizeof(text),
                  "zones leave a gap: x %g..%g, z %g..%g of the world belongs to no zone",
                  xs[cell % columns],
                  xs[cell % columns + 1],
                  zs[cell / columns],
                  zs[cell / columns + 1]);
    diagnostics.add("zones", text);
}

std::vector<ZoneRegion> expand_grid(const proto::config::Config& config) {
    const auto& world = config.world();
    const auto& grid = config.zones().zone_grid();
    const auto cut = [](double low, double high, std::uint32_t i, std::uint32_t n) {
        return i == n ? high : low + (high - low) * i / n;
    };
    std::vector<ZoneRegion> zones;
    for (std::uint32_t r = 0; r < grid.rows(); ++r) {
        for (std::uint32_t c = 0; c < grid.columns(); ++c) {
            ZoneRegion zone;
            zone.id = ZoneId(static_cast<std::uint16_t>(zones.size() + 1));
            zone.name = "x" + std::to_string(c) + "z" + std::to_string(r);
            zone.min_x = cut(world.min_x_m(), world.max_x_m(), c, grid.columns());
            zone.max_x = cut(world.min_x_m(), world.max_x_m(), c + 1, grid.columns());
            zone.min_z = cut(world.min_z_m(), world.max_z_m(), r, grid.rows());
            zone.max_z = cut(world.min_z_m(), world.max_z_m(), r + 1, grid.rows());
            zones.push_back(zone);
        }
    }
    return zones;
}

/// False when the zone cannot take part in the checks of pairs.
bool check_zone(const proto::config::Config& config, int i, Diagnostics& diagnostics) {
    const auto& world = config.world();
    const auto& zone = config.zones().zone(i);
    const std::string path = join_path("zones", "zone", i);
    if (!zone.has_min_x_m() || !zone.has_min_z_m() || !zone.has_max_x_m() || !zone.has_max_z_m()) {
        diagnostics.add(path, "a zone needs min_x_m, min_z_m, max_x_m and max_z_m");
        return false;
    }
    bool good = true;
    if (!(zone.min_x_m() < zone.max_x_m())) {
        diagnostics.add(path + ".max_x_m", "must be greater than min_x_m");
        good = false;
    }
    if (!(zone.min_z_m() < zone.max_z_m())) {
        diagnostics.add(path + ".max_z_m", "must be greater than min_z_m");
        good = false;
    }
    if (good && (zone.min_x_m() < world.min_x_m() || zone.max_x_m() > world.max_x_m() ||
                 zone.min_z_m() < world.min_z_m() || zone.max_z_m() > world.max_z_m())) {
        diagnostics.add(path, "reaches outside the world");
        good = false;
    }
    return good;
}

std::vector<ZoneRegion> expand_list(const proto::config::Config& config,
                                    bool& good,
                                    Diagnostics& diagnostics) {
    std::vector<ZoneRegion> zones;
    std::map<std::string, int> names;
    for (int i = 0; i < config.zones().zone_size(); ++i) {
        const auto& zone = config.zones().zone(i);
        const std::string path = join_path("zones", "zone", i);
        if (check_name(zone.name(), "zone", path, diagnostics) &&
            !names.emplace(zone.name(), i).second) {
            diagnostics.add(path + ".name",
                            "'" + zone.name() + "' is the name of " +
                                join_path("zones", "zone", names[zone.name()]) + " already");
        }
        good = check_zone(config, i, diagnostics) && good;
        zones.push_back({ZoneId(static_cast<std::uint16_t>(i + 1)),
                         zone.name(),
                         zone.min_x_m(),
                         zone.min_z_m(),
                         zone.max_x_m(),
                         zone.max_z_m()});
    }
    int named = 0;
    for (std::size_t a = 0; a < zones.size() && named < kMaxPairsNamed; ++a) {
        for (std::size_t b = a + 1; b < zones.size() && named < kMaxPairsNamed; ++b) {
            if (overlap(zones[a], zones[b])) {
                diagnostics.add(join_path("zones", "zone", static_cast<int>(b)),
                                "overlaps zone '" + zones[a].name + "'");
                good = false;
                ++named;
            }
        }
    }
    return zones;
}

}  // namespace

std::vector<ZoneRegion> expand_zones(const proto::config::Config& config,
                                     Diagnostics& diagnostics) {
    const auto& world = config.world();
    bool good = true;
    if (!(world.min_x_m() < world.max_x_m())) {
        diagnostics.add("world.max_x_m", "must be greater than min_x_m");
        good = false;
    }
    if (!(world.min_z_m() < world.max_z_m())) {
        diagnostics.add("world.max_z_m", "must be greater than min_z_m");
        good = false;
    }
    check_name(world.name(), "world", "world", diagnostics);
    const auto& zones = config.zones();
    if (zones.has_zone_grid() && zones.zone_size() > 0) {
        diagnostics.add("zones.zone_grid", "give either zone_grid or a list of zone, not both");
        return {};
    }
    if (!zones.has_zone_grid() && zones.zone_size() == 0) {
        diagnostics.add("zones", "there is no zone: give zone_grid or a list of zone");
        return {};
    }
    if (zones.has_zone_grid()) {
        return good ? expand_grid(config) : std::vector<ZoneRegion>();
    }
    std::vector<ZoneRegion> list = expand_list(config, good, diagnostics);
    if (good) {
        check_gaps(world, list, diagnostics);
    }
    return list;
}

}  // namespace zoned::config
