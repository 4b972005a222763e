// The report of zoned-bench in a real browser.
#include "tests/browser/browser.h"
#include "tests/integration/process/fixture.h"
#include "tests/unit/json_reader.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <sstream>

namespace zoned::testing_browser {
namespace {

using testing_process::Child;
using testing_process::kPatience;
using testing_process::read;
using testing_process::scratch_folder;

/// A row of the JSON that the same run wrote.
struct JsonRow {
    std::string figure;  ///< rows of one figure have the same
    std::string method;
    bool peer = false;
    bool curve = false;
    double time = 0.0;
    double error = 0.0;
    bool has_unit = false;
    bool has_bytes = false;
};

double number_in(const json_text::Struct& metrics, const std::string& name) {
    double value = std::numeric_limits<double>::quiet_NaN();
    json_text::for_each_field(metrics, [&](const std::string& key, const json_text::Value& v) {
        value = key == name ? v.number_value() : value;
    });
    return value;
}

JsonRow row_of(const json_text::Struct& row) {
    using json_text::field;
    JsonRow out;
    const json_text::Struct metrics = field(row, "metrics").struct_value();
    const double steps = number_in(metrics, "steps_per_s");
    std::string parameter = field(row, "parameter").string_value();
    out.curve = !std::isnan(steps) || !std::isnan(number_in(metrics, "updates_per_s"));
    if (out.curve) {
        const std::size_t blank = parameter.find(' ');
        parameter = blank == std::string::npos ? "" : parameter.substr(blank);
    }
    out.figure = field(row, "suite").string_value() + "|" + field(row, "scene").string_value() +
                 "|" + parameter + "|" + field(row, "error_unit").string_value();
    out.peer = !field(row, "peer").string_value().empty();
    out.method = field(row, "peer").string_value() + "/" + field(row, "method").string_value();
    out.time = field(row, "time_us_p50").number_value() * (std::isnan(steps) ? 1.0 : steps);
    const json_text::Value error = field(row, "error");
    out.error = error.kind_case() == json_text::Value::kNumberValue
                    ? std::abs(error.number_value())
                    : std::numeric_limits<double>::infinity();
    out.has_unit = !field(row, "error_unit").string_value().empty();
    out.has_bytes = number_in(metrics, "bytes_per_s") > 0.0;
    return out;
}

struct Counts {
    int scenes = 0;
    int ours = 0;
    int any = 0;
};

/// The page's claims, computed from the JSON by comparing each row with each other.
struct Expected {
    std::size_t plots = 0;
    Counts peers;
    Counts all;
    std::size_t behind = 0;
};

bool is_near_front(const JsonRow& row, const std::vector<JsonRow>& rows) {
    return std::none_of(rows.begin(), rows.end(), [&row](const JsonRow& other) {
        return other.error <= row.error && other.time * 1.05 < row.time;
    });
}

Expected expected_of(const std::string& json) {
    const json_text::Struct top = json_text::parse(json);
    std::map<std::string, std::vector<JsonRow>> figures;
    std::set<std::string> plots;
    const json_text::Value list = json_text::field(top, "rows");
    for (const json_text::Value& value : list.list_value().values()) {
        const JsonRow row = row_of(value.struct_value());
        plots.insert("time|" + row.figure);
        if (std::isfinite(row.error) && row.time > 0.0) {
            if (row.curve) {
                plots.insert("along|" + row.figure);
            }
            if (row.method != "/threads_2") {  // not compared: a second thread helps it
                figures[row.figure].push_back(row);
            }
        }
        if (row.has_bytes) {
            plots.insert("bytes|" + row.figure);
        }
    }
    Expected expected;
    expected.plots = plots.size();
    for (const auto& [name, rows] : figures) {
        std::set<std::string> methods;
        bool peer = false;
        bool has_default = false;
        bool default_on = false;
        bool own_on = false;
        for (const JsonRow& row : rows) {
            methods.insert(row.method);
            peer = peer || row.peer;
            const bool ours = row.method == "/default";
            has_default = has_default || ours;
            default_on = default_on || (ours && is_near_front(row, rows));
            own_on = own_on || (!row.peer && is_near_front(row, rows));
        }
        if (!has_default || methods.size() < 2 || !rows[0].has_unit) {
            continue;
        }
        for (Counts* counts : {&expected.all, peer ? &expected.peers : nullptr}) {
            if (counts != nullptr) {
                ++counts->scenes;
                counts->ours += default_on ? 1 : 0;
                counts->any += own_on ? 1 : 0;
            }
        }
        expected.behind += default_on ? 0 : 1;
    }
    return expected;
}

class Report : public ::testing::Test {
  protected:
    /// One report, which all look at: ctest runs the suite in one process.
    static void SetUpTestSuite() {
        page = scratch_folder() + "/bench.html";
        json = scratch_folder() + "/bench.json";
        Child bench("zoned-bench",
                    {"physics",
                     "integrators",
                     "replication",
                     "decisions",
                     "--quick",
                     "--scene",
                     "S2,S5,S7,kepler,dead_reckoning,fuzzy_sugeno,fuzzy_mamdani",
                     "--json",
                     json,
                     "--report",
                     page});
        ASSERT_EQ(bench.wait(4 * kPatience), 0) << bench.errors();
    }

    void SetUp() override {
        ASSERT_TRUE(has_browser()) << "chromium is not installed (config/packages.txt)";
        browser = std::make_unique<Browser>();
        browser->open("file://" + page);
        ASSERT_TRUE(browser->wait_until("window.zonedReport !== undefined"));
    }

    void expect_no_errors() const {
        for (const std::string& error : browser->errors()) {
            ADD_FAILURE() << error;
        }
    }

    [[nodiscard]] std::string text_of(const std::string& id) const {
        return browser->evaluate("document.getElementById('" + id + "').textContent");
    }

    void expect_counts(const std::string& id, const Counts& counts) const {
        EXPECT_EQ(text_of(id + "-scenes"), std::to_string(counts.scenes));
        EXPECT_EQ(text_of(id + "-default"), std::to_string(counts.ours));
        EXPECT_EQ(text_of(id + "-own"), std::to_string(counts.any));
    }

    inline static std::string page;
    inline static std::string json;
    std::unique_ptr<Browser> browser;
};

TEST_F(Report, ShowsEachPlotAndTheNumbersOfItsJson) {
    const Expected expected = expected_of(read(json));
    EXPECT_GE(expected.peers.scenes, 5);
    EXPECT_EQ(browser->evaluate("document.querySelectorAll('canvas').length"),
              std::to_string(expected.plots));
    EXPECT_EQ(browser->evaluate("zonedReport.charts.length"), std::to_string(expected.plots));
    expect_counts("peers", expected.peers);
    expect_counts("all", expected.all);
    EXPECT_EQ(browser->evaluate("document.querySelectorAll('#behind tbody tr').length"),
              std::to_string(expected.behind));
    // Every plot has marks, and is drawn where it is looked for.
    EXPECT_EQ(browser->evaluate("performance.getEntriesByName('first-plot').length"), "1");
    RecordProperty("first_plot_ms",
                   browser->evaluate("performance.getEntriesByName('first-plot')[0].startTime"));
    EXPECT_EQ(
        browser->evaluate(
            "zonedReport.charts.filter((c) => c.series.length === 0 || "
            "(zonedReport.chartFor(c.id), (() => { const canvas = "
            "document.getElementById(c.id).querySelector('canvas'); const p = "
            "canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data; return "
            "!p.some((v, i) => i % 4 === 3 && v > 0); })())).map((c) => c.id).join()"),
        "");
    EXPECT_LE(std::filesystem::file_size(page), 2'000'000U);
    expect_no_errors();
}

TEST_F(Report, StandsInTablesBesideItsPlots) {
    EXPECT_EQ(browser->evaluate(
                  "[...document.querySelectorAll('.figure')].filter((f) => !f.querySelector("
                  "'canvas[role=img][aria-label]') || f.querySelectorAll('tbody tr').length === 0 "
                  "|| f.querySelectorAll('th[scope=col]').length === 0).length"),
              "0");
    // Marks of a plot and numbers of its table are the same.
    EXPECT_EQ(
        browser->evaluate(
            "zonedReport.charts.filter((c) => { const shown = new "
            "Set([...document.querySelectorAll("
            "`[aria-labelledby='h-${c.id}'] tbody tr td:first-child`)].map((t) => t.textContent)"
            ".filter((t) => t !== '')); const drawn = new Set(c.series.flatMap((s) => s.points.map("
            "(p) => String(p.n)))); return shown.size !== drawn.size || [...drawn].some((n) => "
            "!shown.has(n)); }).length"),
        "0");
    EXPECT_EQ(browser->evaluate("new Set([...document.querySelectorAll('[id]')].map((e) => e.id))"
                                ".size === document.querySelectorAll('[id]').length"),
              "true");
}

/// Contrast of text and back by WCAG 2.1, of an element.
std::string contrast_of(const std::string& selector) {
    return "(() => { const rgb = (c) => c.match(/[\\d.]+/g).slice(0, 3).map((v) => { const s = v / "
           "255; return s <= 0.03928 ? s / 12.92 : ((s + 0.055) / 1.055) ** 2.4; }); const light = "
           "(c) => { const [r, g, b] = rgb(c); return 0.2126 * r + 0.7152 * g + 0.0722 * b; }; "
           "const a = light(getComputedStyle(document.querySelector('" +
           selector +
           "')).color); const b = light(getComputedStyle(document.body).backgroundColor); return "
           "(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05); })()";
}

TEST_F(Report, IsReadInBothThemes) {
    std::set<std::string> backs;
    std::set<std::string> marks;
    for (const bool dark : {false, true}) {
        browser->set_dark(dark);
        EXPECT_TRUE(browser->wait_until("document.documentElement.dataset.theme === '" +
                                        std::string(dark ? "dark" : "light") + "'"));
        backs.insert(browser->evaluate("getComputedStyle(document.body).backgroundColor"));
        marks.insert(browser->evaluate(
            "zonedReport.chartFor(zonedReport.charts[0].id).data.datasets[0].borderColor"));
        for (const char* selector : {"body", ".summary-text", ".command", "a", ".bad"}) {
            EXPECT_GE(std::stod(browser->evaluate(contrast_of(selector))), 4.5) << selector << dark;
        }
        browser->screenshot(scratch_folder() + (dark ? "/dark.png" : "/light.png"));
    }
    EXPECT_EQ(backs.size(), 2U);
    EXPECT_EQ(marks.size(), 2U);
    // Roles differ in shape, not in colour alone.
    EXPECT_EQ(browser->evaluate(
                  "(() => { const c = zonedReport.charts.find((f) => new Set(f.series.map((s) => "
                  "s.role)).size === 3); return new Set(zonedReport.chartFor(c.id).data.datasets"
                  ".filter((d) => !d.front).map((d) => d.pointStyle)).size; })()"),
              "3");
    expect_no_errors();
}

TEST_F(Report, IsWalkedByKeys) {
    // The first three stops of Tab: to the summary, the theme, the contents.
    browser->press("Tab", 9);
    EXPECT_EQ(browser->evaluate("document.activeElement.className"), "skip");
    browser->press("Tab", 9);
    EXPECT_EQ(browser->evaluate("document.activeElement.id"), "theme");
    const std::string before = browser->evaluate("document.documentElement.dataset.theme");
    browser->press("Enter", 13);
    EXPECT_NE(browser->evaluate("document.documentElement.dataset.theme"), before);
    browser->press("Tab", 9);
    EXPECT_EQ(browser->evaluate("document.activeElement.hash"), "#summary");
    // A plot's points by rising error.
    browser->evaluate("document.querySelector('canvas').focus()");
    const std::string announced = "document.getElementById('announcer').textContent";
    const auto error_of_next = [&](const std::string& key) {
        browser->press(key, key == "ArrowRight" ? 39 : key == "Home" ? 36 : 27);
        return browser->evaluate(announced);
    };
    const std::string first = error_of_next("ArrowRight");
    EXPECT_THAT(first, testing::HasSubstr(" us; front: "));
    const std::string second = error_of_next("ArrowRight");
    EXPECT_NE(first, second);
    const auto number = [](const std::string& text) {
        std::istringstream in(text.substr(text.find("error, ") + 7));
        std::string unit;
        double value = -1.0;
        in >> unit >> value;
        return value;
    };
    EXPECT_LE(number(first), number(second)) << first << " / " << second;
    EXPECT_EQ(error_of_next("Home"), first);
    EXPECT_EQ(error_of_next("Escape"), "");
    expect_no_errors();
}

TEST_F(Report, PrintsInLightWithAllPlots) {
    browser->set_dark(true);
    EXPECT_TRUE(browser->wait_until("document.documentElement.dataset.theme === 'dark'"));
    browser->evaluate("dispatchEvent(new Event('beforeprint'))");
    EXPECT_EQ(browser->evaluate("document.documentElement.dataset.theme"), "light");
    EXPECT_EQ(browser->evaluate("zonedReport.drawn.size === zonedReport.charts.length"), "true");
    browser->evaluate("dispatchEvent(new Event('afterprint'))");
    EXPECT_EQ(browser->evaluate("document.documentElement.dataset.theme"), "dark");
    expect_no_errors();
}

}  // namespace
}  // namespace zoned::testing_browser
