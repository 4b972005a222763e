// WorldTrial: a world with bots on a bad network, and everything that must hold of it, whatever it
// is.
#pragma once

#include "tests/random_worlds/changed_world.h"
#include "tests/random_worlds/forked_work.h"

#include <cstdint>
#include <string>

namespace zoned::random_worlds {

/// The result of a trial. The first three say nothing against the world.
enum class Finding : std::uint8_t {
    kNone,
    kRefused,       ///< rules or world refuse settings that the checks take
    kInconclusive,  ///< a verdict that says nothing, or too much work for the trial
    kCrash,         ///< a signal, a failed assertion, an exception
    kInconsistent,  ///< the verdict on the bots
    kLimits,        ///< the same, where something moved as the declared limits of its type forbid
    kUnhealed,      ///< views differ from the server's though the network is good again
    kThreads,       ///< another number of threads, or a replay's reload, gives another world
    kSnapshot,      ///< a copy from a snapshot goes on in another way
    kStopped        ///< a zone stopped as its rules threw
};

const char* name_of(Finding finding);

struct TrialOutcome {
    Finding finding = Finding::kNone;
    std::string text;  ///< in words
    double cpu_s = 0.0;

    [[nodiscard]] bool failed() const { return finding > Finding::kInconclusive; }
};

struct TrialSettings {
    std::size_t bots = 5;
    double seconds = 5.0;    ///< of virtual time that bots play
    std::uint64_t seed = 0;  ///< of networks and bots
    double most_cpu_s = 60.0;
};

/// Runs it in a process of its own: on one thread and on three, with the same bots on the same bad
/// network, and with copies from snapshots. The second of the two takes what is read anew as a
/// replay does.
TrialOutcome try_world(const ChangedWorld& world, const TrialSettings& settings);

/// An outcome as a process says it, and what to make of a process's end.
std::string text_of(const TrialOutcome& outcome);
TrialOutcome outcome_of(const ForkedResult& result);

}  // namespace zoned::random_worlds
