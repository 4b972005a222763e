#include "tests/stability/run.h"

#include <cstdio>
#include <iterator>
#include <utility>

namespace zoned::stability {

const std::vector<std::string>& fault_names() {
    static const std::vector<std::string> kNames{"none",
                                                 "nan",
                                                 "energy",
                                                 "floor",
                                                 "escape",
                                                 "drift",
                                                 "momentum",
                                                 "joint",
                                                 "time",
                                                 "hull",
                                                 "awake"};
    return kNames;
}

void Run::add(Row row) {
    progress((row.passed() ? "pass  " : (row.fails_run() ? "FAIL  " : "known ")) + row.name + " " +
             row.parameter);
    results.rows.push_back(std::move(row));
}

void Run::progress(const std::string& what) const {
    if (talk) {
        std::fprintf(stderr, "%s\n", what.c_str());
    }
}

std::vector<Case> all_cases() {
    std::vector<Case> all;
    for (auto* list : {&stack_cases,
                       &mass_cases,
                       &speed_cases,
                       &press_cases,
                       &world_cases,
                       &input_cases,
                       &filter_cases,
                       &motor_cases,
                       &anchor_cases,
                       &hull_cases,
                       &crowd_cases}) {
        std::vector<Case> cases = list();
        std::move(cases.begin(), cases.end(), std::back_inserter(all));
    }
    return all;
}

}  // namespace zoned::stability
