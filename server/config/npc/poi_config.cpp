#include "server/config/npc/poi_config.h"

#include "server/config/npc/find_by_name.h"
#include "server/config/settings.h"
#include "server/config/text/config_numbers.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace zoned::config {

namespace {

using proto::config::Config;

int find_stock(const proto::config::PointOfInterest& place, const std::string& good) {
    for (int s = 0; s < place.stock_size(); ++s) {
        if (place.stock(s).good() == good) {
            return s;
        }
    }
    return -1;
}

void check_trade(const Config& config,
                 int root,
                 const proto::config::Trade& trade,
                 const std::string& path,
                 Diagnostics& diagnostics) {
    if (find_point_of_interest(config, trade.point_of_interest()) < 0) {
        diagnostics.add(path + ".point_of_interest",
                        "there is no point of interest named '" + trade.point_of_interest() + "'");
    }
    if (trade.give_size() + trade.take_size() == 0) {
        diagnostics.add(path, "gives nothing and takes nothing");
    }
    std::set<std::string> goods;
    const auto check = [&](const auto& amounts, const char* field) {
        for (int a = 0; a < amounts.size(); ++a) {
            const std::string& good = amounts.Get(a).good();
            const std::string at = join_path(path, field, a) + ".good";
            if (find_variable(config.brain(root), good) < 0) {
                diagnostics.add(at,
                                "agents of brain '" + config.brain(root).name() +
                                    "' have no variable named '" + good + "'");
            } else if (!goods.insert(good).second) {
                diagnostics.add(at, "'" + good + "' is in this trade already");
            }
        }
    };
    check(trade.give(), "give");
    check(trade.take(), "take");
}

/// Or beyond the world's edge.
/// Cells from a nest to the side of its map, at most.
constexpr double kMostCells = 500.0;

bool in_one_zone(const proto::config::PointOfInterest& place,
                 const std::vector<ZoneRegion>& zones) {
    const double r = place.radius_m();
    return zones.size() < 2 || std::any_of(zones.begin(), zones.end(), [&](const ZoneRegion& zone) {
               return place.x_m() - r >= zone.min_x && place.x_m() + r <= zone.max_x &&
                      place.z_m() - r >= zone.min_z && place.z_m() + r <= zone.max_z;
           });
}

}  // namespace

ai::PoiSettings expand_points_of_interest(const proto::config::Config& config) {
    ai::PoiSettings out;
    out.day_s = config.ai().day_s();
    out.dawn_s = config.ai().dawn_s();
    for (const auto& place : config.point_of_interest()) {
        ai::PointOfInterestDef def;
        def.name = place.name();
        def.at = {place.x_m(), place.z_m()};
        if (place.has_y_m()) {
            def.y_m = place.y_m();
        }
        def.radius_m = narrow(place.radius_m());
        for (const auto& stock : place.stock()) {
            def.stock.push_back(
                {stock.good(), narrow(stock.start()), narrow(stock.high()), narrow(stock.per_s())});
        }
        out.points_of_interest.push_back(std::move(def));
    }
    return out;
}

std::optional<ai::PointOfInterestSense> find_poi_sense(const proto::config::Config& config,
                                                       const std::string& sense) {
    // Names may have dots of their own: whatever fits.
    for (int p = 0; p < config.point_of_interest_size(); ++p) {
        const std::string& name = config.point_of_interest(p).name();
        if (sense == name + ".distance") {
            return ai::PointOfInterestSense{static_cast<std::uint16_t>(p), -1, sense};
        }
        for (int s = 0; s < config.point_of_interest(p).stock_size(); ++s) {
            if (sense == name + "." + config.point_of_interest(p).stock(s).good()) {
                return ai::PointOfInterestSense{
                    static_cast<std::uint16_t>(p), static_cast<std::int16_t>(s), sense};
            }
        }
    }
    return std::nullopt;
}

ai::Trade expand_trade(const proto::config::Config& config,
                       const proto::config::Trade& trade,
                       const VariableOf& variable_of) {
    ai::Trade out;
    const int place = find_point_of_interest(config, trade.point_of_interest());
    out.place = static_cast<std::uint16_t>(std::max(place, 0));
    const auto add = [&](const proto::config::Amount& amount, float sign) {
        ai::TradeItem item;
        item.variable = variable_of(amount.good());
        item.amount = sign * narrow(amount.amount());
        if (place >= 0) {
            item.stock = static_cast<std::int16_t>(
                find_stock(config.point_of_interest(place), amount.good()));
        }
        out.items.push_back(item);
    };
    for (const auto& amount : trade.give()) {
        add(amount, -1.0F);
    }
    for (const auto& amount : trade.take()) {
        add(amount, 1.0F);
    }
    return out;
}

ai::ForageDef expand_forage(const proto::config::Config& config,
                            const proto::config::Forage& forage) {
    ai::ForageDef out;
    const auto place = [&config](const std::string& name) {
        return static_cast<std::uint16_t>(std::max(find_point_of_interest(config, name), 0));
    };
    out.nest = place(forage.nest());
    for (const std::string& food : forage.food()) {
        out.food.push_back(place(food));
    }
    out.radius_m = narrow(forage.radius_m());
    out.cell_m = narrow(forage.cell_m());
    out.explore = narrow(forage.explore());
    out.trails.evaporation = narrow(forage.evaporation_per_s());
    out.trails.fade = narrow(forage.fade());
    out.trails.patience = forage.patience();
    out.trails.reinforcement = narrow(forage.reinforcement());
    return out;
}

ai::FormationDef expand_formation(const proto::config::Formation& formation) {
    ai::FormationDef out;
    out.shape = static_cast<ai::FormationShape>(formation.shape());
    out.columns = static_cast<std::uint16_t>(formation.columns());
    out.spacing_m = narrow(formation.spacing_m());
    out.settings.straggler_m = narrow(formation.straggler_m());
    out.settings.taken_back_m = narrow(formation.taken_back_m());
    return out;
}

void check_points_of_interest(const proto::config::Config& config,
                              const std::vector<ZoneRegion>& zones,
                              Diagnostics& diagnostics) {
    std::set<std::string> names;
    const auto& world = config.world();
    for (int p = 0; p < config.point_of_interest_size(); ++p) {
        const auto& place = config.point_of_interest(p);
        const std::string path = join_path("", "point_of_interest", p);
        if (!names.insert(place.name()).second) {
            diagnostics.add(path + ".name", "there is another place named '" + place.name() + "'");
        }
        const bool inside = place.x_m() >= world.min_x_m() && place.x_m() <= world.max_x_m() &&
                            place.z_m() >= world.min_z_m() && place.z_m() <= world.max_z_m();
        if (!inside) {
            diagnostics.add(path, "lies outside the world");
        } else if (place.stock_size() > 0 && !in_one_zone(place, zones)) {
            diagnostics.add(path, "has stock and reaches into several zones: one of them keeps it");
        }
        std::set<std::string> goods{"distance"};
        for (int s = 0; s < place.stock_size(); ++s) {
            const auto& stock = place.stock(s);
            const std::string at = join_path(path, "stock", s);
            if (!goods.insert(stock.good()).second) {
                diagnostics.add(at + ".good",
                                stock.good() == "distance"
                                    ? "'distance' is what the place is sensed by"
                                    : "'" + stock.good() + "' is in stock here already");
            }
            if (stock.start() > stock.high()) {
                diagnostics.add(at + ".start", "begins above `high`");
            }
        }
    }
    if (config.ai().dawn_s() >= config.ai().day_s()) {
        diagnostics.add("ai.dawn_s", "must be below ai.day_s");
    }
}

namespace {

/// Checks that nest and food exist, and lie in the searched area.
void check_forage(const Config& config,
                  const proto::config::Forage& forage,
                  const std::string& path,
                  Diagnostics& diagnostics) {
    const int nest = find_point_of_interest(config, forage.nest());
    if (nest < 0) {
        diagnostics.add(path + ".nest",
                        forage.has_nest()
                            ? "there is no point of interest named '" + forage.nest() + "'"
                            : "says nowhere to bring food to");
    }
    if (forage.radius_m() > kMostCells * forage.cell_m()) {
        diagnostics.add(path + ".radius_m", "is more than 500 times cell_m");
    }
    for (int f = 0; f < forage.food_size(); ++f) {
        const int food = find_point_of_interest(config, forage.food(f));
        const std::string here = join_path(path, "food", f);
        if (food < 0) {
            diagnostics.add(here, "there is no point of interest named '" + forage.food(f) + "'");
        } else if (nest >= 0 &&
                   std::max(std::abs(config.point_of_interest(food).x_m() -
                                     config.point_of_interest(nest).x_m()),
                            std::abs(config.point_of_interest(food).z_m() -
                                     config.point_of_interest(nest).z_m())) > forage.radius_m()) {
            diagnostics.add(here, "lies farther than radius_m from the nest");
        }
    }
}

}  // namespace

template <class ActionSpec>
void expand_action_details(const proto::config::Config& config,
                           const ActionSpec& action,
                           const VariableOf& variable_of,
                           ai::BrainState& out) {
    if (action.action() == proto::config::GO) {
        out.place = static_cast<std::uint16_t>(
            std::max(find_point_of_interest(config, action.point_of_interest()), 0));
    }
    if (action.action() == proto::config::FORM_UP) {
        out.formation = expand_formation(action.formation());
    }
    if (action.action() == proto::config::FORAGE) {
        out.forage = expand_forage(config, action.forage());
    }
    if (action.action() == proto::config::FOLLOW_TRACK) {
        out.follow = expand_follow(config, action.follow());
    }
    out.flock = {narrow(action.flock().separation()),
                 narrow(action.flock().alignment()),
                 narrow(action.flock().cohesion())};
    for (const std::string& place : action.along()) {
        out.along.push_back(
            static_cast<std::uint16_t>(std::max(find_point_of_interest(config, place), 0)));
    }
    for (const auto& trade : action.trade()) {
        out.trades.push_back(expand_trade(config, trade, variable_of));
    }
}

template void expand_action_details(const proto::config::Config& config,
                                    const proto::config::State& action,
                                    const VariableOf& variable_of,
                                    ai::BrainState& out);
template void expand_action_details(const proto::config::Config& config,
                                    const proto::config::Action& action,
                                    const VariableOf& variable_of,
                                    ai::BrainState& out);

template <class ActionSpec>
void check_action_details(const proto::config::Config& config,
                          int root,
                          const ActionSpec& action,
                          const std::string& path,
                          Diagnostics& diagnostics) {
    if (action.has_point_of_interest() &&
        find_point_of_interest(config, action.point_of_interest()) < 0) {
        diagnostics.add(path + ".point_of_interest",
                        "there is no point of interest named '" + action.point_of_interest() + "'");
    } else if (action.action() == proto::config::GO && !action.has_point_of_interest()) {
        diagnostics.add(path + ".action", "says nowhere to go: `point_of_interest` is not set");
    } else if (action.action() != proto::config::GO && action.has_point_of_interest()) {
        diagnostics.add(path + ".point_of_interest", "is of GO alone");
    }
    if (action.has_formation() && action.action() != proto::config::FORM_UP) {
        diagnostics.add(path + ".formation", "is of FORM_UP alone");
    } else if (action.formation().taken_back_m() > action.formation().straggler_m()) {
        diagnostics.add(path + ".formation", "taken_back_m is above straggler_m");
    }
    if (action.action() == proto::config::FORAGE) {
        check_forage(config, action.forage(), path + ".forage", diagnostics);
    } else if (action.has_forage()) {
        diagnostics.add(path + ".forage", "is of FORAGE alone");
    }
    if (action.action() == proto::config::FOLLOW_TRACK) {
        check_follow(config, action.follow(), path + ".follow", diagnostics);
    } else if (action.has_follow()) {
        diagnostics.add(path + ".follow", "is of FOLLOW_TRACK alone");
    }
    if (action.along_size() > 0 && action.action() != proto::config::FLOCK) {
        diagnostics.add(join_path(path, "along", 0), "is of FLOCK alone");
    }
    if (action.has_flock() && action.action() != proto::config::FLOCK) {
        diagnostics.add(path + ".flock", "is of FLOCK alone");
    }
    if (action.along_size() == 2) {
        diagnostics.add(join_path(path, "along", 1),
                        "leads back the way it came: name one place, or three and more");
    }
    for (int a = 0; a < action.along_size(); ++a) {
        if (find_point_of_interest(config, action.along(a)) < 0) {
            diagnostics.add(join_path(path, "along", a),
                            "there is no point of interest named '" + action.along(a) + "'");
        }
    }
    for (int t = 0; t < action.trade_size(); ++t) {
        check_trade(config, root, action.trade(t), join_path(path, "trade", t), diagnostics);
    }
}

template void check_action_details(const proto::config::Config& config,
                                   int root,
                                   const proto::config::State& action,
                                   const std::string& path,
                                   Diagnostics& diagnostics);
template void check_action_details(const proto::config::Config& config,
                                   int root,
                                   const proto::config::Action& action,
                                   const std::string& path,
                                   Diagnostics& diagnostics);

}  // namespace zoned::config
