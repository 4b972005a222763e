#include "tests/bench/suite.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <utility>

namespace zoned::bench {

namespace {

std::vector<Suite>& registered() {
    static std::vector<Suite> suites;
    return suites;
}

bool holds(const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

bool Session::wants_scene(const std::string& scene) const {
    return scenes.empty() || holds(scenes, scene);
}

bool Session::wants_method(const std::string& method, const std::string& peer) const {
    if (methods.empty()) {
        return true;
    }
    return peer.empty() ? holds(methods, method)
                        : holds(methods, peer) || holds(methods, peer + "/" + method);
}

void Session::progress(const std::string& what) const {
    std::fprintf(stderr, "zoned-bench: %s\n", what.c_str());
}

void Session::add(std::vector<Row> rows) {
    std::move(rows.begin(), rows.end(), std::back_inserter(results.rows));
}

void Session::note(const std::string& text) {
    if (!holds(results.notes, text)) {
        results.notes.push_back(text);
    }
}

Registration::Registration(Suite suite) {
    registered().push_back(std::move(suite));
}

std::vector<Suite> all_suites() {
    std::vector<Suite> suites = registered();
    std::sort(suites.begin(), suites.end(), [](const Suite& a, const Suite& b) {
        return a.name < b.name;
    });
    return suites;
}

}  // namespace zoned::bench
