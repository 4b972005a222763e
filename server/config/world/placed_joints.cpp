#include "server/config/world/placed_joints.h"

#include "server/config/settings.h"
#include "server/config/text/check_name.h"
#include "server/config/types/joint_config.h"
#include "server/config/types/type_shapes.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace zoned::config {

namespace {

class JointPlacer {
  public:
    JointPlacer(const proto::config::Config& config, Settings& settings, Diagnostics& diagnostics)
        : config_(config),
          settings_(settings),
          diagnostics_(diagnostics) {}

    void place(const proto::config::Joint& from, const std::string& path) {
        if (from.has_name() && check_name(from.name(), "joint", path, diagnostics_) &&
            !names_.insert(from.name()).second) {
            diagnostics_.add(path + ".name", "'" + from.name() + "' is the name of another joint");
        }
        if (!from.has_b()) {
            diagnostics_.add(path, "a joint needs b, the name of a placed entity");
            return;
        }
        const std::optional<JointEnd> a =
            from.has_a() ? find_end(from.a(), path + ".a") : JointEnd{};
        const std::optional<JointEnd> b = find_end(from.b(), path + ".b");
        if (!a || !b) {
            return;
        }
        if (a->entity == b->entity && a->part == b->part) {
            diagnostics_.add(path + ".b", "an entity cannot be joined to itself");
            return;
        }
        JointEnds ends;
        ends.to_world = a->entity < 0;
        ends.stands_a = stands_of(*a);
        ends.stands_b = stands_of(*b);
        if (auto plan = read_joint(from, ends, path, diagnostics_)) {
            settings_.placed_joints.push_back({std::move(plan), *a, *b});
        }
    }

  private:
    /// NAME, or NAME.PART. A name may hold dots itself: the longest that an entity has counts.
    std::optional<JointEnd> find_end(const std::string& name, const std::string& at) {
        JointEnd end;
        std::string part;
        const auto& initial = settings_.initial;
        for (std::size_t i = 0; i < initial.size(); ++i) {
            const std::string& own = initial[i].name;
            const bool whole = own == name;
            if (!own.empty() &&
                (whole || (name.size() > own.size() + 1 && name.compare(0, own.size(), own) == 0 &&
                           name[own.size()] == '.'))) {
                end.entity = static_cast<int>(i);
                part = whole ? "" : name.substr(own.size() + 1);
                if (whole) {
                    break;
                }
            }
        }
        if (end.entity < 0) {
            diagnostics_.add(at, "there is no placed entity named '" + name + "'");
            return std::nullopt;
        }
        const InitialEntity& entity = initial[static_cast<std::size_t>(end.entity)];
        const world::EntityType& type = settings_.types[entity.type];
        if (!part.empty() && !find_part(type, part, end.part)) {
            diagnostics_.add(at, "'" + entity.name + "' has no part named '" + part + "'");
            return std::nullopt;
        }
        if (type.kind != world::EntityKind::kProp || type.shape == world::TypeShape::kSoft) {
            diagnostics_.add(at, "'" + entity.name + "' is no rigid prop: it takes no joint");
            return std::nullopt;
        }
        if (entity.asleep) {
            diagnostics_.add(at,
                             "'" + entity.name + "' is asleep: what a joint holds begins awake");
            return std::nullopt;
        }
        return end;
    }

    bool find_part(const world::EntityType& type, const std::string& name, std::uint16_t& out) {
        if (!type.is_root()) {
            return false;
        }
        const auto& parts = (*settings_.assemblies)[type.assembly - 1U].parts;
        const auto at = std::find_if(
            parts.begin(), parts.end(), [&](const auto& part) { return part.name == name; });
        out = static_cast<std::uint16_t>(at - parts.begin());
        return at != parts.end();
    }

    [[nodiscard]] Quat stands_of(const JointEnd& end) const {
        if (end.entity < 0) {
            return Quat::Identity();
        }
        const world::EntityType& root =
            settings_.types[settings_.initial[static_cast<std::size_t>(end.entity)].type];
        const int index = root.is_root()
                              ? (*settings_.assemblies)[root.assembly - 1U].parts[end.part].type
                              : settings_.initial[static_cast<std::size_t>(end.entity)].type;
        const auto& type = config_.type(index);
        if (!type.has_hull() && !type.has_compound()) {
            return Quat::Identity();
        }
        const auto solid = build_solid(type);
        return solid ? solid->stands : Quat(Quat::Identity());
    }

    const proto::config::Config& config_;
    Settings& settings_;
    Diagnostics& diagnostics_;
    std::set<std::string> names_;
};

}  // namespace

void place_joints(const proto::config::Config& config,
                  Settings& settings,
                  Diagnostics& diagnostics) {
    settings.placed_joints.clear();
    JointPlacer placer(config, settings, diagnostics);
    for (int j = 0; j < config.joint_size(); ++j) {
        placer.place(config.joint(j), join_path("", "joint", j));
    }
}

}  // namespace zoned::config
