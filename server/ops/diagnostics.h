// Diagnostics: collects the mistakes of a config and knows where in the file each setting stands.
#pragma once

#include "server/ops/settings.h"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace zoned::ops {

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

    /// A mistake in the setting `path`; its place is that of the nearest enclosing setting that the
    /// file holds.
    void add(const std::string& path, const std::string& text);
    /// A mistake at a place that the parser named.
    void add_at(int line, int column, const std::string& path, const std::string& text);

    /// From now on add() is silent on lines that have a mistake already: what the checks of
    /// relations find there as well is most likely its consequence.
    void silence_reported_lines();

    [[nodiscard]] bool empty() const { return errors_.empty(); }

    [[nodiscard]] std::size_t size() const { return errors_.size(); }

    /// All mistakes in order of line and column, each once; those without a place come last.
    [[nodiscard]] std::vector<ConfigError> sorted() const;

  private:
    struct Place {
        int line = 0;
        int column = 0;
    };

    std::map<std::string, Place> places_;
    std::set<int> silenced_lines_;
    std::vector<ConfigError> errors_;
};

}  // namespace zoned::ops
