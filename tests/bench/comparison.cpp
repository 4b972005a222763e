#include "tests/bench/comparison.h"

#include <algorithm>
#include <utility>

namespace zoned::bench {

namespace {

void add_ratios(std::vector<Row>& rows, const std::vector<Timing>& timings) {
    const auto bullet = std::find_if(rows.begin(), rows.end(), [](const Row& row) {
        return row.peer == "bullet" && row.method == "default";
    });
    if (bullet == rows.end()) {
        return;
    }
    const Timing& theirs = timings[static_cast<std::size_t>(bullet - rows.begin())];
    if (theirs.p50_us <= 0.0 || theirs.mean_us <= 0.0) {
        return;
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
        rows[i].metric("bullet_ratio", timings[i].p50_us / theirs.p50_us);
        rows[i].metric("bullet_ratio_of_means", timings[i].mean_us / theirs.mean_us);
    }
}

}  // namespace

std::string full_name(const std::string& method, const std::string& peer) {
    return peer.empty() ? method : peer + "/" + method;
}

std::vector<Row> compare(const std::string& suite,
                         const std::string& scene,
                         const std::string& parameter,
                         const std::vector<Method>& methods,
                         const Plan& plan) {
    std::vector<Contender> contenders;
    std::vector<Row> rows(methods.size());
    for (std::size_t i = 0; i < methods.size(); ++i) {
        contenders.push_back({full_name(methods[i].name, methods[i].peer), methods[i].build});
        rows[i].suite = suite;
        rows[i].scene = scene;
        rows[i].parameter = parameter;
        rows[i].method = methods[i].name;
        rows[i].peer = methods[i].peer;
    }
    const std::vector<Timing> timings =
        time_interleaved(contenders, plan, [&rows](std::size_t i, Trial& trial) {
            static_cast<JudgedTrial&>(trial).judge(rows[i]);
        });
    for (std::size_t i = 0; i < rows.size(); ++i) {
        rows[i].time_us_p50 = timings[i].p50_us;
        rows[i].time_us_p99 = timings[i].p99_us;
        rows[i].metric("time_us_mean", timings[i].mean_us);
        rows[i].metric("wall_us_p50", timings[i].wall_p50_us);
        rows[i].metric("frames", plan.frames);
    }
    add_ratios(rows, timings);
    return rows;
}

std::vector<Method> wanted(const Session& session, std::vector<Method> methods) {
    std::erase_if(methods, [&session](const Method& method) {
        return !session.wants_method(method.name, method.peer);
    });
    return methods;
}

}  // namespace zoned::bench
