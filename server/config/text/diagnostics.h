// Diagnostics: collects the mistakes of a config and knows where in the file each setting stands.
#pragma once

#include "server/config/text/config_error.h"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace zoned::config {

/// Joins path components: "zones" + "zone", 2 -> "zones.zone[2]". An index below 0 is left out.
std::string join_path(const std::string& parent, const std::string& field, int index = -1);

/// Where settings stand, by path, and what is wrong with them.
class Diagnostics {
  public:
    /// Line and column count from 1.
    void set_place(const std::string& path, int line, int column);
    /// The setting was given by --set: it and what lies below it have no place in the file any
    /// more.
    void forget_place(const std::string& path);
    /// `made`, and what lies below it, was made of `origin`, which the file holds: mistakes there
    /// are reported as of the origin, once whatever else was made of it, with " (`as`)" at the end.
    void set_origin(const std::string& made, const std::string& origin, const std::string& as);

    /// A mistake in the setting `path`; its place is that of the nearest enclosing setting that the
    /// file holds.
    void add(const std::string& path, const std::string& text);
    /// A mistake at a place that the parser named.
    void add_at(int line, int column, const std::string& path, const std::string& text);

    /// From now on add() is silent on lines that have a mistake already: what the checks of
    /// relations find there as well is most likely its consequence.
    void silence_reported_lines();
    /// From now on add() is silent on the line on which `path` stands: the same, of a mistake
    /// elsewhere.
    void silence_line_of(const std::string& path);

    [[nodiscard]] bool empty() const { return errors_.empty(); }

    [[nodiscard]] std::size_t size() const { return errors_.size(); }

    /// All mistakes in order of line and column, each once; those without a place come last.
    [[nodiscard]] std::vector<ConfigError> sorted() const;

  private:
    struct FilePlace {
        int line = 0;
        int column = 0;
    };

    struct Origin {
        std::string path;
        std::string as;
    };

    /// The path in the file, and what to say of the way from there.
    [[nodiscard]] Origin origin_of(const std::string& path) const;

    std::map<std::string, FilePlace> places_;
    std::map<std::string, Origin> origins_;
    std::set<int> silenced_lines_;
    std::vector<ConfigError> errors_;
};

}  // namespace zoned::config
