#include "tests/stability/random/random_lab.h"

#include "tests/bench/cpu_clock.h"
#include "tests/stability/random/scene_generator.h"
#include "tests/stability/random/scene_shrink.h"
#include "tests/stability/random/scene_text.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <thread>

namespace zoned::stability {

namespace {

const std::string& name_of(Invariant what) {
    return invariant_names()[static_cast<std::size_t>(what)];
}

template <class... Values>
std::string line(const char* format, Values... values) {
    std::array<char, 512> text{};
    std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
}

/// Calls job(i) for each i below count, on so many threads; the first exception comes out.
template <class Job>
void share_out(std::size_t count, int threads, Job&& job) {
    std::atomic<std::size_t> next{0};
    std::vector<std::exception_ptr> thrown(static_cast<std::size_t>(std::max(threads, 1)));
    const auto work = [&](std::exception_ptr& error) {
        try {
            for (std::size_t i = next++; i < count; i = next++) {
                job(i);
            }
        } catch (...) {
            error = std::current_exception();
            next = count;
        }
    };
    std::vector<std::thread> team;
    for (std::size_t t = 1; t < thrown.size(); ++t) {
        team.emplace_back([&work, &thrown, t] { work(thrown[t]); });
    }
    work(thrown.front());
    for (std::thread& thread : team) {
        thread.join();
    }
    for (const std::exception_ptr& error : thrown) {
        if (error) {
            std::rethrow_exception(error);
        }
    }
}

/// The findings of a thread about one scene.
struct SceneResult {
    std::string families;
    std::size_t bodies = 0;
    std::size_t joints = 0;
    float dt = 0.0F;
    SceneVerdict verdict;
};

SceneRunOptions run_options(Fault fault) {
    SceneRunOptions options;
    if (fault != Fault::kNone) {
        options.spoil = spoil_with(fault);
    }
    return options;
}

bool asked(const std::vector<Invariant>& only, Invariant what) {
    return only.empty() || std::find(only.begin(), only.end(), what) != only.end();
}

std::string write_shrunk(const RandomLabOptions& options, const RandomFailure& failure) {
    SceneRunOptions run = run_options(options.fault);
    run.until = failure.breach.what;
    const RandomScene shrunk = shrink_scene(
        generate_scene(options.seed, failure.scene, options.families),
        [&](const RandomScene& scene) { return run_scene(scene, run).fails(failure.breach.what); },
        options.shrink_runs);
    const std::filesystem::path path =
        std::filesystem::path(options.folder) / line("random-%llu-%llu-%s.txt",
                                                     static_cast<unsigned long long>(options.seed),
                                                     static_cast<unsigned long long>(failure.scene),
                                                     name_of(failure.breach.what).c_str());
    std::ofstream out(path, std::ios::binary);
    out << scene_to_text(shrunk);
    if (!out.flush()) {
        throw std::runtime_error("can't write " + path.string());
    }
    return path.string();
}

/// The first failures of each invariant that are kept.
std::vector<std::size_t> kept_of(const RandomLabOptions& options, const RandomLabResult& result) {
    std::array<int, kInvariants> count{};
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < result.failures.size(); ++i) {
        if (count[static_cast<std::size_t>(result.failures[i].breach.what)]++ < options.keep) {
            kept.push_back(i);
        }
    }
    return kept;
}

std::string to_line(const RandomFailure& f) {
    return line("%8llu  %-8s  %10.4g  %10.4g  %7.2f  %5zu  %6zu  %6zu  %5.1f  %s%s%s\n",
                static_cast<unsigned long long>(f.scene),
                name_of(f.breach.what).c_str(),
                f.breach.figure,
                f.breach.bound,
                f.breach.time,
                f.breach.item,
                f.bodies,
                f.joints,
                1.0e3 * static_cast<double>(f.dt),
                f.families.c_str(),
                f.file.empty() ? "" : "  -> ",
                f.file.c_str());
}

}  // namespace

RandomLabResult run_random_lab(const RandomLabOptions& options) {
    std::vector<SceneResult> scenes(options.count);
    std::atomic<std::size_t> done{0};
    std::atomic<std::size_t> failed{0};
    std::atomic<std::int64_t> told_ns{bench::wall_ns()};
    const SceneRunOptions run = run_options(options.fault);
    share_out(scenes.size(), options.threads, [&](std::size_t i) {
        const RandomScene scene = generate_scene(options.seed, options.first + i, options.families);
        scenes[i] = {scene.families,
                     scene.bodies.size(),
                     scene.joints.size(),
                     scene.dt,
                     run_scene(scene, run)};
        const auto& breaches = scenes[i].verdict.breaches;
        failed += std::any_of(
                      breaches.begin(), breaches.end(), [](const Breach& b) { return !b.gave_up; })
                      ? 1
                      : 0;
        const std::size_t count = ++done;
        std::int64_t told = told_ns;
        const std::int64_t now = bench::wall_ns();
        if (options.talk && now - told > 2'000'000'000 &&
            told_ns.compare_exchange_strong(told, now)) {
            std::fprintf(
                stderr, "%zu of %zu scenes, %zu failed\n", count, scenes.size(), failed.load());
        }
    });
    RandomLabResult result;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        const SceneResult& scene = scenes[i];
        const std::uint64_t number = options.first + i;
        ++result.scenes;
        result.bodies += scene.bodies;
        result.joints += scene.joints;
        result.steps += scene.verdict.steps;
        result.limited_steps += scene.verdict.limited_steps;
        result.cpu_ms += scene.verdict.cpu_ms;
        if (!scene.verdict.refused.empty()) {
            result.refused.push_back("scene " + std::to_string(number) + ": " +
                                     scene.verdict.refused);
        }
        for (const Breach& breach : scene.verdict.breaches) {
            if (asked(options.only, breach.what)) {
                (breach.gave_up ? result.gave_up : result.failures)
                    .push_back(
                        {number, scene.families, scene.bodies, scene.joints, scene.dt, breach, ""});
            }
        }
    }
    const std::vector<std::size_t> kept = kept_of(options, result);
    share_out(kept.size(), options.threads, [&](std::size_t i) {
        RandomFailure& failure = result.failures[kept[i]];
        failure.file = write_shrunk(options, failure);
        if (options.talk) {
            std::fprintf(stderr, "shrunk %s\n", failure.file.c_str());
        }
    });
    return result;
}

std::string to_table(const RandomLabResult& result) {
    std::string text;
    for (const auto* list : {&result.failures, &result.gave_up}) {
        if (!list->empty()) {
            text +=
                list == &result.failures ? "failures:\n" : "joints open where effort gave up:\n";
            text +=
                "   scene  breaks        figure       bound     at s   item  bodies  joints     ms "
                " "
                "families\n";
        }
        for (const RandomFailure& failure : *list) {
            text += to_line(failure);
        }
    }
    for (const std::string& reason : result.refused) {
        text += "refused: " + reason + "\n";
    }
    std::map<std::string, int> counts;
    for (const RandomFailure& failure : result.failures) {
        ++counts[name_of(failure.breach.what)];
    }
    text += line(
        "%llu scenes, %.1f bodies and %.1f joints each, %llu steps, %.0f s of CPU: %zu failures",
        static_cast<unsigned long long>(result.scenes),
        static_cast<double>(result.bodies) /
            static_cast<double>(std::max<std::uint64_t>(result.scenes, 1)),
        static_cast<double>(result.joints) /
            static_cast<double>(std::max<std::uint64_t>(result.scenes, 1)),
        static_cast<unsigned long long>(result.steps),
        result.cpu_ms * 1.0e-3,
        result.failures.size());
    for (const auto& [name, count] : counts) {
        text += ", " + name + " " + std::to_string(count);
    }
    return text + line("; %zu joints open where effort gave up, %zu refused\n",
                       result.gave_up.size(),
                       result.refused.size());
}

bool replay_scene(const std::string& file, const std::vector<Invariant>& only, Fault fault) {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (!in.is_open() || in.bad()) {
        throw std::runtime_error("can't read " + file);
    }
    const auto scene = scene_from_text(text);
    if (!scene) {
        throw std::runtime_error(file + ": " + scene.error());
    }
    const SceneVerdict verdict = run_scene(*scene, run_options(fault));
    if (!verdict.refused.empty()) {
        throw std::runtime_error(file + ": " + verdict.refused);
    }
    bool good = true;
    for (const Breach& breach : verdict.breaches) {
        if (asked(only, breach.what)) {
            good = good && breach.gave_up;
            std::fputs(line("%s%s: %.6g > %.6g, first at %.3f s, %s %zu\n",
                            name_of(breach.what).c_str(),
                            breach.gave_up ? " (effort gave up)" : "",
                            breach.figure,
                            breach.bound,
                            breach.time,
                            breach.what == Invariant::kJoint ? "joint" : "body",
                            breach.item)
                           .c_str(),
                       stdout);
        }
    }
    std::fputs(line("%llu steps, %llu of limited effort, top speed %.3g m/s, %s\n",
                    static_cast<unsigned long long>(verdict.steps),
                    static_cast<unsigned long long>(verdict.limited_steps),
                    verdict.top_speed_mps,
                    good ? "all holds" : "FAIL")
                   .c_str(),
               stdout);
    return good;
}

}  // namespace zoned::stability
