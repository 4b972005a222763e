#include "tests/stability/report.h"

#include "shared/core/json.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace zoned::stability {

namespace {

std::string number(double value) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.3g", value);
    return text.data();
}

/// The check with the least margin.
const Check* tightest(const Row& row) {
    const Check* found = nullptr;
    const auto share = [](const Check& c) {
        return c.bound > 0.0 ? c.value / c.bound : (c.good() ? 0.0 : 1.0e300);
    };
    for (const Check& check : row.checks) {
        if (!check.good()) {
            return &check;
        }
        if (found == nullptr || share(check) > share(*found)) {
            found = &check;
        }
    }
    return found;
}

std::string to_text(const Check& check) {
    return check.what + " " + number(check.value) + (check.good() ? " <= " : " > ") +
           number(check.bound);
}

std::vector<std::string> cells(const Row& row) {
    const Check* check = tightest(row);
    return {row.passed() ? "pass" : (row.fails_run() ? "FAIL" : "known"),
            row.name,
            row.parameter,
            std::to_string(row.steps),
            number(row.max_speed_mps),
            number(row.energy_share),
            number(row.depth_m),
            number(row.drift_m),
            std::to_string(row.quarantined),
            number(row.ms_per_step),
            check != nullptr ? to_text(*check) : ""};
}

/// " (speed_mps <= 90, ...)".
std::string bounds_text(const Row& row) {
    std::string text;
    for (const KnownBound& known : row.known_bounds) {
        text += (text.empty() ? " (" : ", ") + known.what + " <= " + number(known.bound);
    }
    return text.empty() ? text : text + ")";
}

void write_row(core::JsonWriter& json, const Row& row) {
    json.begin_object();
    json.field("name", row.name).field("parameter", row.parameter);
    json.field("passed", row.passed()).field("steps", row.steps);
    json.field("max_speed_mps", row.max_speed_mps).field("energy_share", row.energy_share);
    json.field("depth_m", row.depth_m).field("drift_m", row.drift_m);
    json.field("quarantined", row.quarantined).field("ms_per_step", row.ms_per_step);
    json.field("known", row.known).field("fails_run", row.fails_run());
    json.key("checks").begin_array();
    for (const Check& check : row.checks) {
        json.begin_object();
        json.field("what", check.what).field("value", check.value);
        json.field("bound", check.bound).field("good", check.good());
        json.end_object();
    }
    json.end_array();
    json.end_object();
}

}  // namespace

bool Row::passed() const {
    return std::all_of(checks.begin(), checks.end(), [](const Check& c) { return c.good(); });
}

bool Row::fails_run() const {
    return std::any_of(checks.begin(), checks.end(), [this](const Check& c) {
        const auto known_as = [&c](const KnownBound& k) {
            return k.what == c.what && c.value <= k.bound;
        };
        return !c.good() && std::none_of(known_bounds.begin(), known_bounds.end(), known_as);
    });
}

void Row::know(std::string reason, std::vector<KnownBound> bounds) {
    known = std::move(reason);
    known_bounds = std::move(bounds);
}

void Row::check(std::string what, double value, double bound) {
    checks.push_back({std::move(what), value, bound});
}

std::string to_table(const Results& results) {
    std::vector<std::vector<std::string>> lines{{"",
                                                 "name",
                                                 "parameter",
                                                 "steps",
                                                 "m/s max",
                                                 "energy",
                                                 "depth m",
                                                 "drift m",
                                                 "stopped",
                                                 "ms/step",
                                                 "tightest check"}};
    for (const Row& row : results.rows) {
        lines.push_back(cells(row));
    }
    std::vector<std::size_t> widths(lines.front().size(), 0);
    for (const auto& line : lines) {
        for (std::size_t c = 0; c < line.size(); ++c) {
            widths[c] = std::max(widths[c], line[c].size());
        }
    }
    std::string text;
    for (std::size_t i = 0; i < lines.size(); ++i) {
        std::string out;
        for (std::size_t c = 0; c < lines[i].size(); ++c) {
            out += lines[i][c] + std::string(widths[c] - lines[i][c].size() + 2, ' ');
        }
        out.erase(out.find_last_not_of(' ') + 1);
        text += out + "\n";
        if (i > 0 && !results.rows[i - 1].passed()) {
            for (const Check& check : results.rows[i - 1].checks) {
                text += check.good() ? "" : "      " + to_text(check) + "\n";
            }
        }
        if (i > 0 && !results.rows[i - 1].passed() && !results.rows[i - 1].known.empty()) {
            text += "      known: " + results.rows[i - 1].known + bounds_text(results.rows[i - 1]) +
                    "\n";
        }
    }
    return text;
}

std::string to_json(const Results& results) {
    core::JsonWriter json;
    json.begin_object();
    json.field("machine", results.machine).field("commit", results.commit);
    json.field("seed", results.seed).field("quick", results.quick);
    json.field("passed", std::none_of(results.rows.begin(), results.rows.end(), [](const Row& row) {
                   return row.fails_run();
               }));
    json.key("rows").begin_array();
    for (const Row& row : results.rows) {
        write_row(json, row);
    }
    json.end_array();
    json.end_object();
    return json.text() + "\n";
}

}  // namespace zoned::stability
