#include "server/ai/agent/brain/sense_names.h"

#include <array>

namespace zoned::ai {

namespace {

void append_senses_of_brain(const Brain& brain, std::vector<std::string>& names) {
    for (const BrainVariable& variable : brain.variables) {
        names.push_back(variable.name);
    }
    for (const FuzzySense& fuzzy : brain.fuzzy) {
        for (const fuzzy::FuzzyOutput& output : fuzzy.def.outputs) {
            names.push_back(fuzzy.def.name + "." + output.name);
        }
    }
    for (const PointOfInterestSense& place : brain.points_of_interest) {
        names.push_back(place.name);
    }
}

/// Names of a sense that every agent has: in accounts and in configs. By SenseIndex.
struct OwnSense {
    const char* text;
    const char* in_config;
};

constexpr std::array<OwnSense, kOwnSenses> kOwnSenseNames{{
    {"player distance", "PLAYER_DISTANCE"},
    {"home distance", "HOME_DISTANCE"},
    {"random", "RANDOM"},
    {"confidence", "TARGET_CONFIDENCE"},
    {"allies", "ALLIES"},
    {"foes", "FOES"},
    {"time of day", "TIME_OF_DAY"},
    {"leads", "LEADS"},
}};
static_assert(kOwnSenseNames.back().text != nullptr, "each has its names");

}  // namespace

std::vector<std::string> sense_names(const Brain& brain) {
    std::vector<std::string> names;
    for (const OwnSense& sense : kOwnSenseNames) {
        names.emplace_back(sense.text);
    }
    if (brain.perception.given) {
        names[kSensePlayerDistance] = "target distance";
    }
    append_senses_of_brain(brain, names);
    return names;
}

std::vector<std::string> config_sense_names(const Brain& brain) {
    std::vector<std::string> names;
    for (const OwnSense& sense : kOwnSenseNames) {
        names.emplace_back(sense.in_config);
    }
    append_senses_of_brain(brain, names);
    return names;
}

}  // namespace zoned::ai
