// The cases' own checks are checked: each deliberate fault fails its own check.
#include "tests/stability/run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

namespace zoned::stability {
namespace {

/// The quick rows of a case.
std::vector<Row> rows_of(const std::string& name, Fault fault) {
    stability::Run run;
    run.quick = true;
    run.fault = fault;
    for (const Case& one : all_cases()) {
        if (one.name == name) {
            one.run(run);
        }
    }
    return run.results.rows;
}

/// Rows of that name that have that check, and how many of them fail it.
struct Verdict {
    int rows = 0;
    int failed = 0;
};

Verdict verdict(const std::vector<Row>& rows, const std::string& name, const std::string& what) {
    Verdict v;
    for (const Row& row : rows) {
        for (const Check& check : row.checks) {
            if ((name.empty() || row.name == name) && check.what == what) {
                ++v.rows;
                v.failed += check.good() ? 0 : 1;
            }
        }
    }
    return v;
}

struct Expected {
    const char* row;
    const char* check;
};

/// All rows with the check fail it under the fault.
void expect_found(const std::string& name, Fault fault, const std::vector<Expected>& expected) {
    const std::vector<Row> rows = rows_of(name, fault);
    for (const Expected& e : expected) {
        const Verdict v = verdict(rows, e.row, e.check);
        EXPECT_GT(v.rows, 0) << e.row << " " << e.check;
        EXPECT_EQ(v.failed, v.rows) << e.row << " " << e.check;
    }
}

TEST(StabilityCases, OfFiltersFindABodyThatFallsWrong) {
    const std::vector<Row> rows = rows_of("filter", Fault::kNan);
    EXPECT_EQ(verdict(rows, "", "not_finite").failed, verdict(rows, "", "not_finite").rows);
    expect_found("filter",
                 Fault::kFloor,
                 {{"filter-sleep", "depth_at_end_m"},
                  {"filter-flicker", "depth_at_end_m"},
                  {"filter-column", "depth_m"},
                  {"", "fall_error_m"}});
    expect_found("filter",
                 Fault::kEnergy,
                 {{"filter-flicker", "speed_mps"},
                  {"filter-column", "speed_mps"},
                  {"filter-crowds", "energy_share"}});
}

TEST(StabilityCases, OfMotorsFindJointsBeyondTheirLimits) {
    expect_found("motor",
                 Fault::kJoint,
                 {{"motor-hinge", "beyond_rad"},
                  {"motor-hinge", "joints_gone"},
                  {"motor-arm", "beyond_rad"},
                  {"motor-slider", "beyond_m"},
                  {"motor-piston", "beyond_m"},
                  {"motor-pair", "beyond_rad"}});
}

TEST(StabilityCases, OfMotorsFindWhatIsTooFastOrTooStrong) {
    expect_found("motor",
                 Fault::kEnergy,
                 {{"motor-hinge", "speed_mps"},
                  {"motor-arm", "speed_mps"},
                  {"motor-piston", "speed_mps"},
                  {"motor-pair", "speed_mps"},
                  {"motor-work", "excess_share"}});
    expect_found("motor",
                 Fault::kDrift,
                 {{"motor-hinge", "gap_m"}, {"motor-arm", "gap_m"}, {"motor-slider", "across_m"}});
    expect_found("motor", Fault::kMomentum, {{"motor-pair", "momentum_share"}});
}

TEST(StabilityCases, OfAnchorsFindWhatTheyLose) {
    expect_found("anchor", Fault::kJoint, {{"", "gap_m"}, {"", "gap_after_m"}});
    expect_found("anchor", Fault::kFloor, {{"", "sunk_m"}, {"anchor-jumps", "fall_error_m"}});
    expect_found("anchor",
                 Fault::kEscape,
                 {{"", "shift_m"}, {"", "slide_error_m"}, {"", "swing_error_share"}});
    expect_found("anchor", Fault::kEnergy, {{"", "speed_mps"}});
}

TEST(StabilityCases, OfHullsFindWhatIsNotItsPointsOrSinks) {
    expect_found("hull", Fault::kHull, {{"", "without_reason"}, {"", "misfit_m"}, {"", "unsound"}});
    expect_found("hull", Fault::kFloor, {{"", "sunk_m"}});
    expect_found("hull", Fault::kEnergy, {{"", "speed_at_end_mps"}, {"", "energy_share"}});
}

TEST(StabilityCases, OfCrowdsFindStepsThatTakeTooLong) {
    expect_found("crowd", Fault::kTime, {{"crowd", "step_ms"}});
}

}  // namespace
}  // namespace zoned::stability
