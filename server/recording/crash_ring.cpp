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
    std::error_code error;
    while (pieces_.size() > kPieces) {
        fs::remove(pieces_.front().file, error);
        pieces_.pop_front();
    }
    char name[32];
    std::snprintf(name, sizeof(name), "/%012lld.zrec", static_cast<long long>(tick));
    ticks_ = 0;
    pieces_.push_back({tick, folder_ + name});
    // A failure stays in error(); the next piece tries again.
    [[maybe_unused]] const Result<bool> opened = piece_.open(pieces_.back().file, header_);
}

Tick CrashRing::first_tick() const {
    return lock_ < 0 || pieces_.empty() ? 0 : pieces_.front().first;
}

void CrashRing::restart() {
    piece_ = RecordingFile();
    std::error_code error;
    for (const Piece& piece : pieces_) {
        fs::remove(piece.file, error);
    }
    pieces_.clear();
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
