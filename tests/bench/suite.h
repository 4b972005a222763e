// Suites: how a benchmark registers itself, and the session that it is given to run.
#pragma once

#include "tests/bench/results.h"

#include <functional>
#include <string>
#include <vector>

namespace zoned::bench {

/// The session that the command line asks for; a suite reads it and adds its rows.
class Session {
  public:
    std::vector<std::string> scenes;   ///< empty: all
    std::vector<std::string> methods;  ///< names of methods or peers; empty: all
    int repeats = 3;                   ///< timed runs of each method, > 0
    bool pictures = false;             ///< a report is written: scenes may be drawn
    bool quick = false;                ///< cut every scene short: the suite ends within seconds
    Results results;

    [[nodiscard]] bool wants_scene(const std::string& scene) const;
    /// True where the method's name or its peer's is asked for.
    [[nodiscard]] bool wants_method(const std::string& method, const std::string& peer) const;
    /// A line about the current work, on standard error.
    void progress(const std::string& what) const;
    /// Appends rows.
    void add(std::vector<Row> rows);
    /// Something the reader of the table must know; kept once.
    void note(const std::string& text);
};

/// One file of tests/bench defines a suite and registers it by a constant of namespace scope:
///     const Registration kThis({"name", "what it measures", {"scene", ...}, {"method", ...},
///     run});
struct Suite {
    std::string name;
    std::string purpose;
    std::vector<std::string> scenes;
    std::vector<std::string> methods;  ///< peers as "peer/method"
    std::function<void(Session&)> run;
};

class Registration {
  public:
    explicit Registration(Suite suite);
};

/// All suites by name.
std::vector<Suite> all_suites();

}  // namespace zoned::bench
