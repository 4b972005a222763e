// Suite `ants`: the MAX-MIN ant system on instances of TSPLIB, ten seeds each.
#include "server/ai/ants/max_min.h"
#include "server/ai/ants/tsp_text.h"
#include "tests/bench/cpu_clock.h"
#include "tests/bench/grid_scene.h"
#include "tests/bench/public_data.h"
#include "tests/bench/statistics.h"
#include "tests/bench/suite.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace zoned::bench {

namespace {

using ai::pathfinding::LocalSearch;
using ai::pathfinding::MaxMin;
using ai::pathfinding::MaxMinSettings;
using ai::pathfinding::TspInstance;

struct KnownInstance {
    const char* name;
    std::int64_t optimum;
};

constexpr KnownInstance kInstances[] = {{"berlin52", 7542},
                                        {"eil51", 426},
                                        {"kroA100", 21282},
                                        {"d198", 15780}};

/// PointsOfInterest that all tours of a run may visit together: what stops a run that does not find
/// the optimum. Counted, so that a run is the same everywhere.
constexpr std::uint64_t kVisitsAlone = 80'000'000;
constexpr std::uint64_t kVisitsWithSearch = 5'000'000;

struct AntMethod {
    const char* name;
    LocalSearch local;
};

constexpr AntMethod kAntMethods[] = {{"default", LocalSearch::kOrOpt},
                                     {"two_opt", LocalSearch::kTwoOpt},
                                     {"ants_alone", LocalSearch::kNone}};

std::optional<TspInstance> read_tsp(const std::string& name, std::string& why) {
    const std::string file = "/tsplib/" + name + ".tsp";
    std::string text = text_of_file(data_directory() + file);
    if (text.empty()) {
        text = text_of_file(ZONED_SOURCE_DIR "/tests/conformance" + file);
    }
    auto read = ai::pathfinding::parse_tsp(text);
    if (!read) {
        why = file + ": " + read.error();
        return std::nullopt;
    }
    return std::move(*read);
}

Row run_instance(const TspInstance& instance,
                 const KnownInstance& known,
                 const AntMethod& method,
                 std::uint64_t seeds) {
    const bool alone = method.local == LocalSearch::kNone;
    const std::uint64_t most_tours =
        (alone ? kVisitsAlone : kVisitsWithSearch) / instance.distances.size();
    std::vector<double> times;
    std::vector<double> tours;
    std::vector<double> excess;
    double optimal = 0.0;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
        MaxMinSettings settings;
        settings.local = method.local;
        settings.seed = seed;
        const std::int64_t before = thread_cpu_ns();
        MaxMin ants(instance.distances, settings);
        optimal += ants.run(most_tours, known.optimum) ? 1.0 : 0.0;
        times.push_back(static_cast<double>(thread_cpu_ns() - before) * 1e-3);
        tours.push_back(static_cast<double>(ants.tours()));
        excess.push_back(
            static_cast<double>(ants.best_length()) / static_cast<double>(known.optimum) - 1.0);
    }
    Row row;
    row.suite = "ants";
    row.scene = known.name;
    row.method = method.name;
    row.time_us_p50 = median(times);
    row.time_us_p99 = largest(times);
    row.error = largest(excess);
    row.error_unit = "worst excess";
    row.metric("seeds", static_cast<double>(seeds));
    row.metric("optimal_of_10", optimal * 10.0 / static_cast<double>(seeds));
    row.metric("mean_excess", mean(excess));
    row.metric("worst_s", largest(times) * 1e-6);
    row.metric("tours_p50", median(tours));
    row.metric("most_tours", static_cast<double>(most_tours));
    return row;
}

void run_ants(Session& session) {
    session.note(
        "ants: time until the optimum was found or the counted work was done, over ten seeds (p99: "
        "the longest); the error is the worst excess over the optimum. default: 2-opt and Or-opt");
    for (const KnownInstance& known : kInstances) {
        if (!session.wants_scene(known.name)) {
            continue;
        }
        session.progress(std::string("ants ") + known.name);
        std::string why;
        const auto instance = read_tsp(known.name, why);
        if (!instance) {
            session.note("ants: " + why);
            continue;
        }
        for (const AntMethod& method : kAntMethods) {
            const bool alone = method.local == LocalSearch::kNone;
            if (session.wants_method(method.name, "") && !(alone && session.quick)) {
                session.add({run_instance(*instance, known, method, session.quick ? 1 : 10)});
            }
        }
    }
}

const Registration kAnts({"ants",
                          "tours by ants: time to the optimum, excess over it",
                          {"berlin52", "eil51", "kroA100", "d198"},
                          {"default", "two_opt", "ants_alone"},
                          run_ants});

}  // namespace

}  // namespace zoned::bench
