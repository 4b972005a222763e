#include "server/config/npc/difficulty_names.h"

#include "proto/config/config.pb.h"

#include <algorithm>
#include <set>

namespace zoned::config {

namespace {

using proto::config::Config;

/// Number in the list, -1: it is not there.
int find_level(const proto::config::Adaptation& adaptation, const std::string& name) {
    const auto& names = adaptation.difficulty();
    const auto at = std::find(names.begin(), names.end(), name);
    return at == names.end() ? -1 : static_cast<int>(at - names.begin());
}

void check_level_names(const Config& config, Diagnostics& diagnostics) {
    std::set<std::string> seen;
    const proto::config::Adaptation& adaptation = config.ai().adaptation();
    for (int k = 0; k < adaptation.difficulty_size(); ++k) {
        const std::string& name = adaptation.difficulty(k);
        const std::string path = join_path(kAdaptationPath, "difficulty", k);
        const bool known = std::any_of(config.difficulty().begin(),
                                       config.difficulty().end(),
                                       [&](const auto& of) { return of.name() == name; });
        if (!known) {
            diagnostics.add(path, "there is no difficulty named '" + name + "'");
        } else if (!seen.insert(name).second) {
            diagnostics.add(path, "'" + name + "' is in the list already");
        }
    }
}

void check_level_range(const proto::config::Adaptation& adaptation, Diagnostics& diagnostics) {
    const LevelRange range = level_range(adaptation);
    const std::string path = kAdaptationPath;
    bool listed = true;
    const auto check = [&](int level, const char* field, const std::string& name) {
        if (level < 0) {
            diagnostics.add(path + "." + field,
                            "'" + name + "' is not in the list of difficulties");
            listed = false;
        }
    };
    check(range.least, "least", adaptation.least());
    check(range.most, "most", adaptation.most());
    if (adaptation.has_start()) {
        check(range.start, "start", adaptation.start());
    }
    if (!listed) {
        return;
    }
    if (range.least >= range.most) {
        diagnostics.add(path + (adaptation.has_least() ? ".least" : ".most"),
                        "the least must come before the most, or it would never change");
    } else if (range.start < range.least || range.start > range.most) {
        diagnostics.add(path + ".start", "lies outside of least and most");
    }
}

}  // namespace

LevelRange level_range(const proto::config::Adaptation& adaptation) {
    LevelRange range;
    range.least = adaptation.has_least() ? find_level(adaptation, adaptation.least()) : 0;
    range.most = adaptation.has_most() ? find_level(adaptation, adaptation.most())
                                       : adaptation.difficulty_size() - 1;
    range.start = adaptation.has_start() ? find_level(adaptation, adaptation.start()) : range.least;
    return range;
}

std::string first_difficulty(const Config& config) {
    const proto::config::Adaptation& adaptation = config.ai().adaptation();
    if (config.ai().has_difficulty() || !config.ai().has_adaptation()) {
        return config.ai().difficulty();
    }
    const int start = level_range(adaptation).start;
    return start >= 0 && start < adaptation.difficulty_size() ? adaptation.difficulty(start) : "";
}

void check_adaptation(const Config& config, Diagnostics& diagnostics) {
    if (!config.ai().has_adaptation()) {
        return;
    }
    if (config.ai().has_difficulty()) {
        diagnostics.add("ai.difficulty", "is chosen by ai.adaptation: say `start` there");
    }
    const std::size_t before = diagnostics.size();
    check_level_names(config, diagnostics);
    if (diagnostics.size() == before) {  // else what is not in the list is a consequence
        check_level_range(config.ai().adaptation(), diagnostics);
    }
}

}  // namespace zoned::config
