#include "server/config/groups/group_config.h"

#include "server/config/text/check_name.h"
#include "proto/config/config.pb.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

namespace zoned::config {

std::optional<zone::PartySettings> expand_parties(const proto::config::Config& config) {
    if (!config.has_parties()) {
        return std::nullopt;
    }
    const auto& from = config.parties();
    const double rate_hz = config.world().tick_rate_hz();
    zone::PartySettings out;
    out.size = from.size();
    out.most = from.most();
    out.invitation_ticks = std::lround(from.invitation_s() * rate_hz);
    out.rejoin_ticks = std::lround(from.rejoin_s() * rate_hz);
    return out;
}

std::optional<zone::MatchSettings> expand_matches(const proto::config::Config& config,
                                                  Diagnostics& diagnostics) {
    if (config.match_size() == 0) {
        return std::nullopt;
    }
    const double rate_hz = config.world().tick_rate_hz();
    const auto ticks = [rate_hz](double seconds) {
        return static_cast<Tick>(std::lround(seconds * rate_hz));
    };
    constexpr double kCall_s = 10.0;
    constexpr double kGrace_s = 1.0;
    zone::MatchSettings out;
    out.call_ticks = ticks(kCall_s);
    out.grace_ticks = ticks(kGrace_s);
    std::set<std::string> names;
    for (int i = 0; i < config.match_size(); ++i) {
        const auto& from = config.match(i);
        const std::string path = join_path("", "match", i);
        if (check_name(from.name(), "a match", path, diagnostics) &&
            !names.insert(from.name()).second) {
            diagnostics.add(path + ".name", "'" + from.name() + "' is the name of another match");
        }
        if (from.has_least() && from.least() > from.size()) {
            diagnostics.add(path + ".least", "more than size, which a team cannot have");
        }
        const bool known = std::ranges::any_of(
            config.instance(), [&](const auto& one) { return one.name() == from.instance(); });
        if (from.has_instance() && !known) {
            diagnostics.add(path + ".instance", "no instance is called '" + from.instance() + "'");
        }
        out.kinds.push_back({from.name(),
                             from.teams(),
                             from.size(),
                             from.has_least() ? from.least() : from.size(),
                             from.instance(),
                             ticks(from.wait_s()),
                             ticks(from.limit_s()),
                             from.backfill()});
    }
    return out;
}

}  // namespace zoned::config
