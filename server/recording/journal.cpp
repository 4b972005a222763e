#include "server/recording/journal.h"

#include "shared/core/files/replace_file.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <vector>

namespace zoned::recording {

namespace {

namespace fs = std::filesystem;
using core::Result;

std::string name_of(Tick tick) {
    char name[32];
    std::snprintf(name, sizeof(name), "/%012lld.zrec", static_cast<long long>(tick));
    return name;
}

}  // namespace

Result<bool> Journal::open(const std::string& folder, const RecordingHeader& header) {
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
        if (entry.path().extension() == ".zrec") {
            const std::string stem = entry.path().stem().string();
            pieces_.push_back({std::atoll(stem.c_str()), entry.path().string()});
        }
    }
    if (error) {
        return Result<bool>::failure("cannot read the folder '" + folder + "': " + error.message());
    }
    std::sort(pieces_.begin(), pieces_.end(), [](const JournalPiece& a, const JournalPiece& b) {
        return a.first < b.first;
    });
    folder_ = folder;
    header_ = header;
    return true;
}

void Journal::append(std::string_view frame, Tick tick, bool begins_tick) {
    if (!is_open()) {
        return;
    }
    if (begins_tick && cut_) {
        begin_piece(tick);
    }
    piece_.append(frame, begins_tick);
    newest_ = tick;
}

void Journal::begin_piece(Tick tick) {
    piece_ = RecordingFile();
    pieces_.push_back({tick, folder_ + name_of(tick)});
    cut_ = false;
    // A failure stays in error(); the next piece tries again.
    const Result<bool> opened = piece_.open(pieces_.back().file, header_);
    open_error_ = opened.ok() ? "" : opened.error();
    core::sync_folder(folder_);
}

void Journal::sync(bool power) {
    if (power) {
        piece_.sync();
    } else {
        piece_.flush();
    }
}

void Journal::forget(Tick through) {
    std::error_code error;
    const auto is_old = [&] {
        return pieces_.size() > 1 ? pieces_[1].first <= through + 1 : cut_ && newest_ <= through;
    };
    while (!pieces_.empty() && is_old()) {
        if (pieces_.size() == 1) {
            piece_ = RecordingFile();
        }
        fs::remove(pieces_.front().file, error);
        pieces_.pop_front();
    }
}

void Journal::give_up(const std::string& why) {
    piece_.give_up(why);
}

}  // namespace zoned::recording
