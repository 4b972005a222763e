#include "server/config/text/renamed_words.h"

#include <algorithm>
#include <array>

namespace zoned::config {

namespace {

constexpr std::array kRenamed{
    RenamedWord{"zoned.proto.config.Config", "machine", "brain"},
    RenamedWord{"zoned.proto.config.Config", "place", "point_of_interest"},
    RenamedWord{"zoned.proto.config.Config", "slow", "environment"},
    RenamedWord{"zoned.proto.config.Surface", "told", "replicated"},
    RenamedWord{"zoned.proto.config.Type", "machine", "brain"},
    RenamedWord{"zoned.proto.config.Type", "conceal", "visibility_filter"},
    RenamedWord{"zoned.proto.config.Behaviour", "machine", "brain"},
    RenamedWord{"zoned.proto.config.State", "machine", "brain"},
    RenamedWord{"zoned.proto.config.State", "place", "point_of_interest"},
    RenamedWord{"zoned.proto.config.Action", "place", "point_of_interest"},
    RenamedWord{"zoned.proto.config.Trade", "place", "point_of_interest"},
    RenamedWord{"zoned.proto.config.Interest", "conceal_checks_per_tick", "filter_checks_per_tick"},
    RenamedWord{"zoned.proto.config.Interest", "conceal_stale_ticks", "filter_stale_ticks"},
    RenamedWord{"zoned.proto.config.Interest", "conceal_grace_ticks", "filter_grace_ticks"},
    RenamedWord{"zoned.proto.config.Ai", "skip_unseen", "suspend_offscreen"},
    RenamedWord{"zoned.proto.config.Ai", "calm_s", "suspend_after_s"},
    RenamedWord{"zoned.proto.config.Ai", "ways", "pathfinding"},
    RenamedWord{"zoned.proto.config.Pathfinding.Map", "MESH", "NAVMESH"},
    RenamedWord{"zoned.proto.config.Pathfinding.Map", "GRAPH", "WAYPOINT_GRAPH"},
    RenamedWord{"zoned.proto.config.Burst", "conceal", "visibility_filter"},
    RenamedWord{"zoned.proto.config.Testing", "leak_concealed", "leak_filtered"},
};

}  // namespace

std::span<const RenamedWord> renamed_words() {
    return kRenamed;
}

std::string_view word_now(const std::string& scope, const std::string& before) {
    const auto found = std::find_if(kRenamed.begin(), kRenamed.end(), [&](const RenamedWord& word) {
        return word.scope == scope && word.before == before;
    });
    return found == kRenamed.end() ? std::string_view() : found->now;
}

}  // namespace zoned::config
