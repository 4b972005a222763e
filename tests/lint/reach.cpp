#include "tests/lint/reach.h"

#include "tests/lint/text.h"

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <string_view>

namespace zoned::lint {

namespace {

constexpr std::string_view kRegistered = "server/rules/";

bool is_kernel(std::string_view path) {
    return path.starts_with("kernels/") && path.ends_with(".cl");
}

/// How many words two names have in common at their beginnings.
std::size_t common_words(std::string_view a, std::string_view b) {
    std::size_t words = 0;
    while (!a.empty() && !b.empty()) {
        const std::string_view first = a.substr(0, a.find('_'));
        if (first != b.substr(0, b.find('_'))) {
            break;
        }
        ++words;
        a.remove_prefix(std::min(first.size() + 1, a.size()));
        b.remove_prefix(std::min(first.size() + 1, b.size()));
    }
    return words;
}

/// The words of a comment with one blank between them, wherever its lines end.
std::string words_of_comment(std::string_view comment) {
    std::string words;
    for (std::string_view line : lines_of(comment)) {
        line.remove_prefix(std::min(line.find_first_not_of("/ "), line.size()));
        words += line;
        words += ' ';
    }
    return words;
}

class Reach {
  public:
    explicit Reach(const std::vector<SourceFile>& files) {
        for (const SourceFile& file : files) {
            if (is_product(file.path) || is_kernel(file.path)) {
                texts_.emplace(file.path, file.text);
            }
        }
        for (const auto& [path, text] : texts_) {
            for (const Include& include : includes_of(text)) {
                if (include.quoted && texts_.contains(include.target)) {
                    includes_[path].push_back(include.target);
                }
            }
            name_kernels(path, text);
        }
        for (const auto& [path, text] : texts_) {
            if (path.ends_with(".cpp")) {
                for (const std::string_view header : headers_of(path)) {
                    sources_[header].push_back(path);
                }
            }
        }
        walk();
    }

    [[nodiscard]] std::vector<Finding> findings() const {
        std::vector<Finding> found;
        for (const auto& [path, text] : texts_) {
            const bool reached = reached_.contains(path);
            if (reached && says_so(path)) {
                found.push_back({std::string(path), 1, "a program reaches it: take the note out"});
            }
            if (!reached && !excepted(path)) {
                found.push_back({std::string(path), 0, "no program reaches it"});
            }
        }
        return found;
    }

  private:
    /// A source reaches the kernels whose paths it names.
    void name_kernels(std::string_view path, std::string_view text) {
        for (const auto& [kernel, unused] : texts_) {
            if (is_kernel(kernel) &&
                text.find('"' + std::string(kernel) + '"') != std::string_view::npos) {
                includes_[path].push_back(kernel);
            }
        }
    }

    [[nodiscard]] bool says_so(std::string_view path) const {
        const auto at = texts_.find(path);
        return at != texts_.end() &&
               words_of_comment(opening_comment(at->second)).find(kUnreachedNote) !=
                   std::string::npos;
    }

    /// A source is excepted with all headers that it belongs to.
    [[nodiscard]] bool excepted(std::string_view path) const {
        const std::vector<std::string_view> headers =
            path.ends_with(".cpp") ? headers_of(path) : std::vector<std::string_view>();
        return says_so(path) ||
               (!headers.empty() &&
                std::all_of(headers.begin(), headers.end(), [this](std::string_view header) {
                    return says_so(header);
                }));
    }

    [[nodiscard]] std::vector<std::string_view> headers_of(std::string_view source) const {
        const auto same = texts_.find(std::string(stem_of(source)) + ".h");
        if (same != texts_.end()) {
            return {same->first};
        }
        const auto at = includes_.find(source);
        if (at == includes_.end()) {
            return {};
        }
        std::vector<std::string_view> beside;
        std::size_t most = 0;
        for (const std::string_view header : at->second) {
            if (folder_of(header) != folder_of(source)) {
                continue;
            }
            const std::size_t words =
                common_words(name_of(stem_of(source)), name_of(stem_of(header)));
            if (words > most) {
                beside.clear();
                most = words;
            }
            if (words == most) {
                beside.push_back(header);
            }
        }
        return beside.empty() ? std::vector<std::string_view>{at->second.front()} : beside;
    }

    void walk() {
        std::vector<std::string_view> open{"server/main.cpp",
                                           "client-sim/main.cpp",
                                           "client-sim/library/zoned_client.cpp",
                                           "client-sim/web/web_client.cpp",
                                           "client-sim/library/godot/client_node.h"};
        for (const auto& [path, text] : texts_) {
            if (path.starts_with(kRegistered) && path.ends_with(".cpp")) {
                open.push_back(path);
            }
        }
        while (!open.empty()) {
            const std::string_view path = open.back();
            open.pop_back();
            if (!texts_.contains(path) || !reached_.insert(path).second) {
                continue;
            }
            for (const auto* next : {&includes_, &sources_}) {
                if (const auto at = next->find(path); at != next->end()) {
                    open.insert(open.end(), at->second.begin(), at->second.end());
                }
            }
        }
    }

    std::map<std::string_view, std::string_view, std::less<>> texts_;  // by path
    std::map<std::string_view, std::vector<std::string_view>> includes_;
    std::map<std::string_view, std::vector<std::string_view>> sources_;  // by header
    std::set<std::string_view> reached_;
};

}  // namespace

std::vector<Finding> check_reached(const std::vector<SourceFile>& files) {
    return Reach(files).findings();
}

}  // namespace zoned::lint
