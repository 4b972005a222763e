#include "server/config/text/diagnostics.h"

#include <climits>

#include <algorithm>
#include <tuple>

namespace zoned::config {

namespace {

/// "a.b[2].c" -> "a.b[2]", "a.b[2]" -> "a.b", "a" -> "".
std::string enclosing(const std::string& path) {
    const std::size_t cut = path.find_last_of(".[");
    return cut == std::string::npos ? std::string() : path.substr(0, cut);
}

}  // namespace

std::string join_path(const std::string& parent, const std::string& field, int index) {
    std::string path = parent.empty() ? field : parent + "." + field;
    if (index >= 0) {
        path += "[" + std::to_string(index) + "]";
    }
    return path;
}

void Diagnostics::set_place(const std::string& path, int line, int column) {
    places_[path] = FilePlace{line, column};
}

void Diagnostics::forget_place(const std::string& path) {
    const auto below = [&](const std::string& other) {
        return other.size() > path.size() && other.compare(0, path.size(), path) == 0 &&
               (other[path.size()] == '.' || other[path.size()] == '[');
    };
    auto it = places_.lower_bound(path);
    while (it != places_.end() && it->first.compare(0, path.size(), path) == 0) {
        if (it->first == path || below(it->first)) {
            it = places_.erase(it);
        } else {
            ++it;
        }
    }
    places_[path] = FilePlace{};
}

void Diagnostics::set_origin(const std::string& made,
                             const std::string& origin,
                             const std::string& as) {
    origins_[made] = Origin{origin, as};
}

Diagnostics::Origin Diagnostics::origin_of(const std::string& path) const {
    Origin origin{path, {}};
    // An origin may itself have been made from another: follow all steps, but no ring.
    for (std::size_t step = 0; step < origins_.size(); ++step) {
        auto found = origins_.end();
        std::string at = origin.path;
        for (; !at.empty() && found == origins_.end(); at = enclosing(at)) {
            found = origins_.find(at);
            if (found != origins_.end()) {
                break;
            }
        }
        if (found == origins_.end()) {
            break;
        }
        origin.path = found->second.path + origin.path.substr(at.size());
        origin.as = origin.as.empty() ? found->second.as : origin.as;
    }
    return origin;
}

void Diagnostics::add(const std::string& path_of_mistake, const std::string& text_of_mistake) {
    const Origin origin = origin_of(path_of_mistake);
    const std::string& path = origin.path;
    const std::string& as = origin.as;
    std::string text = text_of_mistake;
    if (!as.empty()) {
        const std::string begin = text;
        const bool known = std::any_of(errors_.begin(), errors_.end(), [&](const auto& error) {
            return error.path == path && error.text.rfind(begin, 0) == 0;
        });
        if (known) {
            return;
        }
        text += " (" + as + ")";
    }
    FilePlace place;
    for (std::string at = path; !at.empty(); at = enclosing(at)) {
        const auto it = places_.find(at);
        if (it != places_.end()) {
            place = it->second;
            break;
        }
    }
    if (place.line != 0 && silenced_lines_.count(place.line) != 0) {
        return;
    }
    const bool said = std::any_of(errors_.begin(), errors_.end(), [&](const ConfigError& error) {
        return error.path == path && error.text == text;
    });
    if (!said) {
        errors_.push_back({place.line, place.column, path, text});
    }
}

void Diagnostics::add_at(int line, int column, const std::string& path, const std::string& text) {
    errors_.push_back({line, column, path, text});
}

void Diagnostics::silence_reported_lines() {
    for (const ConfigError& error : errors_) {
        silenced_lines_.insert(error.line);
    }
}

void Diagnostics::silence_line_of(const std::string& path) {
    const auto it = places_.find(path);
    if (it != places_.end() && it->second.line != 0) {
        silenced_lines_.insert(it->second.line);
    }
}

std::vector<ConfigError> Diagnostics::sorted() const {
    std::vector<ConfigError> errors = errors_;
    const auto line_of = [](const ConfigError& e) {
        return e.line == 0 ? INT_MAX : e.line;
    };
    std::stable_sort(errors.begin(), errors.end(), [&](const ConfigError& a, const ConfigError& b) {
        const int line_a = line_of(a);
        const int line_b = line_of(b);
        return std::tie(line_a, a.column) < std::tie(line_b, b.column);
    });
    errors.erase(std::unique(errors.begin(),
                             errors.end(),
                             [](const ConfigError& a, const ConfigError& b) {
                                 return std::tie(a.line, a.column, a.path, a.text) ==
                                        std::tie(b.line, b.column, b.path, b.text);
                             }),
                 errors.end());
    return errors;
}

}  // namespace zoned::config
