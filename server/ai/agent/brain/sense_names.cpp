#include "server/ai/agent/brain/sense_names.h"

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

}  // namespace

std::vector<std::string> sense_names(const Brain& brain) {
    std::vector<std::string> names{"player distance",
                                   "home distance",
                                   "random",
                                   "confidence",
                                   "allies",
                                   "foes",
                                   "time of day",
                                   "leads"};
    if (brain.perception.given) {
        names[kSensePlayerDistance] = "target distance";
    }
    append_senses_of_brain(brain, names);
    return names;
}

std::vector<std::string> config_sense_names(const Brain& brain) {
    std::vector<std::string> names{"PLAYER_DISTANCE",
                                   "HOME_DISTANCE",
                                   "RANDOM",
                                   "TARGET_CONFIDENCE",
                                   "ALLIES",
                                   "FOES",
                                   "TIME_OF_DAY",
                                   "LEADS"};
    append_senses_of_brain(brain, names);
    return names;
}

}  // namespace zoned::ai
