#include "tests/random_worlds/world_lab.h"

#include "tests/random_worlds/forked_work.h"
#include "tests/scenario/minimise.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <list>
#include <map>
#include <utility>

namespace zoned::random_worlds {

namespace {

ChangedWorld with(const ChangedWorld& world, const std::vector<std::size_t>& chosen) {
    ChangedWorld fewer{world.file, {}};
    for (const std::size_t i : chosen) {
        if (i < world.sets.size()) {
            fewer.sets.push_back(world.sets[i]);
        } else {
            fewer.reload.push_back(world.reload[i - world.sets.size()]);
        }
    }
    return fewer;
}

TrialSettings trial_of(const LabSettings& settings, std::uint64_t seed) {
    TrialSettings trial = settings.trial;
    trial.seed = seed;
    return trial;
}

void run_entry(const LabSettings& settings, LabEntry& entry) {
    const TrialSettings trial = trial_of(settings, entry.trial_seed);
    entry.outcome = try_world(entry.world, trial);
    if (entry.outcome.failed() && settings.shrink_runs > 0) {
        entry.world = reduce(entry.world, trial, entry.outcome.finding, settings.shrink_runs);
        const double cpu_s = entry.outcome.cpu_s;
        entry.outcome = try_world(entry.world, trial);
        entry.outcome.cpu_s = cpu_s;
    }
}

/// A world that a process draws, tries and reduces.
struct RunningWorld {
    std::uint64_t index = 0;
    ForkedWork work;
    bool over = false;
};

/// Separates what a process says of its world: outcome, CPU time, seed, file, number of sets, sets,
/// those of a reload.
constexpr char kSeparator = '\x1e';

std::string packed(const LabEntry& entry) {
    std::string text = text_of(entry.outcome) + kSeparator + std::to_string(entry.outcome.cpu_s) +
                       kSeparator + std::to_string(entry.trial_seed) + kSeparator +
                       entry.world.file + kSeparator + std::to_string(entry.world.sets.size());
    for (const auto* list : {&entry.world.sets, &entry.world.reload}) {
        for (const std::string& one : *list) {
            text += kSeparator + one;
        }
    }
    return text;
}

LabEntry unpacked(const std::string& text) {
    std::vector<std::string> parts;
    for (std::size_t at = 0; at <= text.size();) {
        const std::size_t end = std::min(text.find(kSeparator, at), text.size());
        parts.push_back(text.substr(at, end - at));
        at = end + 1;
    }
    LabEntry entry;
    ForkedResult result;
    result.ended = true;
    result.text = parts.at(0);
    result.cpu_s = std::stod(parts.at(1));
    entry.outcome = outcome_of(result);
    entry.trial_seed = std::stoull(parts.at(2));
    entry.world.file = parts.at(3);
    const auto reload = parts.begin() + 5 + std::stol(parts.at(4));
    entry.world.sets.assign(parts.begin() + 5, reload);
    entry.world.reload.assign(reload, parts.end());
    return entry;
}

RunningWorld begin_world(const WorldChanger& changer,
                         const LabSettings& settings,
                         std::uint64_t index) {
    const auto work = [&, index] {
        LabEntry entry = draw_entry(changer, settings, settings.first + index);
        run_entry(settings, entry);
        return packed(entry);
    };
    return {index, ForkedWork(work, 0.0)};
}

/// A process that died on its own was drawing the world: the checks of configs crashed.
LabEntry ended_world(const LabSettings& settings, RunningWorld& one) {
    const ForkedResult result = one.work.finish();
    LabEntry entry;
    if (result.ended) {
        entry = unpacked(result.text);
    } else {
        entry.outcome = outcome_of(result);
    }
    entry.number = settings.first + one.index;
    return entry;
}

void wait_for_any(std::list<RunningWorld>& running) {
    std::vector<pollfd> files;
    for (const RunningWorld& one : running) {
        files.push_back({one.work.file(), POLLIN, 0});
    }
    while (::poll(files.data(), files.size(), -1) < 0 && errno == EINTR) {
    }
    std::size_t k = 0;
    for (RunningWorld& one : running) {
        one.over = files[k++].revents != 0 && !one.work.read_some();
    }
}

}  // namespace

LabEntry draw_entry(const WorldChanger& changer,
                    const LabSettings& settings,
                    std::uint64_t number) {
    core::Rng rng(settings.seed, number);
    LabEntry entry;
    entry.number = number;
    entry.world = changer.draw(rng, settings.most_changes);
    entry.world.sets.insert(entry.world.sets.end(), settings.sets.begin(), settings.sets.end());
    entry.trial_seed = settings.trial.seed != 0 ? settings.trial.seed : 1 + rng.below(1000000);
    entry.world.reload = settings.reload;
    if (settings.reload.empty() && settings.most_changes > 0 && rng.below(2) == 0) {
        changer.draw_reload(rng, settings.most_changes, entry.world);
    }
    return entry;
}

ChangedWorld reduce(const ChangedWorld& world,
                    const TrialSettings& trial,
                    Finding finding,
                    int runs) {
    const auto fails = [&](const std::vector<std::size_t>& chosen) {
        return try_world(with(world, chosen), trial).finding == finding;
    };
    if (fails({})) {
        return {world.file, {}};
    }
    const std::size_t changes = world.sets.size() + world.reload.size();
    return with(world, scenario::minimise(changes, fails, runs));
}

std::vector<LabEntry> run_lab(const LabSettings& settings) {
    const WorldChanger changer(settings.files);
    std::vector<LabEntry> entries(settings.count);
    std::list<RunningWorld> running;
    std::uint64_t begun = 0;
    for (std::uint64_t done = 0; done < settings.count;) {
        while (begun < settings.count && running.size() < static_cast<std::size_t>(settings.jobs)) {
            running.push_back(begin_world(changer, settings, begun++));
        }
        wait_for_any(running);
        for (auto one = running.begin(); one != running.end();) {
            if (!one->over) {
                ++one;
                continue;
            }
            LabEntry& entry = entries[one->index];
            entry = ended_world(settings, *one);
            one = running.erase(one);
            ++done;
            if (settings.each) {
                settings.each(entry, done);
            }
        }
    }
    return entries;
}

std::string to_text(const LabEntry& entry) {
    std::string text = "world " + std::to_string(entry.number) + " (trial seed " +
                       std::to_string(entry.trial_seed) + "): " + name_of(entry.outcome.finding);
    if (entry.outcome.finding != Finding::kNone) {
        text += ": " + entry.outcome.text;
    }
    return entry.outcome.failed() ? text + "\n  " + command_of(entry.world) : text;
}

std::string summary_of(const std::vector<LabEntry>& entries) {
    std::map<Finding, int> counts;
    double cpu_s = 0.0;
    for (const LabEntry& entry : entries) {
        ++counts[entry.outcome.finding];
        cpu_s += entry.outcome.cpu_s;
    }
    std::string text = std::to_string(entries.size()) + " worlds";
    for (const auto& [finding, count] : counts) {
        text += ", " + std::to_string(count) + " " + name_of(finding);
    }
    char end[40];
    std::snprintf(end, sizeof(end), "; %.0f s of CPU", cpu_s);
    return text + end;
}

}  // namespace zoned::random_worlds
