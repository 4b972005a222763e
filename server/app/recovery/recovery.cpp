#include "server/app/recovery/recovery.h"

#include "server/app/log/log.h"
#include "server/app/recovery/world_life.h"
#include "server/app/runtime/tick_loop.h"
#include "server/app/world/replayed_tick.h"
#include "server/recording/recording_reader.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <stdexcept>

namespace zoned::app {

namespace {

namespace fs = std::filesystem;

/// A tick whose inputs kill the server would do so again: the third start leaves out a last tick
/// that did not come to its end, and after so many starts the world begins anew.
constexpr unsigned kLeavesOutFrom = 3;
constexpr unsigned kMostAttempts = 5;

std::string utc_now() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    char text[32];
    std::strftime(text, sizeof(text), "%Y%m%dT%H%M%S", &parts);
    return text;
}

void remove_pieces(const std::string& folder) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        if (entry.path().extension() == ".zrec") {
            fs::remove(entry.path(), error);
        }
    }
}

bool has_pieces(const std::string& folder) {
    std::error_code error;
    const fs::directory_iterator entries(folder, error);
    return std::any_of(fs::begin(entries), fs::end(entries), [](const auto& entry) {
        return entry.path().extension() == ".zrec";
    });
}

std::string attempts_file(const std::string& folder) {
    return folder + "/attempts";
}

/// How many starts in a row have tried to go on from here.
unsigned attempts_in(const std::string& folder) {
    unsigned attempts = 0;
    std::ifstream(attempts_file(folder)) >> attempts;
    return attempts;
}

void note_attempts(const std::string& folder, unsigned attempts) {
    std::ofstream(attempts_file(folder), std::ios::trunc) << attempts << '\n';
}

/// How often the world has come back, with this time; kept with it.
std::uint64_t count_recovery(const std::string& folder) {
    const std::string file = folder + "/recoveries";
    std::uint64_t count = 0;
    std::ifstream(file) >> count;
    std::ofstream(file, std::ios::trunc) << ++count << '\n';
    return count;
}

}  // namespace

Recovery::Recovery(const config::Settings& settings)
    : settings_(settings),
      folder_(settings.server.session.state_folder + "/journal"),
      every_ticks_(std::max<Tick>(
          1,
          static_cast<Tick>(settings.server.recovery.snapshot_every_s * settings.tick_rate_hz))),
      lives_ticks_(static_cast<Tick>(settings.tick_rate_hz) + 1) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) {
        throw std::runtime_error("cannot create the folder '" + folder_ +
                                 "' (recovery.on): " + error.message());
    }
    lock();
}

Recovery::~Recovery() {
    copy_.stop();
    if (lock_ >= 0) {
        ::close(lock_);
    }
}

void Recovery::lock() {
    const std::string file = folder_ + ".lock";
    lock_ = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640);
    if (lock_ < 0) {
        throw std::runtime_error("cannot open '" + file + "': " + std::strerror(errno));
    }
    if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
        throw std::runtime_error("another server keeps its world in '" + folder_ +
                                 "': give each a session.state_folder of its own");
    }
}

RecoveredRun Recovery::begin(World& world, const std::string& life) {
    RecoveredRun run;
    bool goes_on = !snapshots_in(folder_).empty();
    if (goes_on && !life.empty() && life != kept_life(settings_)) {
        set_aside("another server has had the world since");
        goes_on = false;
    }
    attempts_ = goes_on ? attempts_in(folder_) + 1 : 0;
    note_attempts(folder_, attempts_);
    try {
        if (attempts_ > kMostAttempts) {
            set_aside(std::to_string(kMostAttempts) +
                      " starts in a row died after they brought the world back");
        } else if (goes_on) {
            go_on(world, run);
        }
        note_life(settings_, life);
        keep_state(world);
    } catch (...) {
        refused();
        throw;
    }
    return run;
}

void Recovery::refused() const {
    note_attempts(folder_, attempts_ > 0 ? attempts_ - 1 : 0);
}

void Recovery::go_on(World& world, RecoveredRun& run) {
    const double begin_s = steady_seconds();
    load(world, run);
    replay(world, attempts_ >= kLeavesOutFrom, run);
    run.tick = world.now();
    run.sessions = ledger_.sessions().size();
    run.recoveries = count_recovery(folder_);
    run.seconds = steady_seconds() - begin_s;
    run.text = "the world goes on after tick " + std::to_string(run.tick) + ": snapshot of tick " +
               std::to_string(run.snapshot) + " and " + std::to_string(run.tick - run.snapshot) +
               " ticks again in " + std::to_string(static_cast<int>(1e3 * run.seconds)) + " ms, " +
               std::to_string(run.sessions) + " sessions";
}

void Recovery::set_aside(const std::string& why) {
    const std::string name = folder_ + "-" + utc_now();
    std::string aside = name;
    std::error_code error;
    for (int i = 2; fs::exists(aside, error); ++i) {
        aside = name + "-" + std::to_string(i);
    }
    fs::rename(folder_, aside, error);
    if (error) {
        throw std::runtime_error("cannot rename '" + folder_ + "': " + error.message());
    }
    fs::create_directories(folder_, error);
    log_of(LogArea::kServer)
        .error("{}: it begins anew; what was kept of it lies in {}", why, aside);
}

/// The newest snapshot that can be read.
void Recovery::load(World& world, RecoveredRun& run) {
    for (const SnapshotFile& file : snapshots_in(folder_)) {
        const auto bytes = read_snapshot(file);
        if (!bytes.ok()) {
            run.trouble += (run.trouble.empty() ? "" : "; ") + bytes.error();
            continue;
        }
        const std::string wrong = load_snapshot(*bytes, world, ledger_);
        if (!wrong.empty()) {
            throw std::runtime_error(
                "the server before this one died, and this one cannot go on from '" + file.path +
                "': " + wrong + "; start with the config and the program of then, or move '" +
                folder_ + "' away to begin anew");
        }
        run.snapshot = file.tick;
        return;
    }
    throw std::runtime_error("the server before this one died, and no snapshot in '" + folder_ +
                             "' can be read (" + run.trouble +
                             "); move the folder away to begin anew");
}

void Recovery::replay(World& world, bool leaves_out_last, RecoveredRun& run) {
    if (!has_pieces(folder_)) {
        return;
    }
    recording::RecordingReader reader;
    auto more = reader.open(folder_);
    if (more.ok()) {
        more = reader.check_build();
    }
    if (more.ok()) {
        more = reader.seek(world.now() + 1);
    }
    recording::TickRecord record;
    std::vector<mailbox::OutboxItem> out;
    for (bool compare = true; more.ok() && *more;) {
        more = reader.next(record);
        if (!more.ok() || !*more || (leaves_out_last && record.hashes.empty())) {
            break;
        }
        out.clear();
        const std::string wrong = replayed_tick(settings_, record, compare, world, out);
        if (record.tick != world.now()) {
            run.trouble += (run.trouble.empty() ? "" : "; ") + wrong;
            return;
        }
        if (!wrong.empty()) {
            run.trouble += (run.trouble.empty() ? "" : "; ") + wrong;
            compare = false;
        }
        ledger_.apply(record.items, out);
        ledger_.ask_store(world.now(), world.store_requests());
    }
    if (!more.ok()) {
        // A server that dies leaves no end mark, and perhaps half a frame of which nobody heard.
        log_of(LogArea::kServer).info("the end of the journal: {}", more.error());
    }
}

/// From here on this state is the one to go back to.
void Recovery::keep_state(const World& world) {
    std::vector<std::uint8_t> buffer;
    const std::string wrong = write_snapshot(folder_, world, ledger_, buffer);
    if (!wrong.empty()) {
        throw std::runtime_error("this world cannot be kept for after a crash (recovery.on): " +
                                 wrong);
    }
    last_ = world.now();
    before_ = last_;
    begun_ = last_;
    remove_snapshots_before(folder_, last_);
    remove_pieces(folder_);
}

void Recovery::after_tick(World& world,
                          std::span<const mailbox::InboxItem> in,
                          std::vector<mailbox::OutboxItem>& out,
                          recording::Recorder& recorder) {
    for (const mailbox::InboxItem& item : in) {
        const auto* command = std::get_if<mailbox::Command>(&item);
        const auto* progress = std::get_if<mailbox::SessionProgress>(&item);
        if (command != nullptr) {
            out.emplace_back(mailbox::CommandsKept{command->client, command->number});
        } else if (progress != nullptr &&
                   progress->commands > ledger_.commands_of(progress->client)) {
            out.emplace_back(mailbox::CommandsKept{progress->client, progress->commands});
        }
    }
    ledger_.apply(in, out);
    ledger_.ask_store(world.now(), world.store_requests());
    if (world.now() == begun_ + lives_ticks_) {
        std::error_code error;
        fs::remove(attempts_file(folder_), error);
    }
    look_after_copy(recorder);
    if (!copy_.works() && world.now() >= last_ + every_ticks_ &&
        world.now() >= started_ + every_ticks_) {
        take_snapshot(world, recorder);
    }
}

void Recovery::take_snapshot(const World& world, recording::Recorder& recorder) {
    recorder.cut_journal(world.now());
    started_ = world.now();
    const std::string wrong = copy_.start([&] {
        std::vector<std::uint8_t> buffer;
        const std::string failed = write_snapshot(folder_, world, ledger_, buffer);
        if (!failed.empty()) {
            return "a snapshot failed: " + failed;
        }
        remove_snapshots_before(folder_, last_);
        return std::string();
    });
    if (!wrong.empty()) {
        ++figures_.failed;
        log_of(LogArea::kServer).error("no snapshot: {}", wrong);
    }
}

void Recovery::look_after_copy(recording::Recorder& recorder) {
    const ProcessCopy::CopyEnd outcome = copy_.look();
    if (outcome == ProcessCopy::CopyEnd::kFailed) {
        ++figures_.failed;
        log_of(LogArea::kServer)
            .error("the snapshot of tick {} failed; the next one is due in {} ticks",
                   started_,
                   every_ticks_);
    }
    if (outcome != ProcessCopy::CopyEnd::kDone) {
        return;
    }
    ++figures_.taken;
    before_ = last_;
    last_ = started_;
    // The snapshot before is kept too, with the inputs since: a disk may lie.
    recorder.forget_journal(before_);
}

std::string Recovery::end(const World& world) {
    copy_.stop();
    std::error_code error;
    if (settings_.server.recovery.over_restarts) {
        std::vector<std::uint8_t> buffer;
        std::string wrong = write_snapshot(folder_, world, ledger_, buffer);
        if (wrong.empty()) {
            fs::remove(attempts_file(folder_), error);
            remove_snapshots_before(folder_, world.now());
            remove_pieces(folder_);
        }
        return wrong;
    }
    fs::remove_all(folder_, error);
    return error ? "cannot remove '" + folder_ + "': " + error.message() : "";
}

}  // namespace zoned::app
