#include "tests/lint/check.h"

#include "tests/lint/layers.h"
#include "tests/lint/text.h"

#include <algorithm>
#include <cctype>
#include <iterator>

namespace zoned::lint {

namespace {

/// The layer of the folder that holds `path`: the longest entry that is a folder above it.
const Layer* layer_of(std::string_view path) {
    const Layer* found = nullptr;
    for (const Layer& layer : kLayers) {
        const bool inside = path.starts_with(layer.folder) && path.size() > layer.folder.size() &&
                            path[layer.folder.size()] == '/';
        if (inside && (found == nullptr || layer.folder.size() > found->folder.size())) {
            found = &layer;
        }
    }
    // server/ and client-sim/ themselves hold a main.cpp and nothing else.
    const bool top = found != nullptr && found->folder.find('/') == std::string_view::npos &&
                     found->side != Side::kShared;
    if (top && path.substr(found->folder.size()) != "/main.cpp") {
        return nullptr;
    }
    return found;
}

bool may_see(Side from, Side to) {
    return to == Side::kShared || from == to;
}

bool is_excepted(const Layer& from, std::string_view target) {
    return std::any_of(kSiblingExceptions.begin(), kSiblingExceptions.end(), [&](const auto& e) {
        return e.from == from.folder && target.starts_with(e.prefix);
    });
}

/// Why a file of layer `from` may not include `target` of the repository; empty: it may.
std::string layer_violation(const Layer& from, std::string_view target) {
    const Layer* to = layer_of(target);
    const std::string quoted = "\"" + std::string(target) + "\"";
    if (to == nullptr) {
        return "includes " + quoted +
               ", which lies in no folder of the layer table (write paths from the root)";
    }
    if (to->folder == from.folder || is_excepted(from, target)) {
        return {};
    }
    if (!may_see(from.side, to->side)) {
        return std::string(from.folder) + " must never include " + quoted + " of the other program";
    }
    if (to->row == from.row) {
        return std::string(from.folder) + " includes " + quoted + " of its sibling " +
               std::string(to->folder);
    }
    if (to->row > from.row) {
        return std::string(from.folder) + " includes " + quoted +
               ", which stands below it in the layer order";
    }
    // The clients see of the rows below proto only what is shared.
    return {};
}

/// Whether the included name is `prefix` itself or, for prefixes of folders and families, begins
/// with it: "asio" covers <asio.hpp> and <asio/ip/udp.hpp>, "thread" only <thread>.
bool names(std::string_view target, std::string_view prefix) {
    if (!target.starts_with(prefix)) {
        return false;
    }
    return target.size() == prefix.size() || prefix.back() == '/' || target[prefix.size()] == '.' ||
           target[prefix.size()] == '/';
}

std::string restriction_violation(const Layer& from,
                                  std::string_view path,
                                  std::string_view target) {
    for (const RestrictedInclude& restricted : kRestrictedIncludes) {
        if (from.row > restricted.last_row || !names(target, restricted.prefix)) {
            continue;
        }
        const bool allowed = std::any_of(
            restricted.allowed.begin(), restricted.allowed.end(), [&](std::string_view place) {
                return !place.empty() && path.starts_with(place);
            });
        if (!allowed) {
            return std::string(from.folder) + " must not include <" + std::string(target) + ">: " +
                   (restricted.last_row == kLastRow
                        ? "only " + std::string(restricted.allowed[0]) + " knows it"
                        : "it replays bit for bit, without network, logs, threads or a clock");
        }
    }
    return {};
}

bool has_word(std::string_view line, std::string_view word) {
    for (std::size_t at = line.find(word); at != std::string_view::npos;
         at = line.find(word, at + 1)) {
        const std::size_t end = at + word.size();
        const bool starts = at == 0 || !is_word_character(line[at - 1]);
        const bool stops = end == line.size() || !is_word_character(line[end]);
        if (starts && stops) {
            return true;
        }
    }
    return false;
}

}  // namespace

std::vector<Finding> check_includes(const SourceFile& file) {
    std::vector<Finding> findings;
    if (file.path.starts_with("tests/") || file.path.starts_with("docker/") ||
        file.path.starts_with("config/")) {
        return findings;
    }
    const bool source =
        file.path.ends_with(".h") || file.path.ends_with(".cpp") || file.path.ends_with(".cc");
    if (!source) {
        return findings;
    }
    const Layer* layer = layer_of(file.path);
    if (layer == nullptr) {
        return {{file.path, 0, "lies in no folder of the layer table"}};
    }
    for (const Include& include : includes_of(file.text)) {
        for (const std::string& what :
             {restriction_violation(*layer, file.path, include.target),
              include.quoted ? layer_violation(*layer, include.target) : std::string()}) {
            if (!what.empty()) {
                findings.push_back({file.path, include.line, what});
                break;
            }
        }
    }
    return findings;
}

std::vector<Finding> check_header(const SourceFile& file) {
    std::vector<Finding> findings;
    if (!file.path.ends_with(".h")) {
        return findings;
    }
    const std::vector<std::string_view> lines = lines_of(file.text);
    if (lines.empty() || !lines[0].starts_with("// ") || lines[0].size() < 8) {
        findings.push_back(
            {file.path, 1, "a header begins with a // comment that says what it is for"});
    }
    const auto first = std::find_if(lines.begin(), lines.end(), [](std::string_view line) {
        return !line.empty() && !line.starts_with("//");
    });
    if (first == lines.end() || *first != "#pragma once") {
        findings.push_back({file.path, 1, "#pragma once is missing after the opening comment"});
    }
    return findings;
}

std::vector<Finding> check_length(const SourceFile& file) {
    const bool limited = file.path.starts_with("server/") || file.path.starts_with("client-sim/") ||
                         file.path.starts_with("shared/");
    const std::size_t lines = lines_of(file.text).size();
    if (limited && lines > static_cast<std::size_t>(kMaxLines)) {
        return {{file.path,
                 kMaxLines + 1,
                 std::to_string(lines) + " lines; a file tells one story in at most " +
                     std::to_string(kMaxLines)}};
    }
    return {};
}

std::vector<Finding> check_words(const SourceFile& file) {
    // Written in two parts, so that this file passes its own check.
    static const std::string kWords[] = {
        "TO"
        "DO",
        "FIX"
        "ME",
        "XX"
        "X",
        "HA"
        "CK"};
    std::vector<Finding> findings;
    const std::vector<std::string_view> lines = lines_of(file.text);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        for (const std::string& word : kWords) {
            if (has_word(lines[i], word)) {
                findings.push_back(
                    {file.path, static_cast<int>(i) + 1, word + " marks unfinished work"});
            }
        }
    }
    return findings;
}

std::vector<Finding> check_sandbox(const SourceFile& file) {
    static constexpr std::string_view kPlaces[] = {
        "server/rules/", "client-sim/bot/", "proto/sandbox.proto", "tests/"};
    for (const std::string_view place : kPlaces) {
        if (file.path.starts_with(place)) {
            return {};
        }
    }
    std::vector<Finding> findings;
    const std::vector<std::string_view> lines = lines_of(file.text);
    for (std::size_t i = 0; i < lines.size(); ++i) {
        if (lines[i].find("sandbox.pb.h") != std::string_view::npos) {
            findings.push_back({file.path,
                                static_cast<int>(i) + 1,
                                "the sandbox game is known to its rules, the bots and tests only"});
        }
    }
    return findings;
}

std::vector<Finding> check_file(const SourceFile& file) {
    std::vector<Finding> all;
    for (const auto check :
         {check_includes, check_header, check_length, check_words, check_sandbox}) {
        std::vector<Finding> found = check(file);
        std::move(found.begin(), found.end(), std::back_inserter(all));
    }
    return all;
}

std::vector<Finding> check_top_level(const std::vector<std::string>& names) {
    std::vector<Finding> findings;
    for (const std::string& name : names) {
        const bool known = std::find(kTopLevel.begin(), kTopLevel.end(), name) != kTopLevel.end();
        // Build folders and what CMake writes for editors are not part of the repository.
        const bool built =
            name == "build" || name.starts_with("build-") || name == "compile_commands.json";
        if (!known && !built && !name.starts_with(".")) {
            findings.push_back({name, 0, "does not belong to the fixed top level"});
        }
    }
    return findings;
}

std::string to_text(const std::vector<Finding>& findings) {
    std::string text;
    for (const Finding& finding : findings) {
        text += finding.path + ":" + std::to_string(finding.line) + ": " + finding.what + "\n";
    }
    return text;
}

}  // namespace zoned::lint
