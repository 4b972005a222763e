#include "server/config/plan/budget_load.h"

#include "proto/config/config.pb.h"

#include <algorithm>
#include <numbers>
#include <string>

namespace zoned::config {

namespace {

using proto::config::Config;

const proto::config::Type* type_named(const Config& config, const std::string& name) {
    for (const auto& type : config.type()) {
        if (type.name() == name) {
            return &type;
        }
    }
    return nullptr;
}

int tallest_pile(const Config& config) {
    PileCount piles;
    for (const auto& entity : config.entity()) {
        const auto* type = type_named(config, entity.type());
        if (type != nullptr && type->kind() == proto::config::PROP && !type->has_soft()) {
            piles.add(entity.x_m(), entity.z_m());
        }
    }
    return piles.most();
}

}  // namespace

BudgetLoad load_of(const Config& config) {
    BudgetLoad load;
    load.viewers = config.budget().viewers();
    load.pile = {tallest_pile(config), config.physics().gravity_mps2()};
    const auto add = [&](const std::string& name, double count, bool asleep) {
        const auto* type = type_named(config, name);
        if (type != nullptr && type->kind() == proto::config::CHARACTER) {
            load.movers += count;
        } else if (type != nullptr && !type->has_soft()) {
            load.bodies += asleep ? kTouchedShare / kAwakeShare * count : count;
        }
    };
    for (const auto& entity : config.entity()) {
        add(entity.type(), 1.0, entity.asleep());
    }
    for (const auto& scatter : config.scatter()) {
        add(scatter.type(), scatter.count(), scatter.asleep());
    }
    load.movers += load.viewers;
    for (const auto& type : config.type()) {
        load.nimbus_m = std::max(load.nimbus_m, type.nimbus_m().normal());
    }
    const auto& w = config.world();
    const double area = (w.max_x_m() - w.min_x_m()) * (w.max_z_m() - w.min_z_m());
    const double share = std::numbers::pi * load.nimbus_m * load.nimbus_m / std::max(area, 1.0);
    load.heard = (load.movers + kAwakeShare * load.bodies) * std::min(1.0, share);
    return load;
}

}  // namespace zoned::config
