#include "server/config/world/trigger_config.h"

#include "server/config/text/check_name.h"
#include "server/config/world/statics.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <set>
#include <string>

namespace zoned::config {

namespace {

motion::StaticBox box_of(const proto::config::Trigger& trigger) {
    proto::config::Box box;
    box.set_x_m(trigger.x_m());
    box.set_y_m(trigger.y_m());
    box.set_z_m(trigger.z_m());
    box.set_yaw_deg(trigger.yaw_deg());
    *box.mutable_size() = trigger.size();
    return static_box(box);
}

std::vector<bool> types_of(const proto::config::Trigger& trigger,
                           const world::TypeTable& types,
                           const std::string& path,
                           Diagnostics& diagnostics) {
    std::vector<bool> noticed(types.size(), trigger.type_size() == 0);
    for (int i = 0; i < trigger.type_size(); ++i) {
        const std::string& name = trigger.type(i);
        const auto at = std::ranges::find(types, name, &world::EntityType::name);
        if (at == types.end()) {
            diagnostics.add(join_path(path, "type", i), "no type is called '" + name + "'");
        } else {
            noticed[static_cast<std::size_t>(at - types.begin())] = true;
        }
    }
    return noticed;
}

}  // namespace

std::vector<zone::Trigger> expand_triggers(const proto::config::Config& config,
                                           const world::TypeTable& types,
                                           Diagnostics& diagnostics) {
    std::vector<zone::Trigger> out;
    std::set<std::string> names;
    for (int i = 0; i < config.trigger_size(); ++i) {
        const auto& trigger = config.trigger(i);
        const std::string path = join_path("", "trigger", i);
        if (check_name(trigger.name(), "a trigger", path, diagnostics) &&
            !names.insert(trigger.name()).second) {
            diagnostics.add(path + ".name",
                            "'" + trigger.name() + "' is the name of another trigger");
        }
        if (!trigger.has_size()) {
            diagnostics.add(path, "a trigger has a size");
            continue;
        }
        const motion::StaticBox box = box_of(trigger);
        check_inside(config.world(), box, path, diagnostics);
        out.push_back({trigger.name(), box, types_of(trigger, types, path, diagnostics)});
    }
    return out;
}

}  // namespace zoned::config
