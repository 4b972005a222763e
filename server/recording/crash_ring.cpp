#include "server/recording/crash_ring.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <limits>
#include <vector>

namespace zoned::recording {

namespace {

namespace fs = std::filesystem;
using core::Result;

/// Complete ones beside the one that is written.
constexpr std::size_t kPieces = 4;
constexpr std::size_t kKeptRuns = 3;

bool holds_pieces(const std::string& folder) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        if (entry.path().extension() == ".zrec") {
            return true;
        }
    }
    return false;
}

constexpr std::string_view kStateEnd = "-state.zrec";
/// States that are so many lengths of the ring old are followed by no newer ones.
constexpr Tick kStateLives = 4;

/// When the folder was written last, in UTC: 20260131T235959.
std::string time_of(const std::string& folder) {
    struct stat info {};

    if (::stat(folder.c_str(), &info) != 0) {
        return "unknown";
    }
    std::tm time{};
    gmtime_r(&info.st_mtime, &time);
    char text[32];
    std::strftime(text, sizeof(text), "%Y%m%dT%H%M%S", &time);
    return text;
}

/// Removes all but the newest of the folders `base`-TIME.
void remove_oldest(const std::string& base) {
    const std::string prefix = fs::path(base).filename().string() + "-";
    std::vector<std::string> runs;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(fs::path(base).parent_path(), error)) {
        if (entry.is_directory(error) && entry.path().filename().string().starts_with(prefix)) {
            runs.push_back(entry.path().string());
        }
    }
    std::sort(runs.begin(), runs.end());
    for (std::size_t i = 0; i + kKeptRuns < runs.size(); ++i) {
        fs::remove_all(runs[i], error);
    }
}

}  // namespace

std::string ring_state_file(const std::string& folder, Tick tick) {
    char name[32];
    std::snprintf(name, sizeof(name), "/%012lld", static_cast<long long>(tick + 1));
    return folder + name + std::string(kStateEnd);
}

bool is_ring_state(const std::string& file) {
    return std::string_view(file).ends_with(kStateEnd);
}

CrashRing::~CrashRing() {
    if (lock_ >= 0) {
        ::close(lock_);
    }
}

Result<bool> CrashRing::open(const std::string& folder,
                             std::uint64_t ticks,
                             const RecordingHeader& header) {
    folder_ = folder;
    header_ = header;
    piece_ticks_ = std::max<std::uint64_t>(1, (ticks + kPieces - 1) / kPieces);
    const std::string lock = folder + ".lock";
    std::error_code error;
    fs::create_directories(fs::absolute(folder).parent_path(), error);
    const int fd = ::open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0640);
    if (fd < 0) {
        return Result<bool>::failure("cannot open '" + lock + "': " + std::strerror(errno));
    }
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
        ::close(fd);
        return Result<bool>::failure("another server keeps its last inputs in '" + folder +
                                     "': give each a session.state_folder of its own");
    }
    lock_ = fd;
    keep_old();
    if (!fs::is_directory(folder, error) && !fs::create_directories(folder, error)) {
        return Result<bool>::failure("cannot create the folder '" + folder +
                                     "': " + error.message());
    }
    return true;
}

void CrashRing::keep_old() {
    if (!holds_pieces(folder_)) {
        return;
    }
    const std::string kept = folder_ + "-" + time_of(folder_);
    std::error_code error;
    fs::remove_all(kept, error);
    fs::rename(folder_, kept, error);
    if (!error) {
        kept_ = kept;
        remove_oldest(fs::absolute(folder_).string());
    }
}

void CrashRing::append(std::string_view frame, Tick tick, bool begins_tick) {
    if (lock_ < 0) {
        return;
    }
    if (begins_tick && (!piece_.is_open() || ticks_ >= piece_ticks_)) {
        begin_piece(tick);
    }
    ticks_ += begins_tick ? 1 : 0;
    piece_.append(frame, begins_tick);
}

void CrashRing::flush() {
    piece_.flush();
}

void CrashRing::begin_piece(Tick tick) {
    piece_ = RecordingFile();
    remove_old_pieces(tick);
    char name[32];
    std::snprintf(name, sizeof(name), "/%012lld.zrec", static_cast<long long>(tick));
    ticks_ = 0;
    pieces_.push_back({tick, folder_ + name});
    // A failure stays in error(); the next piece tries again.
    [[maybe_unused]] const Result<bool> opened = piece_.open(pieces_.back().file, header_);
}

void CrashRing::remove_old_pieces(Tick tick) {
    const auto ring_ticks = static_cast<Tick>(kPieces * piece_ticks_);
    if (state_ > 0 && tick > state_ + kStateLives * ring_ticks) {
        state_ = 0;
        remove_states_before(tick);
    }
    std::error_code error;
    while (pieces_.size() > kPieces && (state_ == 0 || pieces_[1].first <= state_ + 1)) {
        fs::remove(pieces_.front().file, error);
        pieces_.pop_front();
    }
}

void CrashRing::keep_from(Tick state) {
    if (lock_ < 0) {
        return;
    }
    state_ = state;
    remove_states_before(state);
}

void CrashRing::remove_states_before(Tick tick) {
    const std::string first = ring_state_file(folder_, tick);
    std::vector<std::string> old;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder_, error)) {
        const std::string file = entry.path().string();
        const bool finished_or_not = file.find(kStateEnd) != std::string::npos;
        if (finished_or_not && file < first) {
            old.push_back(file);
        }
    }
    for (const std::string& file : old) {
        fs::remove(file, error);
    }
}

void CrashRing::restart() {
    piece_ = RecordingFile();
    std::error_code error;
    for (const Piece& piece : pieces_) {
        fs::remove(piece.file, error);
    }
    pieces_.clear();
    state_ = 0;
    remove_states_before(std::numeric_limits<Tick>::max() - 1);
}

void CrashRing::close(bool keeps) {
    if (lock_ < 0) {
        return;
    }
    if (keeps) {
        piece_ = RecordingFile();
    } else {
        restart();
    }
    ::close(lock_);
    lock_ = -1;
}

}  // namespace zoned::recording
