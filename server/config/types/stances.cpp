#include "server/config/types/stances.h"

#include "server/world/entity_type.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace zoned::config {

namespace {

constexpr std::array<std::string_view, world::kFirstNamedStance> kBuiltIn = {"normal",
                                                                             "idle",
                                                                             "running",
                                                                             "riding"};

// The columns of radii that are left.
constexpr int kMostNamed = world::kStances - world::kFirstNamedStance;

}  // namespace

int find_stance(const proto::config::Config& config, const std::string& name) {
    for (std::size_t i = 0; i < kBuiltIn.size(); ++i) {
        if (kBuiltIn[i] == name) {
            return static_cast<int>(i);
        }
    }
    for (int b = 0; b < std::min(config.stance_size(), kMostNamed); ++b) {
        if (config.stance(b) == name) {
            return world::kFirstNamedStance + b;
        }
    }
    return -1;
}

double largest_radius(const proto::config::Radii& radii) {
    double largest = std::max({radii.normal(), radii.idle(), radii.running(), radii.riding()});
    for (const auto& named : radii.named()) {
        largest = std::max({largest, named.radius_m(), named.cone().length_m()});
    }
    return largest;
}

void check_stances(const proto::config::Config& config, Diagnostics& diagnostics) {
    for (int b = 0; b < config.stance_size(); ++b) {
        if (b >= kMostNamed) {
            diagnostics.add(join_path("", "stance", b), "a config names at most 4 stances");
            return;
        }
        const std::string path = join_path("", "stance", b);
        const std::string& name = config.stance(b);
        if (find_stance(config, name) != world::kFirstNamedStance + b) {
            diagnostics.add(path, "'" + name + "' is the name of another stance");
        }
    }
    const auto check = [&](const std::string& name, const std::string& path) {
        if (find_stance(config, name) < world::kFirstNamedStance) {
            diagnostics.add(
                path,
                "there is no stance: \"" + name + "\" in this config" +
                    (find_stance(config, name) >= 0 ? "; this one has its own field" : ""));
        }
    };
    for (int t = 0; t < config.type_size(); ++t) {
        const auto check_radii = [&](const proto::config::Radii& radii, const std::string& field) {
            for (int r = 0; r < radii.named_size(); ++r) {
                const std::string path =
                    join_path(join_path("", "type", t) + "." + field, "named", r);
                check(radii.named(r).stance(), path + ".stance");
                if (radii.named(r).has_cone() &&
                    (field == "aura_m" || config.type(t).kind() != proto::config::CHARACTER)) {
                    diagnostics.add(path + ".cone", "only the nimbus of characters has a cone");
                }
            }
        };
        check_radii(config.type(t).aura_m(), "aura_m");
        check_radii(config.type(t).nimbus_m(), "nimbus_m");
    }
    for (int m = 0; m < config.brain_size(); ++m) {
        for (int s = 0; s < config.brain(m).state_size(); ++s) {
            const auto& state = config.brain(m).state(s);
            if (state.has_named_stance()) {
                check(state.named_stance(),
                      join_path(join_path("", "brain", m), "state", s) + ".named_stance");
            }
        }
    }
    const auto check_action = [&check](const proto::config::Action& action,
                                       const std::string& path) {
        if (action.has_named_stance()) {
            check(action.named_stance(), path + ".do.named_stance");
        }
    };
    for (int t = 0; t < config.tree_size(); ++t) {
        for (int n = 0; n < config.tree(t).node_size(); ++n) {
            check_action(config.tree(t).node(n).do_(),
                         join_path(join_path("", "tree", t), "node", n));
        }
    }
    for (int b = 0; b < config.blend_size(); ++b) {
        for (int s = 0; s < config.blend(b).state_size(); ++s) {
            check_action(config.blend(b).state(s).do_(),
                         join_path(join_path("", "blend", b), "state", s));
        }
    }
    for (int d = 0; d < config.domain_size(); ++d) {
        for (int a = 0; a < config.domain(d).action_size(); ++a) {
            check_action(config.domain(d).action(a).do_(),
                         join_path(join_path("", "domain", d), "action", a));
        }
    }
}

}  // namespace zoned::config
