#include "tests/bench/compare/judgement.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

namespace zoned::bench {
namespace {

constexpr int kSuites = 6;
constexpr int kScenes = 4;
constexpr int kMethods = 5;
constexpr int kRounds = 12;

/// A busy machine, as it slows a run and its rows: factors by which times grow.
struct Machine {
    std::mt19937 random;
    double run_noise = 0.03;    ///< of a whole run, heavy-tailed
    double row_noise = 0.04;    ///< of a row, heavy-tailed
    double drift = 0.0;         ///< growth of the logarithm from run to run
    double burst_chance = 0.0;  ///< of a suite of a run
    double burst = 0.0;         ///< added to the logarithm then
    double now = 0.0;
    std::student_t_distribution<double> tail{2.0};
    std::uniform_real_distribution<double> uniform{0.0, 1.0};

    double next_run() {
        now += drift;
        return now + run_noise * tail(random);
    }

    double next_suite() { return uniform(random) < burst_chance ? burst * uniform(random) : 0.0; }

    double next_row() { return row_noise * tail(random); }
};

Machine machine_with(unsigned seed) {
    Machine machine;
    machine.random.seed(seed);
    return machine;
}

using Plant = std::function<void(Row&)>;

Results run_on(Machine& machine, const Plant& plant, bool calibrated = true) {
    Results results;
    const double run = machine.next_run();
    for (int suite = 0; suite < kSuites; ++suite) {
        const double busy = run + machine.next_suite();
        for (int scene = 0; scene < kScenes; ++scene) {
            for (int method = 0; method < kMethods; ++method) {
                Row row;
                row.suite = "suite" + std::to_string(suite);
                row.scene = "scene" + std::to_string(scene);
                row.method = "method" + std::to_string(method);
                row.time_us_p50 = 10.0 * (1 + method) * std::exp(busy + machine.next_row());
                row.error = 0.01 * (1 + scene);
                row.error_unit = std::string("m");
                plant(row);
                results.rows.push_back(row);
            }
            // The kernel beside a scene sees most of what slows the machine, and noise of its own.
            const double seen = 0.8 * busy + 0.4 * machine.next_row();
            results.runs.push_back({"", "", 0.0, kMethods, calibrated ? std::exp(seen) : 0.0});
        }
    }
    return results;
}

void leave(Row&) {
}

std::vector<Block> blocks_on(Machine& machine, const Plant& plant) {
    std::vector<Block> blocks;
    for (int i = 0; i < kRounds; ++i) {
        Block block;
        const bool old_first = i % 2 == 0;
        const Plant outer = old_first ? Plant(leave) : plant;
        const Plant inner = old_first ? plant : Plant(leave);
        auto& outer_runs = old_first ? block.old_runs : block.new_runs;
        auto& inner_runs = old_first ? block.new_runs : block.old_runs;
        outer_runs[0] = run_on(machine, outer);
        inner_runs[0] = run_on(machine, inner);
        inner_runs[1] = run_on(machine, inner);
        outer_runs[1] = run_on(machine, outer);
        blocks.push_back(block);
    }
    return blocks;
}

std::vector<Finding> judged(Machine& machine, const Plant& plant) {
    return judge(samples_of(blocks_on(machine, plant)), Limits());
}

bool any_worse(const std::vector<Finding>& findings) {
    return std::any_of(
        findings.begin(), findings.end(), [](const Finding& f) { return is_worse(f.change); });
}

bool names(const std::vector<Finding>& findings, Change change, const std::string& name) {
    return std::any_of(findings.begin(), findings.end(), [&](const Finding& f) {
        return f.change == change && f.name == name;
    });
}

struct Noise {
    const char* name;
    void (*set)(Machine&);
};

class OnABusyMachine : public testing::TestWithParam<Noise> {
  protected:
    static Machine machine(unsigned seed) {
        Machine m = machine_with(seed);
        GetParam().set(m);
        return m;
    }
};

INSTANTIATE_TEST_SUITE_P(Judgement,
                         OnABusyMachine,
                         testing::Values(Noise{"HeavyTails",
                                               [](Machine&) {
                                               }},
                                         Noise{"Drift",
                                               [](Machine& m) {
                                                   m.drift = 0.02;
                                               }},
                                         Noise{"Bursts",
                                               [](Machine& m) {
                                                   m.burst_chance = 0.15;
                                                   m.burst = 0.6;
                                               }}),
                         [](const auto& of) { return std::string(of.param.name); });

TEST_P(OnABusyMachine, TheSameBuildRaisesAtMostTwoAlarmsInForty) {
    int alarms = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) {
        Machine m = machine(seed);
        alarms += any_worse(judged(m, leave)) ? 1 : 0;
    }
    EXPECT_LE(alarms, 2);
    RecordProperty("alarms", alarms);
}

TEST_P(OnABusyMachine, ASuiteThatIsATenthSlowerIsFoundNineteenTimesInTwenty) {
    int found = 0;
    int others = 0;
    for (unsigned seed = 101; seed <= 120; ++seed) {
        Machine m = machine(seed);
        const std::vector<Finding> findings =
            judged(m, [](Row& row) { row.time_us_p50 *= row.suite == "suite2" ? 1.10 : 1.0; });
        found += names(findings, Change::kSlower, "suite2") ? 1 : 0;
        others += std::any_of(findings.begin(),
                              findings.end(),
                              [](const Finding& f) {
                                  return is_worse(f.change) && !f.name.starts_with("suite2");
                              })
                      ? 1
                      : 0;
    }
    EXPECT_GE(found, 19);
    EXPECT_LE(others, 1);
    RecordProperty("found", found);
}

TEST_P(OnABusyMachine, ALossOfAccuracyOfATwentiethIsAlwaysNamed) {
    for (unsigned seed = 201; seed <= 220; ++seed) {
        Machine m = machine(seed);
        const std::vector<Finding> findings = judged(m, [](Row& row) {
            const bool planted =
                row.suite == "suite4" && row.scene == "scene1" && row.method == "method3";
            row.error *= planted ? -1.05 : 1.0;  // of either sign
        });
        EXPECT_TRUE(names(findings, Change::kLessAccurate, "suite4 scene1 method3")) << seed;
        EXPECT_EQ(std::count_if(findings.begin(),
                                findings.end(),
                                [](const Finding& f) { return f.change == Change::kLessAccurate; }),
                  1);
    }
}

TEST(Judgement, FindsASuiteThatIsFasterAndDoesNotCallItWorse) {
    Machine m = machine_with(7);
    const std::vector<Finding> findings =
        judged(m, [](Row& row) { row.time_us_p50 *= row.suite == "suite1" ? 0.7 : 1.0; });
    EXPECT_TRUE(names(findings, Change::kFaster, "suite1"));
    EXPECT_FALSE(any_worse(findings));
    const Finding& f = findings.front();
    EXPECT_LT(f.low, 0.7 * 1.02);
    EXPECT_GT(f.high, 0.7 * 0.98);
}

// A change of a quarter of the threshold, however sure, is a trifle.
TEST(Judgement, BearsTrifles) {
    Machine m = machine_with(8);
    m.run_noise = m.row_noise = 1e-4;
    EXPECT_FALSE(any_worse(judged(m, [](Row& row) { row.time_us_p50 *= 1.025; })));
    EXPECT_TRUE(any_worse(judged(m, [](Row& row) { row.time_us_p50 *= 1.10; })));
}

// Errors of threads differ from run to run: a tenth more is found, the same spread is not.
TEST(Judgement, TellsRandomErrorsApartByTheirRanks) {
    const auto randomly = [](double factor, unsigned seed) {
        auto random = std::make_shared<std::mt19937>(seed);
        return [factor, random](Row& row) {
            std::uniform_real_distribution<double> spread(0.97, 1.03);
            row.error *= factor * spread(*random);
        };
    };
    int alarms = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
        Machine m = machine_with(seed);
        std::vector<Block> blocks = blocks_on(m, leave);
        std::vector<Block> worse = blocks;
        const auto same = randomly(1.0, seed);
        const auto more = randomly(1.1, seed);
        for (std::size_t i = 0; i < blocks.size(); ++i) {
            for (std::size_t j = 0; j < 2; ++j) {
                std::for_each(
                    blocks[i].old_runs[j].rows.begin(), blocks[i].old_runs[j].rows.end(), same);
                std::for_each(
                    blocks[i].new_runs[j].rows.begin(), blocks[i].new_runs[j].rows.end(), same);
                worse[i].old_runs[j] = blocks[i].old_runs[j];
                std::for_each(
                    worse[i].new_runs[j].rows.begin(), worse[i].new_runs[j].rows.end(), more);
            }
        }
        alarms += any_worse(judge(samples_of(blocks), Limits())) ? 1 : 0;
        EXPECT_TRUE(names(
            judge(samples_of(worse), Limits()), Change::kLessAccurate, "suite0 scene0 method0"));
    }
    EXPECT_LE(alarms, 1);
}

TEST(Judgement, NamesErrorsThatStopBeingZeroOrFinite) {
    for (const double error : {1.0, std::numeric_limits<double>::quiet_NaN()}) {
        Machine m = machine_with(9);
        const std::vector<Block> blocks = blocks_on(m, [error](Row& row) {
            row.error = row.method == "method0" && row.scene == "scene0" ? error : row.error;
        });
        Samples samples = samples_of(blocks);
        for (RowSamples& row : samples.rows) {
            if (row.scene == "scene0" && error == 1.0) {
                std::fill(row.old_errors.begin(), row.old_errors.end(), 0.0);
            }
        }
        EXPECT_TRUE(
            names(judge(samples, Limits()), Change::kLessAccurate, "suite3 scene0 method0"));
    }
}

TEST(Judgement, NamesRowsThatAreGone) {
    Machine m = machine_with(10);
    std::vector<Block> blocks = blocks_on(m, leave);
    for (Block& block : blocks) {
        for (Results& run : block.new_runs) {
            run.rows.pop_back();
        }
        for (Results& run : block.old_runs) {
            run.rows.erase(run.rows.begin());
        }
    }
    const Samples samples = samples_of(blocks);
    EXPECT_THAT(samples.came, testing::ElementsAre("suite0 scene0 method0"));
    EXPECT_TRUE(names(judge(samples, Limits()), Change::kGone, "suite5 scene3 method4"));
}

TEST(Judgement, SaysHowManyBlocksASingleRowNeeds) {
    EXPECT_EQ(blocks_for_rows(120, 0.05), 13);  // 2^-13 * 120 * 3 < 0.05
    EXPECT_EQ(blocks_for_rows(1, 0.06), 6);
}

// Two files: scenes stand for repetitions, and a machine that slowed down between the runs is taken
// out by the calibration kernel.
TEST(JudgementOfSingleRuns, FindsAllSuitesSlowerButNotASlowerMachine) {
    Machine m = machine_with(11);
    m.run_noise = 0.0;
    m.row_noise = 0.02;
    const auto with_runs = [](Results results, double calibration_us) {
        results.runs.clear();
        for (int i = 0; i < kSuites * kScenes; ++i) {
            results.runs.push_back({"", "", 0.0, kMethods, calibration_us});
        }
        return results;
    };
    const auto slower = [](Row& row) {
        row.time_us_p50 *= 1.15;
    };
    const Results old_run = with_runs(run_on(m, leave), 100.0);
    EXPECT_FALSE(
        any_worse(judge_single(samples_of(old_run, with_runs(run_on(m, leave), 100.0)), Limits())));
    EXPECT_TRUE(any_worse(
        judge_single(samples_of(old_run, with_runs(run_on(m, slower), 100.0)), Limits())));
    EXPECT_FALSE(any_worse(
        judge_single(samples_of(old_run, with_runs(run_on(m, slower), 115.0)), Limits())));
    const Results worse = with_runs(
        run_on(m,
               [](Row& row) {
                   row.error *= row.scene == "scene2" && row.suite == "suite1" ? 1.05 : 1.0;
               }),
        100.0);
    EXPECT_TRUE(names(judge_single(samples_of(old_run, worse), Limits()),
                      Change::kLessAccurate,
                      "suite1 scene2 method0"));
}

}  // namespace
}  // namespace zoned::bench
