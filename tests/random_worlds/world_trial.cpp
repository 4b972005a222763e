#include "tests/random_worlds/world_trial.h"

#include "server/app/world/agent_reload.h"
#include "server/app/world/world.h"
#include "tests/harness/virtual_server.h"
#include "tests/network_matrix/cell.h"
#include "tests/random_worlds/forked_work.h"
#include "tests/random_worlds/snapshot_run.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <utility>
#include <vector>

namespace zoned::random_worlds {

namespace {

using network_matrix::Cell;
using network_matrix::CellResult;
using network_matrix::CellSettings;

/// A letter for each finding, from this one on.
constexpr char kFirstFinding = 'A';

Cell cell_of(std::uint64_t seed) {
    core::Rng rng(seed, 0xCE11);
    static constexpr std::array<double, 4> kLosses = {0.0, 0.02, 0.05, 0.1};
    static constexpr std::array<double, 3> kJitters_s = {0.0, 0.02, 0.05};
    return {kLosses[rng.below(kLosses.size())],
            kJitters_s[rng.below(kJitters_s.size())],
            rng.below(2) == 0 ? 0.0 : 0.05,
            rng.below(2) == 0 ? 0.0 : 0.1,
            rng.below(4) == 0};
}

/// The hashes of all zones after each tick.
using Course = std::vector<std::vector<std::uint64_t>>;

/// Notes each tick of a run, and the first zone that stops.
struct CourseNotes {
    Course course;
    std::string stopped;
    std::uint64_t beyond_limits = 0;  ///< times that an entity moved as its type's limits forbid
    Tick last = 0;
    bool reloaded = false;

    /// False: no tick has passed.
    bool note(harness::VirtualServer& server) {
        if (server.simulated() == last) {
            return false;
        }
        last = server.simulated();
        server.hash_zones(course.emplace_back());
        for (const auto& zone : server.world().zones()) {
            beyond_limits += zone->report().replication.limit_exceeded;
        }
        if (stopped.empty() && !server.world().stopped().empty()) {
            const app::StoppedZone& zone = server.world().stopped().front();
            stopped = "zone " + std::to_string(zone.zone.value) + " at tick " +
                      std::to_string(zone.tick) + " in " + zone.place + ": " + zone.text;
        }
        return true;
    }
};

std::string first_difference(const Course& a, const Course& b) {
    for (std::size_t t = 0; t < std::min(a.size(), b.size()); ++t) {
        for (std::size_t z = 0; z < std::min(a[t].size(), b[t].size()); ++z) {
            if (a[t][z] != b[t][z]) {
                return "zone " + std::to_string(z + 1) + " differs at tick " +
                       std::to_string(t + 1);
            }
        }
    }
    return a.size() == b.size()
               ? ""
               : std::to_string(a.size()) + " and " + std::to_string(b.size()) + " ticks";
}

TrialOutcome judged(const CellResult& result) {
    const measure::RunReport& r = result.report;
    std::string text;
    for (const std::string& reason : r.reasons) {
        text += (text.empty() ? "" : "; ") + reason;
    }
    if (!r.inconclusive.empty()) {
        return {Finding::kInconclusive, r.inconclusive, 0.0};
    }
    if (r.audit.samples == 0 && r.audit.records > 0) {
        return {Finding::kInconclusive, text, 0.0};  // players see nothing in such a world
    }
    if (!r.consistent) {
        return {Finding::kInconsistent, text, 0.0};
    }
    return result.healed ? TrialOutcome()
                         : TrialOutcome{Finding::kUnhealed, r.frozen_difference, 0.0};
}

/// As a replay has them from a recording, which holds their text.
mailbox::InboxItem replayed(const mailbox::NewBrains& brains, harness::VirtualServer& server) {
    mailbox::InboxItem item = mailbox::NewBrains{brains.config, nullptr};
    const auto restored = app::restore_brains(server.settings(), item);
    if (!restored.ok()) {
        throw std::runtime_error("a replay cannot read the agents anew: " + restored.error());
    }
    return item;
}

TrialOutcome run_trial(const ChangedWorld& world, const TrialSettings& settings, bool& began) {
    CellSettings run;
    run.config = world.file;
    run.sets = world.sets;
    run.bots = settings.bots;
    run.seconds = settings.seconds;
    run.seed = settings.seed;
    run.heal_s = 10.0;  // a world may have a small budget of bytes
    std::array<CourseNotes, 2> notes;
    const auto reload = brains_of_reload(world);
    const auto play = [&](unsigned threads, CourseNotes& into) {
        run.threads = threads;
        run.each_step = [&](harness::VirtualServer& server) {
            began = true;
            if (into.note(server) && reload.ok() && server.now_s() >= 0.5 * settings.seconds &&
                !std::exchange(into.reloaded, true)) {
                server.give(threads == 1 ? mailbox::InboxItem(*reload) : replayed(*reload, server));
            }
        };
        return network_matrix::run_cell(cell_of(settings.seed), run);
    };
    TrialOutcome outcome = judged(play(1, notes[0]));
    if (!notes[0].stopped.empty()) {
        return {Finding::kStopped, notes[0].stopped, 0.0};
    }
    if (outcome.finding == Finding::kInconsistent && notes[0].beyond_limits > 0) {
        outcome.finding = Finding::kLimits;
        outcome.text = std::to_string(notes[0].beyond_limits) + " times; " + outcome.text;
    }
    if (outcome.failed()) {
        return outcome;
    }
    play(3, notes[1]);
    if (std::string differs = first_difference(notes[0].course, notes[1].course);
        !differs.empty()) {
        return {Finding::kThreads, std::move(differs), 0.0};
    }
    snapshot::SnapshotCourse course;
    course.config = world.file;
    course.sets = world.sets;
    course.bots = settings.bots;
    course.seed = settings.seed;
    course.snapshots = 2;
    course.longest_refusal = 600;  // a crowd on a large map is looked at again and again
    course.follows = 40;
    const snapshot::SnapshotResult copied = snapshot::run_course(course);
    return copied.wrong.empty() ? outcome : TrialOutcome{Finding::kSnapshot, copied.wrong, 0.0};
}

/// An exception before anything runs is a refusal, by the rules or the world that is made.
TrialOutcome guarded(const ChangedWorld& world, const TrialSettings& settings) {
    bool began = false;
    try {
        return run_trial(world, settings, began);
    } catch (const std::exception& error) {
        return {began ? Finding::kCrash : Finding::kRefused, error.what(), 0.0};
    }
}

}  // namespace

const char* name_of(Finding finding) {
    switch (finding) {
        case Finding::kNone:
            return "good";
        case Finding::kRefused:
            return "refused";
        case Finding::kInconclusive:
            return "inconclusive";
        case Finding::kCrash:
            return "crash";
        case Finding::kInconsistent:
            return "inconsistent";
        case Finding::kLimits:
            return "limits";
        case Finding::kUnhealed:
            return "unhealed";
        case Finding::kThreads:
            return "threads";
        case Finding::kSnapshot:
            return "snapshot";
        case Finding::kStopped:
            return "stopped";
    }
    return "?";
}

TrialOutcome outcome_of(const ForkedResult& result) {
    TrialOutcome outcome;
    outcome.cpu_s = result.cpu_s;
    if (result.ended && !result.text.empty()) {
        outcome.finding = static_cast<Finding>(result.text.front() - kFirstFinding);
        outcome.text = result.text.substr(1);
    } else if (result.signal == SIGXCPU) {
        outcome.finding = Finding::kInconclusive;
        outcome.text = "takes more CPU time than a trial may";
    } else {
        outcome.finding = Finding::kCrash;
        outcome.text = result.signal != 0 ? std::string(::strsignal(result.signal)) + ": " : "";
        outcome.text += result.text;
    }
    return outcome;
}

std::string text_of(const TrialOutcome& outcome) {
    return static_cast<char>(kFirstFinding + static_cast<int>(outcome.finding)) + outcome.text;
}

TrialOutcome try_world(const ChangedWorld& world, const TrialSettings& settings) {
    ForkedWork work([&] { return text_of(guarded(world, settings)); }, settings.most_cpu_s);
    return outcome_of(work.finish());
}

}  // namespace zoned::random_worlds
