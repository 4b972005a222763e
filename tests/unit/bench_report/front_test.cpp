#include "tests/bench/report/front.h"

#include "tests/bench/report/growth.h"
#include "tests/bench/report/page.h"
#include "tests/bench/report/results_reader.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace zoned::bench {
namespace {

Row row_with(const std::string& method, const std::string& peer, double time_us, double error) {
    Row row;
    row.suite = "s";
    row.scene = "a";
    row.method = method;
    row.peer = peer;
    row.time_us_p50 = time_us;
    row.error = error;
    row.error_unit = "m";
    return row;
}

TEST(Front, HoldsTheRowsThatNoneBeatsInBoth) {
    Results results;
    results.rows = {row_with("default", "", 10.0, 0.01),
                    row_with("exact", "", 40.0, -0.001),
                    row_with("default", "bullet", 5.0, 1.0),
                    row_with("slow", "bullet", 20.0, 0.02),
                    row_with("broken", "", 1.0, NAN),
                    row_with("untimed", "", 0.0, 0.0)};
    const std::vector<Figure> figures = figures_of(results);
    ASSERT_EQ(figures.size(), 1U);
    EXPECT_EQ(figures[0].points.size(), 4U);
    std::vector<std::string> names;
    for (const FigurePoint* point : front_of(figures[0])) {
        names.push_back(method_name(*point->row));
    }
    EXPECT_THAT(names, testing::ElementsAre("exact", "default", "bullet/default"));
    EXPECT_EQ(figures[0].points[3].factor, 2.0);
}

/// By brute force over random points, with ties: a factor of 1 is nobody's being faster and as
/// exact.
TEST(Front, AgreesWithBruteForce) {
    std::mt19937 random(3);
    std::uniform_int_distribution<int> grade(1, 12);
    for (int round = 0; round < 200; ++round) {
        Results results;
        for (int i = 0; i < 15; ++i) {
            results.rows.push_back(
                row_with("m" + std::to_string(i), "", grade(random), grade(random)));
        }
        const std::vector<Figure> figures = figures_of(results);
        for (const FigurePoint& point : figures.at(0).points) {
            const bool beaten =
                std::any_of(results.rows.begin(), results.rows.end(), [&point](const Row& other) {
                    return other.error <= point.error && other.time_us_p50 < point.time_us;
                });
            EXPECT_EQ(point.factor > 1.0, beaten);
        }
        for (const FigurePoint* point : front_of(figures[0])) {
            EXPECT_EQ(point->factor, 1.0);
        }
    }
}

TEST(Front, CountsScenesByWhoIsOnIt) {
    Results results;
    const auto add = [&results](const char* scene, Row row) {
        row.scene = scene;
        results.rows.push_back(row);
    };
    // The default within 5 % of the front; another of ours on it; a peer alone; no peer.
    add("near", row_with("default", "", 10.4, 0.1));
    add("near", row_with("default", "ode", 10.0, 0.1));
    add("ours", row_with("default", "", 30.0, 0.1));
    add("ours", row_with("fast", "", 10.0, 0.1));
    add("ours", row_with("default", "ode", 12.0, 0.1));
    add("theirs", row_with("default", "", 40.0, 0.1));
    add("theirs", row_with("default", "ode", 10.0, 0.05));
    add("alone", row_with("default", "", 40.0, 0.1));
    add("alone", row_with("fast", "", 80.0, 0.1));
    add("single", row_with("default", "", 40.0, 0.1));
    const std::vector<Figure> figures = figures_of(results);
    const std::vector<Standing> standings = standings_of(figures);
    const FrontCounts peers = count_fronts(standings, true);
    EXPECT_EQ(peers.scenes, 3);
    EXPECT_EQ(peers.default_on_front, 1);
    EXPECT_EQ(peers.own_on_front, 2);
    const FrontCounts all = count_fronts(standings, false);
    EXPECT_EQ(all.scenes, 4);
    EXPECT_EQ(all.default_on_front, 2);
    EXPECT_EQ(standings[1].beaten_by, "fast");
    EXPECT_EQ(standings[1].default_factor, 3.0);
    EXPECT_EQ(standings[2].beaten_by, "ode/default");
}

TEST(Front, LeavesOutRowsOfAnotherTask) {
    Results results;
    results.rows = {row_with("default", "", 10.0, 0.0), row_with("goal_field", "", 0.1, 0.0)};
    for (Row& row : results.rows) {
        row.suite = "navigation";
    }
    const std::vector<Figure> figures = figures_of(results);
    EXPECT_EQ(figures[0].points[0].factor, 1.0);
    EXPECT_FALSE(figures[0].points[1].aside.empty());
    EXPECT_TRUE(standings_of(figures).empty());
}

TEST(Figures, JoinCurvesWhateverTheFirstWordOfTheirParameter) {
    Results results;
    for (const int steps : {10, 20, 40}) {
        Row row = row_with("a", "", 0.5, steps == 10 ? INFINITY : 1.0 / steps);
        row.parameter = "dt=" + std::to_string(1.0 / steps) + " motion=walk";
        row.metric("steps_per_s", steps);
        results.rows.push_back(row);
    }
    const std::vector<Figure> figures = figures_of(results);
    ASSERT_EQ(figures.size(), 1U);
    EXPECT_EQ(figures[0].parameter, "motion=walk");
    EXPECT_EQ(figures[0].points.size(), 2U);
    EXPECT_EQ(figures[0].points[0].time_us, 10.0);  // of a simulated second
}

TEST(Figures, KeepErrorsOfOtherUnitsApart) {
    Results results;
    results.rows = {row_with("default", "", 10.0, 0.0), row_with("mesh", "", 1.0, 0.0)};
    results.rows[1].error_unit = "mean excess";
    EXPECT_EQ(figures_of(results).size(), 2U);
}

// The fit of n = 4 with residuals +1, -1, -1, +1 at x = 0, 1, 2, 3 (times 0.1) by hand: slope 2,
// standard error 0.1 sqrt(4 / 2 / 5), Student's 4.303.
TEST(Growth, FitsTheExponentWithItsInterval) {
    std::vector<SizedTime> times;
    const double residuals[] = {0.1, -0.1, -0.1, 0.1};
    for (int i = 0; i < 4; ++i) {
        times.push_back({std::exp(i), std::exp(2.0 * i + residuals[i])});
    }
    const PowerFit fit = fit_power(times);
    EXPECT_NEAR(fit.exponent, 2.0, 1e-9);
    EXPECT_NEAR(fit.high - fit.exponent, 4.303 * 0.1 * std::sqrt(4.0 / 2.0 / 5.0), 1e-3);
    EXPECT_NEAR(fit.exponent - fit.low, fit.high - fit.exponent, 1e-12);
}

// Of 400 intervals over noise, 95 % cover the exponent.
TEST(Growth, CoversTheExponentAsOftenAsItSays) {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0.0, 0.2);
    int covered = 0;
    for (int round = 0; round < 400; ++round) {
        std::vector<SizedTime> times;
        for (int i = 1; i <= 5; ++i) {
            times.push_back(
                {std::pow(10.0, i), std::exp(1.3 * std::log(10.0) * i + noise(random))});
        }
        const PowerFit fit = fit_power(times);
        covered += fit.low <= 1.3 && 1.3 <= fit.high ? 1 : 0;
    }
    EXPECT_NEAR(covered / 400.0, 0.95, 0.025);
}

TEST(Growth, NeedsThreeSizesOfAScene) {
    Results results;
    for (const int n : {10, 100, 1000}) {
        for (const char* rest : {"all move", "none moves"}) {
            Row row = row_with("default", "", 3.0 * n, 0.0);
            row.parameter = "n=" + std::to_string(n) + " " + rest;
            if (n != 1000 || std::string(rest) == "all move") {
                results.rows.push_back(row);
            }
        }
    }
    const std::vector<Growth> growths = growths_of(results);
    ASSERT_EQ(growths.size(), 1U);
    EXPECT_EQ(growths[0].parameter, "all move");
    EXPECT_NEAR(growths[0].series.at(0).fit.exponent, 1.0, 1e-9);
}

std::size_t count_of(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
        ++count;
    }
    return count;
}

TEST(Page, EscapesTextAndNamesMachineBuildAndCommands) {
    Results results;
    results.rows = {row_with("default", "", 10.0, 0.0), row_with("<m>", "", 1.0, 0.1)};
    results.rows[0].error_unit = results.rows[1].error_unit = "</script>";
    results.machine = "machine <1> & \"2\"";
    results.notes = {"note <1>"};
    results.flags = "-O2 -mavx";
    results.runs = {{"s", "outer", 1.0, 2, 0.0}};
    results.repeats = 4;
    results.quick = true;
    const std::string page = report_html(results, "zoned-bench --json <x>");
    EXPECT_THAT(page, testing::HasSubstr("machine &lt;1&gt; &amp; &quot;2&quot;"));
    EXPECT_THAT(page, testing::HasSubstr("note &lt;1&gt;"));
    EXPECT_THAT(page, testing::HasSubstr("-O2 -mavx"));
    EXPECT_THAT(page, testing::HasSubstr("zoned-bench --json &lt;x&gt;"));
    EXPECT_THAT(page, testing::HasSubstr("zoned-bench s --scene outer --repeat 4 --quick"));
    EXPECT_EQ(count_of(page, "</script>"), 3U) << "text of a row ends a script";
    EXPECT_EQ(count_of(page, "<canvas"), 1U);
    // One self-contained file: nothing is loaded.
    EXPECT_EQ(page.find(" src="), std::string::npos);
    EXPECT_EQ(page.find("<link"), std::string::npos);
}

TEST(Page, LeavesOutPicturesBeyondItsLimitAndSaysSo) {
    Results results;
    results.rows = {row_with("default", "", 10.0, 0.0)};
    results.pictures = {{"a", "small <1>", "<svg id=\"own\"></svg>"},
                        {"b", "large", "<svg>" + std::string(kLargestPage, ' ') + "</svg>"}};
    const std::string page = report_html(results, "");
    EXPECT_LE(page.size(), kLargestPage);
    EXPECT_THAT(page, testing::HasSubstr("small &lt;1&gt;"));
    EXPECT_THAT(page, testing::HasSubstr("<svg id=\"own\"></svg>"));
    EXPECT_THAT(page, testing::HasSubstr("1 pictures of scenes were left out"));
}

TEST(SummaryPicture, ShowsEachSceneWithAPeer) {
    Results results;
    results.rows = {row_with("default", "", 10.0, 0.0), row_with("default", "ode", 30.0, 0.0)};
    const std::string svg = summary_svg(results);
    EXPECT_THAT(svg,
                testing::HasSubstr("Of 1 scenes with a peer, our default is on the front of 1"));
    EXPECT_THAT(svg, testing::HasSubstr(">s: a</text>"));
    EXPECT_EQ(count_of(svg, "<circle"), 2U);  // one in the legend
}

}  // namespace
}  // namespace zoned::bench
