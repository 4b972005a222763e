// Diagnostics: collects the mistakes of a config and knows the place of each setting in the file.
#pragma once

#include "server/config/text/config_error.h"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace zoned::config {

/// Joins path components: "zones" + "zone", 2 -> "zones.zone[2]". An index below 0 is left out.
std::string join_path(const std::string& parent, const std::string& field, int index = -1);

/// Places of settings by path, and the mistakes in them.
class Diagnostics {
  public:
    /// Line and column count from 1.
    void set_place(const std::string& path, int line, int column);
    /// The setting was given by --set: it and all settings below it have no place in the file any
    /// more.
    void forget_place(const std::string& path);
    /// `made`, and all below it, was made from `origin`, which the file holds. Mistakes there are
    /// reported as mistakes of the origin, once for all that was made from it, with " (`as`)" at
    /// the end.
    void set_origin(const std::string& made, const std::string& origin, const std::string& as);

    /// A mistake in the setting `path`; its place is that of the nearest enclosing setting that the
    /// file holds.
    void add(const std::string& path, const std::string& text);
    /// A mistake at a place that the parser named.
    void add_at(int line, int column, const std::string& path, const std::string& text);

    /// From now on add() is silent on lines that have a mistake already: further findings of the
    /// checks of relations are most likely its consequence.
    void silence_reported_lines();
    /// From now on add() is silent on the line of `path`: its mistake was reported elsewhere.
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

    /// The path in the file, and the text about what was made from it.
    [[nodiscard]] Origin origin_of(const std::string& path) const;

    std::map<std::string, FilePlace> places_;
    std::map<std::string, Origin> origins_;
    std::set<int> silenced_lines_;
    std::vector<ConfigError> errors_;
};

}  // namespace zoned::config
