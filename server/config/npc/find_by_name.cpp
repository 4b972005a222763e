#include "server/config/npc/find_by_name.h"

#include "proto/config/config.pb.h"

namespace zoned::config {

using proto::config::Config;

int find_brain(const Config& config, const std::string& name) {
    return index_of(config.brain(), name);
}

int find_variable(const proto::config::Brain& brain, const std::string& name) {
    return index_of(brain.variable(), name);
}

int find_tree(const Config& config, const std::string& name) {
    return index_of(config.tree(), name);
}

int find_domain(const Config& config, const std::string& name) {
    return index_of(config.domain(), name);
}

int find_policy(const Config& config, const std::string& name) {
    return index_of(config.policy(), name);
}

int find_goal(const proto::config::Domain& domain, const proto::config::State& state) {
    return state.has_goal() ? index_of(domain.goal(), state.goal()) : 0;
}

int find_blend(const Config& config, const std::string& name) {
    return index_of(config.blend(), name);
}

int find_point_of_interest(const Config& config, const std::string& name) {
    return index_of(config.point_of_interest(), name);
}

}  // namespace zoned::config
