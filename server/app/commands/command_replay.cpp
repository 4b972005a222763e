#include "server/app/commands/commands.h"
#include "server/app/replay/replay_server.h"
#include "server/app/world/replayed_tick.h"
#include "server/app/world/world_rules.h"
#include "server/config/expand/load_settings.h"
#include "server/recording/recording_file.h"
#include "server/recording/recording_reader.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <utility>

namespace zoned::app {

namespace {

using recording::RecordingReader;
using recording::TickRecord;

constexpr Tick kProgressEvery = 900;

int complain(ExitCode code, const std::string& text) {
    std::fprintf(stderr, "zoned: %s\n", text.c_str());
    return code;
}

long long number(Tick tick) {
    return static_cast<long long>(tick);
}

Tick last_asked(const ReplayArguments& arguments) {
    return arguments.to == 0 ? std::numeric_limits<Tick>::max() : arguments.to;
}

bool settings_of(const recording::RecordingHeader& header,
                 const std::string& file,
                 config::Settings& settings) {
    std::vector<config::ConfigError> errors;
    if (config::parse_settings(header.config_text, {}, settings, errors)) {
        declare_fields(settings);
        if (settings.digest == header.config_digest) {
            return true;
        }
        std::fprintf(stderr,
                     "zoned: %s: its config now gives a world with digest %s, when it was recorded "
                     "it was %s: a file that the config names has changed\n",
                     file.c_str(),
                     settings.digest.c_str(),
                     header.config_digest.c_str());
        return false;
    }
    std::fputs(config::format_errors(file + " (its config)", errors).c_str(), stderr);
    return false;
}

/// What a recording holds, without simulating: every checksum is compared on the way.
int describe(RecordingReader& reader, const ReplayArguments& arguments) {
    const recording::RecordingHeader& header = reader.header();
    std::printf("recorded by     zoned %s, %s, target %s\n",
                header.program.c_str(),
                header.compiler.c_str(),
                header.target.c_str());
    std::printf("format          %u, simulation generation %u\n",
                recording::kRecordingFormat,
                header.generation);
    std::printf("config digest   %s\n", header.config_digest.c_str());
    TickRecord record;
    Tick first = 0;
    Tick last = 0;
    std::uint64_t ticks = 0;
    std::uint64_t messages = 0;
    auto more = reader.next(record);
    for (; more.ok() && *more; more = reader.next(record)) {
        first = ticks == 0 ? record.tick : first;
        last = record.tick;
        ++ticks;
        messages += record.items.size();
    }
    std::printf("ticks           %llu, %lld to %lld\n",
                static_cast<unsigned long long>(ticks),
                number(first),
                number(last));
    if (reader.state()) {
        std::printf("begins          with the state of tick %lld, %zu bytes\n",
                    number(reader.state()->tick),
                    reader.state()->bytes.size());
    }
    std::printf("messages        %llu\n", static_cast<unsigned long long>(messages));
    std::printf("bytes           %llu\n", static_cast<unsigned long long>(reader.bytes()));
    if (ticks > 0 && record.hashes.empty()) {
        std::printf("last tick       not simulated to its end\n");
    }
    if (!more.ok()) {
        return complain(kFailed, more.error());
    }
    const auto comparable = reader.check_build();
    std::printf("ends            in good order\nreplay          %s\n",
                !comparable.ok()               ? comparable.error().c_str()
                : first == 1 || reader.state() ? ("zoned replay " + arguments.file).c_str()
                                               : "needs the world's state before its first tick");
    return kGood;
}

/// Copies the ticks of a span into a recording of its own; with the state before them, where the
/// span begins with the recording.
int slice(RecordingReader& reader, const ReplayArguments& arguments) {
    recording::RecordingFile out;
    const bool from_state = reader.state() && arguments.from <= reader.state()->tick + 1;
    const auto opened =
        out.open(arguments.out, reader.header(), from_state ? &*reader.state() : nullptr);
    if (!opened.ok()) {
        return complain(kEnvironment, opened.error());
    }
    TickRecord record;
    std::uint64_t ticks = 0;
    Tick last = 0;
    auto more = reader.seek(arguments.from);
    if (more.ok() && *more) {
        more = reader.next(record);
    }
    for (; more.ok() && *more && record.tick <= last_asked(arguments); more = reader.next(record)) {
        out.add_tick(record);
        last = record.tick;
        ++ticks;
    }
    const auto closed = out.close();
    if (!closed.ok()) {
        return complain(kEnvironment, closed.error());
    }
    if (ticks > 0) {
        std::printf("%s holds %llu ticks, up to tick %lld\n",
                    arguments.out.c_str(),
                    static_cast<unsigned long long>(ticks),
                    number(last));
    }
    if (!more.ok()) {
        return complain(kFailed, more.error());
    }
    return ticks > 0 ? kGood : complain(kFailed, arguments.file + " holds no tick of that span");
}

int say_what_is_missing(const std::string& file, Tick first) {
    return complain(kFailed,
                    file + " begins with tick " + std::to_string(first) +
                        ": to simulate it one needs the state of the world before that tick, which "
                        "it does not hold. Record the whole run (recording.file), begin a "
                        "recording while it runs (`zoned ctl record on` keeps the state), or keep "
                        "more than the run's length in the ring (recording.ring_s). `--info` and "
                        "`--out` work without");
}

/// The first tick and all after it, up to the last that is asked for.
int simulate(RecordingReader& reader,
             const config::Settings& settings,
             const ReplayArguments& arguments) {
    World world(settings, arguments.threads);
    const std::string bad_state = begin_with_state(reader, world);
    if (!bad_state.empty()) {
        return complain(kFailed, arguments.file + ": " + bad_state);
    }
    const Tick before = world.now();
    TickRecord record;
    const auto begin = std::chrono::steady_clock::now();
    auto more = reader.next(record);
    for (; more.ok() && *more && record.tick <= last_asked(arguments); more = reader.next(record)) {
        if (world.now() == before && record.tick != before + 1) {
            return say_what_is_missing(arguments.file, record.tick);
        }
        if (record.hashes.empty()) {
            std::fprintf(stderr,
                         "zoned: tick %lld: its inputs are the last that were recorded, the server "
                         "stopped within it; it is simulated now\n",
                         number(record.tick));
        }
        const std::string wrong =
            replayed_tick(settings, record, record.tick >= arguments.from, world);
        if (!wrong.empty()) {
            return complain(kFailed, arguments.file + ": " + wrong);
        }
        if (world.now() % kProgressEvery == 0) {
            std::fprintf(stderr, "replayed %lld ticks\n", number(world.now() - before));
        }
    }
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const double simulated = static_cast<double>(world.now() - before) / settings.tick_rate_hz;
    std::printf(
        "replayed %lld ticks of %zu zones with %u threads: every hash agrees, state_hash %016llx, "
        "%.1f times real time\n",
        number(world.now() - before),
        settings.zones.size(),
        arguments.threads,
        static_cast<unsigned long long>(world.state_hash()),
        simulated / std::max(seconds, 1e-9));
    return more.ok() ? kGood : complain(kFailed, more.error());
}

}  // namespace

int replay(const ReplayArguments& arguments) {
    RecordingReader reader;
    const auto opened = reader.open(arguments.file);
    if (!opened.ok()) {
        return complain(kEnvironment, opened.error());
    }
    if (arguments.info) {
        return describe(reader, arguments);
    }
    if (!arguments.out.empty()) {
        return slice(reader, arguments);
    }
    const auto comparable = reader.check_build();
    if (!comparable.ok()) {
        return complain(kEnvironment, comparable.error());
    }
    config::Settings settings;
    if (!settings_of(reader.header(), arguments.file, settings)) {
        return kUsage;
    }
    if (arguments.serve) {
        const auto shown =
            serve_replay(std::move(settings),
                         {arguments.file, arguments.threads, arguments.port, arguments.from});
        return !shown.ok() ? complain(kFailed, shown.error()) : *shown ? kGood : kFailed;
    }
    return simulate(reader, settings, arguments);
}

}  // namespace zoned::app
