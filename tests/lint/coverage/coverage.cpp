#include "tests/lint/coverage/coverage.h"

#include "tests/lint/coverage/config_setting.h"
#include "tests/lint/text.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace zoned::lint {

namespace {

constexpr std::size_t kStateCells = 3;
constexpr std::size_t kItemCells = 7;
const std::string kAll = "all";  ///< the head counts them too

/// Without blanks and code marks at both ends.
std::string_view bare(std::string_view s) {
    const std::size_t begin = s.find_first_not_of(" \t\r`");
    return begin == std::string_view::npos
               ? std::string_view()
               : s.substr(begin, s.find_last_not_of(" \t\r`") - begin + 1);
}

std::vector<std::string_view> split(std::string_view text, char at) {
    std::vector<std::string_view> parts;
    while (true) {
        const std::size_t end = text.find(at);
        parts.push_back(bare(text.substr(0, end)));
        if (end == std::string_view::npos) {
            return parts;
        }
        text.remove_prefix(end + 1);
    }
}

/// The names of a cell, with commas between them.
std::vector<std::string> names_in(std::string_view cell) {
    std::vector<std::string> names;
    for (const std::string_view name : split(cell, ',')) {
        if (!name.empty()) {
            names.emplace_back(name);
        }
    }
    return names;
}

std::optional<int> number_in(std::string_view text) {
    int number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size() ? std::optional(number)
                                                                    : std::nullopt;
}

std::string as_code(std::string_view text) {
    return "`" + std::string(text) + "`";
}

/// A count of the head.
struct Count {
    int line = 0;
    std::string what;  ///< a state, or kAll
    int items = 0;
};

/// Reads a page and goes over its rows; one object for one check.
class CoverageCheck {
  public:
    CoverageCheck(const SourceFile& page, const CoverageFacts& facts)
        : page_(page),
          facts_(facts) {}

    std::vector<Finding> run(const ItemNumbers& numbers) {
        read();
        for (const CoverageRow& row : rows_) {
            check_state(row);
            check_worlds(row);
            check_tests(row);
        }
        check_numbers(numbers);
        check_counts();
        std::sort(findings_.begin(), findings_.end(), [](const Finding& a, const Finding& b) {
            return a.line < b.line;
        });
        return std::move(findings_);
    }

  private:
    void find(int line, std::string what) {
        findings_.push_back({page_.path, line, std::move(what)});
    }

    void find(const CoverageRow& row, const std::string& what) {
        find(row.line, "item " + std::to_string(row.number) + ": " + what);
    }

    void read() {
        int line = 0;
        for (std::string_view text : lines_of(page_.text)) {
            ++line;
            text = bare(text);
            if (!text.starts_with('|')) {
                continue;
            }
            if (text.size() < 2 || !text.ends_with('|')) {
                find(line, "a row of a table begins and ends with |");
                continue;
            }
            read_row(line, split(text.substr(1, text.size() - 2), '|'));
        }
    }

    void read_row(int line, const std::vector<std::string_view>& cells) {
        const std::string_view first = cells[0];
        if (first == "number" || first == "state" || first.starts_with("---")) {
            return;
        }
        if (cells.size() == kStateCells) {
            if (const std::optional<int> items = number_in(cells[2])) {
                counts_.push_back({line, std::string(first), *items});
            } else {
                find(line, as_code(cells[2]) + " is no number of items");
            }
        } else if (cells.size() != kItemCells) {
            find(line,
                 "a row of " + std::to_string(cells.size()) + " cells: an item has " +
                     std::to_string(kItemCells) + ", a state " + std::to_string(kStateCells));
        } else if (const std::optional<int> number = number_in(first); !number) {
            find(line, as_code(first) + " is no number of an item");
        } else {
            rows_.push_back({line,
                             *number,
                             std::string(cells[1]),
                             std::string(cells[2]),
                             names_in(cells[3]),
                             names_in(cells[4]),
                             names_in(cells[5]),
                             std::string(cells[6])});
        }
    }

    /// A row of a state has things to say, and no place for others.
    void check_state(const CoverageRow& row) {
        if (row.item.empty()) {
            find(row, "has no name");
        }
        if (row.state.size() != 1 || kCoverageStates.find(row.state) == std::string_view::npos) {
            find(row, as_code(row.state) + " is no state");
            return;
        }
        const char state = row.state[0];
        const bool happens = state == 'x' || state == 's' || state == 'p';
        if (state == 'x' && row.worlds.empty()) {
            find(row, "names no world in which it happens");
        }
        if (state != 'x' && state != 'p' && !row.worlds.empty()) {
            find(row, "names a world, in which nothing of it happens");
        }
        if ((state == 'x' || state == 's') && row.settings.empty()) {
            find(row, "names no setting");
        }
        if (!happens && !row.settings.empty()) {
            find(row, "names a setting, of which it has none");
        }
        if ((happens || state == 'l') == row.tests.empty()) {
            find(row, row.tests.empty() ? "names no test" : "names a test of what is not there");
        }
        if (state != 'x' && state != 's' && row.remark.empty()) {
            find(row, "does not say what is missing");
        }
    }

    void check_worlds(const CoverageRow& row) {
        std::vector<ConfigSetting> settings;
        for (const std::string& name : row.settings) {
            if (name.find(' ') != std::string::npos) {
                check_command(row, name);
                continue;
            }
            ConfigSetting setting;
            if (const std::string why = read_setting(name, setting); !why.empty()) {
                find(row, as_code(name) + " is no setting: " + why);
                return;
            }
            settings.push_back(std::move(setting));
        }
        for (const std::string& name : row.worlds) {
            const auto world = facts_.worlds.find(name);
            if (world == facts_.worlds.end()) {
                find(row, "there is no world config/" + name + ".txtpb");
            } else {
                check_uses(row, name, world->second, settings);
            }
        }
        if (row.state == "s" && !settings.empty()) {
            check_unused(row, settings);
        }
    }

    /// A command or option of a program: `zoned check`, `client-sim --view`.
    void check_command(const CoverageRow& row, std::string_view command) {
        const std::vector<std::string_view> words = split(command, ' ');
        const auto program = facts_.programs.find(std::string(words[0]));
        if (program == facts_.programs.end()) {
            find(row, "there is no program " + as_code(words[0]));
            return;
        }
        for (std::size_t i = 1; i < words.size(); ++i) {
            const std::string literal = "\"" + std::string(words[i]);
            if (program->second.find(literal + "\"") == std::string::npos &&
                program->second.find(literal + ",") == std::string::npos) {
                find(row, program->first + " has no " + as_code(words[i]));
            }
        }
    }

    void check_uses(const CoverageRow& row,
                    const std::string& name,
                    const proto::config::Config& world,
                    const std::vector<ConfigSetting>& settings) {
        for (const ConfigSetting& setting : settings) {
            if (use_of(world, setting) == SettingUse::kNone) {
                find(row, "config/" + name + ".txtpb does not use " + as_code(text_of(setting)));
            }
        }
    }

    void check_unused(const CoverageRow& row, const std::vector<ConfigSetting>& settings) {
        for (const auto& [name, world] : facts_.worlds) {
            const bool used = std::all_of(settings.begin(), settings.end(), [&](const auto& s) {
                return use_of(world, s) == SettingUse::kWritten;
            });
            if (used) {
                find(row, "config/" + name + ".txtpb uses it: its state is x");
            }
        }
    }

    [[nodiscard]] static std::string text_of(const ConfigSetting& setting) {
        std::string text;
        for (const auto* field : setting.path) {
            text += (text.empty() ? "" : ".") + field->name();
        }
        return setting.value.empty() ? text : text + "=" + setting.value;
    }

    void check_tests(const CoverageRow& row) {
        constexpr std::string_view kBench = "zoned-bench ";
        for (const std::string& name : row.tests) {
            if (name.starts_with(kBench)) {
                if (!facts_.benchmarks.contains(name.substr(kBench.size()))) {
                    find(row, "there is no benchmark " + as_code(name));
                }
            } else if (!has_test(name)) {
                find(row, "there is no test " + as_code(name));
            }
        }
    }

    [[nodiscard]] bool has_test(const std::string& name) const {
        if (!name.ends_with('*')) {
            return facts_.tests.contains(name);
        }
        // A star for the suite's own name would fit whatever begins alike.
        const std::string begin = name.substr(0, name.size() - 1);
        const auto at = facts_.tests.lower_bound(begin);
        return begin.find('.') != std::string::npos && at != facts_.tests.end() &&
               at->starts_with(begin);
    }

    void check_numbers(const ItemNumbers& numbers) {
        std::map<int, int> line_of;
        for (const CoverageRow& row : rows_) {
            const bool wanted =
                std::any_of(numbers.begin(), numbers.end(), [&row](const auto& range) {
                    return range.first <= row.number && row.number <= range.second;
                });
            if (!wanted) {
                find(row, "is none of this table");
            }
            if (const auto [at, first] = line_of.try_emplace(row.number, row.line); !first) {
                find(row, "stands in line " + std::to_string(at->second) + " already");
            }
        }
        for (const auto& [from, to] : numbers) {
            for (int number = from; number <= to; ++number) {
                if (!line_of.contains(number)) {
                    find(0, "item " + std::to_string(number) + " is missing");
                }
            }
        }
    }

    void check_counts() {
        std::map<std::string, int> items{{kAll, static_cast<int>(rows_.size())}};
        for (const char state : kCoverageStates) {
            items[std::string(1, state)] = 0;
        }
        for (const CoverageRow& row : rows_) {
            if (const auto at = items.find(row.state); at != items.end() && row.state != kAll) {
                ++at->second;
            }
        }
        std::set<std::string> counted;
        for (const Count& count : counts_) {
            const auto at = items.find(count.what);
            if (at == items.end()) {
                find(count.line, as_code(count.what) + " is no state");
            } else if (at->second != count.items) {
                find(count.line,
                     "there are " + std::to_string(at->second) + " items of " +
                         as_code(count.what) + ", not " + std::to_string(count.items));
            }
            if (!counted.insert(count.what).second) {
                find(count.line, as_code(count.what) + " is counted twice");
            }
        }
        for (const auto& [what, number] : items) {
            if (!counted.contains(what)) {
                find(0, "the head does not count " + as_code(what));
            }
        }
    }

    const SourceFile& page_;
    const CoverageFacts& facts_;
    std::vector<CoverageRow> rows_;
    std::vector<Count> counts_;
    std::vector<Finding> findings_;
};

}  // namespace

void add_tests(std::string_view source, std::set<std::string>& tests) {
    const std::string code = code_of(source);
    const std::vector<Token> tokens = tokens_of(code);
    std::vector<std::string> names;
    std::vector<std::pair<std::string, std::string>> instances;  // suite, prefix
    for (std::size_t i = 0; i + 5 < tokens.size(); ++i) {
        if (tokens[i + 1].text != "(" || tokens[i + 3].text != ",") {
            continue;
        }
        const std::string first(tokens[i + 2].text);
        const std::string second(tokens[i + 4].text);
        const std::string_view macro = tokens[i].text;
        if (macro == "INSTANTIATE_TEST_SUITE_P") {
            instances.emplace_back(second, first);
        } else if ((macro == "TEST" || macro == "TEST_F" || macro == "TEST_P") &&
                   !first.starts_with("DISABLED_") && !second.starts_with("DISABLED_")) {
            names.push_back(first + "." + second);
        }
    }
    for (const std::string& name : names) {
        tests.insert(name);
        for (const auto& [suite, prefix] : instances) {
            if (name.starts_with(suite + ".")) {
                tests.insert(prefix + "/" + name);
            }
        }
    }
}

void add_benchmarks(std::string_view source, std::set<std::string>& benchmarks) {
    constexpr std::string_view kMark = "const Registration ";
    const std::string code = code_of(source);
    for (std::size_t at = code.find(kMark); at != std::string::npos;
         at = code.find(kMark, at + 1)) {
        // Literals are blanks in the code, at the same places.
        const std::size_t open = source.find('"', at);
        const std::size_t close = source.find('"', open + 1);
        if (open < source.find(';', at) && close != std::string_view::npos) {
            benchmarks.emplace(source.substr(open + 1, close - open - 1));
        }
    }
}

std::vector<Finding> check_coverage(const SourceFile& page,
                                    const ItemNumbers& numbers,
                                    const CoverageFacts& facts) {
    return CoverageCheck(page, facts).run(numbers);
}

}  // namespace zoned::lint
